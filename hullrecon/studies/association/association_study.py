# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Three ways of pairing points, on fields that were moved as a whole [Aulinas2011 4.2.2]."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.association.methods import joint_compatibility, nearest_neighbours
from hullrecon.studies.association.point_sets import Association, PointSets, chi_square
from hullrecon.studies.association.trials import (
    JCBB,
    NN,
    RJC,
    Field,
    Score,
    score,
    simulate_field,
)
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

METHODS = {NN: COLOURS["geva"], JCBB: COLOURS["maxmix"], RJC: GREEN}
HEADS = (
    "fields",
    "method",
    "true pairs found %",
    "of its pairs false %",
    "joint tests a field",
    "CPU ms a field",
)

# points in common, strangers as a share of them, offset in spacings, dimension, fields
CASES = {
    "clear: 20 points, off by 0.4 of their spacing": (20, 0.0, 0.4, 2, 500),
    "in space: 20 points, off by 0.4": (20, 0.1, 0.4, 3, 10),
    "strangers: 60 points and 6, off by 0.4": (60, 0.1, 0.4, 2, 3),
    "ambiguous: 10 points and 3, off by 1": (10, 0.3, 1.0, 2, 10),
    "ambiguous: 20 points and 6, off by 1": (20, 0.3, 1.0, 2, 5),
    "ambiguous: 30 points and 9, off by 1": (30, 0.3, 1.0, 2, 2),
    "ambiguous: 60 points and 6, off by 0.8": (60, 0.1, 0.8, 2, 3),
}
CLEAR, *_, LARGE = CASES
SURE = 0.99


def compare_methods() -> StudyResult:
    """Run the three methods on all cases, and draw why neighbours mislead."""
    scores = {}
    for name in CASES:
        fields = draw_fields(name)
        scores[name] = {method: score(fields, method) for method in METHODS}
    rows = tuple(
        (
            *(name, method, f"{100 * s.recall:.1f}", f"{100 * s.false:.1f}"),
            *(f"{s.tests:.0f}", f"{1e3 * s.cpu_s:.0f}"),
        )
        for name, by_method in scores.items()
        for method, s in by_method.items()
    )
    return StudyResult(
        figures=(draw_examples(),),
        values={name: {m: s.recall for m, s in by.items()} for name, by in scores.items()},
        heads=HEADS,
        rows=rows,
        compared=_compare(scores, score(draw_fields(CLEAR), JCBB, confidence=SURE)),
    )


def draw_fields(name: str) -> list[Field]:
    """Draw the fields of a case."""
    points, strangers, offset, dimension, count = CASES[name]
    rng = np.random.default_rng(list(CASES).index(name))
    return [
        simulate_field(points, rng, dimension=dimension, offset=offset, strangers=strangers)
        for _ in range(count)
    ]


def _compare(scores: dict[str, dict[str, Score]], sure: Score) -> tuple[ComparedValue, ...]:
    """Compare shares of right pairs by method with what the thesis says of them.

    scores: by kind of field and method. sure: of JCBB on clear fields, with gates of 99 %.
    """
    clear, large = scores[CLEAR], scores[LARGE]
    words = "the thesis prints no number"
    drawn = [by_method[RJC] for by_method in scores.values()]
    return (
        ComparedValue(
            what="NN: true pairs found, off by 0.4 of the spacing",
            unit="%",
            ours=100 * clear[NN].recall,
            note=f"{words}: `leads to misclassification` as uncertainties grow",
        ),
        ComparedValue(
            what="JCBB: the same",
            unit="%",
            ours=100 * clear[JCBB].recall,
            note=f"{words}: `very robust`, nor its gate: here 95 %, asked anew with each pair "
            f"that joins. {_losses(clear[JCBB])}",
        ),
        ComparedValue(
            what="JCBB: the same, with a gate of 99 %",
            unit="%",
            ours=100 * sure.recall,
            note=f"as the filters of hullrecon/studies/submaps have it. {_losses(sure)}",
        ),
        ComparedValue(
            what="RJC: true pairs by those of JCBB, 60 ambiguous points",
            unit="%",
            ours=100 * large[RJC].recall / large[JCBB].recall,
            note=f"{words}: `without loosing accuracy`",
        ),
        ComparedValue(
            what="RJC: joint tests by those of JCBB, the same",
            unit="%",
            ours=100 * large[RJC].tests / large[JCBB].tests,
            note=f"{words}: `much faster` than a search that `becomes very expensive`. So it does "
            "where each point has many candidates; with few, both cost the same, since JCBB tries "
            "the clearest points first",
        ),
        ComparedValue(
            what="RJC: CPU time by that of JCBB, the same",
            unit="%",
            ours=100 * large[RJC].cpu_s / large[JCBB].cpu_s,
            note="draws end by the share of points that the best of them paired",
        ),
        ComparedValue(
            what="RJC: false of its pairs, all fields",
            ours=sum(score.false_pairs for score in drawn),
            note=f"of {sum(score.pairs for score in drawn)} pairs, with strangers among the points",
        ),
    )


def _losses(score: Score) -> str:
    """Say in how many fields pairs are lost, and how many pairs are false."""
    return (
        f"{100 * (1 - score.complete):.0f} % of the fields lose a pair, "
        f"{score.false_pairs} of {score.pairs} pairs are false"
    )


def draw_examples() -> PublishedFigure:
    """Draw a clear case, an ambiguous one, and the same seen as a whole [Aulinas2011 Fig. 4.6]."""
    rng = np.random.default_rng(4)
    clear = simulate_field(8, rng, offset=0.1)
    doubtful = simulate_field(8, rng, offset=0.6)
    canvas, rows = new_canvas(10.5, 3.8, 1, 3)
    panels = (
        ("a) clear: nearest neighbour", clear, nearest_neighbours(clear.sets)),
        ("b) ambiguous: nearest neighbour", doubtful, nearest_neighbours(doubtful.sets)),
        ("c) the same: joint compatibility", doubtful, joint_compatibility(doubtful.sets)),
    )
    table = ["panel,first_x,first_y,second_x,second_y,true"]
    for axis, (title, field, found) in zip(rows[0], panels, strict=True):
        _draw_pairs(axis, title, field, found)
        for i, j in found.pairs:
            values = [*field.sets.first[i], *field.sets.second[j]]
            numbers = ",".join(f"{value:.3f}" for value in values)
            table.append(f"{title[0]},{numbers},{int((i, j) in field.true_pairs)}")
    return finish_figure(
        "association",
        canvas,
        table,
        "Points of two surveys, paired: arrows are blue where right, red where wrong.",
    )


def _draw_pairs(axis: Axes, title: str, field: Field, found: Association) -> None:
    """Draw a field seen twice, with search ellipses and pairs, right ones blue, wrong ones red."""
    sets = field.sets
    for ellipse in _ellipses(sets):
        axis.plot(*ellipse, color="#9aa5b1", lw=0.6)
    axis.plot(*sets.first.T, "o", color=INK, ms=5, label="known")
    axis.plot(*sets.second.T, "x", color=COLOURS["geva"], ms=6, mew=1.6, label="new")
    for i, j in found.pairs:
        colour = COLOURS["maxmix"] if (i, j) in field.true_pairs else RED
        arrow = {"arrowstyle": "->", "color": colour, "lw": 1.3}
        axis.annotate("", xy=tuple(sets.first[i]), xytext=tuple(sets.second[j]), arrowprops=arrow)
    right = sum(pair in field.true_pairs for pair in found.pairs)
    axis.set_title(f"{title}, {right} of {len(field.true_pairs)} right", fontsize=9, loc="left")
    axis.set(xlabel="x (spacings)", aspect="equal")
    if title.startswith("a"):
        axis.set_ylabel("y (spacings)")
        axis.legend(frameon=False, fontsize=8)


def _ellipses(sets: PointSets) -> list[Array]:
    """Trace the ellipse (2, 73) around each new point in which its mate is looked for."""
    angle = np.linspace(0, 2 * np.pi, 73)
    circle = np.sqrt(chi_square(0.95, 2)) * np.stack([np.cos(angle), np.sin(angle)])
    ellipses = []
    for number, point in enumerate(sets.second):
        spread = sets.covariance((0, number), (0, number))
        ellipses.append(point[:, None] + np.linalg.cholesky(spread) @ circle)
    return ellipses
