# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One pair of images registered stage by stage [KimEustice2009 Fig. 1], by the product's parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from scipy.spatial.transform import Rotation

from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.rows import spread_rows
from hullrecon.studies.engine.one_camera import OneCameraDive, read_one_camera
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.typing import Array, Ints, Mask, Pixels
from hullrecon.vision.features.descriptors import Putative, match_descriptors
from hullrecon.vision.pairs import mono_inliers, two_view
from hullrecon.vision.pairs.gating import Motion, in_ellipse, transfer
from hullrecon.vision.pairs.matching import GATE_CHI2, VERIFY_PX
from hullrecon.vision.stereo.node_view import NodeView

RIGHT_PX = 3.0  # of a match from where its point lies in truth
ELLIPSES = 25  # drawn of a pair
LINES = 120  # matches drawn of a stage


@dataclass(frozen=True, kw_only=True)
class PairStages:
    """What the registration of one pair leaves after each of its stages."""

    nodes: tuple[int, int]
    first: NodeView
    second: NodeView
    mean: Array  # (n, 2) where navigation expects the first image's features, ideal coordinates
    covariance: Array  # (n, 2, 2)
    candidates: tuple[Ints, Ints]  # pairs of features in the ellipses
    putative: Putative  # matches by descriptor among the candidates
    both: two_view.BothModels  # fitted to the putative matches
    chosen: two_view.TwoView
    motion: Motion  # refined, with navigation's length
    inlier: Mask  # of the putative matches, on its epipolar lines

    def matched(self) -> tuple[Array, Array]:
        """Ideal coordinates (n, 2) of the putative matches in both images."""
        return self.first.xy[self.putative.first], self.second.xy[self.putative.second]


def register_pair(dive: OneCameraDive, nodes: tuple[int, int]) -> PairStages:
    """Register two images as the product does with one camera, keeping every stage.

    Raises InputError where the pair has too few matches for a two-view model.
    """
    first, second = dive.view(nodes[0]), dive.view(nodes[1])
    prior = dive.track.motion(*nodes)
    mean, covariance, candidates = expect_features(dive, nodes)
    putative = match_descriptors(first, second, candidates)
    matched = first.xy[putative.first], second.xy[putative.second]
    tolerance = VERIFY_PX / dive.worker.rig.focal_px(Camera.TOP)
    both = two_view.fit_both(*matched, tolerance)
    if both is None:
        raise InputError(f"images {nodes[0]} and {nodes[1]} have too few matches for two views")
    flat = both.homography.criterion < both.essential.criterion
    chosen = (both.homography if flat else both.essential).within(tolerance)
    possible = [p for p in two_view.motions_of(chosen, *matched) if p.motion[:3, 3].any()]
    if not possible:
        raise InputError(f"images {nodes[0]} and {nodes[1]} show no motion")
    on_model = matched[0][chosen.inlier], matched[1][chosen.inlier]
    start = mono_inliers.choose(possible, on_model, prior, first.normal)
    motion, inlier = mono_inliers.gather(start, *matched, prior, tolerance)
    return PairStages(
        nodes=nodes,
        first=first,
        second=second,
        mean=mean,
        covariance=covariance,
        candidates=candidates,
        putative=putative,
        both=both,
        chosen=chosen,
        motion=motion,
        inlier=inlier,
    )


def expect_features(
    dive: OneCameraDive, nodes: tuple[int, int]
) -> tuple[Array, Array, tuple[Ints, Ints]]:
    """Find where navigation expects one node's features in another's image.

    Returns mean (n, 2) and covariance (n, 2, 2) in ideal coordinates, and the pairs of features
    inside the ellipses.
    """
    first, second = dive.view(nodes[0]), dive.view(nodes[1])
    sigma = dive.worker.options.sigma_px / dive.worker.rig.focal_px(Camera.TOP)
    mean, covariance = transfer(
        dive.track.motion(*nodes), first.xy, first.depth, first.depth_sigma, sigma
    )
    known = np.flatnonzero(np.isfinite(mean).all(axis=1))
    a, b = in_ellipse(mean[known], covariance[known], second.xy, GATE_CHI2)
    return mean, covariance, (known[a], b)


def five_numbers(second_from_first: Array) -> Array:
    """Turn second_from_first (4, 4) into five angles (5,), degrees.

    They are azimuth and elevation of the baseline, and roll, pitch and yaw of the rotation.

    The baseline is the second camera's centre in the first camera's axes, as z_ji in
    [KimEustice2009 II-B].
    """
    rotation = second_from_first[:3, :3]
    x, y, z = -rotation.T @ second_from_first[:3, 3]
    yaw, pitch, roll = Rotation.from_matrix(rotation.T).as_euler("ZYX", degrees=True)
    azimuth, elevation = np.degrees([np.arctan2(y, x), np.arctan2(-z, np.hypot(x, y))])
    return np.array([azimuth, elevation, roll, pitch, yaw])


def study(given: StudyDive) -> StudyResult:
    """Explain the registration of the pair of two legs that has the most matches."""
    dive = read_one_camera(given)
    stages = register_pair(dive, most_matched(dive))
    rows = stage_rows(dive, stages)
    found, true = (
        five_numbers(motion)
        for motion in (stages.motion.second_from_first, true_motion(dive, stages.nodes))
    )
    names = ("azimuth", "elevation", "roll", "pitch", "yaw")
    rows += [
        (f"{name} of the relative pose", f"{ours:.2f}°", f"{there:.2f}° in truth")
        for name, ours, there in zip(names, found, true, strict=True)
    ]
    picture = pair_engine(dive, stages)
    return StudyResult(
        figures=(picture,),
        heads=("stage", "leaves", "of which"),
        rows=tuple(rows),
        compared=compare_counts(dive, stages, found, true),
    )


def most_matched(dive: OneCameraDive) -> tuple[int, int]:
    """Choose the pair of two legs with the most matches before verification."""
    count = {
        (int(a), int(b)): int(n)
        for a, b, n in zip(dive.pairs.first, dive.pairs.second, dive.pairs.putative, strict=True)
    }
    return max(dive.across, key=lambda nodes: (count[nodes], nodes))


def true_motion(dive: OneCameraDive, nodes: tuple[int, int]) -> Array:
    """Compute second_from_first (4, 4) of the true cameras at two nodes."""
    poses = dive.camera.hull_from_camera
    return np.asarray((poses[nodes[1]].inverse() @ poses[nodes[0]]).matrix()[0])


def right_matches(dive: OneCameraDive, stages: PairStages) -> Mask:
    """Test the putative matches (n) against the truth."""
    xy, _ = stages.matched()
    there = dive.pixels(stages.second, stages.putative.second)
    return dive.camera.are_right(stages.nodes, xy, there, RIGHT_PX)


def stage_rows(dive: OneCameraDive, stages: PairStages) -> list[tuple[str, str, str]]:
    """Write a row for each stage: its name, how much it leaves, and how good that is."""
    right = right_matches(dive, stages)
    n, m = len(stages.first), len(stages.second)
    tolerance = VERIFY_PX / dive.worker.rig.focal_px(Camera.TOP)

    def share(of: Mask) -> str:
        """Say which share of some matches is right."""
        return f"{100 * right[of].mean():.1f} % right in truth" if of.any() else ""

    everything = np.ones(len(right), bool)
    rows = [
        ("SIFT features of both images", f"{n:,} and {m:,}", ""),
        (
            "pairs inside the ellipses of navigation",
            f"{len(stages.candidates[0]):,}",
            f"{100 * len(stages.candidates[0]) / (n * m):.2f} % of all pairs",
        ),
        ("putative matches by descriptor", f"{len(right):,}", share(everything)),
    ]
    for model in (stages.both.essential, stages.both.homography):
        within = model.within(tolerance).inlier
        of = "essential matrix" if model.model == "essential" else "homography"
        rows.append(
            (
                f"within {VERIFY_PX:g} px of the {of}",
                f"{within.sum():,}",
                f"criterion {model.criterion:.0f}, {share(within)}",
            )
        )
    rows.append(("model of the smaller criterion", stages.chosen.model, ""))
    rows.append(("on the refined epipolar lines", f"{stages.inlier.sum():,}", share(stages.inlier)))
    return rows


def compare_counts(
    dive: OneCameraDive, stages: PairStages, found: Array, true: Array
) -> tuple[ComparedValue, ...]:
    """Compare what the stages leave of a pair with what the paper says in words.

    found, true: (5,) degrees, as of `five_numbers`.
    """
    right = right_matches(dive, stages)
    inside = len(stages.candidates[0]) / (len(stages.first) * len(stages.second))
    in_words = "stages drawn in the paper, without counts"
    off = (found - true + 180.0) % 360.0 - 180.0
    return (
        ComparedValue(
            what="pairs of features left by navigation",
            unit="%",
            ours=100 * inside,
            note=in_words,
        ),
        ComparedValue(
            what="matches on the refined lines that are right",
            unit="%",
            ours=float(100 * right[stages.inlier].mean()),
            note=f"within {RIGHT_PX:g} px of where their point lies in truth",
        ),
        ComparedValue(
            what="largest error of the five numbers",
            unit="°",
            ours=float(np.abs(off).max()),
            note="azimuth, elevation, roll, pitch, yaw against truth",
        ),
    )


def pair_engine(dive: OneCameraDive, stages: PairStages) -> PublishedFigure:
    """Draw the stages of [KimEustice2009 Fig. 1] on the two images."""
    images = [dive.image(node) for node in stages.nodes]
    width = images[0].shape[1]
    figure, axes = new_canvas(10.0, 5.0 * images[0].shape[0] / width + 0.7, 2, 2)
    panels = [axis for row in axes for axis in row]
    for axis in panels:
        show_side_by_side(axis, images)
    own = dive.camera.model.distort(stages.first.xy)
    other = dive.camera.model.distort(stages.second.xy)
    panels[0].plot(*own.T, ".", color=COLOURS["geva"], markersize=1.2)
    panels[0].plot(other[:, 0] + width, other[:, 1], ".", color=COLOURS["geva"], markersize=1.2)
    panels[0].set_title(f"features: {len(own):,} and {len(other):,}", fontsize=9)
    _draw_ellipses(panels[1], dive, stages, own, width)
    here, there = own[stages.putative.first], other[stages.putative.second]
    right = right_matches(dive, stages)
    for axis, rows, name in (
        (panels[2], np.arange(len(right)), "putative matches"),
        (
            panels[3],
            np.flatnonzero(stages.inlier),
            f"after RANSAC ({stages.chosen.model}) and refinement",
        ),
    ):
        draw_matches(axis, here[rows], there[rows], right[rows], width)
        wrong = int((~right[rows]).sum())
        axis.set_title(f"{name}: {len(rows):,}, {wrong:,} wrong in truth", fontsize=9)
    table = ["first_u,first_v,second_u,second_v,inlier,right"]
    table += [
        f"{a[0]:.2f},{a[1]:.2f},{b[0]:.2f},{b[1]:.2f},{kept:d},{good:d}"
        for a, b, kept, good in zip(here, there, stages.inlier, right, strict=True)
    ]
    caption = (
        f"Registration of images {stages.nodes[0]} and {stages.nodes[1]} of two legs, stage by "
        "stage: features, where navigation expects them (99 % ellipses), putative matches, and "
        "those that the model keeps. Green matches are right in truth, red ones wrong."
    )
    return finish_figure("pair_engine", figure, table, caption)


def _draw_ellipses(
    axis: Axes, dive: OneCameraDive, stages: PairStages, own: Array, width: int
) -> None:
    """Draw some features of the first image, and their search ellipses in the second one.

    own: (n, 2) px of all features of the first image. width: of an image, px.
    """
    known = np.flatnonzero(np.isfinite(stages.mean).all(axis=1))
    pixel = dive.camera.model.distort(stages.mean[known])
    w, h = dive.camera.model.width, dive.camera.model.height
    inside = known[((pixel > 0) & (pixel < [w, h])).all(axis=1)]
    few = inside[spread_rows(len(inside), ELLIPSES)]
    around = np.linspace(0, 2 * np.pi, 33)
    circle = np.sqrt(GATE_CHI2) * np.stack([np.cos(around), np.sin(around)])
    for row in few:
        outline = stages.mean[row] + (np.linalg.cholesky(stages.covariance[row]) @ circle).T
        drawn = dive.camera.model.distort(outline)
        axis.plot(*own[row], "o", color=COLOURS["maxmix"], markersize=2.5)
        axis.plot(drawn[:, 0] + width, drawn[:, 1], color=COLOURS["maxmix"], linewidth=0.9)
    share = len(stages.candidates[0]) / (len(stages.first) * len(stages.second))
    axis.set(xlim=(0, 2 * width), ylim=(h, 0))
    axis.set_title(f"search ellipses: {100 * share:.2f} % of all pairs", fontsize=9)


def show_side_by_side(axis: Axes, images: list[Pixels]) -> None:
    """Show two images of one size beside each other, without ticks."""
    axis.imshow(np.hstack(images), cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axis.grid(False)
    axis.set(xticks=[], yticks=[])


def draw_matches(axis: Axes, here: Array, there: Array, right: Mask, width: int) -> None:
    """Draw some matches as lines from one image to the other, wrong ones red and on top.

    here, there: (n, 2) px in the two images, which lie side by side. right: (n,) which matches are
    right. width: of an image, px.
    """
    from matplotlib.collections import LineCollection

    ends = np.stack([here, there + np.array([width, 0])], axis=1)
    for which, ink in ((right, GREEN), (~right, RED)):
        rows = np.flatnonzero(which)
        few = rows[spread_rows(len(rows), LINES)]
        axis.add_collection(LineCollection(list(ends[few]), colors=ink, linewidths=0.5, alpha=0.8))
    axis.plot([width, width], axis.get_ylim(), color=INK, linewidth=1.0)
