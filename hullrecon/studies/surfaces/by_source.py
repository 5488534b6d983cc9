# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's surface by the poses' source and by interpolation [Ozog2016 Figs 3.8 to 3.10]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable

from hullrecon.evaluation.trajectory import rms
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.records.surface import Surface
from hullrecon.steps.artifacts import SurfaceArtifact
from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.studies.surfaces.pose_sources import (
    ADJUSTED,
    PLANES,
    WITHOUT_HULL,
    PlacedPath,
    PlacedPaths,
    place_paths,
)
from hullrecon.studies.surfaces.regression import by_triangles, heights_over_plane
from hullrecon.surface.build import gaussian_process
from hullrecon.surface.from_returns import CadHull, SurfaceInputs, surface_from_survey
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Mask

INTERPOLATIONS = {"linear": by_triangles, "GP": gaussian_process}
RANGE_SIGMA_M = 0.01
TOP_SHARE = 0.1  # of the surface's girth: what lies along the waterline
MOST_POINTS = 4000  # drawn


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """How far a surface lies from the CAD model and from the true hull, m."""

    rms: float  # from the CAD model
    p95: float
    rms_top: float  # of the part along the waterline
    rms_rest: float
    rms_true: float  # from the steel as built


def study(given: StudyDive) -> StudyResult:
    """Make the surface of every source by both interpolations, and hold it to the CAD model."""
    placed = place_paths(given)
    chart = SurfaceArtifact(given.dive.workspace.artifact("surface")).chart
    options = cast("SurfaceOptions", given.dive.chain.sections["surface"])
    surfaces = {
        (source, name): make_surface(path, placed, chart, options, name)
        for source, path in placed.paths.items()
        for name in INTERPOLATIONS
    }
    found = {key: measure(surface, chart, given.truth) for key, surface in surfaces.items()}
    return StudyResult(
        figures=(
            draw_registration(placed.paths[WITHOUT_HULL], placed),
            draw_deviations(surfaces, found, chart),
        ),
        heads=("poses", "surface", "rms, mm", "95 %, mm", "waterline", "rest", "to the steel"),
        rows=tuple(
            (*key, *(f"{1e3 * v:.1f}" for v in (d.rms, d.p95, d.rms_top, d.rms_rest, d.rms_true)))
            for key, d in found.items()
        ),
    )


def make_surface(
    path: PlacedPath, placed: PlacedPaths, chart: Chart, options: SurfaceOptions, name: str
) -> Surface:
    """Make the surface of a path's returns, over a plane: the CAD model does not enter it."""
    survey = SurfaceInputs(
        hull=CadHull(mesh=placed.cad_model),
        track=path.track,
        rig=path.rig,
        returns=placed.returns,
        range_sigma_m=RANGE_SIGMA_M,
        solution=None,
        chart=chart,
    )
    return surface_from_survey(survey, options, INTERPOLATIONS[name], heights_over_plane).surface


def measure(surface: Surface, chart: Chart, truth: Truth) -> Deviation:
    """Measure how far a surface lies from the CAD model and from the steel as built.

    Only vertices count that returns support, and at which the truth is known.
    """
    known = _known(surface, truth)
    at, off = surface.vertices[known], surface.deviation[known]
    girth = chart.to_chart(at)[:, 1]
    top = girth > np.quantile(girth, 1 - TOP_SHARE)
    steel = truth.built.closest(at).distance
    return Deviation(
        rms=rms(off),
        p95=float(np.percentile(np.abs(off), 95)),
        rms_top=rms(off[top]),
        rms_rest=rms(off[~top]),
        rms_true=rms(steel),
    )


def _known(surface: Surface, truth: Truth) -> Mask:
    """Mark the vertices (n,) that returns support and that lie on the surveyed hull."""
    known = truth.near(surface.vertices, 0.25) & (surface.support >= 1)
    known &= ~truth.on_rim(truth.built.closest(surface.vertices).foot)
    return np.asarray(known & np.isfinite(surface.deviation))


def draw_registration(path: PlacedPath, placed: PlacedPaths) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 3.8]: bundle adjusted returns on the CAD model, before and after."""
    figure, axes = new_canvas(10.4, 4.4, 1, 2)
    low, high = path.points.min(axis=0) - 0.5, path.points.max(axis=0) + 0.5
    mesh = placed.cad_model.vertices
    near = mesh[((mesh > low) & (mesh < high)).all(axis=1)]
    scene = Scene(placed.cad_model)
    off = [np.abs(scene.closest(points).distance) for points in (path.before, path.points)]
    few = slice(None, None, max(1, len(path.points) // MOST_POINTS))
    for axis, (a, b), names in zip(
        axes[0],
        ((0, 2), (1, 2)),
        (("along the hull (m)", "up (m)"), ("across it (m)", "up (m)")),
        strict=True,
    ):
        axis.scatter(
            near[:, a], near[:, b], s=2, color=COLOURS["maxmix"], linewidths=0, label="CAD model"
        )
        for points, ink, word, distance in zip(
            (path.before, path.points), (INK, RED), ("before", "registered"), off, strict=True
        ):
            axis.scatter(
                points[few, a], points[few, b], s=4, color=ink, linewidths=0,
                label=f"returns, {word}: {1e3 * np.mean(distance):.0f} mm off",
            )  # fmt: skip
        axis.set(xlabel=names[0], ylabel=names[1], aspect="equal", adjustable="datalim")
    axes[0][1].legend(fontsize=8, frameon=True, edgecolor="none", loc="lower left", markerscale=2)
    table = ["when,returns,mean_m,p95_m"]
    table += [
        f"{word},{len(d)},{np.mean(d):.5f},{np.percentile(d, 95):.5f}"
        for word, d in zip(("before", "registered"), off, strict=True)
    ]
    words = f"{1e3 * np.mean(off[0]):.0f} mm before, {1e3 * np.mean(off[1]):.0f} mm after"
    moved = np.abs(np.mean(path.points - path.before, axis=0))
    return finish_figure(
        "registration",
        figure,
        table,
        f"Returns on the bundle adjusted path lie off the CAD model by {words} the registration, "
        f"in the mean. From where the hull truly lies it moves them by {1e3 * moved[0]:.0f} mm "
        f"along and {1e3 * np.linalg.norm(moved[1:]):.0f} mm across the hull.",
        (
            ComparedValue(
                what="mean distance of bundle adjusted returns from the CAD model, registered",
                unit="mm",
                ours=1e3 * float(np.mean(off[1])),
                note="Fig. 3.8, printed as a picture alone",
            ),
        ),
    )


def draw_deviations(
    surfaces: Mapping[tuple[str, str], Surface],
    found: Mapping[tuple[str, str], Deviation],
    chart: Chart,
) -> PublishedFigure:
    """Draw [Ozog2016 Figs 3.9, 3.10]: each surface's deviation from the CAD model."""
    sources = list(dict.fromkeys(source for source, _ in surfaces))
    figure, axes = new_canvas(7.6, 2.1 * len(sources), len(sources), 2, sharex="all", sharey="all")
    most = 1e3 * max(d.p95 for d in found.values())
    for row, source in zip(axes, sources, strict=True):
        for axis, name in zip(row, INTERPOLATIONS, strict=True):
            drawn = _draw_map(axis, surfaces[source, name], chart, most)
            axis.set_title(
                f"{source},\n{name}: {1e3 * found[source, name].rms:.1f} mm rms", fontsize=8
            )
    for axis in axes[-1]:
        axis.set_xlabel("along the hull (m)")
    for row in axes:
        row[0].set_ylabel("girth (m)")
    panels = [axis for row in axes for axis in row]
    figure.colorbar(drawn, ax=panels, label="deviation from the CAD model (mm)", shrink=0.5)
    table = ["poses,surface,rms_m,p95_m,rms_waterline_m,rms_rest_m,rms_to_steel_m"]
    table += [
        ",".join([*key, *(f"{v:.5f}" for v in (d.rms, d.p95, d.rms_top, d.rms_rest, d.rms_true))])
        for key, d in found.items()
    ]
    words = "; ".join(
        f"{source} {1e3 * found[source, 'linear'].rms:.1f} and {1e3 * found[source, 'GP'].rms:.1f}"
        for source in sources
    )
    return finish_figure(
        "deviation_by_source",
        figure,
        table,
        f"Deviation of the DVL's surface from the CAD model, rms in mm, linear and GP: {words}.",
        _compare(found),
    )


def _draw_map(axis: Axes, surface: Surface, chart: Chart, most_mm: float) -> ScalarMappable:
    """Draw the deviation of a surface from the CAD model on the chart, up to most_mm."""
    at = chart.to_chart(surface.vertices)
    drawn: ScalarMappable = axis.tripcolor(
        at[:, 0],
        at[:, 1],
        surface.faces,
        1e3 * np.abs(np.nan_to_num(surface.deviation)),
        cmap="turbo",
        vmin=0,
        vmax=most_mm,
        shading="gouraud",
        rasterized=True,
    )
    axis.set_aspect("equal", adjustable="box")
    return drawn


def _compare(found: Mapping[tuple[str, str], Deviation]) -> tuple[ComparedValue, ...]:
    """Compare deviations by two sources or interpolations, as ratios, with what is printed."""
    small = "printed: the highest of all, on a hull of 183 m"
    pairs = [
        ("rms by bundle adjustment without the hull over that by planes, linear", small,
         (WITHOUT_HULL, "linear"), (PLANES, "linear"), "rms"),
        ("the same, GP", small, (WITHOUT_HULL, "GP"), (PLANES, "GP"), "rms"),
        ("rms of GP over linear on side and bottom, planes", 'printed: "much improved"',
         (PLANES, "GP"), (PLANES, "linear"), "rms_rest"),
        ("rms of GP over linear along the waterline, planes",
         'printed: "significantly larger"; beyond the returns our linear surface keeps its height',
         (PLANES, "GP"), (PLANES, "linear"), "rms_top"),
        ("rms by bundle adjustment to the CAD model over that without the hull, GP", small,
         (ADJUSTED, "GP"), (WITHOUT_HULL, "GP"), "rms"),
    ]  # fmt: skip
    return tuple(
        ComparedValue(
            what=what,
            ours=getattr(found[one], of) / getattr(found[other], of),
            note=note,
        )
        for what, note, one, other, of in pairs
        if one in found and other in found
    )
