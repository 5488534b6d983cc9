# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of what links and planes do to a path, from a run as far as it has come."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.adjustment.hull_pose.registration import register
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.runner import RunContext
from hullrecon.artifacts.stage import settings_for
from hullrecon.artifacts.workspace import Workspace
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.output.tile_store import TileStore
from hullrecon.navigation.planes.planar_graph import PlanarSolution, planar_graph
from hullrecon.records.links import LinkedPath, no_links
from hullrecon.records.trajectory import Trajectory, VehiclePath, VehicleTrack
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact
from hullrecon.steps.links import pose_graph
from hullrecon.steps.links import run as run_links
from hullrecon.steps.mosaic_sonar import blend_pings
from hullrecon.steps.mosaics import read_mosaic_inputs
from hullrecon.steps.sonar import ping_poses
from hullrecon.studies.dive_steps import build_beside, inputs_of_step, with_stages, workspace_beside
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.matching.comparison import TWO_VIEW_MODELS
from hullrecon.studies.methods.comparison import DeadReckoning
from hullrecon.studies.paths.link_plots import (
    LinkedBy,
    links_on_hull,
    sigma_along_path,
    two_view_models,
)
from hullrecon.studies.study import ComparedValue
from hullrecon.threads import in_threads
from hullrecon.typing import Array

MOST_DRAWN_PX = 700  # along either side of a map
INKS = (COLOURS["geva"], COLOURS["naive"], GREEN, COLOURS["maxmix"])


@dataclass(frozen=True, kw_only=True)
class VarianceMap:
    """The variance of the intensities blended in each pixel."""

    variance: Array  # (height, width) gray levels squared, NaN where fewer than two were blended
    extent: tuple[float, float, float, float]  # left, right, bottom, top in m of the chart


def sonar_variance(maps: Mapping[str, VarianceMap]) -> PublishedFigure:
    """Draw a map per source of poses, and the share of pixels above each variance."""
    figure, axes = new_canvas(9.6, 2.0 * -(-len(maps) // 2) + 3.2, -(-len(maps) // 2) + 1, 2)
    blended = {name: found.variance[np.isfinite(found.variance)] for name, found in maps.items()}
    most = max(
        float(np.percentile(values, 95)) if len(values) else 1.0 for values in blended.values()
    )
    panels = [axis for row in axes[:-1] for axis in row]
    for axis, (name, found) in zip(panels, maps.items(), strict=False):
        step = max(1, max(found.variance.shape) // MOST_DRAWN_PX)
        drawn = axis.imshow(
            found.variance[::step, ::step],
            extent=found.extent,
            cmap="coolwarm",
            vmin=0,
            vmax=most,
            aspect="equal",
            interpolation="none",
        )
        axis.grid(False)
        axis.set_title(name, fontsize=9)
        axis.set(xlabel="along the hull (m)", ylabel="girth (m)")
    for axis in panels[len(maps) :]:
        axis.set_axis_off()
    figure.colorbar(drawn, ax=panels, label="variance (gray levels squared)", shrink=0.8)
    edges = np.linspace(0, 4 * most, 161)
    table = [",".join(["variance_at_least", *(f"share_{name.replace(' ', '_')}" for name in maps)])]
    beyond = {
        name: 1 - np.searchsorted(np.sort(v), edges) / max(len(v), 1) for name, v in blended.items()
    }
    for (name, share), ink in zip(beyond.items(), (*INKS, INK, RED), strict=False):
        for axis in axes[-1]:
            axis.plot(edges, 100 * share, color=ink, linewidth=1.6, label=name)
    axes[-1][0].set(xlabel="variance of at least", ylabel="pixels (%)", xlim=(0, most))
    axes[-1][1].set(
        xlabel="variance of at least (the tail)",
        ylabel="pixels (%)",
        xlim=(most, 4 * most),
        yscale="log",
    )
    axes[-1][0].legend(fontsize=8, frameon=False)
    table += [
        f"{edge:.3f}," + ",".join(f"{share[k]:.6f}" for share in beyond.values())
        for k, edge in enumerate(edges)
    ]
    words = "; ".join(f"{name} {np.mean(v):.0f}" for name, v in blended.items() if len(v))
    caption = (
        "Variance of the intensities that a pixel of the sonar mosaic blends, by what the poses "
        f"are from; means: {words}."
    )
    return finish_figure("sonar_variance", figure, table, caption)


MOST_DRAWN = 4000
# [Ozog2016 2.5.6]: mean and sigma of distances in m, share of returns beyond 1.5 m in percent
PRINTED_DISTANCES = {"without planes": (1.31, 1.38, 20.0), "with planes": (0.45, 0.19, 0.0)}


@dataclass(frozen=True, kw_only=True)
class ReturnsOnHull:
    """DVL returns on one path, registered to the CAD model."""

    points: Array  # (n, 3) m in M
    distance: Array  # (n,) m from its surface


def distance_to_cad_model(paths: Mapping[str, ReturnsOnHull]) -> PublishedFigure:
    """Draw the returns from above, a panel a path, and their distances' spread."""
    figure, axes = new_canvas(4.2 * (len(paths) + 1), 3.6, 1, len(paths) + 1)
    palette = dict(zip(paths, (COLOURS["geva"], COLOURS["maxmix"], INK), strict=False))
    reach = max(float(np.percentile(np.abs(found.distance), 99)) for found in paths.values())
    edges = np.linspace(0, max(reach, 1e-3), 61)
    table, words = ["path,returns,mean_m,sigma_m,median_m,share_beyond_0.1_m"], []
    for axis, (name, found) in zip(axes[0], paths.items(), strict=False):
        few = slice(None, None, max(1, len(found.points) // MOST_DRAWN))
        axis.scatter(
            found.points[few, 0], found.points[few, 1], s=2, color=palette[name], linewidths=0
        )
        axis.set(title=name, xlabel="along the hull (m)", ylabel="across it (m)")
        away = np.abs(found.distance)
        share = 100 * np.histogram(away, edges)[0] / max(1, len(away))
        axes[0][-1].stairs(share, 1e3 * edges, color=palette[name], linewidth=1.8, label=name)
        beyond = float(np.mean(away > 0.1))
        table.append(
            f"{name},{len(away)},{np.mean(away):.5f},{np.std(away):.5f},{np.median(away):.5f},{beyond:.5f}"
        )
        words.append(
            f"{name} {1e3 * np.mean(away):.0f} mm in the mean, {100 * beyond:.0f} % beyond 0.1 m"
        )
    axes[0][-1].set(xlabel="distance of a DVL return from the CAD model (mm)", ylabel="returns (%)")
    axes[0][-1].legend(fontsize=8, frameon=False)
    return finish_figure(
        "distance_to_cad_model",
        figure,
        table,
        f"DVL returns laid onto the CAD model: {'; '.join(words)}.",
        _compare_distances(paths),
    )


def _compare_distances(paths: Mapping[str, ReturnsOnHull]) -> tuple[ComparedValue, ...]:
    """Set distances as [Ozog2016 2.5.6] prints them beside ours, in metres."""
    return tuple(
        ComparedValue(what=f"{what}, {name}", unit=unit, printed=printed, ours=ours, note=note)
        for name, of_paper in PRINTED_DISTANCES.items()
        if name in paths
        for (what, unit), printed, ours, note in zip(
            (
                ("mean distance of returns from the CAD model", "m"),
                ("standard deviation of these distances", "m"),
                ("returns more than 1.5 m off", "%"),
            ),
            of_paper,
            _distances_as_printed(np.abs(paths[name].distance)),
            ("printed of hours around a ship of 183 m; ours of minutes",) * 3,
            strict=True,
        )
    )


def _distances_as_printed(away: Array) -> tuple[float, float, float]:
    """Compute mean m, standard deviation m, and percentage beyond 1.5 m, of distances (n,) m."""
    return float(np.mean(away)), float(np.std(away)), float(100 * np.mean(away > 1.5))


# m, rad: how far a path may have drifted
TRUE_POSE_SIGMA = np.r_[1.0, 1.0, 0.3, np.radians([1.0, 1.0, 5.0])]
# of a hull and a DVL as packages state them
DEVIATION_SIGMA_M, DEVIATION_LENGTH_M, RANGE_SIGMA_M = 0.02, (3.0, 1.5), 0.01
MODEL_WORDS = {
    "essential": "essential matrix alone",
    "homography": "homography alone",
    "automatic": "chosen by the criterion",
}


def draw_path_figures(
    dive: DiveRun, start: DeadReckoning, truth: Truth, run_context: RunContext
) -> list[PublishedFigure]:
    """Draw [KimEustice2009 Figs 3, 4, 5], [Ozog2016 Figs 2.22, 2.23, 3.11, 3.12].

    A figure without its data is left out. Without links there are no figures. With one camera the
    step `links` runs for each two-view model.
    """
    if dive.workspace.manifest("links") is None:
        return []
    links = LinksArtifact(dive.workspace.artifact("links"))
    tracks = {"dead reckoned": start.trajectory.track()}
    planar = path_by_planes(dive)
    if planar is not None:
        tracks["with planes"] = linked_track(start.trajectory, planar)
    figures, compared = [], links.compared
    if compared is not None:
        tracks["with links"] = linked_track(start.trajectory, links.path)
        figures.append(
            links_on_hull(tracks["dead reckoned"], tracks["with links"], compared, truth)
        )
        if len(IngestArtifact(dive.workspace.artifact("ingest")).camera_models) == 1:
            figures.append(
                two_view_models(by_two_view_model(dive, start.trajectory, run_context), truth)
            )
    figures.insert(0, sigma_along_path(tracks))
    if planar is not None:
        figures += _distances(dive, start, planar, truth)
    if (
        "mosaic-sonar" not in dive.chain.skip_reasons()
        and dive.workspace.manifest("surface") is not None
    ):
        figures.append(sonar_variance(_variances(dive, tracks)))
    return figures


def linked_track(trajectory: Trajectory, path: LinkedPath) -> VehicleTrack:
    """Make a track in g of a path that links or planes tie."""
    found = path.path()
    return replace(
        trajectory.track(), poses=found.poses, tray=found.tray, covariance=path.covariance
    )


def lay_onto_cad_model(
    path: VehiclePath, start: DeadReckoning, mesh: Mesh, global_from_hull: Poses
) -> ReturnsOnHull:
    """Register the DVL's returns on a path to the CAD model, and measure their distances from it.

    start: has returns and rig. global_from_hull: true pose, from which the registration starts.
    """
    assert start.returns is not None
    points = start.rig.dvl_points(start.returns, path).points[~start.returns.flagged]
    in_hull = place_on_cad_model(points, mesh, global_from_hull).inverse().apply(points)
    return ReturnsOnHull(points=in_hull, distance=Scene(mesh).closest(in_hull).distance)


def place_on_cad_model(points: Array, mesh: Mesh, global_from_hull: Poses) -> Poses:
    """Register the CAD model to returns (n, 3) m in g, and return the pose found.

    global_from_hull: true pose, from which the search starts.
    """
    model = CadModel(
        mesh,
        chart_for_hull(mesh),
        global_from_hull,
        TRUE_POSE_SIGMA,
        DEVIATION_SIGMA_M,
        DEVIATION_LENGTH_M,
    )
    return register(points, model, RANGE_SIGMA_M).global_from_hull


def path_by_planes(dive: DiveRun) -> LinkedPath | None:
    """Solve the path with the hull's planes, without images. None if none tie it."""
    solved = solve_planes(dive)
    return None if solved is None or solved.planes is None else solved.record()


def solve_planes(dive: DiveRun) -> PlanarSolution | None:
    """Solve the graph of path and planes, without images. None without DVL ranges."""
    inputs = inputs_of_step(dive, "links")
    returns = inputs.navigate.returns
    if returns is None:
        return None
    graph = pose_graph(
        inputs,
        inputs.mounted(settings_for(dive.chain.stage("links"), dive.chain.sections)),
    )
    return planar_graph(graph, returns, inputs.ingest.hull).solve(no_links())


def by_two_view_model(
    dive: DiveRun, trajectory: Trajectory, run_context: RunContext
) -> dict[str, LinkedBy]:
    """Solve the path with links of each two-view model, where out of date."""
    found: dict[str, LinkedBy] = {}
    for model, words in MODEL_WORDS.items():
        if model != "automatic":
            links_of = partial(run_links, strategy=TWO_VIEW_MODELS[model])
            chain = with_stages(dive.chain, replace(dive.chain.stage("links"), run=links_of))
            build_beside(dive, f"links {model}", "links", chain, run_context)
        links = LinksArtifact(workspace_of_model(dive, model).artifact("links"))
        found[words] = LinkedBy(
            track=linked_track(trajectory, links.path), joined=int(links.pairs.joined.sum())
        )
    return found


def workspace_of_model(dive: DiveRun, model: str) -> Workspace:
    """Choose where links of a two-view model lie: those by choice are the run's own."""
    if model == "automatic":
        return dive.workspace
    return workspace_beside(dive, f"links {model}")


def _distances(
    dive: DiveRun, start: DeadReckoning, planar: LinkedPath, truth: Truth
) -> list[PublishedFigure]:
    """Draw the returns' distances to the CAD model, where there is one, without and with planes."""
    mesh = IngestArtifact(dive.workspace.artifact("ingest")).hull
    if mesh is None or start.returns is None:
        return []
    paths = {"without planes": start.trajectory.track().path, "with planes": planar.path()}
    laid = {
        name: lay_onto_cad_model(path, start, mesh, truth.global_from_hull)
        for name, path in paths.items()
    }
    return [distance_to_cad_model(laid)]


def _variances(dive: DiveRun, tracks: Mapping[str, VehicleTrack]) -> dict[str, VarianceMap]:
    """Blend the sonar's pings by each path on one surface, and map their variance.

    The tracks, in g, are moved rigidly onto the delivered path, so that what differs is their form.
    """
    inputs = inputs_of_step(dive, "mosaic-sonar")
    settings = inputs.mounted(settings_for(dive.chain.stage("mosaic-sonar"), dive.chain.sections))
    surface = read_mosaic_inputs(inputs)
    pings = inputs.ingest.sonar
    assert pings is not None
    delivered = {} if inputs.adjust is None else {"adjusted": surface.track}
    found: dict[str, VarianceMap] = {}
    for name, track in {**tracks, **delivered}.items():
        onto = fit_rigid(track.poses.translation, surface.track.vehicle_at(track.t_ns).translation)
        poses = ping_poses(
            inputs, settings, replace(track, poses=onto @ track.poses, frame=surface.track.frame)
        )
        with tempfile.TemporaryFile(dir=dive.workspace.root) as scratch:
            mosaic = blend_pings(surface.surface, pings, poses, settings, in_threads, scratch)
            found[name] = variance_map(mosaic.store)
    return found


def variance_map(store: TileStore) -> VarianceMap:
    """Map the variance of the pixels in which more than one view was blended."""
    variance = join_tiles(store, store.variance, least=2)
    return VarianceMap(variance=variance, extent=extent_m(store.grid))


def join_tiles(
    store: TileStore, tiles: Iterable[NDArray[Any]], least: int, channels: tuple[int, ...] = ()
) -> Array:
    """Join tiles (size, size, *channels) of a mosaic, NaN where fewer views were blended."""
    grid = store.grid
    joined = np.full((grid.height, grid.width, *channels), np.nan)
    for window, tile, views in zip(grid.tiles(store.size), tiles, store.counts, strict=True):
        inside = window.meet(grid.whole)
        height, width = inside.shape
        known = np.asarray(views[:height, :width], int) >= least
        part = joined[inside.top : inside.bottom, inside.left : inside.right]
        part[known] = tile[:height, :width][known]
    return joined


def extent_m(grid: TexelGrid) -> tuple[float, float, float, float]:
    """Give left, right, bottom and top of a mosaic on the chart, m, as matplotlib draws it."""
    right, bottom = grid.west + grid.width * grid.step_m, grid.north - grid.height * grid.step_m
    return grid.west, right, bottom, grid.north
