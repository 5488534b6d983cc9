# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated sea floor with rocks, as a down-looking camera sees it [Aulinas2011 4.4]."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from hullrecon.typing import Array, Mask, Pixels

WIDTH, HEIGHT = 320, 240  # of an image [Aulinas2011 4.4.3]
FLOOR_SIZE = 900  # px of the floor's picture, each side
SAND, ROCK = np.array([92.0, 132.0, 118.0]), np.array([128.0, 92.0, 60.0])  # RGB
STAIN = np.array([118.0, 104.0, 84.0])  # soft growth: a rock's hue, without edges
ROCK_PX = (34, 62)  # mean radius


@dataclass(frozen=True, kw_only=True)
class Floor:
    """A picture of the floor in even light."""

    picture: Array  # (s, s, 3) RGB
    rocks: Mask  # (s, s)


@dataclass(frozen=True, kw_only=True)
class View:
    """An image of the floor."""

    image: Pixels  # (HEIGHT, WIDTH, 3) RGB
    rocks: Mask  # (HEIGHT, WIDTH), true
    image_from_floor: Array  # (2, 3) affine, px


def draw_floor(seed: int, rocks: Array, stains: Array | None = None) -> Floor:
    """Draw a floor with rocks around middles (n, 2), and soft stains around others.

    Between the rocks lie dark pebbles and ripples of the sand's own hue: edges without a hue.
    """
    rng = np.random.default_rng(seed)
    size = (FLOOR_SIZE, FLOOR_SIZE)
    grain = 1 + 0.05 * _noise(rng, size, 2) + 0.06 * _noise(rng, size, 40)
    y, x = np.mgrid[:FLOOR_SIZE, :FLOOR_SIZE].astype(float)
    grain += 0.05 * np.sin((x + 0.4 * y) / 9 + 2 * _noise(rng, size, 90))
    picture = SAND * np.repeat(grain[..., None], 3, axis=2)
    for middle in rng.uniform(0, FLOOR_SIZE, (60, 2)):
        cv2.circle(
            picture, tuple(int(v) for v in middle), int(rng.integers(2, 5)), tuple(0.55 * SAND), -1
        )
    for middle in [] if stains is None else stains:
        weight = 0.8 * np.exp(-((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (2 * 45.0**2))
        picture += weight[..., None] * (STAIN - picture)
    covered = np.zeros(size, bool)
    relief = 1 + 0.16 * _noise(rng, size, 3) + 0.16 * _noise(rng, size, 7)
    relief += 0.16 * _noise(rng, size, 16)
    for middle in rocks:
        shape = _outline(rng, middle)
        covered |= shape
        light = relief * (1 + 0.25 * (x - middle[0] + y - middle[1]) / ROCK_PX[1])
        picture[shape] = (ROCK * light[..., None])[shape]
    return Floor(picture=np.maximum(picture, 5), rocks=covered)


def look(
    floor: Floor,
    seed: int,
    middle: tuple[float, float],
    turn_rad: float = 0.0,
    scale: float = 1.0,
    haze: float = 0.15,
    uneven: float = 0.5,
    noise: float = 3.0,
) -> View:
    """Take an image of the floor.

    Parameters
    ----------
    middle
        Where on the floor the camera looks, px.
    turn_rad, scale
        Turn of the image about its middle, and its pixels for one of the floor.
    haze
        Share of scattered light, which takes contrast.
    uneven
        How much darker the border is than the middle of the lamp's light.
    noise
        Of the camera, grey levels.
    """
    rng = np.random.default_rng(seed)
    c, s = scale * np.cos(turn_rad), scale * np.sin(turn_rad)
    linear = np.array([[c, -s], [s, c]])
    shift = np.array([WIDTH / 2, HEIGHT / 2]) - linear @ np.array(middle)
    warp = np.column_stack([linear, shift])
    seen = cv2.warpAffine(floor.picture, warp, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR)
    rocks = cv2.warpAffine(floor.rocks.astype(np.uint8), warp, (WIDTH, HEIGHT)) > 0
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    # light falls off from a point near the middle, and scattered light has the colour of sand
    lamp = rng.uniform(0.4, 0.6, 2) * (WIDTH, HEIGHT)
    away = ((x - lamp[0]) ** 2 + (y - lamp[1]) ** 2) / (WIDTH / 2) ** 2
    lit = seen * (1 - uneven * np.clip(away, 0, 1.3) / 1.3)[..., None]
    hazy = (1 - haze) * lit + haze * SAND
    noisy = cv2.GaussianBlur(hazy, (0, 0), 0.7) + noise * rng.standard_normal(hazy.shape)
    return View(image=np.clip(noisy, 0, 255).astype(np.uint8), rocks=rocks, image_from_floor=warp)


def _outline(rng: np.random.Generator, middle: Array) -> Mask:
    """Mark the texels of an irregular blob around a middle (2,) px, as of a rock or a stain."""
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    radius = rng.uniform(*ROCK_PX) * (
        1 + sum(0.15 / k * np.sin(k * angle + rng.uniform(0, 6)) for k in (2, 3, 5))
    )
    points = middle + np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    mask = np.zeros((FLOOR_SIZE, FLOOR_SIZE), np.uint8)
    cv2.fillPoly(mask, [points.round().astype(np.int32)], 1)
    return mask > 0


def _noise(rng: np.random.Generator, size: tuple[int, int], grain_px: int) -> Array:
    """Make smooth noise of variance 1 with grains of a size."""
    small = rng.standard_normal((size[0] // grain_px + 2, size[1] // grain_px + 2))
    smooth = cv2.resize(small, (size[1], size[0]), interpolation=cv2.INTER_CUBIC)
    return np.asarray(smooth / smooth.std())
