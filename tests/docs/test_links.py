# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Documents name what exists: links, files of the repository, decisions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)(#[^)\s]+)?\)")
PATH = re.compile(
    r"`((?:hullrecon|cli|native|tests|docs|benchmarks|pipelines|sample_data)/[A-Za-z0-9_./-]*)`"
)
CITED = re.compile(r"\bdocs/[A-Za-z0-9_/-]+\.(?:md|py|json|svg|png)\b")


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_links_and_paths_of_a_page_exist(page: Path) -> None:
    text = page.read_text()
    links = [target for target, _ in LINK.findall(text) if not (page.parent / target).exists()]
    paths = [name for name in PATH.findall(text) if not (ROOT / name).exists()]
    assert not links + paths


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_a_link_to_a_heading_finds_it(page: Path) -> None:
    anchors = {
        path: {_anchor(h) for h in re.findall(r"^#+ (.+)$", path.read_text(), re.MULTILINE)}
        for path in PAGES
    }
    for target, anchor in re.findall(r"\]\(([^)#\s:]*)#([^)\s]+)\)", page.read_text()):
        there = (page.parent / target).resolve() if target else page
        assert anchor in anchors[there], f"{target}#{anchor}"


def test_documents_that_the_code_cites_exist() -> None:
    sources = [
        p
        for folder in ("hullrecon", "cli", "native", "benchmarks", "tests")
        for p in (ROOT / folder).rglob("*")
    ]
    missing = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in sources
        if path.suffix in {".py", ".h", ".cpp"} and path != Path(__file__).resolve()
        for name in CITED.findall(path.read_text())
        if not (ROOT / name).exists()
    }
    assert not missing


def test_decisions_are_numbered_and_cited_rightly() -> None:
    files = sorted(p.name for p in (ROOT / "docs/adr").glob("*.md"))
    numbers = [int(name[:4]) for name in files]
    assert numbers == list(range(1, len(numbers) + 1))
    for name, number in zip(files, numbers, strict=True):
        assert (ROOT / "docs/adr" / name).read_text().startswith(f"# {number}. ")
    for folder in ("hullrecon", "native", "cli", "docs"):
        for path in (
            p for p in (ROOT / folder).rglob("*") if p.suffix in {".py", ".h", ".cpp", ".md"}
        ):
            for cited in re.findall(r"docs/adr/(\d{4})|\bADR (\d+)\b", path.read_text()):
                assert int(cited[0] or cited[1]) in numbers, path


def _anchor(heading: str) -> str:
    """The name that GitHub gives a heading."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
