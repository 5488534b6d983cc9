# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where images were taken, which texels they may see, and the samples that the light is estimated
from.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera, Frame
from hullrecon.geometry.poses import Poses, from_mount, from_rpy
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.imagery.camera_views import (
    CameraImages,
    camera_views,
    compute_footprints,
    estimate_light,
    footprint_windows,
    images_of_camera,
    plain_views,
    sample_light,
)
from hullrecon.mosaic.imagery.radiometry import FIELD, LightModel
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import rig_from_settings
from hullrecon.threads import in_threads

GRID = TexelGrid(west=-0.5, north=0.5, step_m=0.05, height=20, width=20)
BLOCK = ([0.05, -0.1, 0.0], [0.1, 0.1, 0.3])

WHOLE = np.s_[:, :]


def ramp(row: int) -> np.ndarray:
    """An image that grows brighter to the right, from 50 to 150, the same in all channels."""
    shade = np.tile(np.linspace(50, 150, 400), (320, 1))
    return np.repeat(shade[..., None], 3, axis=2).astype(np.uint8)


def images_at(camera: CameraModel, spots: list[tuple[float, float]], read=ramp) -> CameraImages:
    poses = Poses(
        np.tile([1.0, 0, 0, 0], (len(spots), 1)), np.array([[x, y, 1.0] for x, y in spots])
    )
    return CameraImages(camera=camera, rows=np.arange(len(spots)), poses=poses, read=read)


def test_usable_posed_images_have_pose_of_rig(camera: CameraModel) -> None:
    track = VehicleTrack(
        t_ns=np.arange(4),
        poses=from_rpy([[float(k), 0, 0] for k in range(4)], np.zeros((4, 3))),
        tray=np.array([0.0, 0.0, 0.0, np.pi / 2]),
        covariance=np.zeros((4, 6, 6)),
        image=np.array([[0, -1], [-1, 0], [1, -1], [2, -1]]),
        frame=Frame.GLOBAL,
    )
    rig = rig_from_settings(
        {"tray.origin": (0.5, 0.0, 0.0), "camera.top.mount": (0.2, 0.0, 0.0, 0, 0, 0)},
        {Camera.TOP: camera},
    )
    images = images_of_camera(rig, track, Camera.TOP, np.array([True, False, True]), ramp)
    assert images.rows.tolist() == [0, 2]
    # the last node's tray is turned by a quarter about y: what was ahead of it is now above (z is
    # down)
    np.testing.assert_allclose(images.poses.translation, [[0.7, 0, 0], [3.5, 0, -0.2]], atol=1e-12)


def test_the_footprint_of_an_image_is_where_it_meets_the_surface(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    footprints = compute_footprints(
        flat_surface(), plain_views([images_at(camera, [(0.1, 0.2), (5.0, 5.0)])])
    )
    np.testing.assert_allclose(np.nanmean(footprints.at[0], axis=0), [0.1, 0.2], atol=1e-3)
    assert np.isnan(footprints.at[1]).all()
    assert (
        1.0
        <= footprints.distance[0]
        < footprints.span_m
        == pytest.approx(np.hypot(1, np.hypot(0.1985, 0.1585)), abs=1e-3)
    )
    assert np.isnan(footprints.distance[1])


def test_far_hits_are_left_out_of_footprint(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    views = plain_views([images_at(camera, [(0.0, 0.0)])])
    whole, near = (compute_footprints(flat_surface(), views, most) for most in (1.1, 1.005))
    assert np.isfinite(whole.at).all()
    dropped = np.isnan(near.at[0]).any(axis=1)
    assert 0 < dropped.sum() < len(dropped)
    radius = np.linalg.norm(whole.at[0], axis=1)
    assert radius[dropped].min() > radius[~dropped].max()
    assert near.span_m < whole.span_m
    np.testing.assert_array_equal(near.distance, whole.distance)


def test_the_window_of_an_image_holds_its_footprint_and_a_margin(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    footprints = compute_footprints(
        flat_surface(), plain_views([images_at(camera, [(0.0, 0.0), (5.0, 5.0)])])
    )
    seen, missed = footprint_windows(GRID, footprints)
    # 0.2 by 0.16 m each way, and 2.4 cm
    assert (seen.left, seen.right, seen.top, seen.bottom) == (5, 15, 6, 14)
    assert missed.empty


def test_light_sample_is_brightness_at_its_place(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    images = images_at(camera, [(0.0, 0.0)])
    views = plain_views([images])
    thumbnail = ramp(0)[::5, ::5]
    windows = footprint_windows(GRID, compute_footprints(flat_surface(), views))
    samples = sample_light(flat_surface(), GRID, views, windows, [thumbnail], np.zeros(1, np.int64))
    assert len(samples.view) == 8 * 6  # texels of 5 cm whose centres the image of 40 by 32 cm holds
    column = samples.cell % FIELD[1]
    np.testing.assert_allclose(
        np.exp(samples.log_value[:, 0]), 50 + 100 * (column + 0.5) / FIELD[1], atol=4
    )
    assert len(np.unique(samples.texel)) == len(samples.texel)


def test_texels_that_two_images_see_are_sampled_twice(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    views = plain_views([images_at(camera, [(0.0, 0.0), (0.1, 0.0)])])
    windows = footprint_windows(GRID, compute_footprints(flat_surface(), views))
    samples = sample_light(
        flat_surface(), GRID, views, windows, [ramp(0)[::5, ::5]] * 2, np.zeros(2, np.int64)
    )
    assert np.bincount(np.bincount(samples.texel)).tolist() == [0, 2 * 2 * 6, 6 * 6]


def test_a_texel_that_a_block_hides_is_no_sample_of_light(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    views = plain_views([images_at(camera, [(0.0, 0.0)])])
    counts = []
    for surface in (flat_surface(), flat_surface(BLOCK)):
        windows = footprint_windows(GRID, compute_footprints(flat_surface(), views))
        counts.append(
            len(
                sample_light(
                    surface, GRID, views, windows, [ramp(0)[::5, ::5]], np.zeros(1, np.int64)
                ).view
            )
        )
    # from 1 m above (0, 0) the block, 0.3 m high, hides the plate up to x = 0.1 / 0.7 and y = 0.1 /
    # 0.7: texels at x = 0.125 behind it, and at x = 0.075 and 0.125 those at y = 0.125 on either
    # side
    assert counts[0] - counts[1] == 4 + 4


def test_an_image_that_cannot_be_read_gives_no_samples(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    views = plain_views([images_at(camera, [(0.0, 0.0)])])
    windows = footprint_windows(GRID, compute_footprints(flat_surface(), views))
    samples = sample_light(flat_surface(), GRID, views, windows, [None], np.zeros(1, np.int64))
    assert len(samples.view) == 0
    assert samples.log_value.shape == (0, 3)


def test_the_light_of_fewer_than_two_images_is_not_estimated(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    images = images_at(
        camera, [(0.0, 0.0), (0.1, 0.0)], read=lambda row: ramp(row) if row == 0 else None
    )
    views = plain_views([images])
    footprints = compute_footprints(flat_surface(), views)
    assert estimate_light(flat_surface(), [images], views, footprints, in_threads) is None


def test_lamp_is_estimated_from_overlapping_images(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    images = images_at(
        camera, [(x, y) for x in np.linspace(-0.3, 0.3, 9) for y in (-0.1, 0.0, 0.1)]
    )
    views = plain_views([images])
    light = estimate_light(
        flat_surface(),
        [images],
        views,
        compute_footprints(flat_surface(), views),
        in_threads,
    )
    assert light is not None
    even = light.correct(ramp(0), WHOLE, camera=0, view=13)
    assert even[40:-40, 40:-40].std() < 0.04 * even.mean()
    np.testing.assert_allclose(light.log_gain, 0, atol=0.02)


def test_views_read_their_pictures_with_the_light_taken_off(camera: CameraModel) -> None:
    light = LightModel(log_field=(np.zeros((*FIELD, 3)),), log_gain=np.log([1.0, 2.0]))
    plain, halved = camera_views([images_at(camera, [(0.0, 0.0), (0.1, 0.0)])], light)
    np.testing.assert_allclose(halved.picture(WHOLE), 0.5 * plain.picture(WHOLE), rtol=1e-5)
    part = np.s_[32:96, 64:192]
    np.testing.assert_array_equal(halved.picture(part), halved.picture(WHOLE)[part])
    (unread,) = camera_views([images_at(camera, [(0.0, 0.0)], read=lambda row: None)], None)
    assert unread.picture(WHOLE) is None


def test_a_camera_that_looks_aside_meets_the_plate_aside(
    flat_surface: Callable[..., MosaicSurface], camera: CameraModel
) -> None:
    down = Poses(np.array([[1.0, 0, 0, 0]]), np.array([[0.0, 0, 1.0]]))
    aside = down @ from_mount([0, 0, 0, 0, 20, 0])
    images = CameraImages(camera=camera, rows=np.arange(1), poses=aside, read=ramp)
    footprints = compute_footprints(flat_surface(), plain_views([images]))
    assert np.nanmedian(footprints.at[0, :, 0]) == pytest.approx(np.tan(np.radians(20)), abs=0.01)
