# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Mosaics on the CAD model beside mosaics on the hull as surveyed [Ozog2016 Figs 3.7, 4.19]."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from typing import cast

import msgspec
import numpy as np
from matplotlib.axes import Axes

from hullrecon.artifacts.stage import settings_for
from hullrecon.evaluation.truth import TrueStructure
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.mosaic.grid import TexelGrid, grid_around
from hullrecon.mosaic.imagery.camera_views import (
    CameraImages,
    camera_views,
    compute_footprints,
    images_of_camera,
)
from hullrecon.mosaic.mosaic_surface import MosaicSurface, build_mosaic_surface, sample_surface
from hullrecon.mosaic.optical import LIMITS
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.output.tile_store import TileStore, blend_tiles
from hullrecon.steps.artifacts import DetectArtifact, SurfaceArtifact
from hullrecon.steps.mosaic_sonar import blend_pings
from hullrecon.steps.mosaics import REACH_M
from hullrecon.steps.sonar import ping_poses
from hullrecon.studies.dive_steps import inputs_of_step
from hullrecon.studies.figure_style import PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.paths.path_figures import extent_m, join_tiles
from hullrecon.studies.structures.inspected import InspectedHull, inspect
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Mask

CLOSE_UP_M, TEXEL_M = 1.0, 0.004  # side of a close-up, and its texels
SONAR_TEXEL_M = 0.02
TILE_PX = 256
SHOWN = 2  # structures whose close-ups are drawn
ON_CAD, AS_FOUND, BY_DVL = "on the CAD model", "on the hull as found", "on the DVL's surface"


@dataclass(frozen=True, kw_only=True)
class CloseUp:
    """A mosaic around one structure."""

    color: Array  # (h, w, 3) 0 to 255, NaN where nothing was seen
    height_m: Array  # (h, w) over the CAD model's chart
    grid: TexelGrid

    def footprint(self, at: Array, reach_m: float) -> Mask:
        """Mark the texels (h, w) within reach of a place (2,) of the chart."""
        rows, columns = np.arange(float(self.grid.height)), np.arange(float(self.grid.width))
        away = self.grid.centers(rows, columns) - at
        return np.asarray(np.hypot(*np.moveaxis(away, -1, 0)) < reach_m)


def study(given: StudyDive) -> StudyResult:
    """Lay close-ups on both surfaces, and the sonar's pings."""
    truth = given.truth
    run_to_detect(given.dive, given.run_context)
    hull = inspect(given.dive, truth)
    as_found = DetectArtifact(given.dive.workspace.artifact("detect")).as_found
    assert as_found is not None  # there are images and a CAD model
    meshes = {ON_CAD: hull.cad_model, AS_FOUND: as_found.mesh()}
    structures = sorted(truth.structures(), key=lambda s: -s.height)[:SHOWN]
    close_ups = {
        (s.kind, name): close_up(hull, mesh, _middle(hull, s))
        for s in structures
        for name, mesh in meshes.items()
    }
    figures = [draw_close_ups(close_ups, structures, hull)]
    figures += _sonar_mosaics(given, hull)
    return StudyResult(figures=tuple(figures))


def _middle(hull: InspectedHull, structure: TrueStructure) -> Array:
    """Find the place (2,) m of the chart at which the dive's result has a structure."""
    at = hull.truth_from_result.inverse().apply(np.array(structure.center)[None])
    return np.asarray(hull.chart.to_chart(at)[0, :2])


def close_up(hull: InspectedHull, mesh: Mesh, at: Array) -> CloseUp:
    """Blend the images around a place (2,) m of the chart on a mesh in M."""
    half = 0.5 * CLOSE_UP_M
    grid = grid_around(np.array([at - half, at + half]), TEXEL_M)
    surface = build_mosaic_surface(mesh, hull.chart, REACH_M)
    images = _images_near(hull, at)
    views = camera_views([images], None)
    footprints = compute_footprints(surface, views)
    with tempfile.TemporaryFile() as scratch:
        store = blend_tiles(
            surface, grid, footprints, views, LIMITS, 3, TILE_PX, in_threads, scratch
        )
        color = read_store(store)
    return CloseUp(color=color, height_m=_heights(surface, grid), grid=grid)


def _images_near(hull: InspectedHull, at: Array) -> CameraImages:
    """Choose the top camera's images taken near a place (2,) m of the chart.

    Near is within one and a half sides of a close-up.
    """
    store = hull.images[Camera.TOP]
    images = images_of_camera(hull.rig, hull.track, Camera.TOP, store.index.usable, store.read)
    foot = hull.chart.from_chart(at[None])[0][0]
    near = np.linalg.norm(images.poses.translation - foot, axis=1) < 1.5 * CLOSE_UP_M
    return replace(images, rows=images.rows[near], poses=images.poses[near])


def read_store(store: TileStore) -> Array:
    """Join the tiles of a mosaic to its colours (h, w, channels), NaN where nothing was seen."""
    colors = (tile[..., : store.channels] for tile in store.color)  # without alpha
    return join_tiles(store, colors, 1, (store.channels,))


def _heights(surface: MosaicSurface, grid: TexelGrid) -> Array:
    """Measure the heights (h, w) m of a surface's texels over the CAD model's chart."""
    point = sample_surface(surface, grid, grid.whole).point
    return np.asarray(surface.chart.to_chart(point.reshape(-1, 3))[:, 2].reshape(point.shape[:2]))


def draw_close_ups(
    close_ups: dict[tuple[str, str], CloseUp],
    structures: list[TrueStructure],
    hull: InspectedHull,
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.19]: close-ups on both surfaces, shaded by height."""
    figure, axes = new_canvas(8.8, 4.3 * len(structures), len(structures), 2)
    table = ["structure,true_height_m,surface,relief_m"]
    relief: dict[str, list[float]] = {ON_CAD: [], AS_FOUND: []}
    for row, structure in zip(axes, structures, strict=True):
        at = _middle(hull, structure)
        for axis, name in zip(row, (ON_CAD, AS_FOUND), strict=True):
            found = close_ups[structure.kind, name]
            near = found.footprint(at, 0.5 * max(structure.extent))
            around = ~found.footprint(at, 0.5 * max(structure.extent) + 0.1)
            raised = float(
                np.nanpercentile(found.height_m[near], 95) - np.nanmedian(found.height_m[around])
            )
            relief[name].append(raised / structure.height)
            table.append(f"{structure.kind},{structure.height:.3f},{name},{raised:.4f}")
            _draw_close_up(
                axis, found, f"{structure.kind}, {name}: {100 * raised:.1f} cm of relief"
            )
    return finish_figure(
        "mosaic_relief",
        figure,
        table,
        f"Mosaics around {len(structures)} structures, shaded by height: on the CAD model "
        f"{100 * np.mean(relief[ON_CAD]):.0f} % of their height is left, on the hull as found "
        f"{100 * np.mean(relief[AS_FOUND]):.0f} %.",
        (
            ComparedValue(
                what="share of a structure's height in the mosaic's surface, CAD model",
                unit="%",
                printed=0.0,
                ours=100 * float(np.mean(relief[ON_CAD])),
                note='printed "near-perfectly flat"',
            ),
            ComparedValue(
                what="share of a structure's height in the mosaic's surface, hull as found",
                unit="%",
                ours=100 * float(np.mean(relief[AS_FOUND])),
                note="printed as a picture alone",
            ),
        ),
    )


def _draw_close_up(axis: Axes, found: CloseUp, title: str) -> None:
    """Draw the texture, lit from above along the hull, and coloured by height."""
    import matplotlib as mpl

    height = np.nan_to_num(found.height_m - np.nanmedian(found.height_m))
    slope = np.gradient(height, found.grid.step_m)
    light = np.clip(0.75 + 0.5 * (slope[1] - slope[0]), 0.3, 1.2)[..., None]
    hue = mpl.colormaps["turbo"](np.clip(height / 0.14, 0, 1))[..., :3]
    share = np.clip(height / 0.06, 0, 1)[..., None] * 0.35
    picture = np.nan_to_num(found.color, nan=255.0) / 255 * light
    picture = np.clip((1 - share) * picture + share * hue, 0, 1)
    axis.imshow(picture, extent=extent_m(found.grid))
    axis.grid(False)
    axis.set_title(title, fontsize=9)
    axis.set(xlabel="along the hull (m)", ylabel="girth (m)")


def _sonar_mosaics(given: StudyDive, hull: InspectedHull) -> list[PublishedFigure]:
    """Blend the pings on the CAD model and on the DVL's surface, where there is a sonar."""
    dive = given.dive
    if "mosaic-sonar" in dive.chain.skip_reasons():
        return []
    inputs = inputs_of_step(dive, "mosaic-sonar")
    sections = dict(dive.chain.sections)
    own = cast("SonarOptions", sections["mosaic-sonar"])
    sections["mosaic-sonar"] = msgspec.structs.replace(own, resolution_m=SONAR_TEXEL_M)
    settings = inputs.mounted(settings_for(dive.chain.stage("mosaic-sonar"), sections))
    pings = inputs.ingest.sonar
    assert pings is not None
    poses = ping_poses(inputs, settings, hull.track)
    surface = SurfaceArtifact(dive.workspace.artifact("surface")).surface
    found = {}
    for name, mesh in ((ON_CAD, hull.cad_model), (BY_DVL, surface.mesh())):
        with tempfile.TemporaryFile() as scratch:
            on = build_mosaic_surface(mesh, hull.chart, REACH_M)
            store = blend_pings(on, pings, poses, settings, in_threads, scratch).store
            found[name] = (store.grid, read_store(store)[..., 0])
    return [draw_sonar_mosaics(found)]


def draw_sonar_mosaics(found: dict[str, tuple[TexelGrid, Array]]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 3.7]: the sonar mosaic on two surfaces.

    found: grid and intensities (h, w) of the mosaic, by the surface's name.
    """
    figure, axes = new_canvas(8.8, 7.6, len(found), 1, sharex="all")
    table = ["surface,seen_m2"]
    area = {}
    for row, (name, (grid, picture)) in zip(axes, found.items(), strict=True):
        area[name] = float(np.isfinite(picture).sum() * grid.step_m**2)
        row[0].imshow(picture, cmap="gray", vmin=0, vmax=200, extent=extent_m(grid))
        row[0].grid(False)
        row[0].set_title(f"sonar mosaic {name}: {area[name]:.1f} m²", fontsize=9)
        row[0].set(ylabel="girth (m)")
        table.append(f"{name},{area[name]:.2f}")
    axes[-1][0].set_xlabel("along the hull (m)")
    alike = correlation(*found.values())
    return finish_figure(
        "sonar_mosaics",
        figure,
        table,
        f"The sonar mosaic on the CAD model and on the DVL's surface: their intensities correlate "
        f"by {alike:.2f}; the latter covers {100 * area[BY_DVL] / area[ON_CAD]:.0f} % of the area.",
        (
            ComparedValue(
                what="correlation of the sonar mosaics on CAD model and DVL's surface",
                ours=alike,
                note='printed "nearly identical in texture"',
            ),
            ComparedValue(
                what="area of the mosaic on the DVL's surface over that on the CAD model",
                unit="%",
                ours=100 * area[BY_DVL] / area[ON_CAD],
                note='printed "smaller": no returns near the waterline',
            ),
        ),
    )


def correlation(first: tuple[TexelGrid, Array], second: tuple[TexelGrid, Array]) -> float:
    """Correlate two pictures (h, w) where both are known, each on its own grid of one step."""
    (grid, one), (other_grid, other) = first, second
    # Where the other picture's first texel lies on the grid of the first
    row = round((other_grid.north - grid.north) / -grid.step_m)
    column = round((other_grid.west - grid.west) / grid.step_m)
    moved = np.full(one.shape, np.nan)
    rows = np.arange(one.shape[0]) - row
    columns = np.arange(one.shape[1]) - column
    good_rows = (rows >= 0) & (rows < other.shape[0])
    good_columns = (columns >= 0) & (columns < other.shape[1])
    moved[np.ix_(good_rows, good_columns)] = other[np.ix_(rows[good_rows], columns[good_columns])]
    both = np.isfinite(one) & np.isfinite(moved)
    return float(np.corrcoef(one[both], moved[both])[0, 1])
