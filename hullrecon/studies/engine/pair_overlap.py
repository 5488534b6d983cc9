# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Matches that either two-view model accepts outside the overlap [KimEustice2009 Fig. 2(b)].

An essential matrix holds a point to a line: a false match along it is an inlier. A homography holds
it to a point. Pairs are matched as the paper does, inside the ellipses of navigation, and over the
whole image, where the ratio of descriptors has more to compare with and lets fewer false ones pass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rows import spread_rows
from hullrecon.studies.engine.one_camera import OneCameraDive, read_one_camera
from hullrecon.studies.engine.pair_stages import expect_features, show_side_by_side
from hullrecon.studies.figure_style import PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.typing import Array, Mask
from hullrecon.vision.features.descriptors import Putative, match_descriptors
from hullrecon.vision.pairs import two_view
from hullrecon.vision.pairs.matching import VERIFY_PX
from hullrecon.vision.stereo.node_view import NodeView

PAIRS = 40  # of two legs, evenly from all of them
RIGHT_PX = 3.0
SEARCHES = ("search ellipses", "whole image")
MODELS = ("essential", "homography")
YELLOW, BOX = "#e0b400", "#b3202c"


@dataclass(frozen=True, kw_only=True)
class Accepted:
    """The matches of a pair that a model accepts, by the truth."""

    outside: int  # matches of points that the second image does not show
    wrong: int  # matches off by more than RIGHT_PX, those outside included
    count: int  # all that the model accepts


@dataclass(frozen=True, kw_only=True)
class ComparedPair:
    """Two images matched in one way, with both models fitted."""

    nodes: tuple[int, int]
    here: Array  # (n, 2) px of the matches
    there: Array
    inlier: Mapping[str, Mask]  # (n,) of each model
    shared: Mask  # (n,) the second image shows the first feature's point
    right: Mask  # (n,)

    def accepted(self, model: str) -> Accepted:
        """Count what a model accepts."""
        of = self.inlier[model]
        return Accepted(
            outside=int((of & ~self.shared).sum()),
            wrong=int((of & ~self.right).sum()),
            count=int(of.sum()),
        )


def study(given: StudyDive) -> StudyResult:
    """Compare pairs of two legs with and without navigation, and count false inliers."""
    dive = read_one_camera(given)
    some = spread_rows(len(dive.across), PAIRS)
    pairs = [dive.across[k] for k in some]
    found = {
        name: [
            pair
            for pair in (compare_pair(dive, nodes, gated=name == SEARCHES[0]) for nodes in pairs)
            if pair is not None
        ]
        for name in SEARCHES
    }
    rows = [
        (f"{model}, {name}", *_row([pair.accepted(model) for pair in compared]))
        for name, compared in found.items()
        for model in MODELS
    ]
    drawn = max(found[SEARCHES[0]], key=_false_on_lines)
    return StudyResult(
        figures=(pair_inliers(dive, drawn, rows),),
        heads=("model, search", "pairs", "matches", "outside", "wrong"),
        rows=tuple(rows),
        compared=tuple(_compared(found)),
    )


def compare_pair(
    dive: OneCameraDive, nodes: tuple[int, int], *, gated: bool
) -> ComparedPair | None:
    """Match two images and fit both models. None with too few matches.

    `gated`: search where navigation expects a feature, else everywhere.
    """
    first, second = dive.view(nodes[0]), dive.view(nodes[1])
    allowed = expect_features(dive, nodes)[2] if gated else None
    putative = match_descriptors(first, second, allowed)
    focal = dive.worker.rig.focal_px(Camera.TOP)
    tolerance = VERIFY_PX / focal
    xy, other = first.xy[putative.first], second.xy[putative.second]
    both = two_view.fit_both(xy, other, tolerance)
    if both is None:
        return None
    return _by_truth(dive, nodes, putative, (first, second), both, tolerance)


def _by_truth(
    dive: OneCameraDive,
    nodes: tuple[int, int],
    putative: Putative,
    views: tuple[NodeView, NodeView],
    both: two_view.BothModels,
    tolerance: float,
) -> ComparedPair:
    """Judge a pair's matches by what its images show in truth.

    Parameters
    ----------
    dive, nodes, views
        The dive, and the two nodes with their features.
    putative
        Matches by descriptor.
    both
        The two-view models fitted to them.
    tolerance
        Distance from a model up to which it accepts a match, ideal coordinates.
    """
    xy = views[0].xy[putative.first]
    there = dive.pixels(views[1], putative.second)
    again = dive.camera.seen_again(*nodes, xy)
    shared = np.asarray(np.isfinite(again).all(axis=1))
    with np.errstate(invalid="ignore"):
        right = np.linalg.norm(again - there, axis=1) < RIGHT_PX
    return ComparedPair(
        nodes=nodes,
        here=dive.pixels(views[0], putative.first),
        there=there,
        inlier={m.model: m.within(tolerance).inlier for m in (both.essential, both.homography)},
        shared=shared,
        right=np.asarray(right),
    )


def _false_on_lines(pair: ComparedPair) -> tuple[int, int]:
    """Rank pairs by what the essential matrix accepts outside the overlap, then by matches."""
    accepted = pair.accepted("essential")
    return accepted.outside, accepted.count


def _row(accepted: Sequence[Accepted]) -> tuple[str, str, str, str]:
    """Write what a model accepts of all pairs as a row: pairs, matches, outside, wrong."""
    count = sum(a.count for a in accepted)
    outside, wrong = sum(a.outside for a in accepted), sum(a.wrong for a in accepted)
    return (
        f"{len(accepted)}",
        f"{count:,}",
        f"{outside:,} ({100 * outside / max(count, 1):.2f} %)",
        f"{wrong:,} ({100 * wrong / max(count, 1):.2f} %)",
    )


def _compared(found: Mapping[str, Sequence[ComparedPair]]) -> list[ComparedValue]:
    """Set the shares outside the overlap beside what the paper says of them."""
    values = []
    for name, pairs in found.items():
        for model in MODELS:
            accepted = [pair.accepted(model) for pair in pairs]
            count = sum(a.count for a in accepted)
            values.append(
                ComparedValue(
                    what=f"accepted outside the overlap, {model}, {name}",
                    unit="%",
                    ours=100 * sum(a.outside for a in accepted) / max(count, 1),
                    note="drawn: epipolar inliers outside the box, those of the homography inside",
                )
            )
    return values


def pair_inliers(
    dive: OneCameraDive, pair: ComparedPair, rows: Sequence[tuple[str, ...]]
) -> PublishedFigure:
    """Draw the inliers of both models on the pair with the most false ones along the lines.

    rows: as the result's table has them, by search and model: name, pairs, matches, outside, wrong.
    The caption quotes `outside` of the two models inside the ellipses, then over the whole image.
    """
    images = [dive.image(node) for node in pair.nodes]
    height, width = images[0].shape
    figure, axes = new_canvas(10.0, 10.0 * height / (2 * width) + 0.5)
    axis = axes[0][0]
    show_side_by_side(axis, images)
    for model, ink, size in (("essential", YELLOW, 5.0), ("homography", BOX, 2.2)):
        of = pair.inlier[model]
        name = "essential matrix" if model == "essential" else model
        axis.plot(
            np.r_[pair.here[of, 0], pair.there[of, 0] + width],
            np.r_[pair.here[of, 1], pair.there[of, 1]],
            "o",
            color=ink,
            markersize=size,
            markeredgewidth=0,
            label=f"inliers of the {name}: {of.sum():,}",
        )
    for k, (a, b) in enumerate((pair.nodes, pair.nodes[::-1])):
        outline = dive.camera.outline_of(b, a)  # of the image at b, in the image at a
        closed = np.vstack([outline, outline[:1]])
        axis.plot(
            np.clip(closed[:, 0], 1, width - 2) + k * width,
            np.clip(closed[:, 1], 1, height - 2),
            color=BOX,
            linewidth=1.6,
            label="overlap, in truth" if k == 0 else None,
        )
    axis.set(xlim=(0, 2 * width), ylim=(height, 0))
    axis.legend(fontsize=8, loc="lower right")
    table = ["model_and_search,pairs,matches,outside_overlap,wrong"]
    table += [",".join(f'"{cell}"' for cell in row) for row in rows]
    outside = {model: pair.accepted(model).outside for model in MODELS}
    caption = (
        f"Images {pair.nodes[0]} and {pair.nodes[1]} matched inside navigation's ellipses. Outside "
        f"their overlap the essential matrix accepts {outside['essential']}, the homography "
        f"{outside['homography']} matches. Over {rows[0][1]} pairs of two legs: {rows[0][3]} and "
        f"{rows[1][3]}; searched over the whole image {rows[2][3]} and {rows[3][3]}."
    )
    return finish_figure("pair_inliers", figure, table, caption)
