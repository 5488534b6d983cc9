# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Recognise calibrations of other programs, which are not read, and say how to rewrite them."""

from __future__ import annotations

import re

CENTRE = "cx and cy less 0.5, as its first pixel has its centre at 0.5"
# A pattern in the file, whose calibration it then is, and what of it to write as camera_info YAML
FOREIGN = (
    (r"<opencv_storage>", "OpenCV's XML", "the same names and numbers as YAML"),
    (
        r"<calibration>[\s\S]*<f>",
        "Metashape's XML",
        "fx = f + b1, fy = f, cx and cy plus (width - 1) / 2 and (height - 1) / 2, and "
        "distortion_coefficients k1, k2, p2, p1, k3",
    ),
    (r"(?m)^\d+ (SIMPLE_|FULL_)?(PINHOLE|RADIAL|OPENCV)", "COLMAP's cameras.txt", CENTRE),
    (r"IntrinsicMatrix|RadialDistortion", "MATLAB's", "cx and cy less 1, as its pixels begin at 1"),
    (r"oST version", "camera_calibration's ost.txt", "its ost.yaml, which is written beside it"),
    (r"(?m)^M1:", "OpenCV's of a stereo pair", "one YAML for each camera, with its images' size"),
    (
        r"(?m)^Camera1?\.fx",
        "ORB-SLAM's settings",
        "camera_matrix and distortion_coefficients k1, k2, p1, p2, k3",
    ),
    (
        r"projection_parameters:",
        "VINS-Mono's (camodocal)",
        "camera_matrix fx 0 cx, 0 fy cy, 0 0 1 and distortion_coefficients k1, k2, p1, p2, where "
        "its model_type is PINHOLE",
    ),
    (r"libCalib::", "calib.io's", "fx = f, fy = f ar, cx, cy, and k1, k2, p1, p2, k3"),
    (
        r'"camera_type"',
        "Basalt's",
        "one of plumb_bob, as its models kb4, ds and eucm are other lenses than are read",
    ),
    (
        r"ros__parameters:",
        "a file of a ROS 2 node's parameters",
        "what stands below ros__parameters, without the lines above and without the indentation",
    ),
    (r"\APK\x03\x04", "NumPy's archive", "camera_matrix, distortion_coefficients and the size"),
)


def name_foreign(text: str) -> tuple[str, str] | None:
    """Tell which program's calibration a file is, and what to write in its place.

    None where no pattern of FOREIGN is found.
    """
    for pattern, whose, how in FOREIGN:
        if re.search(pattern, text):
            return whose, f"write a camera_info YAML: {how}"
    return None
