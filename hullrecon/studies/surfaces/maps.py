# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One hull as points, planes and surfaces, and how a surface is meshed [Ozog2016 1.14, 3.2, 3.3].

The surface from dense stereo [Ozog2016 Fig. 1.14d] is the median of the pairs' points in cells of
the chart, not an implicit function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, face_normals
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.meshes.topology import find_shared_edges
from hullrecon.records.surface import Surface
from hullrecon.steps.artifacts import AdjustArtifact, SurfaceArtifact
from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.paths.path_figures import solve_planes
from hullrecon.studies.structures.dense_stereo import (
    dense_points,
    disparities,
    rectified_pair,
    usual_distance,
)
from hullrecon.studies.structures.inspected import InspectedHull, inspect
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.studies.surfaces.by_source import INTERPOLATIONS, RANGE_SIGMA_M
from hullrecon.studies.surfaces.regression import heights_over_plane
from hullrecon.surface.build import GRID_STEP_M, supported_lattice
from hullrecon.surface.from_returns import CadHull, SurfaceInputs, surface_from_survey
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Array

EVERY = 5  # views whose pairs are matched densely
CELL_M = 0.05  # of the chart, in which dense points are merged
LEAST = 5  # dense points of a cell
CLOSE_UP_M = 0.9  # side of the part whose triangles are drawn
OFF_MM = 120.0  # end of the colours


@dataclass(frozen=True, kw_only=True)
class OnChart:
    """Places of the chart with their offset from the CAD model."""

    at: Array  # (n, 2) m
    off_m: Array  # (n,)


def study(given: StudyDive) -> StudyResult:
    """Draw the maps of one dive, and the meshes of its surface."""
    truth = given.truth
    run_to_detect(given.dive, given.run_context)
    hull = inspect(given.dive, truth)
    survey = _survey(given, hull)
    options = cast("SurfaceOptions", given.dive.chain.sections["surface"])
    surfaces = {
        name: surface_from_survey(survey, options, regression, heights_over_plane).surface
        for name, regression in INTERPOLATIONS.items()
    }
    workspace = given.dive.workspace
    surface = SurfaceArtifact(workspace.artifact("surface")).surface
    maps = {
        "(b) landmarks": _on_chart(hull, hull.features),
        "(c) planes of the DVL's patches": _on_chart(hull, _plane_feet(given, hull)),
        "the DVL's surface": OnChart(
            at=hull.chart.to_chart(surface.vertices)[:, :2], off_m=surface.deviation
        ),
    }
    if hull.rig.stereo_mount is not None:
        maps["(d) dense stereo, merged"] = dense_map(hull)
    coarse = _lattice(survey, hull.chart, options)
    split, _ = refine(coarse, options.max_edge_m)
    return StudyResult(figures=(draw_maps(maps), draw_meshes(surfaces, hull.chart, coarse, split)))


def _on_chart(hull: InspectedHull, points: Array) -> OnChart:
    """Place points (n, 3) m of M on the chart, with their distances from the CAD model."""
    return OnChart(
        at=hull.chart.to_chart(points)[:, :2],
        off_m=Scene(hull.cad_model).closest(points).distance,
    )


def _plane_feet(given: StudyDive, hull: InspectedHull) -> Array:
    """Find the points (p, 3) of the tied planes nearest to their anchors, in M.

    A plane is the normal towards the vehicle times its distance, in the vehicle's frame.
    """
    solved = solve_planes(given.dive)
    planes = None if solved is None else solved.planes
    if planes is None:
        return np.zeros((0, 3))
    anchors = hull.track.poses[planes.table.anchor]
    return np.asarray(anchors.translation - anchors.rotation.apply(planes.plane))


def dense_map(hull: InspectedHull) -> OnChart:
    """Merge the dense points of every few pairs in cells of the chart, by their median."""
    distance_m = usual_distance(hull)
    parts = []
    for view in range(0, len(hull.views), EVERY):
        pair = rectified_pair(hull, view)
        points = dense_points(pair, disparities(pair, distance_m), step=8)
        parts.append(hull.views.result_from_camera[view].apply(points))
    points = np.vstack(parts)
    charted = hull.chart.to_chart(points)
    known = np.isfinite(charted).all(axis=1) & (np.abs(charted[:, 2]) < 0.5)
    return merge_cells(charted[known])


def merge_cells(charted: Array, cell_m: float = CELL_M, least: int = LEAST) -> OnChart:
    """Take the median offset of charted points (n, 3), along, girth and offset m, in each cell.

    least: points that a cell needs.
    """
    corner = np.floor(charted[:, :2] / cell_m).astype(np.int64)
    cells, number = np.unique(corner, axis=0, return_inverse=True)
    number = number.reshape(-1)
    order = np.lexsort((charted[:, 2], number))
    count = np.bincount(number)
    start = np.r_[0, np.cumsum(count)[:-1]]
    middle = charted[order[start + count // 2], 2]
    enough = count >= least
    at = np.asarray((cells[enough] + 0.5) * cell_m, float)
    return OnChart(at=at, off_m=middle[enough])


def _survey(given: StudyDive, hull: InspectedHull) -> SurfaceInputs:
    """Collect what the surface of the adjusted returns is made of."""
    solution = AdjustArtifact(given.dive.workspace.artifact("adjust")).solution
    return SurfaceInputs(
        hull=CadHull(mesh=hull.cad_model),
        track=hull.track,
        rig=given.start.rig.with_mounts(solution.mounts),
        returns=given.start.returns,
        range_sigma_m=RANGE_SIGMA_M,
        solution=None,  # no landmarks: the surface is that of the returns alone
        chart=hull.chart,
    )


def _lattice(survey: SurfaceInputs, chart: Chart, options: SurfaceOptions) -> Mesh:
    """Triangulate the chart's grid around the returns, as a surface is begun with."""
    assert survey.returns is not None
    good = ~survey.returns.flagged
    points = survey.rig.dvl_points(survey.returns, survey.track.path).points[good]
    at = chart.to_chart(points)[:, :2]
    return supported_lattice(at[np.isfinite(at).all(axis=1)], GRID_STEP_M, options.reach_m)


def draw_maps(maps: dict[str, OnChart]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 1.14]: each map by its offset from the CAD model."""
    figure, axes = new_canvas(9.6, 6.4, 2, 2, sharex="all", sharey="all")
    panels = [axis for row in axes for axis in row]
    table = ["map,places,median_off_m"]
    for axis, (name, found) in zip(panels, maps.items(), strict=False):
        drawn = axis.scatter(
            found.at[:, 0],
            found.at[:, 1],
            c=1e3 * found.off_m,
            s=30 if len(found.at) < 500 else 3,
            cmap="turbo",
            vmin=-0.3 * OFF_MM,
            vmax=OFF_MM,
            linewidths=0,
            rasterized=True,
        )
        axis.set_title(f"{name}: {len(found.at):,}", fontsize=9)
        axis.set_aspect("equal", adjustable="box")
        table.append(f"{name},{len(found.at)},{np.nanmedian(found.off_m):.5f}")
    for axis in panels[len(maps) :]:
        axis.set_axis_off()
    for axis in axes[-1]:
        axis.set_xlabel("along the hull (m)")
    for row in axes:
        row[0].set_ylabel("girth (m)")
    figure.colorbar(drawn, ax=panels, label="offset from the CAD model (mm)", shrink=0.7)
    words = ", ".join(f"{name} {len(found.at):,}" for name, found in maps.items())
    return finish_figure(
        "maps_of_one_hull", figure, table, f"One hull in several forms, places of each: {words}."
    )


def draw_meshes(
    surfaces: dict[str, Surface], chart: Chart, coarse: Mesh, split: Mesh
) -> PublishedFigure:
    """Draw [Ozog2016 Figs 3.2, 3.3]: both surfaces, and triangles before and after their split."""
    figure, axes = new_canvas(9.6, 7.2, 2, 2)
    for axis, (name, surface) in zip(axes[0], surfaces.items(), strict=True):
        _draw_relief(axis, surface, chart, f"{name}: {roughness_deg(surface.mesh()):.1f}°")
    for axis, mesh, name in (
        (axes[1][0], coarse, "triangles of the grid"),
        (axes[1][1], split, "split at their edges' midpoints"),
    ):
        _draw_triangles(axis, mesh, f"{name}: edges to {longest_edge_m(mesh):.2f} m")
    table = ["surface,turn_between_faces_deg,vertices"]
    table += [
        f"{name},{roughness_deg(s.mesh()):.3f},{len(s.vertices)}" for name, s in surfaces.items()
    ]
    rough = {name: roughness_deg(surface.mesh()) for name, surface in surfaces.items()}
    return finish_figure(
        "surface_meshes",
        figure,
        table,
        f"Neighbouring faces of the DVL's surface turn by {rough['linear']:.1f}° where it is "
        f"interpolated and by {rough['GP']:.1f}° by the Gaussian process (rms). Triangles are "
        f"split until no edge on the chart is longer than {longest_edge_m(split):.2f} m.",
        (
            ComparedValue(
                what="longest edge of the surface's triangles, on the chart",
                unit="m",
                printed=0.1,
                ours=longest_edge_m(split),
            ),
            ComparedValue(
                what="turn between neighbouring faces, GP over linear",
                ours=rough["GP"] / rough["linear"],
                note='printed "a much smoother reconstruction"',
            ),
        ),
    )


def longest_edge_m(mesh: Mesh) -> float:
    """Measure the longest edge of a mesh's triangles."""
    corners = mesh.vertices[mesh.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())


def roughness_deg(mesh: Mesh) -> float:
    """Measure the angle between the normals of neighbouring faces, rms."""
    shared = find_shared_edges(mesh.faces)
    normals = face_normals(mesh)
    cosine = np.einsum("ni,ni->n", normals[shared.first], normals[shared.second])
    return float(np.degrees(np.sqrt(np.mean(np.arccos(np.clip(cosine, -1, 1)) ** 2))))


def _draw_relief(axis: Axes, surface: Surface, chart: Chart, title: str) -> None:
    """Draw a surface on the chart, lit from along the hull.

    title: ends with the rms angle, to which "between faces" is added.
    """
    at = chart.to_chart(surface.vertices)
    normals = face_normals(surface.mesh())
    # grazing light along the hull, so that what is not smooth shows
    light = normals @ (normals.mean(axis=0) + np.array([1.5, 0.0, 0.0]))
    low, high = np.percentile(light, [2, 98])
    axis.tripcolor(
        at[:, 0], at[:, 1], surface.faces, facecolors=light, cmap="gray", vmin=low, vmax=high
    )
    axis.set_title(f"{title} between faces", fontsize=9)
    axis.set(xlabel="along the hull (m)", ylabel="girth (m)", aspect="equal", adjustable="box")


def _draw_triangles(axis: Axes, mesh: Mesh, title: str) -> None:
    """Draw the triangles of a mesh around its middle."""
    middle = np.median(mesh.vertices, axis=0)
    axis.triplot(
        mesh.vertices[:, 0], mesh.vertices[:, 1], mesh.faces, color=COLOURS["maxmix"], linewidth=0.8
    )
    axis.plot(mesh.vertices[:, 0], mesh.vertices[:, 1], ".", color=INK, markersize=3)
    half = 0.5 * CLOSE_UP_M
    axis.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        aspect="equal",
        adjustable="box",
    )
    axis.set_title(title, fontsize=9)
    axis.set(xlabel="along the hull (m)", ylabel="girth (m)")
