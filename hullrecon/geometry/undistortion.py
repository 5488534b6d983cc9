# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Resample images of a distorted camera to a pinhole, for programs that know no distortion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.typing import Array, Pixels

BORDER_SAMPLES = 400  # points on each side of the image at which the distortion is inverted
INVERSE_PX = 0.01  # largest error of the distortion applied to its inverse


@dataclass(frozen=True)
class Undistortion:
    """A camera and the pinhole that its images are resampled to."""

    source: CameraModel
    # With the focal lengths of the camera, an image that is wholly inside of the camera's, and the
    # principal point in its middle, where programs that train Gaussian splats expect it
    pinhole: CameraModel

    def pixels(self, pixels: Array) -> Array:
        """Map pixels (n, 2) of the source to the pinhole's image."""
        return self.pinhole.distort(self.source.undistort(pixels))

    def holds(self, pixels: Array) -> Array:
        """Tell which pixels (n, 2) lie in the pinhole's image."""
        last = np.array([self.pinhole.width, self.pinhole.height]) - 0.5
        return np.asarray(np.all((pixels >= -0.5) & (pixels <= last), axis=1))

    def resample(self, image: Pixels) -> Pixels:
        """Resample an image (h, w, 3) of the source to the pinhole, cubic between pixels.

        Raises InputError for an image of another size than the source's.
        """
        import cv2

        if image.shape[:2] != (self.source.height, self.source.width):
            size, said = image.shape, self.source
            raise InputError(
                f"an image has {size[1]} x {size[0]} pixels, its calibration says "
                f"{said.width} x {said.height}"
            )
        u, v = (part.astype(np.float32) for part in self._source_pixels())
        return np.asarray(
            cv2.remap(image, u, v, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.uint8
        )

    def _source_pixels(self) -> tuple[Array, Array]:
        """Compute columns and rows (h, w) in the source of the pinhole's pixels.

        The image is resampled at these.
        """
        pinhole = self.pinhole
        x = (np.arange(pinhole.width) - pinhole.cx) / pinhole.fx
        y = (np.arange(pinhole.height) - pinhole.cy) / pinhole.fy
        ideal = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        u, v = self.source.distort(ideal).T.reshape(2, pinhole.height, pinhole.width)
        return u, v


def undistortion(camera: CameraModel) -> Undistortion:
    """Choose a pinhole for a camera, with nearly the largest image that is inside of the camera's.

    The image is symmetric about the principal point. Raises InputError if the distortion cannot be
    inverted because it folds the image within its borders.
    """
    columns, rows = (
        np.linspace(0, size - 1, BORDER_SAMPLES) for size in (camera.width, camera.height)
    )
    sides = [np.stack([np.full_like(rows, u), rows], axis=1) for u in (0, camera.width - 1)]
    sides += [np.stack([columns, np.full_like(columns, v)], axis=1) for v in (0, camera.height - 1)]
    left, right, top, bottom = (camera.undistort(side) for side in sides)
    missed = [
        camera.distort(ideal) - side
        for ideal, side in zip((left, right, top, bottom), sides, strict=True)
    ]
    # Half the width and height, px, of the rectangle about the axis that all four borders leave
    # free
    half_x = min(-left[:, 0].max(), right[:, 0].min()) * camera.fx
    half_y = min(-top[:, 1].max(), bottom[:, 1].min()) * camera.fy
    if not (np.abs(missed).max() < INVERSE_PX and half_x >= 1 and half_y >= 1):
        raise InputError("the camera's distortion cannot be undone up to the image's borders")
    # Between the centres of the first and the last pixel lie width - 1 pixels.
    width, height = (int(np.floor(2 * half)) + 1 for half in (half_x, half_y))
    pinhole = CameraModel(width, height, camera.fx, camera.fy, (width - 1) / 2, (height - 1) / 2)
    return Undistortion(camera, pinhole)
