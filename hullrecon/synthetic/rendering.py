# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Camera images by ray casting, one ray a pixel, with one lamp and water.

The water absorbs light, scatters it back as a veil and blurs the image.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.atlas import Albedo, Atlas, PaintedHull, PlateAtlas, paint_atlas
from hullrecon.synthetic.built_hull import Block
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import Cameras, DiveSpec
from hullrecon.synthetic.vehicle import LAMP_IN_TOP, TRAY_ORIGIN
from hullrecon.typing import Array, Floats32, Pixels

ABSORPTION = np.array([1.55, 0.9, 1.1], np.float32)  # RGB, relative: red is absorbed most
VEIL = np.array([0.020, 0.062, 0.050], np.float32)  # RGB radiance of an endless water column
LENS_WAVES = 6  # plane waves of a lens's error in either axis, at most one period over the image
ATLAS_TEXELS = 24e6  # largest texture that is one image: painting it takes 0.5 GB


@dataclass(frozen=True)
class Scene:
    """What a camera looks at."""

    block: Block  # of the hull around the vehicle
    atlas: Albedo  # its colours
    absorption: float  # per metre of water, to be multiplied by ABSORPTION for each colour


@dataclass(frozen=True)
class Lens:
    """A camera's rays."""

    camera: CameraModel
    ray: Floats32  # (h w, 3) unit vectors
    vignetting: Floats32  # (h, w)


def photographs(dive: Dive) -> Iterator[tuple[Pixels, Pixels | None]]:
    """Render each frame's RGB images (h, w, 3) of the top and the bottom camera.

    The second image is None without a bottom camera.
    """
    rig, motion, random = dive.rig, dive.motion, dive.spec.random("camera")
    # 2: to a hull at the visibility and back, light keeps e^-4, 2 %, where ABSORPTION is 1
    paint, absorption = _paint(dive), 2.0 / dive.spec.visibility_m
    top = lens(rig.camera_top, lens_error(dive.spec, "camera_top", rig.camera_top))
    bottom = None
    if rig.camera_bottom is not None:
        error = lens_error(dive.spec, "camera_bottom", rig.camera_bottom)
        bottom = lens(rig.camera_bottom, error)
    exposed_s = row_times(dive.frame_s, dive.spec.cameras)
    poses_per_image = exposed_s.shape[1]
    tray_from_bottom = rig.tray_from_top @ rig.top_from_bottom
    # The bottom image is exposed late_s later, when the lamp has moved on with the top camera
    late_s = dive.spec.cameras.pair_offset_s
    hull_from_top, hull_from_bottom, lit_from = (
        motion.in_hull(motion.on_tray(exposed_s.ravel() + after_s, mount, TRAY_ORIGIN))
        for mount, after_s in (
            (rig.tray_from_top, 0.0),
            (tray_from_bottom, late_s),
            (rig.tray_from_top, late_s),
        )
    )
    for k in range(0, exposed_s.size, poses_per_image):
        scene = Scene(dive.hull.near(hull_from_top.translation[k, 0]), paint, absorption)
        rows = slice(k, k + poses_per_image)
        lamp, lamp_late = (
            pose[rows].apply(np.tile(LAMP_IN_TOP, (poses_per_image, 1)))
            for pose in (hull_from_top, lit_from)
        )
        first = photograph(scene, top, hull_from_top[rows], lamp, random)
        second = None
        if bottom is not None:
            second = photograph(scene, bottom, hull_from_bottom[rows], lamp_late, random)
        yield first, second


def row_times(frame_s: Array, cameras: Cameras) -> Array:
    """List when the rows of each image are exposed (n, h), s; once (n, 1) without a readout time.

    The first row is exposed at the frame's own time.
    """
    if cameras.readout_s == 0:
        return frame_s[:, None]
    rows = np.arange(cameras.image_height) / (cameras.image_height - 1)
    return np.asarray(frame_s[:, None] + cameras.readout_s * rows)


def lens_error(spec: DiveSpec, name: str, camera: CameraModel) -> Array | None:
    """Draw the smooth error e (h, w, 2) px of a lens that its calibration does not model.

    Pixel p sees the ray that the calibration gives pixel p + e. It has no affine part, which any
    calibration would have found. None without an error.
    """
    if spec.cameras.lens_error_px == 0:
        return None
    random = spec.random(f"lens error {name}")
    y, x = np.mgrid[-1 : 1 : camera.height * 1j, -1 : 1 : camera.width * 1j]
    error = np.zeros((camera.height, camera.width, 2))
    for k in range(2):
        for a, b, phase in random.uniform(-np.pi, np.pi, (LENS_WAVES, 3)):
            error[..., k] += np.cos(a * x + b * y + phase)
    affine = np.stack([np.ones(x.size), x.ravel(), y.ravel()], axis=1)
    flat = error.reshape(-1, 2)
    flat = flat - affine @ np.linalg.lstsq(affine, flat, rcond=None)[0]
    rms_px = np.sqrt((flat**2).sum(axis=1).mean())
    return np.asarray((spec.cameras.lens_error_px / rms_px * flat).reshape(error.shape))


def _paint(dive: Dive) -> Albedo:
    """Choose the colours of the hull, made hard for image matching if the spec asks for it.

    The colours come again every `repeats_m` along the hull, so that places look alike. Or the paint
    is of one tone over the share `bare_share` of the legs, from their end towards the stern, so
    that images show nothing.
    """
    paint, survey = dive.spec.paint, dive.spec.survey
    if paint.bare_share == 0 and paint.repeats_m is None:
        return _choose_atlas(dive)
    # forward end of the bare paint; the legs lie about the middle of the hull that is seen
    bare_to_m = float(np.mean(dive.seen_along)) + (paint.bare_share - 0.5) * survey.leg_length_m
    return PaintedHull(
        albedo=_choose_atlas(dive),
        start_m=dive.seen_along[0],
        bare_to_m=bare_to_m if paint.bare_share else None,
        repeats_m=paint.repeats_m,
    )


def _choose_atlas(dive: Dive) -> Atlas | PlateAtlas:
    """Make the texture: as one image if it is small, else plate by plate."""
    spec = dive.spec
    texel_m = max(0.001, 0.75 * spec.survey.standoff_m / dive.rig.camera_top.fx)
    texels = np.ptp(dive.seen_along) * np.ptp(dive.seen_girth) / texel_m**2
    if texels <= ATLAS_TEXELS:
        return paint_atlas(spec, dive.items, dive.seen_along, dive.seen_girth, texel_m)
    return PlateAtlas(spec, dive.items, texel_m)


def lens(camera: CameraModel, error_px: Array | None = None) -> Lens:
    """Compute the rays of all pixels of a camera, row by row, with its lens's error (h, w, 2)."""
    x, y = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
    pixel = np.stack([x.ravel(), y.ravel()], 1)
    if error_px is not None:
        pixel += error_px.reshape(-1, 2)
    ray = camera.rays(pixel).astype(np.float32)
    # Vignetting: light falls off with the cosine to the optical axis
    light = np.asarray(ray[:, 2] ** 2.5, np.float32)
    return Lens(camera, ray, light.reshape(camera.height, camera.width))


def photograph(
    scene: Scene, view: Lens, hull_from_camera: Poses, lamp: Array, random: np.random.Generator
) -> NDArray[np.uint8]:
    """Render an image (h, w, 3) RGB.

    Parameters
    ----------
    scene
        What the camera looks at.
    view
        Its rays.
    hull_from_camera
        One pose, or one for each row of the image (h), as of a rolling shutter.
    lamp
        Position (1, 3) or (h, 3) of the lamp in the hull's frame.
    random
        For particles and noise.
    """
    shape = view.vignetting.shape
    each = len(view.ray) // len(hull_from_camera)  # pixels that share a pose
    turn = hull_from_camera.rotation.as_matrix().swapaxes(1, 2).astype(np.float32)
    direction = (view.ray.reshape(len(turn), each, 3) @ turn).reshape(-1, 3)
    camera, lamp = (np.repeat(at, each, axis=0) for at in (hull_from_camera.translation, lamp))
    hits = scene.block.rays.cast(camera, direction)
    range_m = np.where(hits.hit, hits.range_m, np.float32(8.0))  # 8 m of water where none is hit
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
    light, lamp_m = _illuminate(scene, hits.hit, point, normal, chart, camera, lamp)
    water = np.exp(-scene.absorption * ABSORPTION * (range_m + lamp_m)[:, None])
    veil = VEIL * (1 - np.exp(-scene.absorption * ABSORPTION * 1.3 * range_m[:, None]))
    radiance = albedo * light[:, None] * water * hits.hit[:, None] + veil
    radiance = radiance.reshape(*shape, 3) * view.vignetting[..., None]
    return _expose(_add_particles(radiance, random), random)


def _illuminate(
    scene: Scene,
    hit: NDArray[np.bool_],
    point: Floats32,
    normal: Floats32,
    chart: Floats32,
    camera: Array,
    lamp: Array,
) -> tuple[Floats32, Floats32]:
    """Compute the lamp's light at points of the hull, with the shadows of items.

    Parameters
    ----------
    scene
        The hull.
    hit
        Rays (n,) that hit it.
    point, normal
        Points (n, 3) relative to the camera, and outward normals there.
    chart
        Their chart coordinates (n, 2).
    camera, lamp
        Positions (n, 3) in the hull's frame.

    Returns
    -------
    light
        (n,) irradiance, by angle of incidence and inverse square of the distance.
    distance
        (n,) from lamp to point, m.
    """
    to_lamp = (lamp - camera).astype(np.float32) - point
    distance = np.linalg.norm(to_lamp, axis=1)
    to_lamp /= distance[:, None]
    light = np.clip(np.einsum("nd,nd->n", normal, to_lamp), 0, 1) / distance**2
    # Only items cast shadows, so that rays to the lamp are cast only near items: at nodes of the
    # patch, 0.03 m apart, that are busy. A shadow leaves a quarter of the light.
    patch, busy = scene.block.patch, scene.block.built.busy
    i = np.clip(np.rint((chart[:, 0] - patch.along_m[0]) / 0.03), 0, busy.shape[0] - 1).astype(int)
    j = np.clip(np.rint((chart[:, 1] - patch.girth_m[0]) / 0.03), 0, busy.shape[1] - 1).astype(int)
    ask = np.flatnonzero(busy[i, j] & hit)
    if len(ask):
        start = camera[ask] + point[ask] + 0.004 * normal[ask]
        is_blocked = scene.block.rays.is_blocked(start, to_lamp[ask], distance[ask])
        light[ask[is_blocked]] *= np.float32(0.25)
    return np.asarray(light, np.float32), np.asarray(distance, np.float32)


def _add_particles(radiance: Floats32, random: np.random.Generator) -> Floats32:
    """Add particles in the water to a picture's radiance (h, w, 3), and blur by lens and water.

    Most of them are small and faint, as out of focus.
    """
    import cv2

    height, width = radiance.shape[:2]
    flakes: Floats32 = np.zeros((height, width), np.float32)
    for x, y, size, tone in random.uniform(0, 1, (14, 4)).tolist():
        # Centre and radius in sixteenths of a pixel, as cv2 takes them with a shift of 4 bits
        centre = (round(16 * x * width), round(16 * y * height))
        cv2.circle(
            flakes,
            centre,
            round(16 * (0.5 + 1.5 * size**4)),
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
    """Convert radiance (h, w, 3) to grey levels 0 to 255.

    The gain varies a little from image to image, and noise is added.
    """
    gain = np.float32(2.6 * (1 + 0.02 * random.standard_normal()))
    image = 255 * np.sqrt(np.clip(gain * radiance, 0, 1))
    image += 1.6 * random.standard_normal(image.shape, np.float32)
    return np.asarray(np.clip(np.rint(image), 0, 255), np.uint8)
