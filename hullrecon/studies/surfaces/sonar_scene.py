# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sonar mosaic whose variance distinguishes sources of poses [Ozog2016 Figs 3.11, 3.12].

On a simulated dive the speckle of three looks outweighs what poses do. Here the same dive pings at
the same hull, painted in blocks, with speckle of many looks. The mosaics differ by poses alone.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from typing import cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.stage import StageSettings, settings_for
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.mosaic.mosaic_surface import build_mosaic_surface
from hullrecon.mosaic.options import SonarOptions
from hullrecon.records.sensors import SonarPings
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.mosaic_sonar import blend_pings
from hullrecon.steps.mosaics import REACH_M
from hullrecon.steps.sonar import ping_poses
from hullrecon.studies.dive_steps import inputs_of_step
from hullrecon.studies.paths.path_figures import (
    VarianceMap,
    sonar_variance,
    variance_map,
)
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.studies.surfaces.pose_sources import PlacedPaths, place_paths
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Floats32

BLOCK_M = 0.06  # side of a painted block
DARK, LIGHT = 60.0, 150.0  # mean gray levels of the blocks
LOOKS = 60  # of the speckle
ARC_RAYS = 120  # of a beam, over its arc of elevation
PRINTED_TAIL = 20.0  # variance from which on [Ozog2016 3.3.3] finds heavier tails
STEP_M = 0.02  # of the mosaic
TRUE = "true poses"


def study(given: StudyDive) -> StudyResult:
    """Blend the painted hull by every source of poses, and by the true ones."""
    placed, truth = place_paths(given), given.truth
    inputs = inputs_of_step(given.dive, "mosaic-sonar")
    settings = inputs.mounted(settings_for(given.dive.chain.stage("mosaic-sonar"), _coarse(given)))
    chart = inputs.surface.chart
    pings = inputs.ingest.sonar
    if pings is None:
        return StudyResult()
    true_track = _true_track(placed, truth)
    truly = ping_poses(inputs, settings, true_track)
    painted = replace(
        pings, image=paint_pings(truth.built, chart, truly, pings, _half_elevation(settings))
    )
    maps = {}
    for name, track in {**{k: p.track for k, p in placed.paths.items()}, TRUE: true_track}.items():
        onto = fit_rigid(track.poses.translation, true_track.poses.translation)
        poses = ping_poses(inputs, settings, replace(track, poses=onto @ track.poses))
        maps[name] = _blend(truth, chart, painted, poses, settings)
    name, compared = "sonar_variance_by_source", compare(maps)
    figure = replace(sonar_variance(maps), name=name, compared=compared)
    heads, rows = table(maps)
    return StudyResult(figures=(figure,), heads=heads, rows=rows)


def paint(along_girth: Array) -> Floats32:
    """Paint the hull in blocks: the gray level (n,) at chart points (n, 2) m.

    A block is dark or light by a hash of its column and row, so that no image of it is kept.
    """
    column, row = np.floor(np.nan_to_num(along_girth) / BLOCK_M).astype(np.int64).T
    mixed = (column * 73856093) ^ (row * 19349663)
    dark = ((mixed >> 7) ^ (mixed >> 13)) & 1
    return np.where(dark == 1, DARK, LIGHT).astype(np.float32)


def paint_pings(
    built: Scene,
    chart: Chart,
    poses: Poses,
    pings: SonarPings,
    half_elevation: float,
) -> NDArray[np.uint8]:
    """Ping at the painted hull: each pixel is the mean paint on its arc, with speckle.

    There is no shading, beam pattern or spreading, so that what varies between pings is where they
    are believed to have been.

    Parameters
    ----------
    built, chart
        The hull as built, and its chart, on which it is painted.
    poses
        (p) hull_from_sonar, where each ping truly was.
    pings
        The pings whose geometry is taken.
    half_elevation
        Half of the beams' opening in elevation, rad.

    Returns
    -------
    Array
        Images (p, beams, bins) of the pings.
    """
    rng = np.random.default_rng(0)
    image = np.zeros(pings.image.shape, np.uint8)
    beams, bins = len(pings.directions), len(pings.range_m)
    # A fan of ARC_RAYS rays in elevation (towards x) for each beam
    elevation = half_elevation * np.linspace(-1, 1, ARC_RAYS)
    level = pings.directions[:, None] * np.cos(elevation)[None, :, None]
    rays = level + np.array([1.0, 0.0, 0.0]) * np.sin(elevation)[None, :, None]
    rays = rays.reshape(-1, 3)
    beam = np.repeat(np.arange(beams), ARC_RAYS)
    near, far = pings.range_m[0], pings.range_m[-1]
    for k in range(len(image)):
        directions = poses.rotation[k].apply(rays)
        way = built.cast(poses.translation[k], directions)
        with np.errstate(invalid="ignore"):
            place = np.rint((way - near) / (far - near) * (bins - 1))
        seen = np.isfinite(way) & (place >= 0) & (place < bins)
        at = chart.to_chart(poses.translation[k] + way[seen, None] * directions[seen])[:, :2]
        # Rays that fall into one pixel are averaged
        cell = beam[seen] * bins + place[seen].astype(np.int64)
        total = np.bincount(cell, paint(at), beams * bins)
        count = np.bincount(cell, minlength=beams * bins)
        mean = _fill(*(np.asarray(n, float).reshape(beams, bins) for n in (total, count)))
        speckle = np.sqrt(rng.gamma(LOOKS, 1 / LOOKS, mean.shape))
        image[k] = np.clip(mean * speckle, 0, 255).astype(np.uint8)
    return image


def _fill(total: Array, count: Array) -> Array:
    """Average the paint of each pixel's rays, and fill pixels between rays by those around.

    total, count: (beams, bins) sum of the paint, and number of the rays.
    """
    from scipy.ndimage import uniform_filter1d

    wide = uniform_filter1d(total, 5, axis=1), uniform_filter1d(count, 5, axis=1)
    around = wide[0] / np.maximum(wide[1], 1e-9)
    return np.where(count > 0, total / np.maximum(count, 1), np.where(wide[1] > 1e-9, around, 0.0))


def compare(maps: dict[str, VarianceMap]) -> tuple[ComparedValue, ...]:
    """Compare the tails of the variance with what the source says of them."""
    floor = _seen(maps[TRUE])
    limit = float(np.percentile(floor, 99))
    return tuple(
        ComparedValue(
            what=f"pixels of a variance that true poses exceed at 1 % of them, {name}",
            unit="%",
            ours=float(100 * np.mean(_seen(found) > limit)),
            note="printed: tails above 20 heavier without bundle adjustment",
        )
        for name, found in maps.items()
    )


def table(maps: dict[str, VarianceMap]) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """Tabulate mean variances and shares of pixels in their tails, as heads and rows."""
    limit = float(np.percentile(_seen(maps[TRUE]), 99))
    rows = []
    for name, found in maps.items():
        seen = _seen(found)
        shares = (100 * np.mean(seen > value) for value in (PRINTED_TAIL, limit))
        rows.append((name, f"{np.mean(seen):.0f}", *(f"{share:.1f}" for share in shares)))
    return ("poses", "mean variance", "above 20, %", f"above {limit:.0f}, %"), tuple(rows)


def _seen(found: VarianceMap) -> Array:
    """Select the variances (k,) of the pixels in which pings were blended."""
    return np.asarray(found.variance[np.isfinite(found.variance)])


def _blend(
    truth: Truth, chart: Chart, pings: SonarPings, poses: Poses, settings: StageSettings
) -> VarianceMap:
    """Blend pings at poses hull_from_sonar on the true hull, and map the variance."""
    surface = build_mosaic_surface(truth.built_mesh, chart, REACH_M)
    with tempfile.TemporaryFile() as scratch:
        mosaic = blend_pings(surface, pings, poses, settings, in_threads, scratch)
        return variance_map(mosaic.store)


def _coarse(given: StudyDive) -> dict[str, object]:
    """Read the dive's settings, with a mosaic of coarser texels and its light left alone."""
    sections = dict(given.dive.chain.sections)
    own = cast("SonarOptions", sections["mosaic-sonar"])
    sections["mosaic-sonar"] = msgspec.structs.replace(own, resolution_m=STEP_M, even_light=False)
    return sections


def _half_elevation(settings: StageSettings) -> float:
    return 0.5 * float(np.radians(settings.read("sonar.elevation_deg", float)))


def _true_track(placed: PlacedPaths, truth: Truth) -> VehicleTrack:
    some = next(iter(placed.paths.values())).track
    return replace(some, poses=truth.vehicle_at(some.t_ns / 1e9))
