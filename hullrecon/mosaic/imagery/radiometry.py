# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What lamp and lens do to a camera's images, and how bright each image is.

The logarithm of an intensity is taken as the sum of the scene at the texel, a smooth field over the
image that is common to a camera (lamp, vignetting, attenuation at the usual distance), and a number
for each image. The scene is seen by several views at different places of their images, which tells
it from the field. Back-scatter, which adds, is not modelled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Floats32, Ints

Part = tuple[slice, slice]  # rows and columns
Picture = NDArray[np.uint8] | Floats32  # (h, w, channels)

FLOOR = 2.0  # gray levels: below it the logarithm is of noise
FIELD = (24, 32)  # cells of the field, rows and columns
SMOOTH = 2.0  # cells, sigma of the field's smoothing
# of a camera, whose median is known to a thirtieth of their spread: 0.15 MB each
MOST_IMAGES = 1000


@dataclass(frozen=True, kw_only=True)
class LightModel:
    """What is subtracted from the logarithm of each view."""

    log_field: tuple[Array, ...]  # by camera, (rows, columns, channels)
    log_gain: Array  # (views,)

    def correct(self, picture: Picture, part: Part, camera: int, view: int) -> Floats32:
        """Correct a part of an image as if the lamp were even, 0 to 255 and beyond."""
        factor: Floats32 = np.negative(self._field_of(camera, picture.shape[:2])[part])
        factor -= np.float32(self.log_gain[view])
        np.minimum(np.exp(factor, out=factor), 8, out=factor)
        factor *= picture[part]
        return factor

    def _field_of(self, camera: int, shape: tuple[int, ...]) -> Floats32:
        """Enlarge a camera's field to an image of that shape: kept for the next image."""
        import cv2

        if (camera, shape) not in self._enlarged:
            small = self.log_field[camera].astype(np.float32)
            field = cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC)
            self._enlarged[camera, shape] = np.asarray(field, np.float32).reshape(*shape, -1)
        return self._enlarged[camera, shape]

    @cached_property
    def _enlarged(self) -> dict[tuple[int, tuple[int, ...]], Floats32]:
        return {}


@dataclass(frozen=True, kw_only=True)
class LightSamples:
    """Intensities of scene points in several views, a row (m) each."""

    view: Ints  # (m,)
    texel: Ints  # (m,)
    cell: Ints  # (m,) of the field
    log_value: Array  # (m, channels)
    camera: Ints  # (views,) that took the view


def first_fields(thumbnails: Sequence[NDArray[np.uint8]], camera: Ints) -> list[Array]:
    """Start the fields from the median over each camera's images, smoothed.

    Evenly chosen MOST_IMAGES where there are more; about a mean of zero.
    """
    fields = []
    for k in range(int(camera.max()) + 1):
        own = np.flatnonzero(camera == k)
        chosen = own[np.rint(np.linspace(0, len(own) - 1, min(len(own), MOST_IMAGES))).astype(int)]
        stack = np.stack([thumbnails[i] for i in chosen.tolist()])
        level = np.log(np.maximum(stack.astype(float), FLOOR))
        level -= level.mean(axis=(1, 2), keepdims=True)
        fields.append(_smooth(_resized(np.median(level, axis=0)), np.ones(FIELD)))
    return fields


def solve_light(samples: LightSamples, fields: list[Array], rounds: int = 3) -> LightModel:
    """Estimate gains and fields in turns.

    Each takes clipped departures from the texel's mean, so that glints and shadows count little.
    """
    gain = np.zeros(len(samples.camera))
    for _ in range(rounds):
        residual = samples.log_value - _field_at(samples, fields)
        gain = _gains(samples, residual.mean(axis=1), len(gain))
        residual -= gain[samples.view][:, None]
        residual -= _texel_mean(samples, residual)
        fields = [f + _correction(samples, residual, k) for k, f in enumerate(fields)]
        fields = [f - f.mean(axis=(0, 1)) for f in fields]
    return LightModel(log_field=tuple(fields), log_gain=gain)


def _field_at(samples: LightSamples, fields: list[Array]) -> Array:
    stack = np.stack([f.reshape(-1, f.shape[2]) for f in fields])
    return np.asarray(stack[samples.camera[samples.view], samples.cell])


def _texel_mean(samples: LightSamples, values: Array) -> Array:
    """Average (m, channels) over the views of each sample's texel."""
    count = np.bincount(samples.texel)
    sums = np.stack([np.bincount(samples.texel, v) for v in values.T], axis=1)
    return np.asarray((sums / np.maximum(count, 1)[:, None])[samples.texel])


def _gains(
    samples: LightSamples, values: Array, views: int, sweeps: int = 60, pull: float = 20.0
) -> Array:
    """Estimate each view's level against the scene's mean, by sweeps.

    Huber at 0.2, a fifth of the brightness: glints do not count more. `pull`: samples' worth of
    belief that a view is as bright as the others, which keeps a chain of views from drifting.
    """
    gain = np.zeros(views)
    for _ in range(sweeps):
        level = values - gain[samples.view]
        rest = np.clip(level - _texel_mean(samples, level[:, None])[:, 0], -0.2, 0.2)
        step = np.bincount(samples.view, rest, minlength=views)
        gain = gain + (step - pull * 0.02 * gain) / (
            np.bincount(samples.view, minlength=views) + pull
        )
    return gain


def _correction(samples: LightSamples, residual: Array, camera: int) -> Array:
    """Average what is left of a camera's samples by cell of its image, clipped and smoothed."""
    rows = samples.camera[samples.view] == camera
    cells = FIELD[0] * FIELD[1]
    count = np.bincount(samples.cell[rows], minlength=cells).reshape(FIELD)
    clipped = np.clip(residual[rows], -0.3, 0.3)
    sums = np.stack(
        [np.bincount(samples.cell[rows], v, minlength=cells) for v in clipped.T], axis=1
    )
    mean = sums.reshape(*FIELD, -1) / np.maximum(count, 1)[..., None]
    return _smooth(mean, count.astype(float))


def _resized(level: Array) -> Array:
    import cv2

    small = cv2.resize(level.astype(np.float32), FIELD[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(small, float).reshape(*FIELD, -1)


def _smooth(field: Array, weight: Array) -> Array:
    """Smooth by weight, filling cells without samples from their neighbours."""
    from scipy.ndimage import gaussian_filter

    spread = gaussian_filter(weight.astype(float) + 1e-6, SMOOTH, mode="nearest")
    layers = [
        gaussian_filter(layer * (weight + 1e-6), SMOOTH, mode="nearest") / spread
        for layer in np.moveaxis(field, 2, 0)
    ]
    return np.stack(layers, axis=2)
