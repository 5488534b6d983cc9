# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive as sights: where each was taken, which texels it may see, and the light in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.grid import TexelGrid, Window, grid_around
from hullrecon.mosaic.ground import Ground, patch_of, seen
from hullrecon.mosaic.imagery.image_view import CameraSight, Sight
from hullrecon.mosaic.imagery.radiometry import FIELD, FLOOR, Light, Samples, first_fields, solve_light
from hullrecon.typing import Array, Floats32, Ints

Read = Callable[[int], NDArray[np.uint8] | None]
LIGHT_STEP_M = 0.06  # texels that the light is estimated from
BLOCK = 1024  # of those texels, at a time


@dataclass(frozen=True)
class Station:
    """One camera of the rig and its images: rows (n,) of its index, poses T_M_c (n) (T_g_c without a CAD model), and how a row is
    read, (h, w, 3) uint8 RGB or None."""

    camera: CameraModel
    rows: Ints
    poses: Poses
    read: Read


@dataclass(frozen=True)
class Footprint:
    """Where images meet the surface: point (views, k, 3), at (views, k, 2) on the chart, NaN where they do not; distance
    (views,) m in the median; span_m: the largest of all distances, 0 when no image meets it."""

    point: Array
    at: Array
    distance: Array
    span_m: float


def plain_sights(stations: Sequence[Station]) -> list[CameraSight]:
    """Uncorrected, in the order of the stations."""
    return [CameraSight(s.poses[i], s.camera, lambda: None) for s in stations for i in range(len(s.rows))]


def footprint_of(ground: Ground, sights: Sequence[Sight]) -> Footprint:
    outlines = [sight.outline(ground) for sight in sights]
    middle = [np.linalg.norm(o - s.center, axis=1) for o, s in zip(outlines, sights, strict=True)]
    points = np.stack(outlines)
    good = np.isfinite(points).all(axis=2)
    at = np.full((*points.shape[:2], 2), np.nan)
    at[good] = ground.chart.to_chart(points[good])[:, :2]
    distance = [float(np.median(m[np.isfinite(m)])) if np.isfinite(m).any() else np.nan for m in middle]
    span_m = max((float(m.max(initial=0.0, where=np.isfinite(m))) for m in middle), default=0.0)
    return Footprint(points, at, np.array(distance), span_m)


def windows_of(grid: TexelGrid, footprint: Footprint, margin_share: float = 0.06) -> list[Window]:
    """The texels that each view may see: the bounds of its footprint, a little widened for what lies between its points."""
    spans = []
    for at in footprint.at:
        good = at[np.isfinite(at).all(axis=1)]
        spans.append(grid.window_of(at, margin_share * float(np.ptp(good, axis=0).max()) if len(good) else 0.0))
    return spans


def lit_sights(stations: Sequence[Station], light: Light | None) -> list[CameraSight]:
    """Sights whose pictures are corrected for the light."""
    sights: list[CameraSight] = []
    for k, station in enumerate(stations):
        for i, row in enumerate(station.rows.tolist()):
            view = len(sights)
            sights.append(CameraSight(station.poses[i], station.camera, _loader(station.read, row, light, k, view)))
    return sights


def _loader(read: Read, row: int, light: Light | None, camera: int, view: int) -> Callable[[], Floats32 | None]:
    def load() -> Floats32 | None:
        picture = read(row)
        if picture is None:
            return None
        return light.corrected(picture, camera, view) if light else np.asarray(picture, np.float32)

    return load


def light_of(
    ground: Ground,
    stations: Sequence[Station],
    sights: Sequence[CameraSight],
    footprint: Footprint,
    progress: Callable[[Sequence[Any]], Iterable[Any]],
) -> Light | None:
    """From small copies of all images at texels LIGHT_STEP_M apart; None when fewer than two images could be read."""
    camera = np.concatenate([np.full(len(s.rows), k) for k, s in enumerate(stations)])
    rows = [(s.read, row) for s in stations for row in s.rows.tolist()]
    thumbs: list[NDArray[np.uint8] | None] = [_thumb(read, row) for read, row in progress(rows)]
    good = np.array([t is not None for t in thumbs])
    if good.sum() < 2:
        return None
    fields = first_fields([t for t in thumbs if t is not None], camera[good])
    grid = grid_around(footprint.at.reshape(-1, 2), LIGHT_STEP_M)
    samples = _samples(ground, grid, sights, windows_of(grid, footprint), thumbs, camera)
    return solve_light(samples, fields) if len(samples.view) else Light(tuple(fields), np.zeros(len(sights)))


def _thumb(read: Read, row: int) -> NDArray[np.uint8] | None:
    """A small copy with twice the field's cells a side."""
    import cv2

    picture = read(row)
    if picture is None:
        return None
    return np.asarray(cv2.resize(picture, (2 * FIELD[1], 2 * FIELD[0]), interpolation=cv2.INTER_AREA), np.uint8)


def _samples(
    ground: Ground, grid: TexelGrid, sights: Sequence[CameraSight], windows: Sequence[Window],
    thumbs: Sequence[NDArray[np.uint8] | None], camera: Ints,
) -> Samples:  # fmt: skip
    parts: list[tuple[Any, ...]] = []
    for tile in grid.tiles(BLOCK):
        patch = patch_of(ground, grid, tile)
        for view, (sight, thumb) in enumerate(zip(sights, thumbs, strict=True)):
            window = windows[view].meet(tile)
            if thumb is None or window.empty:
                continue
            part = window.within(tile)
            rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
            known = np.isfinite(patch.point[part][..., 0])
            known[known] = seen(ground, patch.part(part), np.flatnonzero(known), sight.center, 0.0)[0]
            pixel, ratio = sight.project(patch.point[part][known])
            held = np.isfinite(ratio)
            share = (pixel[held] + 0.5) / [sight.camera.width, sight.camera.height]
            texel = (rows * grid.width + columns)[known][held]
            parts.append((np.full(len(texel), view), texel, _cell(share), _value(thumb, share)))
    if not parts:
        none = np.zeros(0, np.int64)
        return Samples(none, none, none, np.zeros((0, 3)), camera)
    view_of, texel_of, cell_of, value = (np.concatenate(p) for p in zip(*parts, strict=True))
    _, texel_of = np.unique(texel_of, return_inverse=True)
    return Samples(view_of.astype(np.int64), texel_of, cell_of.astype(np.int64), value, camera)


def _cell(share: Array) -> Ints:
    row = np.minimum(share[:, 1] * FIELD[0], FIELD[0] - 1).astype(np.int64)
    return row * FIELD[1] + np.minimum(share[:, 0] * FIELD[1], FIELD[1] - 1).astype(np.int64)


def _value(thumb: NDArray[np.uint8], share: Array) -> Array:
    size = np.array(thumb.shape[1::-1])
    at = np.minimum(share * size, size - 1).astype(int)
    return np.asarray(np.log(np.maximum(thumb[at[:, 1], at[:, 0]].astype(float), FLOOR)))
