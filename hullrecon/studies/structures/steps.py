# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Algorithms 4 and 5 of [Ozog2016], a step a picture (Figs 4.8, 4.9)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes

from hullrecon.detection.as_found.shapes import (
    ALPHA_RADIUS_M,
    alpha_shape,
    dbscan,
    find_shape_hits,
)
from hullrecon.detection.options import MIN_CLUSTER_POINTS, MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import rows_in_image
from hullrecon.evaluation.truth import TrueStructure
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.methods.figures import tallest
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.structures.inspected import InspectedHull, inspect
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.typing import Array, Ints, Ints32, Pixels

AROUND_M = 0.4  # where bare hull gives its offset from the CAD model


@dataclass(frozen=True, kw_only=True)
class ShapesOfView:
    """What Algorithm 4 makes of one image."""

    image: Pixels
    pixel: Array  # (n, 2) of the features in it
    height: Array  # (n,) m
    in_camera: Array  # (n, 3) m
    off: Ints  # rows of the features that stand off the hull
    cluster: Ints  # (len(off),) -1 for noise
    faces: tuple[Ints32, ...]  # a cluster's triangles, corners among its members

    def members(self, number: int) -> Ints:
        """List the features of a cluster."""
        return np.asarray(self.off[self.cluster == number])


@dataclass(frozen=True, kw_only=True)
class FusedVertex:
    """What Algorithm 5 makes of one vertex of the CAD model."""

    vertex: Array  # (3,)
    normal: Array  # (3,) outward
    centers: Array  # (k, 3) of the cameras whose rays to it met a shape
    met: Array  # (k, 3) where they did
    hull_m: float  # how far the hull around it lies over the CAD model

    @property
    def heights_m(self) -> Array:
        """How high (k,) each meeting lies over the CAD model."""
        return np.asarray((self.met - self.vertex) @ self.normal)

    @property
    def height_m(self) -> float:
        """Height over the hull at which the vertex ends, NaN where no ray met a shape."""
        return float(self.heights_m.mean()) - self.hull_m if len(self.met) else float("nan")


def study(given: StudyDive) -> StudyResult:
    """Follow one image through Algorithm 4, and one vertex through Algorithm 5."""
    truth = given.truth
    run_to_detect(given.dive, given.run_context)
    hull = inspect(given.dive, truth)
    structure = tallest(truth)
    assert structure is not None
    foot = np.array(structure.center) - structure.height * np.array(structure.normal)
    foot = hull.truth_from_result.inverse().apply(foot[None])[0]
    shapes = shapes_of_view(hull, best_view(hull, foot))
    fused = fuse_vertex(hull, foot)
    return StudyResult(figures=(draw_shapes(shapes), draw_fusion(fused, structure, hull)))


def best_view(hull: InspectedHull, point: Array) -> int:
    """Choose the view that has a point (3,) nearest to its middle."""
    at = hull.views.result_from_camera.inverse()
    camera = hull.views.camera
    away = [
        np.hypot(*(camera.project(at[view].apply(point[None]))[0] - [camera.cx, camera.cy]))
        for view in range(len(hull.views))
    ]
    return int(np.nanargmin(away))


def shapes_of_view(hull: InspectedHull, view: int) -> ShapesOfView:
    """Make the shapes of one view [Ozog2016 Algorithm 4]."""
    pose = hull.views.result_from_camera[view]
    rows = rows_in_image(hull.views, view, hull.features, np.arange(len(hull.features)))
    near = np.linalg.norm(hull.features[rows] - pose.translation[0], axis=1)
    rows = rows[near < hull.views.farthest_m]
    in_camera, height = pose.inverse().apply(hull.features[rows]), hull.height[rows]
    off = np.flatnonzero(height > MIN_OFFSET_M)
    cluster = dbscan(
        np.column_stack([in_camera[off, :2], height[off]]),
        DetectOptions().cluster_reach_m,
        MIN_CLUSTER_POINTS,
    )
    node = int(hull.views.node[view])
    image = hull.images[Camera.TOP].read(int(hull.track.image[node, Camera.TOP.column]))
    assert image is not None  # views are of usable images
    return ShapesOfView(
        image=image,
        pixel=hull.views.camera.project(in_camera),
        height=height,
        in_camera=in_camera,
        off=off,
        cluster=cluster,
        faces=tuple(
            alpha_shape(in_camera[off[cluster == k], :2], ALPHA_RADIUS_M)
            for k in range(int(cluster.max(initial=-1)) + 1)
        ),
    )


def fuse_vertex(hull: InspectedHull, point: Array) -> FusedVertex:
    """Intersect the shapes of all views with the rays to the CAD model below a point (3,)."""
    near = Scene(hull.cad_model).closest(point[None])
    bare = np.abs(hull.height) < MIN_OFFSET_M
    around = hull.features[bare & (np.linalg.norm(hull.features - near.foot, axis=1) < AROUND_M)]
    centers, met = [], []
    for k in range(len(hull.views)):
        view = replace(
            hull.views,
            result_from_camera=hull.views.result_from_camera[[k]],
            node=hull.views.node[[k]],
            name=hull.views.name[k : k + 1],
        )
        hits = find_shape_hits(view, hull.features, hull.height, near.foot, DetectOptions())
        for _, points in hits:
            met += list(points)
            centers += [view.result_from_camera.translation[0]] * len(points)
    return FusedVertex(
        vertex=near.foot[0],
        normal=near.normal[0],
        centers=np.array(centers).reshape(-1, 3),
        met=np.array(met).reshape(-1, 3),
        hull_m=float(np.median((around - near.foot[0]) @ near.normal[0])),
    )


def draw_shapes(shapes: ShapesOfView) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.8]: image, heights, clusters, and their meshes over the image."""
    figure, axes = new_canvas(10.4, 7.6, 2, 2)
    (raw, heights), (clusters, meshes) = axes
    for axis in (raw, heights, meshes):
        axis.imshow(shapes.image)
        axis.grid(False)
        axis.set(xticks=[], yticks=[])
    raw.set_title("(a) an image", fontsize=9)
    drawn = heights.scatter(
        shapes.pixel[:, 0],
        shapes.pixel[:, 1],
        c=100 * shapes.height,
        s=6,
        cmap="turbo",
        vmin=-2,
        vmax=14,
        linewidths=0,
    )
    heights.set_title("(b) features by their height over the hull", fontsize=9)
    figure.colorbar(drawn, ax=heights, label="height (cm)", shrink=0.8)
    _draw_clusters(clusters, shapes)
    _draw_meshes(meshes, shapes)
    count = len(shapes.faces)
    table = ["u_px,v_px,height_m,cluster"]
    number = np.full(len(shapes.pixel), -1)
    number[shapes.off] = shapes.cluster
    table += [
        f"{u:.1f},{v:.1f},{h:.4f},{k}"
        for (u, v), h, k in zip(shapes.pixel, shapes.height, number, strict=True)
    ]
    return finish_figure(
        "shapes_of_view",
        figure,
        table,
        f"Of {len(shapes.pixel):,} features in an image {len(shapes.off)} stand off the hull by "
        f"more than {100 * MIN_OFFSET_M:g} cm; they form {count} shape{'' if count == 1 else 's'}.",
        (
            ComparedValue(
                what="shapes in one image",
                printed=3.0,
                ours=float(count),
                note="of another scene: as many as stand there",
            ),
        ),
    )


def _draw_clusters(axis: Axes, shapes: ShapesOfView) -> None:
    """Draw the height of a view's features across the image, coloured by cluster."""
    import matplotlib as mpl

    noise = shapes.off[shapes.cluster < 0]
    axis.scatter(
        shapes.in_camera[noise, 0], 100 * shapes.height[noise], s=9, color=INK, marker="x",
        linewidths=0.8, label="noise",
    )  # fmt: skip
    palette = mpl.colormaps["tab10"]
    for k in range(len(shapes.faces)):
        rows = shapes.members(k)
        axis.scatter(
            shapes.in_camera[rows, 0], 100 * shapes.height[rows], s=9, color=palette(k % 10),
            linewidths=0, label=f"cluster {k + 1}: {len(rows)} features",
        )  # fmt: skip
    axis.axhline(100 * MIN_OFFSET_M, color=RED, linestyle="--", linewidth=1.0)
    axis.set(xlabel="across the image (m)", ylabel="height (cm)")
    axis.set_title("(c) clusters of (f_x, f_y, d)", fontsize=9)
    axis.legend(fontsize=8, frameon=False)


def _draw_meshes(axis: Axes, shapes: ShapesOfView) -> None:
    """Draw the alpha shapes of the clusters over the image."""
    for k, faces in enumerate(shapes.faces):
        if len(faces):
            axis.triplot(*shapes.pixel[shapes.members(k)].T, faces, color="white", linewidth=0.8)
    axis.set(xlim=(0, shapes.image.shape[1]), ylim=(shapes.image.shape[0], 0))
    axis.set_title("(d) their alpha shapes", fontsize=9)


def draw_fusion(
    fused: FusedVertex, structure: TrueStructure, hull: InspectedHull
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.9]: rays to one vertex, where they meet shapes, and their mean."""
    figure, axes = new_canvas(9.6, 3.8, 1, 2)
    side, views = axes[0]
    along = np.array([1.0, 0.0, 0.0]) - fused.normal * fused.normal[0]
    along /= np.linalg.norm(along)
    frame = np.stack([along, fused.normal])
    _draw_rays(side, fused, frame, hull)
    heights = 100 * fused.heights_m
    number = np.arange(1, len(heights) + 1)
    views.plot(number, heights, "o", color=COLOURS["maxmix"], label="each view")
    views.plot(number, np.cumsum(heights) / number, "-", color=INK, label="moving average (4.15)")
    views.axhline(
        100 * (structure.height + fused.hull_m),
        color=GREEN,
        linestyle="--",
        label="the structure's top",
    )
    views.set(
        xlabel="view",
        ylabel="height over the CAD model (cm)",
        ylim=(0, max(130 * structure.height, float(heights.max(initial=0.0)) + 1)),
    )
    views.legend(fontsize=8, frameon=False, loc="lower right")
    table = [
        "view,height_m",
        *(f"{k},{0.01 * h:.5f}" for k, h in zip(number, heights, strict=True)),
    ]
    return finish_figure(
        "fused_vertex",
        figure,
        table,
        f"Rays of {len(heights)} views to one vertex below the {structure.kind} meet its shapes at "
        f"{100 * fused.height_m:.1f} cm over the hull in the mean; it is "
        f"{100 * structure.height:.0f} cm high.",
        (
            ComparedValue(
                what="vertex moved by Algorithm 5 over the true height",
                ours=fused.height_m / structure.height,
                note="printed as a picture alone",
            ),
        ),
    )


def _draw_rays(axis: Axes, fused: FusedVertex, frame: Array, hull: InspectedHull) -> None:
    """Draw the rays to a vertex, where they meet shapes, and where the vertex is moved.

    frame: unit vectors (2, 3) in M, along the hull and off it, of the plane that is drawn.
    """

    def flat(points: Array) -> Array:
        """Project points (n, 3) m of M into the plane (n, 2) m, with the vertex as origin."""
        return np.asarray((points - fused.vertex) @ frame.T)

    near = np.linalg.norm(hull.features - fused.vertex, axis=1) < 0.5
    slab = near & (np.abs((hull.features - fused.vertex) @ np.cross(*frame)) < 0.06)
    across, up = 100 * flat(hull.features[slab]).T
    axis.scatter(across, up, s=8, color="#8a949e", linewidths=0, label="features")
    for center, met in zip(flat(fused.centers), flat(fused.met), strict=True):
        way = center / np.linalg.norm(center)
        axis.plot([0, 60 * way[0]], [0, 60 * way[1]], color=COLOURS["geva"], linewidth=0.7)
        axis.plot(*(100 * met), "o", color=COLOURS["maxmix"], markersize=4)
    axis.plot(0, 0, "s", color=INK, label="vertex of the CAD model")
    mean = 100 * flat(fused.met.mean(axis=0)[None])[0] if len(fused.met) else np.zeros(2)
    axis.plot(*mean, "D", color=RED, markersize=7, label="where it is moved")
    axis.axhline(0, color=INK, linewidth=1.0)
    axis.set(
        xlabel="along the hull (cm)", ylabel="off the hull (cm)", xlim=(-40, 40), ylim=(-4, 30)
    )
    axis.legend(fontsize=8, frameon=False, loc="upper left")
