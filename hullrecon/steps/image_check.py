# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check a few images of each camera, for `check` and the step navigate.

Images that show nothing, or the same picture again and again, measure no motion. Compared with
other sensors they would make these look wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.navigation.dead_reckoning.dead_reckon import usable_frames
from hullrecon.navigation.suspects.comparisons.comparison import LEAST_WINDOWS
from hullrecon.records.sensors import ImageIndex
from hullrecon.rows import spread_rows
from hullrecon.typing import Pixels
from hullrecon.vision.features.extraction import extract
from hullrecon.vision.options import FeatureOptions
from hullrecon.vision.stereo.image_matcher import ReadImage

LOOKED_AT = 12  # images of a camera that are checked, spread over the dive
FEATURES = FeatureOptions(max_features=50)


def check_images(index: Mapping[Camera, ImageIndex], read: ReadImage) -> list[Finding]:
    """Find cameras whose images show nothing, or are the same to the last bit.

    Cameras of which fewer than LEAST_WINDOWS images can be read are not judged.
    """
    out = []
    for camera, images in index.items():
        _, rows = usable_frames(images)
        few = rows[spread_rows(len(rows), LOOKED_AT)]
        pictures = [picture for row in few if (picture := read(camera, int(row))) is not None]
        # With fewer images no flow is compared with other sensors, so that they do no harm.
        out += _check_pictures(pictures, camera.key) if len(pictures) >= LEAST_WINDOWS else []
    return out


def _check_pictures(pictures: Sequence[Pixels], camera: str) -> list[Finding]:
    """Find out whether some or all of a camera's pictures show nothing or are the same picture.

    There are at most two findings. Blank pictures are equal too: where some are blank, equal ones
    are not reported.
    """
    count = len(pictures)
    blank = sum(len(extract(picture, FEATURES)) == 0 for picture in pictures)
    if blank == count:
        return [Finding("images-blank", {"count": count}, camera)]
    # Exposures of the same scene still differ by noise: equal pictures are a frozen camera.
    same = sum(np.array_equal(a, b) for a, b in pairwise(pictures))
    if same and same == count - 1:
        return [Finding("images-frozen", {"count": count}, camera)]
    out = [Finding("images-blank-some", {"blank": blank, "count": count}, camera)] if blank else []
    if same and not blank:
        out.append(Finding("images-frozen-some", {"same": same + 1, "count": count}, camera))
    return out
