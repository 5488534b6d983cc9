# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sonar that looks at the plate at a slant."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.imagery.camera_views import compute_footprints
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.sonar import (
    LEVEL,
    ReturnLevels,
    SonarView,
    build_fan,
    learn_levels,
    sonar_mosaic,
)
from hullrecon.records.sensors import SonarPings
from hullrecon.threads import in_threads

BEARING = np.radians(np.linspace(-14, 14, 49))
RANGES = np.linspace(0.4, 1.8, 141)
OPTIONS = SonarOptions(tile_px=64, resolution_m=0.02)


def pings_over(
    spots: list[float], draw: Callable[[np.ndarray], np.ndarray]
) -> tuple[SonarPings, Poses]:
    """Pings from (x, -0.8, 0.5), the fan in the y-z plane of the plate's normal, 32 degrees below
    the horizon; draw gives the return of plate points (n, 3).
    """
    # o: x up out of the fan, z ahead (girth)
    turn = Rotation.from_matrix(np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    turn = Rotation.from_euler("x", -32, degrees=True) * turn
    poses = Poses(
        np.tile(turn.as_quat(), (len(spots), 1)), np.array([[x, -0.8, 0.5] for x in spots])
    )
    directions = np.stack([np.zeros(49), np.sin(BEARING), np.cos(BEARING)], axis=1)
    images = [plate_image(poses[k], draw) for k in range(len(spots))]
    return SonarPings(
        t_ns=np.arange(len(spots)), image=np.stack(images), directions=directions, range_m=RANGES
    ), poses


def plate_image(pose: Poses, draw: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """What the plate returns by beam and range: the point of each arc that lies on z = 0, found on
    a fine fan of rays.
    """
    image = np.zeros((49, 141))
    for theta in np.linspace(-0.13, 0.13, 400):
        ray = np.stack(
            [
                np.full(49, np.sin(theta)),
                np.cos(theta) * np.sin(BEARING),
                np.cos(theta) * np.cos(BEARING),
            ],
            axis=1,
        )
        world = pose.rotation.apply(ray)
        gone = np.where(
            world[:, 2] < 0, -pose.translation[0, 2] / np.minimum(world[:, 2], -1e-9), np.inf
        )
        bins = np.rint((gone - 0.4) / 0.01)
        hit = (bins >= 0) & (bins < 141)
        points = pose.translation[0] + np.where(hit, gone, 0)[:, None] * world
        image[np.flatnonzero(hit), bins[hit].astype(int)] = draw(points[hit])
    return np.clip(image, 0, 255).astype(np.uint8)


def test_a_bright_stripe_is_mapped_to_its_place(flat_surface: Callable[..., MosaicSurface]) -> None:
    def stripe(points: np.ndarray) -> np.ndarray:
        return np.where(np.abs(points[:, 0] - 0.1) < 0.03, 200.0, 60.0)

    pings, poses = pings_over([-0.1, 0.0, 0.1, 0.2], stripe)
    made = sonar_mosaic(
        flat_surface(), pings, poses, np.radians(14), OPTIONS, in_threads, BytesIO()
    )
    grid, gray, alpha = (
        made.store.grid,
        made.store.small[..., 0].astype(float),
        made.store.small[..., 1],
    )
    along = grid.west + (np.arange(grid.width) + 0.5) * grid.step_m
    profile = np.array(
        [
            gray[:, k][alpha[:, k] > 0].mean() if (alpha[:, k] > 0).any() else np.nan
            for k in range(grid.width)
        ]
    )
    bright = along[profile > 1.6 * np.nanmedian(profile)]
    assert abs(bright.mean() - 0.1) < 0.02
    assert 0.02 < np.ptp(bright) < 0.10


def test_an_even_plate_becomes_even_whatever_the_beam_pattern(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    pings, poses = pings_over(
        [-0.2, -0.1, 0.0, 0.1, 0.2], lambda points: np.full(len(points), 120.0)
    )
    pattern = np.exp(-((BEARING / 0.3) ** 2))[:, None] * np.linspace(1.4, 0.6, 141)
    shaded = SonarPings(
        t_ns=pings.t_ns,
        image=(pings.image * pattern).astype(np.uint8),
        directions=pings.directions,
        range_m=pings.range_m,
    )
    made = sonar_mosaic(
        flat_surface(), shaded, poses, np.radians(14), OPTIONS, in_threads, BytesIO()
    )
    inner = made.store.small[3:-3, 3:-3]
    seen = inner[..., 0][inner[..., 1] > 0].astype(float)
    assert made.light_corrected
    assert abs(np.median(seen) - LEVEL) < 0.1 * LEVEL
    assert seen.std() < 0.15 * LEVEL


def test_sonar_shadow_of_block_is_not_mapped(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    pings, poses = pings_over([0.0], lambda points: np.full(len(points), 90.0))
    free = sonar_mosaic(
        flat_surface(), pings, poses, np.radians(14), OPTIONS, in_threads, BytesIO()
    ).store
    girth = girths(free)
    girth = girth[(girth > 0.06) & [seen_at(free, 0.0, g) for g in girth]]
    assert girth.max() > 0.2
    # the shadow as seen from y = -0.8 at 0.5 m height, behind the block's far upper edge at y =
    # 0.05
    for height, end in ((0.05, 0.05 + 0.85 * 0.05 / 0.45), (0.2, 0.05 + 0.85 * 0.2 / 0.3)):
        block = ([-0.1, -0.05, 0.0], [0.1, 0.05, height])
        made = sonar_mosaic(
            flat_surface(block), pings, poses, np.radians(14), OPTIONS, in_threads, BytesIO()
        ).store
        mapped = [seen_at(made, 0.0, g) for g in girth]
        clear = np.abs(girth - end) > 0.02
        np.testing.assert_array_equal(np.array(mapped)[clear], (girth > end)[clear])


def test_a_long_shadow_is_found_to_its_end(flat_surface: Callable[..., MosaicSurface]) -> None:
    """From 25 cm height a block of 12 cm, half a metre off, throws a shadow of 46 cm."""
    turn = Rotation.from_matrix(np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    turn = Rotation.from_euler("x", -18, degrees=True) * turn
    poses = Poses(turn.as_quat()[None], np.array([[0.0, -0.9, 0.25]]))
    directions = np.stack([np.zeros(49), np.sin(BEARING), np.cos(BEARING)], axis=1)
    pings = SonarPings(
        t_ns=np.arange(1),
        image=np.full((1, 49, 141), 90, np.uint8),
        directions=directions,
        range_m=RANGES,
    )
    made = sonar_mosaic(
        flat_surface(([-0.3, -0.45, 0.0], [0.3, -0.4, 0.12])),
        pings,
        poses,
        np.radians(40),
        OPTIONS,
        in_threads,
        BytesIO(),
    ).store
    end = -0.4 + 0.5 * 0.12 / 0.13
    girth = girths(made)
    # rays start 4 mm, 1.5 cm of shadow, off it
    girth = girth[(girth > -0.39) & (girth < 0.4) & (np.abs(girth - end) > 0.04)]
    np.testing.assert_array_equal([seen_at(made, 0.0, g) for g in girth], girth > end)


def views_of(pings: SonarPings, poses: Poses, images: np.ndarray) -> list[SonarView]:
    fan = build_fan(pings.directions, pings.range_m, np.radians(14))
    return [SonarView(pose=poses[k], fan=fan, image=image) for k, image in enumerate(images)]


def learn(surface: MosaicSurface, views: list[SonarView]) -> ReturnLevels | None:
    return learn_levels(surface, views, compute_footprints(surface, views), 0.1, BytesIO())


def test_the_level_is_what_the_bare_hull_returns(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    pings, poses = pings_over([-0.1, 0.0, 0.1], lambda points: np.full(len(points), 120.0))
    levels = learn(flat_surface(), views_of(pings, poses, pings.image))
    assert levels is not None
    on_plate = pings.image[1] > 0
    # water before the first return is not counted
    assert np.abs((levels.mean * levels.gain[1])[on_plate] - 120).mean() < 8


def test_returns_that_are_not_where_the_hull_is_are_told(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    """The plate is seen from 0.72 m on: nearer samples are of water."""
    pings, poses = pings_over([-0.1, 0.0, 0.1], lambda points: np.full(len(points), 120.0))
    told = {}
    for name, images in {
        "right": pings.image,
        "turned": pings.image[:, :, ::-1],
        "elsewhere": np.where(pings.image > 0, 5, 120).astype(np.uint8),
    }.items():
        levels = learn(flat_surface(), views_of(pings, poses, images))
        assert levels is not None
        told[name] = levels.contrast.words
    assert told["right"] == ""
    assert told["turned"].startswith("the sonar's samples seem to run from far to near")
    assert told["elsewhere"].endswith("contradict the hull, or noise is brighter than the hull")


def test_each_ping_has_its_own_gain_within_a_factor_of_two(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    _, poses = pings_over([-0.1, 0.0, 0.1, 0.2], lambda points: np.full(len(points), 100.0))
    directions = np.stack([np.zeros(49), np.sin(BEARING), np.cos(BEARING)], axis=1)
    fan = build_fan(directions, RANGES, np.radians(60))
    images = [np.full((49, 141), gray, np.uint8) for gray in (100, 130, 100, 10)]
    levels = learn(
        flat_surface(),
        [SonarView(pose=poses[k], fan=fan, image=image) for k, image in enumerate(images)],
    )
    assert levels is not None
    mean = (100 + 130 + 100 + 10) / 4
    ratio = levels.gain / levels.gain[0]
    np.testing.assert_allclose(ratio[1:3], [1.3, 1.0], rtol=0.05)
    # a ping eight times darker than the mean is evened out by two only
    assert abs(ratio[3] - 0.5 * mean / 100) < 0.05


def test_a_shadow_does_not_darken_the_level(flat_surface: Callable[..., MosaicSurface]) -> None:
    """A block of 10 cm in front of the plate; its shadow reaches from y = -0.2 to -0.05, in 78 to
    90 cm of range.
    """
    block = ([-0.3, -0.25, 0.0], [0.3, -0.2, 0.1])

    def shadowed(points: np.ndarray) -> np.ndarray:
        behind = (points[:, 1] > -0.2) & (points[:, 1] < -0.2 + 0.6 * 0.1 / 0.4)
        return np.where(behind, 0.0, 100.0)

    pings, poses = pings_over([-0.1, 0.0, 0.1], shadowed)
    views = views_of(pings, poses, pings.image)
    aware, blind = learn(flat_surface(block), views), learn(flat_surface(), views)
    assert aware is not None
    assert blind is not None
    in_shadow = np.s_[20:29, 42:46]
    assert (pings.image[1][in_shadow] == 0).all()
    # without the block in the surface the shadow is taken for a dark hull
    assert blind.mean[in_shadow].max() < 50
    assert aware.mean[in_shadow].min() > 75


def test_too_little_hull_has_no_level(flat_surface: Callable[..., MosaicSurface]) -> None:
    pings, poses = pings_over([0.98], lambda points: np.full(len(points), 100.0))
    views = views_of(pings, poses, pings.image)
    footprints = compute_footprints(flat_surface(), views)
    assert learn_levels(flat_surface(), views, footprints, 0.999, BytesIO()) is None


def girths(store) -> np.ndarray:
    return store.grid.north - (np.arange(store.grid.height) + 0.5) * store.grid.step_m


def seen_at(store, along: float, girth: float) -> bool:
    row, column = (
        round((store.grid.north - girth) / 0.02 - 0.5),
        round((along - store.grid.west) / 0.02 - 0.5),
    )
    return bool(store.small[row, column, 1])
