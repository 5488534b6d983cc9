# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.atlas import Atlas
from hullrecon.synthetic.built_hull import Block, build
from hullrecon.synthetic.hull_patch import HullPatch, Rays
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.rendering import Lens, Scene, lens, photograph

# a wall in the x-z plane seen from y > 0: camera x runs aft, its y down
TOWARDS = np.array([[-1.0, 0, 0], [0, 0, -1], [0, -1, 0]]).T
CAMERA = CameraModel(240, 192, 250, 250, 120, 96, -0.06, 0.03)
GRID = np.arange(-1.5, 1.5001, 0.03)


def scene(
    items: tuple[Item, ...] = (), absorption: float = 0.3, spots: tuple[tuple[int, int], ...] = ()
) -> Scene:
    a, g = np.meshgrid(GRID, GRID, indexing="ij")
    patch = HullPatch(
        GRID, GRID, np.stack([a, 0 * a, g], -1), np.tile([0.0, 1.0, 0.0], (*a.shape, 1))
    )
    built = build(spec_from(deviation_mean_m=0.0, deviation_sigma_m=0.0), patch, items)
    image = np.full((1500, 1500, 3), 90, np.uint8)
    for row, column in spots:
        image[row - 4 : row + 5, column - 4 : column + 5] = 150
    return Scene(
        Block(patch=patch, built=built, rays=Rays(built.mesh)),
        Atlas(image, (-1.5, -1.5), 0.002),
        absorption,
    )


def shoot(world: Scene, distance: float = 1.0, view: Lens | None = None) -> np.ndarray:
    pose = Poses(_turn(), np.array([[0.0, distance, 0.0]]))
    lamp = np.array([[0.2, distance, 0.3]])
    return photograph(world, view or lens(CAMERA), pose, lamp, np.random.default_rng(0))


def _turn() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(TOWARDS).as_quat()[None]


def test_spot_is_imaged_where_camera_model_says() -> None:
    world = scene(spots=((900, 600), (650, 950)))
    image = shoot(world).max(2)
    for row, column in ((900, 600), (650, 950)):
        point = np.array([[-1.5 + 0.002 * column, 0.0, -1.5 + 0.002 * row]])
        inside = Poses(_turn(), np.array([[0.0, 1.0, 0.0]])).inverse().apply(point)
        u, v = CAMERA.project(inside)[0]
        area = image[round(v) - 8 : round(v) + 9, round(u) - 8 : round(u) + 9].astype(float)
        rows, columns = np.nonzero(area > 0.5 * (area.max() + np.median(area)))
        assert rows.mean() - 8 + round(v) == pytest.approx(v, abs=0.5)
        assert columns.mean() - 8 + round(u) == pytest.approx(u, abs=0.5)


def test_farther_is_darker_and_red_goes_first() -> None:
    near, far = shoot(scene(), 0.8).astype(float), shoot(scene(), 1.4).astype(float)
    centre = (slice(80, 110), slice(100, 140))
    ratio = (far[centre].mean((0, 1)) ** 2) / (near[centre].mean((0, 1)) ** 2)
    assert (ratio < 0.9).all()
    assert ratio[0] < ratio[1]


def test_murkier_water_has_less_contrast() -> None:
    def contrast(absorption: float) -> float:
        image = shoot(scene(absorption=absorption, spots=((750, 750),))).astype(float).mean(2)
        patch = image[90:103, 114:127]
        return float(patch.max() / np.median(image[70:80, 100:140]) - 1)

    assert contrast(1.5) < 0.6 * contrast(0.1)


def test_where_there_is_no_hull_there_is_only_veil() -> None:
    narrow = lens(replace(CAMERA, fx=40.0, fy=40.0))
    image = shoot(scene(), 2.5, narrow).astype(float)
    assert image[:4, :4].mean((0, 1))[1] > image[:4, :4].mean((0, 1))[0]
    assert image[:4, :4].mean() < 110


def test_structure_casts_shadow_away_from_lamp() -> None:
    plain, blocked = (
        shoot(scene()).astype(float),
        shoot(scene((Item("cylinder", 0.0, 0.0, 0.15, (0.2, 0.2)),))).astype(float),
    )
    darker = (plain - blocked).mean(2) > 25
    rows, columns = np.nonzero(darker)
    assert darker.sum() > 60
    assert columns.mean() > 120  # the lamp stands at x > 0, to the left in the image
    assert rows.mean() > 96  # and above


def test_corners_are_vignetted() -> None:
    view = lens(CAMERA)
    assert view.vignetting[0, 0] < 0.85
    assert view.vignetting[96, 120] > 0.99


def test_images_of_dive_are_rich_in_features(package: object) -> None:
    from pathlib import Path

    from mcap.reader import make_reader

    assert isinstance(package, Path)
    with (package / "logs" / "dive.mcap").open("rb") as file:
        raw = [
            m.data
            for _, c, m in make_reader(file).iter_messages(
                topics=["/camera/top/image_raw/compressed"]
            )
        ]
    image = cv2.imdecode(
        np.frombuffer(raw[2][raw[2].index(b"\xff\xd8") :], np.uint8), cv2.IMREAD_GRAYSCALE
    )
    assert image.shape == (192, 240)
    found = cv2.SIFT_create().detect(cv2.createCLAHE(3, (8, 8)).apply(image))
    assert len(found) > 250  # a quarter of the pixels of 480 x 384, where 1,500 are found
