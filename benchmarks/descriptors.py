# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How long finding and describing the features of an image takes: python -m benchmarks.descriptors
IMAGE [--features N]

By OpenCV alone, and found by OpenCV and described by us, in turn. Prints JSON: median of the CPU
milliseconds that an image takes either, and the share of the numbers that differ.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import cv2
import numpy as np

from benchmarks.arguments import parser_for
from hullrecon.typing import Pixels
from hullrecon.vision.features.extraction import (
    CONTRAST_THRESHOLD,
    find_sift,
    level_image,
    root_sift,
)
from hullrecon.vision.options import FeatureOptions


def by_opencv(levelled: Pixels, max_features: int) -> Pixels:
    """Find and describe features by OpenCV, in the order of `find_sift`."""
    sift = cv2.SIFT.create(
        nfeatures=max_features, contrastThreshold=CONTRAST_THRESHOLD, enable_precise_upscale=True
    )
    found, descriptors = sift.detectAndCompute(levelled, None)
    table = np.array([(*point.pt, point.size, point.response) for point in found])
    order = np.lexsort((table[:, 3], table[:, 2], table[:, 0], table[:, 1]))
    return root_sift(np.asarray(descriptors, np.float32)[order])


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("image", type=Path)
    parser.add_argument("--features", type=int, default=FeatureOptions().max_features)
    parser.add_argument("--repeat", type=int, default=9)
    args = parser.parse_args()
    image = cv2.imread(str(args.image), cv2.IMREAD_GRAYSCALE)
    if image is None:
        parser.error(f"{args.image} is no image")
    levelled, _ = level_image(np.asarray(image, np.uint8), FeatureOptions())
    spent: dict[str, list[float]] = {"opencv_ms": [], "ours_ms": []}
    for _ in range(args.repeat):
        begun = time.thread_time()
        theirs = by_opencv(levelled, args.features)
        between = time.thread_time()
        _, ours = find_sift(levelled, args.features)
        spent["opencv_ms"].append(1e3 * (between - begun))
        spent["ours_ms"].append(1e3 * (time.thread_time() - between))
    print(
        json.dumps(
            {
                "features": len(ours),
                **{name: round(float(np.median(taken)), 1) for name, taken in spent.items()},
                "numbers_that_differ": float(np.mean(ours != theirs)),
            }
        )
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
