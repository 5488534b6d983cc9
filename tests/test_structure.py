# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What keeps the code readable: small folders, the field's words, docstrings that begin with a verb, few untyped values."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = sorted((ROOT / "hullrecon").rglob("*.py"))
SOURCES = [*LIBRARY, *sorted((ROOT / "cli").rglob("*.py"))]
SCRIPTS = sorted((ROOT / "hullrecon" / "report" / "web" / "src").rglob("*.js"))
DOCUMENTS = [*sorted((ROOT / "docs").glob("*.md")), *(ROOT / n for n in ("README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"))]
NATIVE = sorted(p for p in (ROOT / "native").rglob("*") if p.suffix in {".h", ".cpp"})
PACKAGES = sorted(p.parent.name for p in (ROOT / "hullrecon").glob("*/__init__.py"))

# Words that were this project's own, each with the field's word for it (docs/concepts.md has those). Here stand only words that
# no identifier has in a sense of plain English or of algebra: a patch is surveyed, a block has its place, a column is gathered.
FIELD_WORDS = {
    "absences": "missing_deliverables", "complaints": "config_errors", "csvtext": "csv_export", "doubts?": "rejection_reason",
    "drawing": "cad_model", "fellows": "neighbours", "grounded": "hull_pose", "handover": "subprocess_runner",
    "judged?": "score, or check", "ledger": "LossTracker", "lenses": "intrinsics", "lifted": "adjoint", "lonely": "isolated",
    "lowered": "adjoint", "mesh_trust": "closest_face_certificate", "misfit": "cad_error", "opened": "what is open",
    "place_(sigma|columns|words)": "position", "planting": "item_placement", "said": "message", "settled": "profile_mean_pose",
    "shots": "camera_views", "sights?": "image_view, image_terms", "slop": "backlash", "stale": "out_of_date",
    "stray": "outlier", "suspicio(n|ns|us)": "consistency_checks, warnings", "swim": "simulate_path", "told": "message",
    "untold": "message", "witnesses": "supporting_landmarks",
}  # fmt: skip
FIELD_CLASSES = {
    "Arm": "CameraChain", "Eye": "SensorRig", "Ground": "HullPoseEvidence", "Held": "BoundProblem", "Kept": "ReducedLayout",
    "Ledger": "LossTracker", "Means": "RunContext", "Opened": "DiveRun", "Optics": "FreeIntrinsics", "Place": "position",
    "Placement": "what is placed", "Shelf": "DeliverableWriter", "Sight": "ImageView", "Split": "StepVector",
    "Standing": "StepStatus", "Station": "CameraImages", "Team": "TaskPool",
}  # fmt: skip
RETIRED_IN_MESSAGES = re.compile(
    r"\b(the|a|its|this|ship's) drawing\b|\bwith doubts\b|\bsuspicious\b"
    r"|\bdrawn surface\b|made anew|it was never made|not fresh|\d a second\b"
    r"|METHODS|OUTPUTS|INPUTS|\(O \d|\bO \d\."
)
# Of those, what has no sense of its own in a sentence that names a test.
RETIRED_IN_TESTS = re.compile(r"(?i)drawing|misfit|(^|_)(lenses|swim|shots|fellows|lonely|csvtext|planting)(_|$)")
# What a docstring may begin with: a new verb is entered here, a noun is not.
VERBS = re.findall(
    r"\w+",
    """
    Add Answer Append Apply Ask Assign Bring Build Call Carry Check Choose Close Collect Compare Compute Convert Copy
    Count Create Cut Declare Decode Deliver Describe Divide Do Draw Encode End Enter Escape Estimate Exit Export Extract
    Fill Find Fit Flag Flip Follow Forget Give Guess Hand Have Hide Hold Insert Join Keep Label Learn Leave Let List Load
    Lock Log Look Make Map Mark Match Measure Merge Move Note Open Paint Parse Pick Place Predict Print Publish Put
    Raise Read Reconstruct Record Refine Refuse Reject Remember Remove Rename Render Repeat Replace Report Reset Restore
    Return Rewrite Rotate Run Sample Save Say Scale Score Select Send Serve Set Show Simulate Skip Smooth Solve Sort
    Split Spread Start Stop Store Swap Sync Take Tell Tie Track Transform Turn Unpack Update Use Wait Walk Warn Watch
    Weigh Wrap Write Yield
    """,
)
ANY_LINES = 60


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def _field_word(name: str) -> str | None:
    """Return the field's word for an identifier's retired one, None where there is none; a class may be private."""
    if name.lstrip("_") in FIELD_CLASSES:
        return FIELD_CLASSES[name.lstrip("_")]
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
    if snake.endswith("hull_from"):
        return "global_from_hull"
    return next((new for old, new in FIELD_WORDS.items() if re.search(rf"(^|_){old}(_|$)", snake)), None)


def _names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield what a module names itself: functions, classes, arguments, variables and attributes that it assigns."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


COMMENTS = {".js": r"/\*.*?\*/|//[^\n]*", ".h": r"/\*.*?\*/|//[^\n]*", ".cpp": r"/\*.*?\*/|//[^\n]*"}
QUOTED = r'"(?:\\.|[^"\\\n])*"|`(?:\\.|[^`\\])*`'


def _identifiers(path: Path) -> Iterator[tuple[int, str]]:
    """Yield all identifiers of a file in C++ or JavaScript, without comments and strings."""
    text = re.sub(f"{QUOTED}|{COMMENTS[path.suffix]}", lambda found: "\n" * found[0].count("\n"), path.read_text(), flags=re.S)
    for number, line in enumerate(text.splitlines(), 1):
        yield from ((number, name) for name in re.findall(r"\b[A-Za-z_]\w*", line))


def _quoted(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the strings of a file in C++ or JavaScript, line by line."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        yield from ((number, text) for text in re.findall(QUOTED, line))


def _strings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def _is_property(node: ast.FunctionDef) -> bool:
    """A property is read as a value: its docstring may name it."""
    return any(isinstance(d, ast.Name) and d.id in {"property", "cached_property"} for d in node.decorator_list)


def _where(path: Path, line: int, what: str) -> str:
    return f"{path.relative_to(ROOT)}:{line}: {what}"


def test_no_folder_of_the_library_but_steps_holds_more_than_twelve_modules() -> None:
    folders = {path.parent for path in LIBRARY} - {ROOT / "hullrecon" / "steps"}
    full = {
        str(folder.relative_to(ROOT)): len([p for p in folder.glob("*.py") if p.name != "__init__.py"]) for folder in folders
    }
    for folder in {path.parent for path in NATIVE} - {ROOT / "native" / "tests"}:
        full[str(folder.relative_to(ROOT))] = len({p.stem for p in folder.iterdir()})
    assert {name: count for name, count in full.items() if count > 12} == {}


def _retired(path: Path, names: Iterable[tuple[int, str]]) -> list[str]:
    return [_where(path, n, f"{name}: {word}") for n, name in names if (word := _field_word(name)) is not None]


def test_no_function_is_longer_than_sixty_lines() -> None:
    long = [
        _where(path, node.lineno, f"{node.name}: {lines} lines")
        for path in SOURCES
        for node in ast.walk(_tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and (lines := node.end_lineno - node.lineno + 1) > 60
    ]
    assert long == []


def test_no_identifier_is_a_retired_word() -> None:
    assert [line for p in SOURCES for line in _retired(p, _names(_tree(p)))] == []


def test_none_in_cpp_or_in_the_reports_own_javascript_is_one_either() -> None:
    assert [line for p in [*NATIVE, *SCRIPTS] for line in _retired(p, _identifiers(p))] == []


def test_no_name_in_tests_and_benchmarks_is_one_either() -> None:
    paths = [*sorted((ROOT / "tests").rglob("*.py")), *sorted((ROOT / "benchmarks").glob("**/*.py"))]
    ours = [p for p in paths if ".venv" not in p.parts]
    found = [_where(p, n, name) for p in ours for n, name in _names(_tree(p)) if RETIRED_IN_TESTS.search(name)]
    assert found == []


def test_no_module_is_named_by_a_retired_word() -> None:
    assert [str(p.relative_to(ROOT)) for p in [*SOURCES, *NATIVE, *SCRIPTS] if _field_word(p.stem) is not None] == []


def test_no_message_or_docstring_speaks_the_old_language() -> None:
    found = [
        _where(p, n, text.strip()[:80]) for p in SOURCES for n, text in _strings(_tree(p)) if RETIRED_IN_MESSAGES.search(text)
    ]
    assert found == []


def test_no_string_in_cpp_or_javascript_and_no_document_does() -> None:
    quoted = [(p, n, text) for p in [*NATIVE, *SCRIPTS] for n, text in _quoted(p)]
    documents = [*DOCUMENTS, ROOT / "pyproject.toml"]
    lines = [(p, n, line) for p in documents for n, line in enumerate(p.read_text().splitlines(), 1)]
    assert [_where(p, n, text[:80]) for p, n, text in [*quoted, *lines] if RETIRED_IN_MESSAGES.search(text)] == []


def test_docstrings_begin_with_a_verb() -> None:
    found = []
    for path in SOURCES:
        for node in ast.walk(_tree(path)):
            if isinstance(node, ast.FunctionDef):
                text = ast.get_docstring(node)
                if text and not _is_property(node) and text.split()[0].strip(".,:") not in VERBS:
                    found.append(_where(path, node.lineno, f"{node.name}: {text.splitlines()[0][:60]}"))
    assert found == []


def test_few_lines_are_untyped() -> None:
    lines = [
        _where(p, n, line.strip())
        for p in SOURCES
        for n, line in enumerate(p.read_text().splitlines(), 1)
        if re.search(r"\bAny\b", line) and not line.lstrip().startswith(("from typing import", "#"))
    ]
    assert len(lines) < ANY_LINES, "\n".join(lines)


def test_array_types_are_named_in_one_place() -> None:
    here = ROOT / "hullrecon" / "typing.py"
    names = "|".join(re.findall(r"(?m)^(\w+) =", here.read_text()))
    again = re.compile(rf"(?m)^({names}) = .*")
    assert [f"{p.relative_to(ROOT)}: {found[0]}" for p in SOURCES if p != here for found in again.finditer(p.read_text())] == []


def test_a_class_name_is_used_once() -> None:
    where: dict[str, list[str]] = {}
    for path in LIBRARY:
        if "synthetic" in path.parts:  # it shares no code with what it tests, and so may share names
            continue
        for node in _tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                where.setdefault(node.name, []).append(str(path.relative_to(ROOT)))
    assert {name: paths for name, paths in where.items() if len(paths) > 1} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_has_four_lines_of_test_for_five_of_source(package: str) -> None:
    source = sum(len(p.read_text().splitlines()) for p in (ROOT / "hullrecon" / package).rglob("*.py"))
    tests = sum(len(p.read_text().splitlines()) for p in (ROOT / "tests" / package).rglob("*.py"))
    assert tests >= 0.8 * source


def test_native_has_four_lines_of_test_for_five_of_source() -> None:
    sources = [p for p in NATIVE if "tests" not in p.relative_to(ROOT / "native").parts]
    tests = [*(set(NATIVE) - set(sources)), *(ROOT / "tests" / "native").rglob("*.py")]
    assert sum(len(p.read_text().splitlines()) for p in tests) >= 0.8 * sum(len(p.read_text().splitlines()) for p in sources)
