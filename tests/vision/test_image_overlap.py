# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether an image goes on where another ends, on a flat seabed 1 m below the camera."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import identity
from hullrecon.rig import Rig
from hullrecon.typing import Pixels
from hullrecon.vision.odometry import TopImages, fills_most

MODEL = CameraModel(320, 256, 250.0, 250.0, 159.5, 127.5)
RIG = Rig(
    tray_origin=np.zeros(3),
    pressure_origin=np.zeros(3),
    tray_from_dvl=identity(1),
    tray_from_top=identity(1),
    camera_models={Camera.TOP: MODEL},
)


def seabed(seed: int = 4) -> Pixels:
    noise = np.random.default_rng(seed).integers(0, 255, (100, 400), dtype=np.uint8)
    return np.repeat(
        cv2.resize(noise, (1600, 400), interpolation=cv2.INTER_CUBIC)[..., None], 3, axis=2
    )


def water() -> Pixels:
    grey = np.random.default_rng(5).normal(80, 2, (256, 320, 1)).clip(0, 255).astype(np.uint8)
    return np.repeat(grey, 3, axis=2)


def look(along_px: int, ground: Pixels) -> Pixels:
    return np.ascontiguousarray(ground[50:306, along_px : along_px + 320])


def goes_on(images: Sequence[Pixels | None], first: int, second: int) -> bool:
    return TopImages(RIG, lambda row: images[row], 2000, 15).overlap(first, second)


@pytest.mark.parametrize(
    ("step_px", "expected"), [(0, True), (40, True), (200, True), (330, False), (1200, False)]
)
def test_image_goes_on_as_long_as_it_overlaps(step_px: int, expected: bool) -> None:
    images = [look(10, seabed()), look(10 + step_px, seabed())]
    assert goes_on(images, 0, 1) is expected
    assert goes_on(images, 1, 0) is expected


@pytest.mark.parametrize(
    "after", [water(), look(10, seabed(6)), None], ids=["water", "another ground", "unreadable"]
)
def test_nothing_goes_on_in_open_water_or_elsewhere(after: Pixels | None) -> None:
    images = [look(10, seabed()), after]
    assert not goes_on(images, 0, 1)
    assert not goes_on([water(), water()], 0, 1)


def with_part_of_vehicle(seed: int, side_px: tuple[int, int]) -> Pixels:
    """Open water, and in it a part of the vehicle, of so many pixels high and wide."""
    image = (
        np.random.default_rng(seed)
        .normal(40, 4, (256, 320, 1))
        .clip(0, 255)
        .astype(np.uint8)
        .repeat(3, axis=2)
    )
    height, width = side_px
    image[-height:, 40 : 40 + width] = seabed()[:height, :width]
    return image


@pytest.mark.parametrize("side_px", [(80, 160), (110, 220)])
def test_part_of_vehicle_carries_no_walk_through_open_water(side_px: tuple[int, int]) -> None:
    assert not goes_on([with_part_of_vehicle(1, side_px), with_part_of_vehicle(2, side_px)], 0, 1)


def test_points_fill_most_of_image_that_lie_all_over_it() -> None:
    rng = np.random.default_rng(1)
    place = rng.uniform(0.05, 0.95, (200, 2))
    ideal = (place * [MODEL.width, MODEL.height] - [MODEL.cx, MODEL.cy]) / [MODEL.fx, MODEL.fy]
    for count in (15, 30, 200):
        assert fills_most(ideal[:count], MODEL)
    patch = np.abs(place - [0.55, 0.7]).max(axis=1) < 0.25  # in parts of most cells
    assert not fills_most(ideal[patch], MODEL)
    rim = (place[:, 0] < 0.2) | (place[:, 0] > 0.8)  # two skids
    assert not fills_most(ideal[rim], MODEL)


def test_each_image_is_read_once_along_walk() -> None:
    read: list[int] = []

    def image(row: int) -> Pixels:
        read.append(row)
        return look(40 * row, seabed())

    follow = TopImages(RIG, image, 1000, 15).overlap
    assert all(follow(k, k + 1) for k in range(4))
    assert read == [0, 1, 2, 3, 4]


def test_two_images_tell_how_camera_moved_but_not_how_far() -> None:
    images = [look(10, seabed()), look(50, seabed()), water()]
    between = TopImages(RIG, lambda row: images[row], 1000, 15).motion
    found = between(0, 1)
    assert found is not None
    motion, sigma = found
    direction = motion[:3, 3] / np.linalg.norm(motion[:3, 3])
    assert np.arccos(direction @ [-1.0, 0.0, 0.0]) < 3 * sigma[1]
    assert np.arccos((np.trace(motion[:3, :3]) - 1) / 2) < 5 * sigma[0]
    assert 0 < sigma[0] < 0.05
    assert 0 < sigma[1] < 0.3
    assert between(1, 2) is None
