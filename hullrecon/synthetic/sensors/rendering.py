# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Camera images: a ray a pixel, one lamp, and water that absorbs, veils and blurs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.world.built_hull import Block
from hullrecon.synthetic.world.texture import Albedo
from hullrecon.typing import Array, Floats32

ABSORPTION = np.array([1.55, 0.9, 1.1], np.float32)  # RGB, relative: red goes first
VEIL = np.array([0.020, 0.062, 0.050], np.float32)  # RGB, of an endless water column


@dataclass(frozen=True)
class Scene:
    """Hold what is before the lens. absorption: of green light, per metre of water."""

    block: Block
    atlas: Albedo
    absorption: float


@dataclass(frozen=True)
class Lens:
    """Hold a camera's rays (h w, 3) and its vignetting (h, w)."""

    camera: CameraModel
    ray: Floats32
    vignetting: Floats32


def lens(camera: CameraModel) -> Lens:
    """Return the rays of all pixels of a camera, row by row."""
    x, y = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
    ray = camera.rays(np.stack([x.ravel(), y.ravel()], 1)).astype(np.float32)
    return Lens(
        camera, ray, np.asarray(ray[:, 2] ** 2.5, np.float32).reshape(camera.height, camera.width)
    )


def photograph(
    scene: Scene, view: Lens, hull_from_camera: Poses, lamp: Array, random: np.random.Generator
) -> NDArray[np.uint8]:
    """Return one image (h, w, 3) RGB from a pose (a batch of one) with the lamp at that point of M."""
    shape = view.vignetting.shape
    direction = view.ray @ hull_from_camera.rotation.as_matrix()[0].T.astype(np.float32)
    hits = scene.block.rays.cast(hull_from_camera.translation, direction)
    range_m = np.where(hits.hit, hits.range_m, np.float32(8.0))
    corner = scene.block.built.mesh.faces[hits.face]
    chart = np.einsum("nk,nkd->nd", hits.weight, scene.block.built.chart[corner])
    normal = np.einsum("nk,nkd->nd", hits.weight, scene.block.built.normal[corner])
    along_m, girth_m, seen = (
        chart[:, 0].reshape(shape),
        chart[:, 1].reshape(shape),
        hits.hit.reshape(shape),
    )
    albedo = scene.atlas.look_up(along_m, girth_m, seen).reshape(-1, 3)
    point = direction * range_m[:, None]
    light, lamp_way = _lamp(
        scene, hits.hit, point, normal, chart, hull_from_camera.translation[0], lamp
    )
    water = np.exp(-scene.absorption * ABSORPTION * (range_m + lamp_way)[:, None])
    veil = VEIL * (1 - np.exp(-scene.absorption * ABSORPTION * 1.3 * range_m[:, None]))
    radiance = albedo * light[:, None] * water * hits.hit[:, None] + veil
    radiance = radiance.reshape(*shape, 3) * view.vignetting[..., None]
    return _expose(_snow(radiance, random), random)


def _lamp(
    scene: Scene,
    hit: NDArray[np.bool_],
    point: Floats32,
    normal: Floats32,
    chart: Floats32,
    camera: Array,
    lamp: Array,
) -> tuple[Floats32, Floats32]:
    """Return the light (n,) that the lamp throws on points given from the camera, and its way
    through the water; shadows where something stands out nearby.
    """
    to_lamp = (lamp - camera).astype(np.float32) - point
    way = np.linalg.norm(to_lamp, axis=1)
    to_lamp /= way[:, None]
    light = np.clip(np.einsum("nd,nd->n", normal, to_lamp), 0, 1) / way**2
    patch, busy = scene.block.patch, scene.block.built.busy
    i = np.clip(np.rint((chart[:, 0] - patch.along_m[0]) / 0.03), 0, busy.shape[0] - 1).astype(int)
    j = np.clip(np.rint((chart[:, 1] - patch.girth_m[0]) / 0.03), 0, busy.shape[1] - 1).astype(int)
    ask = np.flatnonzero(busy[i, j] & hit)
    if len(ask):
        start = camera + point[ask] + 0.004 * normal[ask]
        light[ask[scene.block.rays.is_blocked(start, to_lamp[ask], way[ask])]] *= np.float32(0.25)
    return np.asarray(light, np.float32), np.asarray(way, np.float32)


def _snow(radiance: Floats32, random: np.random.Generator) -> Floats32:
    """Add particles in the beam, most of them out of focus, and the blur of the lens and the water."""
    import cv2

    height, width = radiance.shape[:2]
    flakes: Floats32 = np.zeros((height, width), np.float32)
    for x, y, r, tone in random.uniform(0, 1, (14, 4)).tolist():
        centre = (round(16 * x * width), round(16 * y * height))
        cv2.circle(
            flakes,
            centre,
            round(16 * (0.5 + 1.5 * r**4)),
            0.02 + 0.12 * tone**3,
            -1,
            cv2.LINE_AA,
            4,
        )
    lit = radiance + cv2.GaussianBlur(flakes, (0, 0), 0.8)[..., None] * np.array(
        [0.8, 1, 0.95], np.float32
    )
    return np.asarray(cv2.GaussianBlur(lit, (0, 0), 0.55), np.float32)


def _expose(radiance: Floats32, random: np.random.Generator) -> NDArray[np.uint8]:
    gain = np.float32(2.6 * (1 + 0.02 * random.standard_normal()))
    image = 255 * np.sqrt(np.clip(gain * radiance, 0, 1))
    image += 1.6 * random.standard_normal(image.shape, np.float32)
    return np.asarray(np.clip(np.rint(image), 0, 255), np.uint8)
