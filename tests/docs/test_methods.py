# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is cited of docs/methods.md is there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EQUATION = re.compile(r"docs/methods\.md \((\d+)\)")
SECTION = re.compile(r"docs/methods\.md (\d+(?:, \d+)*)")


def test_equations_are_numbered_without_gaps() -> None:
    tags = [int(n) for n in re.findall(r"\\tag\{(\d+)\}", _methods())]
    assert len(tags) > 40
    assert tags == list(range(1, len(tags) + 1))


def test_every_section_and_equation_cited_exists() -> None:
    text = _methods()
    sections = set(re.findall(r"^## (\d+)\. ", text, re.MULTILINE))
    tags = set(re.findall(r"\\tag\{(\d+)\}", text))
    cited = 0
    for folder, suffixes in (
        ("hullrecon", {".py"}),
        ("cli", {".py"}),
        ("native", {".h", ".cpp"}),
        ("docs", {".md"}),
    ):
        for path in (
            p for p in (ROOT / folder).rglob("*") if p.suffix in suffixes and p.name != "methods.md"
        ):
            source = path.read_text()
            for numbers in SECTION.findall(source):
                assert set(numbers.split(", ")) <= sections, f"{path}: section {numbers}"
                cited += 1
            for number in EQUATION.findall(source):
                assert number in tags, f"{path}: equation {number}"
    assert cited > 10


def test_the_label_boundary_is_the_one_derived() -> None:
    from hullrecon.adjustment.problem.selection import label_boundary

    assert f"{label_boundary(0.02, 1.0):.5f}" in _methods()


def test_the_huber_thresholds_leave_the_same_share_beyond() -> None:
    from scipy.stats import chi2

    printed = {
        int(rows): float(k)
        for rows, k in re.findall(r"\| (\d) \|[^|]*\| Huber, k = ([\d.]+) \|", _methods())
    }
    assert set(printed) == {1, 2, 4}
    beyond = [float(chi2.sf(k**2, rows)) for rows, k in printed.items()]
    assert max(beyond) - min(beyond) < 3e-4


def test_numbers_of_a_comparison_are_the_defaults() -> None:
    from hullrecon.change.options import ChangeOptions

    o = ChangeOptions()
    section = _methods().split("## 19. ")[1].split("## 20. ")[0]
    for text in (
        f"cells of {100 * o.cell_m:.0f} cm",
        f"within $e = {100 * o.edge_m:.0f}$ cm",
        f"sigma of at most {1000 * o.max_sigma_m:.0f} mm",
        f"at least {1e4 * o.min_area_m2:.0f} cm²",
        f"{1000 * o.min_change_m:.0f}\\,\\mathrm{{mm}}",
        f"patches of {o.patch_m:g} m",
        f"by {1000 * o.min_move_m:.0f} mm or more",
        f"from {100 * o.max_p_value:.0f} % down",
    ):
        assert text in section, text


def _methods() -> str:
    return (ROOT / "docs/methods.md").read_text()
