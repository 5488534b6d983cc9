# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The optical mosaic as a whole, on a painted plate under an uneven lamp."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO

import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import CameraImages
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.optical import optical_mosaic, texel_size
from hullrecon.mosaic.options import OpticalOptions
from hullrecon.threads import in_threads

OPTIONS = OpticalOptions(tile_px=64, resolution_m=0.01)


def paint(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 110 + 40 * np.sign(np.sin(40 * x) * np.sin(40 * y))


def images(camera: CameraModel, spots: np.ndarray, lamp: bool) -> CameraImages:
    """Images from 1 m above the spots (n, 2), each as bright as it likes, under a lamp half as
    strong at the corners.
    """
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    fall = (
        1 - 0.5 * ((u - camera.cx) ** 2 + (v - camera.cy) ** 2) / (camera.cx**2 + camera.cy**2)
        if lamp
        else 1.0
    )

    def read(row: int) -> np.ndarray:
        x, y = (
            (u - camera.cx) / camera.fx + spots[row, 0],
            -(v - camera.cy) / camera.fy + spots[row, 1],
        )
        shade = (1.1 if row % 2 else 0.9) if lamp else 1.0
        return (
            np.repeat((paint(x, y) * fall * shade)[..., None], 3, axis=2)
            .clip(0, 255)
            .astype(np.uint8)
        )

    down = np.tile([1.0, 0.0, 0.0, 0.0], (len(spots), 1))
    return CameraImages(
        camera=camera,
        rows=np.arange(len(spots)),
        poses=Poses(down, np.column_stack([spots, np.ones(len(spots))])),
        read=read,
    )


SPOTS = np.stack(
    np.meshgrid(np.linspace(-0.4, 0.4, 7), np.linspace(-0.15, 0.15, 4)), axis=-1
).reshape(-1, 2)


@pytest.mark.parametrize("lamp", [False, True])
def test_the_mosaic_shows_the_paint_and_not_the_lamp(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel, lamp: bool
) -> None:
    seen = [images(camera, SPOTS, lamp)]
    store = optical_mosaic(flat_surface(), seen, OPTIONS, in_threads, BytesIO()).store
    grid = store.grid
    rows, columns = np.arange(grid.height, dtype=float), np.arange(grid.width, dtype=float)
    at = grid.centers(rows, columns)
    inner = (
        (np.abs(at[..., 0]) < 0.4)
        & (np.abs(at[..., 1]) < 0.22)
        & (np.abs(np.sin(40 * at)) > 0.5).all(axis=2)
    )
    shown, want = store.small[inner][:, 0].astype(float), paint(*at[inner].T)
    scale = shown.mean() / want.mean()
    assert np.abs(shown / scale - want).mean() < 3
    assert np.corrcoef(shown, want)[0, 1] > 0.99


def test_without_correction_the_lamp_stays(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    one = images(camera, SPOTS[:1], True)
    made = optical_mosaic(
        flat_surface(),
        [one],
        OpticalOptions(tile_px=64, resolution_m=0.01, even_light=False),
        in_threads,
        BytesIO(),
    )
    assert not made.light_corrected
    middle = made.store.small.shape[0] // 2
    row = made.store.small[middle, :, 0].astype(float)
    assert row[:6].max() < 0.85 * row[len(row) // 2 - 6 : len(row) // 2 + 6].max()


def test_texels_are_a_pixel_wide_within_bounds() -> None:
    assert texel_size(0.0022, OpticalOptions()) == pytest.approx(0.0022)
    assert texel_size(0.0005, OpticalOptions()) == pytest.approx(0.001)
    assert texel_size(0.1, OpticalOptions()) == pytest.approx(0.02)
    assert texel_size(0.1, OpticalOptions(resolution_m=0.0015)) == 0.0015


def test_images_that_miss_the_surface_make_no_mosaic(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    with pytest.raises(ValueError, match="no image meets"):
        optical_mosaic(
            flat_surface(),
            [images(camera, np.array([[5.0, 5.0]]), False)],
            OPTIONS,
            in_threads,
            BytesIO(),
        )
