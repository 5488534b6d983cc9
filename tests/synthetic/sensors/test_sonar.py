# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import Poses
from hullrecon.synthetic import sonar
from hullrecon.synthetic.built_hull import Block, build
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.hull_patch import HullPatch, Rays
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import spec_from

# a wall in the x-z plane, seen from y > 0; the sonar's z looks down at it at 45 degrees, its fan
# spreads along x
WALL = np.arange(-1.5, 1.5001, 0.03)


def wall(items: tuple[Item, ...] = ()) -> Block:
    a, g = np.meshgrid(WALL, WALL, indexing="ij")
    patch = HullPatch(
        WALL, WALL, np.stack([a, 0 * a, g], -1), np.tile([0.0, 1.0, 0.0], (*a.shape, 1))
    )
    built = build(spec_from(deviation_mean_m=0.0, deviation_sigma_m=0.0), patch, items)
    return Block(patch=patch, built=built, rays=Rays(built.mesh))


def within(near: float, far: float) -> np.ndarray:
    return (near < sonar.RANGE) & (far > sonar.RANGE)


def look(block: Block) -> np.ndarray:
    forward, side = np.array([0, -(0.5**0.5), -(0.5**0.5)]), np.array([1.0, 0, 0])
    up = np.cross(side, forward)
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_matrix(np.stack([up, side, forward], axis=1))
    pose = Poses(turn.as_quat()[None], np.array([[0.0, 1.0, 1.0]]))
    return sonar.ping(pose, block, sonar.fan(), np.random.default_rng(2))


def test_beam_directions_are_unit_vectors_in_fan() -> None:
    directions = sonar.beam_directions()
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1)
    assert (directions[:, 0] == 0).all()
    assert (np.diff(directions[:, 1]) < 0).all()


def test_rays_fill_elevation_and_belong_to_their_beam() -> None:
    fan = sonar.fan()
    elevation = np.degrees(np.arcsin(fan.direction[:, 0]))
    assert 6.9 < elevation.max() < 7.0
    azimuth = np.arctan2(fan.direction[:, 1], fan.direction[:, 2])
    step = abs(sonar.AZIMUTH[1] - sonar.AZIMUTH[0])
    assert np.abs(azimuth - sonar.AZIMUTH[fan.beam]).max() <= step / 2


def test_inclined_wall_echoes_between_nearest_and_farthest_ray() -> None:
    image = look(wall())
    assert image.shape == (96, 256)
    assert image.dtype == np.uint8
    profile = image[40:56].mean(0)
    near, far = 1 / np.cos(np.radians(45 - 7)), 1 / np.cos(np.radians(45 + 7))
    inside = (near + 0.03 < sonar.RANGE) & (far - 0.03 > sonar.RANGE)
    outside = (near - 0.05 > sonar.RANGE) | (far + 0.1 < sonar.RANGE)
    assert profile[inside].mean() > 5 * profile[outside].mean()


def test_something_that_stands_out_is_bright_and_casts_shadow() -> None:
    plain, blocked = look(wall()), look(wall((Item("cylinder", 0.0, 0.0, 0.15, (0.2, 0.2)),)))
    middle = slice(44, 52)
    behind = (sonar.RANGE > 1.45) & (sonar.RANGE < 1.52)
    assert blocked[middle][:, behind].mean() < 0.4 * plain[middle][:, behind].mean()
    front = (sonar.RANGE > 1.25) & (sonar.RANGE < 1.34)
    assert blocked[middle][:, front].mean() > 1.3 * plain[middle][:, front].mean()


def test_speckle_is_multiplicative(monkeypatch: pytest.MonkeyPatch) -> None:
    inside = (sonar.RANGE > 1.33) & (sonar.RANGE < 1.5)
    rough = look(wall())[:, inside].astype(float) ** 2
    monkeypatch.setattr(sonar, "LOOKS", 100.0)
    smooth = look(wall())[:, inside].astype(float) ** 2
    assert rough.std() / rough.mean() > 2 * smooth.std() / smooth.mean()


def test_pings_come_twice_second_and_see_hull(dive: Dive) -> None:
    t, images = sonar.pings(dive)
    assert 1 / np.diff(t).mean() == pytest.approx(2.0, rel=0.02)
    assert (next(images) > 80).mean() > 0.05
