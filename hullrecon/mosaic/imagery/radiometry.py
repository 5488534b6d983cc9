# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Model of the light in a camera's images, and its estimation.

The logarithm of an intensity is the sum of three terms: the scene at the texel, a smooth field over
the image that all images of a camera have in common (lamp, vignetting, attenuation at the usual
distance), and a gain for each image. Several views show a texel at different pixels, which
separates the scene from the field. Back-scatter, which is additive, is not modelled.
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

FLOOR = 2.0  # gray levels, the least whose logarithm is taken: darker ones are noise
FIELD = (24, 32)  # cells of the field, rows and columns
SMOOTH = 2.0  # cells, sigma of the field's smoothing
# Images of a camera whose median starts the field: it is known to a thirtieth of their spread. Each
# takes 0.15 MB.
MOST_IMAGES = 1000
SWEEPS = 60  # over all views, by which their gains are estimated
# Weight, in samples, of a prior that a view is as bright as the others. It keeps the gains from
# drifting along a chain of views
PULL = 20.0


@dataclass(frozen=True, kw_only=True)
class LightModel:
    """Terms that are subtracted from the logarithm of each view's intensities."""

    log_field: tuple[Array, ...]  # for each camera (rows, columns, channels), of mean zero
    log_gain: Array  # (views,) of each image

    def correct(self, picture: Picture, part: Part, camera: int, view: int) -> Floats32:
        """Correct a part of an image as if the light were even. Values may exceed 255.

        No pixel is brightened by more than 8 times, as noise would be all that shows.

        Parameters
        ----------
        picture
            The whole image.
        part
            Rows and columns that are corrected.
        camera, view
            Numbers of the camera, whose field is taken off, and of the view, whose gain is.
        """
        factor: Floats32 = np.negative(self._field_of(camera, picture.shape[:2])[part])
        factor -= np.float32(self.log_gain[view])
        np.minimum(np.exp(factor, out=factor), 8, out=factor)
        factor *= picture[part]
        return factor

    def _field_of(self, camera: int, shape: tuple[int, ...]) -> Floats32:
        """Enlarge a camera's field to the shape of an image, and keep it for the next image."""
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
    """Intensities of texels in several views, n samples."""

    view: Ints  # (n,)
    texel: Ints  # (n,)
    cell: Ints  # (n,) flat cell of the field at the texel's pixel
    log_value: Array  # (n, channels) logarithm of the intensity
    camera: Ints  # (views,) camera of each view


def first_fields(thumbnails: Sequence[NDArray[np.uint8]], camera: Ints) -> list[Array]:
    """Make the start value of each camera's field: the smoothed median of its log images.

    As images show different hull, their median shows the light. The mean of each image is taken off
    first. Of more than MOST_IMAGES images, evenly spaced ones are taken. camera (images,): number
    of each thumbnail's camera.
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
    """Estimate the images' gains and the cameras' fields in turns.

    Each follows from the residuals about the texels' means over their views. These are clipped, so
    that glints and shadows count little.

    Parameters
    ----------
    samples
        Intensities of texels, as the views of all cameras show them.
    fields
        Start values (rows, columns, channels) for each camera.
    rounds
        Number of turns.
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
    """Look up the field (n, channels) at each sample."""
    stack = np.stack([f.reshape(-1, f.shape[2]) for f in fields])
    return np.asarray(stack[samples.camera[samples.view], samples.cell])


def _texel_mean(samples: LightSamples, values: Array) -> Array:
    """Average values (n, channels) over all samples of a texel, and return that mean by sample."""
    count = np.bincount(samples.texel)
    sums = np.stack([np.bincount(samples.texel, v) for v in values.T], axis=1)
    return np.asarray((sums / np.maximum(count, 1)[:, None])[samples.texel])


def _gains(samples: LightSamples, values: Array, views: int) -> Array:
    """Estimate the log gain (views,) of each view relative to the mean of its texels, by sweeps.

    Residuals are clipped at 0.2 (Huber), a fifth of the brightness, so that glints count little.

    Parameters
    ----------
    samples
        Says of which view and texel each value is.
    values
        (n,) log intensity of each sample, without the field.
    views
        Number of views.
    """
    # Each sweep moves every gain by the mean residual of its samples. The prior counts as PULL
    # samples, with a fiftieth of their strength.
    gain = np.zeros(views)
    for _ in range(SWEEPS):
        level = values - gain[samples.view]
        rest = np.clip(level - _texel_mean(samples, level[:, None])[:, 0], -0.2, 0.2)
        step = np.bincount(samples.view, rest, minlength=views)
        gain = gain + (step - PULL * 0.02 * gain) / (
            np.bincount(samples.view, minlength=views) + PULL
        )
    return gain


def _correction(samples: LightSamples, residual: Array, camera: int) -> Array:
    """Average a camera's residuals of log intensity (n, channels) by cell of its light field.

    They are clipped at 0.3 before, and the means are smoothed. The result is added to the field.
    Clipping keeps glints and shadows from entering it.
    """
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
    """Reduce an image's log intensities (h, w, channels) to the cells of the light field."""
    import cv2

    small = cv2.resize(level.astype(np.float32), FIELD[::-1], interpolation=cv2.INTER_AREA)
    return np.asarray(small, float).reshape(*FIELD, -1)


def _smooth(field: Array, weight: Array) -> Array:
    """Smooth a field (rows, columns, channels) by the weight (rows, columns) of its cells.

    Cells without samples follow their neighbours.
    """
    from scipy.ndimage import gaussian_filter

    spread = gaussian_filter(weight.astype(float) + 1e-6, SMOOTH, mode="nearest")
    layers = [
        gaussian_filter(layer * (weight + 1e-6), SMOOTH, mode="nearest") / spread
        for layer in np.moveaxis(field, 2, 0)
    ]
    return np.stack(layers, axis=2)
