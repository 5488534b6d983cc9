# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check that nine numbers are the matrix of a camera with images of some size.

Copied from another program they may be transposed, in another order or unit, or count from the
middle of the image. Each of these is refused by its name.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.typing import Array

LEAST_SKEW = 1e-6  # of the focal length; a smaller skew is rounding
LEAST_FOCAL = 0.13  # of the larger side: an image sees 150 degrees then, more than a pinhole does
# How far a usual camera is off square pixels (log of fx / fy) and off the middle (share of size)
SQUARE, MIDDLE = 0.05, 0.05
# From here on the numbers are doubted, if another order of them makes a usual camera
UNUSUAL, OFF_MIDDLE = 0.25, 0.1
ROW_BY_ROW = "give fx 0 cx, 0 fy cy, 0 0 1, row by row"
IN_PIXELS = "give fx, fy, cx, cy in pixels of the images, from the upper left one"


def read_pinhole(matrix: Sequence[float], size: tuple[int, int], where: str) -> CameraModel:
    """Read a camera without distortion.

    Raises InputError for numbers that are no camera matrix, or that do not fit images of this size.

    Parameters
    ----------
    matrix : (9,) row by row
    size : (width, height), px
    where : its place, for errors
    """
    fx, skew, cx, other, fy, cy = matrix[:6]
    if list(matrix[6:]) != [0, 0, 1]:
        what = "camera_matrix has the last row {:g} {:g} {:g}, not 0 0 1".format(*matrix[6:])
        if matrix[8] == 1 and cx == cy == 0:
            what += ": is it transposed, as MATLAB has it?"
        raise InputError(what, where=where, remedy=ROW_BY_ROW)
    if not (0 < fx < 1e6 and 0 < fy < 1e6):
        swapped = ": are its first two rows swapped?" if fx == fy == 0 and skew * other > 0 else ""
        raise InputError(f"camera_matrix has focal lengths {fx:g} and {fy:g}{swapped}", where=where)
    if max(abs(skew), abs(other)) > LEAST_SKEW * fx:
        raise InputError(
            f"camera_matrix has a skew of {skew or other:g}, which is not modelled",
            where=where,
            remedy="calibrate without it, as camera_calibration and Kalibr do",
        )
    doubt = _find_doubt(np.array([fx, fy, cx, cy]), np.array(size, float))
    if doubt:
        raise InputError(f"camera_matrix has {doubt}", where=where, remedy=IN_PIXELS)
    return CameraModel(*size, fx, fy, cx, cy)


def _find_doubt(lens: Array, size: Array) -> str:
    """Describe why a camera's numbers cannot be in pixels of its images.

    "" if they can. Unusual numbers alone are accepted. They are doubted if another order of them,
    or of width and height, makes a usual camera.

    lens: (4,) fx, fy, cx, cy. size: (2,) width and height, px.
    """
    width, height = size
    fx, fy, cx, cy = lens
    images = f"images of {width:g} x {height:g} pixels"
    if lens[:2].max() < LEAST_FOCAL * size.max():
        return (
            f"the focal lengths {fx:g} and {fy:g} for {images}: are they millimetres, or shares of "
            "the image's size?"
        )
    if (np.abs(lens[2:]) < MIDDLE * size).all():
        return (
            f"the principal point {cx:g}, {cy:g}, a corner of {images}: does it count from their "
            "middle, as Metashape's does?"
        )
    if not _is_usual(lens, size, UNUSUAL, OFF_MIDDLE):
        if _is_usual(lens, size[::-1], SQUARE, MIDDLE):
            return (
                f"the principal point {cx:g}, {cy:g}, far off the middle of {images}: are width "
                "and height of the calibration exchanged?"
            )
        for order in permutations(lens.tolist()):
            if _is_usual(np.array(order), size, SQUARE, MIDDLE):
                return (
                    f"fx = {fx:g}, fy = {fy:g}, cx = {cx:g}, cy = {cy:g} for {images}: are these "
                    f"in another order, cx = {order[2]:g} and cy = {order[3]:g}?"
                )
    return ""


def _is_usual(lens: Array, size: Array, square: float, middle: float) -> bool:
    """Tell whether pixels are nearly square and the principal point is near the middle.

    Parameters
    ----------
    lens : (4,) fx, fy, cx, cy
    size : (2,) width and height
    square : largest log of fx / fy
    middle : largest distance of the principal point from the middle, as a share of the size
    """
    fx, fy, *centre = lens
    off_middle = np.abs(np.array(centre) / size - 0.5)
    return bool(fx > 0 and fy > 0 and abs(np.log(fx / fy)) < square and (off_middle < middle).all())
