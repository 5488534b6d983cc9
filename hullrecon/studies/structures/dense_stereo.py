# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Dense stereo beside landmarks: rectified pair, range image, heights [Ozog2016 D.2, Fig. 4.15].

OpenCV's semi-global matching [Hirschmueller2008] on single pairs. The product does not use it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.errors import InputError
from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.methods.figures import tallest
from hullrecon.studies.methods.method_figures import height_over_steel
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.structures.inspected import InspectedHull, inspect
from hullrecon.studies.structures.steps import best_view
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.typing import Array, Floats32, Pixels
from hullrecon.vision.stereo.matching import Rectification, rectify

BLOCK_PX = 7  # side of the blocks that are compared
NEAR, FAR = 0.5, 2.0  # of the usual distance, between which disparities are sought
MATCH_RATIO = 0.7  # of the best to the second descriptor distance
PRINTED_BASELINE_MM = 77.6
PRINTED_FEATURES_M, PRINTED_DENSE_M = (0.06, 0.18), (0.10, 0.20)  # [Ozog2016 4.4.2.1]
LINES = 9  # drawn over a pair


@dataclass(frozen=True, kw_only=True)
class RectifiedPair:
    """The images (h, w, 3) or (h, w) of a node's two cameras, as they are and turned."""

    raw: tuple[Pixels, Pixels]  # top, bottom
    turned: tuple[Pixels, Pixels]
    camera: CameraModel  # of the turned images, without distortion
    rectification: Rectification


@dataclass(frozen=True, kw_only=True)
class StructureHeights:
    """The height of one structure over the hull around it, m."""

    kind: str
    true: float  # median at the points of dense stereo
    features: Array  # (n,) of landmarks on top of it
    dense: Array  # (m,) of dense stereo


def study(given: StudyDive) -> StudyResult:
    """Rectify and match the pairs that see structures best. Raises InputError with one camera."""
    truth = given.truth
    run_to_detect(given.dive, given.run_context)
    hull = inspect(given.dive, truth)
    if hull.rig.stereo_mount is None:
        raise InputError(
            "dense stereo needs two cameras",
            where=str(given.dive.workspace.root),
            remedy="take a dive with two cameras",
        )
    structure = tallest(truth)
    assert structure is not None
    pair = rectified_pair(hull, view_of(hull, structure))
    disparity = disparities(pair, usual_distance(hull))
    heights = [_heights(hull, truth, s) for s in truth.structures()]
    growth = next((h for h in heights if h.kind == "lump"), heights[0])
    return StudyResult(
        figures=(
            draw_pair(pair),
            draw_ranges(pair, disparity),
            draw_heights(heights, growth),
        )
    )


def view_of(hull: InspectedHull, structure: TrueStructure) -> int:
    """Choose the view that has a structure nearest to its middle."""
    at = hull.truth_from_result.inverse().apply(np.array(structure.center)[None])[0]
    return best_view(hull, at)


def usual_distance(hull: InspectedHull) -> float:
    """Measure the median distance of landmarks from the nearest camera, m."""
    from hullrecon.geometry.neighbours import nearest

    centers = hull.views.result_from_camera.translation
    return float(np.median(nearest(centers, hull.features[::10], 1)[0]))


def rectified_pair(hull: InspectedHull, view: int) -> RectifiedPair:
    """Turn the images of a view's node so that epipolar lines are its columns."""
    node, mount = int(hull.views.node[view]), hull.rig.stereo_mount
    assert mount is not None
    rectification = rectify(mount)
    raw = []
    for camera in Camera:
        image = hull.images[camera].read(int(hull.track.image[node, camera.column]))
        assert image is not None
        raw.append(image)
    top, bottom = hull.rig.model(Camera.TOP), hull.rig.model(Camera.BOTTOM)
    level = CameraModel(
        width=top.width, height=top.height, fx=top.fx, fy=top.fx, cx=top.cx, cy=top.cy
    )
    turned = tuple(
        turn_image(image, camera, rotation, level)
        for image, camera, rotation in zip(
            raw,
            (top, bottom),
            (rectification.rotation_top, rectification.rotation_bottom),
            strict=True,
        )
    )
    return RectifiedPair(
        raw=(raw[0], raw[1]),
        turned=(turned[0], turned[1]),
        camera=level,
        rectification=rectification,
    )


def turn_image(image: Pixels, camera: CameraModel, rotation: Array, level: CameraModel) -> Pixels:
    """Resample an image as a turned camera without distortion sees it.

    Parameters
    ----------
    image, camera
        The image, and the camera that took it.
    rotation
        (3, 3) turned from camera.
    level
        The turned camera.
    """
    import cv2

    u, v = np.meshgrid(np.arange(level.width), np.arange(level.height))
    ideal = np.column_stack(
        [(u.ravel() - level.cx) / level.fx, (v.ravel() - level.cy) / level.fy, np.ones(u.size)]
    )
    pixel = camera.project(ideal @ rotation).reshape(level.height, level.width, 2)
    return np.asarray(cv2.remap(image, pixel.astype(np.float32), None, cv2.INTER_LINEAR), np.uint8)


def disparities(pair: RectifiedPair, distance_m: float) -> Floats32:
    """Match the turned pair densely: v_T - v_B (h, w) px, NaN where it is not sure.

    distance_m: usual distance of the hull, about which distances are searched.
    """
    import cv2

    most = pair.camera.fx * pair.rectification.baseline_m / (NEAR * distance_m)
    count = 16 * int(np.ceil(most / 16))
    matcher = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=count,
        blockSize=BLOCK_PX,
        P1=8 * BLOCK_PX**2,
        P2=32 * BLOCK_PX**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=2,
    )
    # the matcher has its pairs side by side, ours are one above the other
    # and it matches nothing within the largest disparity of their edge, hence the border
    top, bottom = (
        cv2.copyMakeBorder(_gray(image).T, 0, 0, count, 0, cv2.BORDER_REPLICATE)
        for image in pair.turned
    )
    found = matcher.compute(top, bottom)[:, count:].T.astype(np.float32) / 16
    least = pair.camera.fx * pair.rectification.baseline_m / (FAR * distance_m)
    return np.where(found > least, found, np.float32(np.nan))


def ranges(pair: RectifiedPair, disparity: Floats32) -> Array:
    """Convert disparities to depths (h, w) m: z = q34 / ((v_T - v_B) q43) [Ozog2016 D.2.2].

    q34 is the focal length, q43 one over the baseline: the print calls it a scale.
    """
    return np.asarray(pair.camera.fx * pair.rectification.baseline_m / disparity, float)


def dense_points(pair: RectifiedPair, disparity: Floats32, step: int = 2) -> Array:
    """Lift every `step`-th pixel of disparities (h, w) px to a point (n, 3) m in the top camera."""
    depth = ranges(pair, disparity)[::step, ::step]
    v, u = np.nonzero(np.isfinite(depth))
    camera, z = pair.camera, depth[v, u]
    turned = np.column_stack(
        [(step * u - camera.cx) / camera.fx * z, (step * v - camera.cy) / camera.fy * z, z]
    )
    return np.asarray(turned @ pair.rectification.rotation_top)


def column_gaps(images: tuple[Pixels, Pixels]) -> Array:
    """Measure by how many columns (n,) px matched features of a pair's images differ.

    Zero in a rectified pair, whose epipolar lines are columns.
    """
    import cv2

    sift = cv2.SIFT.create()
    (first, a), (second, b) = (sift.detectAndCompute(_gray(image), None) for image in images)
    pairs = cv2.BFMatcher().knnMatch(a, b, k=2)
    sure = [m for m, n in pairs if m.distance < MATCH_RATIO * n.distance]
    return np.array([second[m.trainIdx].pt[0] - first[m.queryIdx].pt[0] for m in sure])


def draw_pair(pair: RectifiedPair) -> PublishedFigure:
    """Draw [Ozog2016 Fig. D.2]: the pair as it is and turned, with vertical lines."""
    figure, axes = new_canvas(8.4, 6.8, 2, 2)
    gaps = [np.abs(column_gaps(images)) for images in (pair.raw, pair.turned)]
    for column, (images, name, gap) in enumerate(
        zip((pair.raw, pair.turned), ("calibrated", "rectified"), gaps, strict=True)
    ):
        for row, (image, word) in enumerate(zip(images, ("top", "bottom"), strict=True)):
            _draw_lined(axes[row][column], image, f"{name}, {word}: {np.median(gap):.2f} px")
    table = ["pair,matches,median_gap_px"]
    table += [
        f"{name},{len(gap)},{np.median(gap):.4f}"
        for name, gap in zip(("calibrated", "rectified"), gaps, strict=True)
    ]
    return finish_figure(
        "rectified_pair",
        figure,
        table,
        f"Matched features differ by {np.median(gaps[0]):.1f} columns in the images as they are, "
        f"and by {np.median(gaps[1]):.2f} once these are turned (medians).",
        (
            ComparedValue(
                what="baseline of the stereo rig",
                unit="mm",
                printed=PRINTED_BASELINE_MM,
                ours=1e3 * pair.rectification.baseline_m,
                note="another rig",
            ),
            ComparedValue(
                what="columns by which features of a rectified pair differ",
                unit="px",
                printed=0.0,
                ours=float(np.median(gaps[1])),
                note='printed "on the same line"; ours holds the features\' noise',
            ),
        ),
    )


def _draw_lined(axis: Axes, image: Pixels, title: str) -> None:
    """Draw an image with vertical lines, along which a rectified pair shows the same points."""
    axis.imshow(image)
    for at in np.linspace(0, image.shape[1], LINES + 2)[1:-1]:
        axis.axvline(at, color="white", linewidth=0.6)
    axis.grid(False)
    axis.set(xticks=[], yticks=[])
    axis.set_title(title, fontsize=9)


def draw_ranges(pair: RectifiedPair, disparity: Floats32) -> PublishedFigure:
    """Draw [Ozog2016 Fig. D.3]: disparity and range image."""
    figure, axes = new_canvas(9.6, 3.6, 1, 2)
    depth = ranges(pair, disparity)
    known = np.isfinite(depth)
    for axis, values, label in (
        (axes[0][0], disparity, "disparity (px)"),
        (axes[0][1], depth, "range (m)"),
    ):
        low, high = np.nanpercentile(values, [1, 99])
        drawn = axis.imshow(values, cmap="turbo", vmin=low, vmax=high, interpolation="none")
        axis.grid(False)
        axis.set(xticks=[], yticks=[])
        figure.colorbar(drawn, ax=axis, label=label, shrink=0.8)
    table = ["row_px,column_px,disparity_px,range_m"]
    rows, columns = np.nonzero(known[::16, ::16])
    table += [
        f"{16 * r},{16 * c},{disparity[16 * r, 16 * c]:.3f},{depth[16 * r, 16 * c]:.4f}"
        for r, c in zip(rows, columns, strict=True)
    ]
    return finish_figure(
        "range_image",
        figure,
        table,
        f"Disparity and range of a rectified pair; {100 * known.mean():.0f} % of the pixels "
        f"matched, at {np.nanmedian(depth):.2f} m in the median.",
    )


def _heights(hull: InspectedHull, truth: Truth, structure: TrueStructure) -> StructureHeights:
    """Measure the heights of points on a structure by features and by dense stereo."""
    view = view_of(hull, structure)
    pair = rectified_pair(hull, view)
    in_camera = dense_points(pair, disparities(pair, usual_distance(hull)))
    in_hull = hull.views.result_from_camera[view].apply(in_camera)
    by_features, _ = height_over_steel(hull.features, structure, truth, hull.truth_from_result)
    by_dense, true_of_dense = height_over_steel(in_hull, structure, truth, hull.truth_from_result)
    return StructureHeights(
        kind=structure.kind,
        true=float(np.median(true_of_dense)) if len(true_of_dense) else structure.height,
        features=by_features,
        dense=by_dense,
    )


def draw_heights(heights: list[StructureHeights], growth: StructureHeights) -> PublishedFigure:
    """Draw what [Ozog2016 Fig. 4.15] compares: heights by features and by dense stereo."""
    figure, axes = new_canvas(7.8, 3.6)
    axis = axes[0][0]
    table = ["structure,true_m,features,features_m,dense_points,dense_m"]
    for k, h in enumerate(heights):
        axis.hlines(100 * h.true, k - 0.4, k + 0.4, color=GREEN, linewidth=2)
        for shift, values, ink in ((-0.15, h.features, COLOURS["maxmix"]), (0.15, h.dense, INK)):
            if len(values):
                low, middle, high = 100 * np.percentile(values, [5, 50, 95])
                axis.vlines(k + shift, low, high, color=ink, linewidth=1.4)
                axis.plot(k + shift, middle, "o", color=ink)
        table.append(
            f"{h.kind},{h.true:.4f},{len(h.features)},{_median(h.features):.4f},"
            f"{len(h.dense)},{_median(h.dense):.4f}"
        )
    for ink, name in ((COLOURS["maxmix"], "landmarks"), (INK, "dense stereo, one pair")):
        axis.plot([], [], "o-", color=ink, label=f"{name}: median, 5 to 95 %")
    axis.plot([], [], "-", color=GREEN, linewidth=2, label="true, on top of it")
    axis.set_xticks(range(len(heights)), [h.kind for h in heights])
    axis.set(ylabel="height over the hull (cm)", ylim=(0, None))
    axis.legend(fontsize=8, frameon=False, loc="lower center", ncols=3)
    worst = max(abs(_median(h.dense) - h.true) for h in heights if len(h.dense))
    return finish_figure(
        "dense_heights",
        figure,
        table,
        f"Heights of {len(heights)} structures by dense stereo of one pair lie within "
        f"{1e3 * worst:.0f} mm of the true ones, in the median of their points.",
        _compare(growth),
    )


def _compare(growth: StructureHeights) -> tuple[ComparedValue, ...]:
    """Compare the span of heights of growth with the one printed."""
    note = "growth of another shape; ours is the middle of a lump"
    return tuple(
        ComparedValue(
            what=f"height of growth by {name}, {word}",
            unit="m",
            printed=printed[end],
            ours=float(np.percentile(values, (5, 95)[end])) if len(values) else None,
            note=note,
        )
        for name, printed, values in (
            ("features", PRINTED_FEATURES_M, growth.features),
            ("dense stereo", PRINTED_DENSE_M, growth.dense),
        )
        for end, word in enumerate(("least", "most"))
    )


def _median(values: Array) -> float:
    return float(np.median(values)) if len(values) else float("nan")


def _gray(image: Pixels) -> Pixels:
    import cv2

    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
