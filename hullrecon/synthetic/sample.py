# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The dive in sample_data/demo, made again byte for byte.

`python -m hullrecon.synthetic.sample [FOLDER]`
"""

from __future__ import annotations

import sys
from pathlib import Path

from hullrecon.synthetic.options import Cameras, DiveSpec, InitialHullPose, Items, Survey
from hullrecon.synthetic.package import write_package

FOLDER = Path(__file__).resolve().parents[2] / "sample_data" / "demo"  # in a checkout
# From the side into the bilge where the bow begins to narrow: there the hull is curved both ways,
# so that the CAD model determines the position along it.
SAMPLE = DiveSpec(
    name="demo",
    seed=8,
    survey=Survey(
        along_m=38.0, top_m=1.75, legs=3, leg_length_m=3.0, leg_spacing_m=0.55, standoff_m=1.05
    ),
    cameras=Cameras(views=6.2, image_width=480, image_height=384, jpeg_quality=80),
    guess=InitialHullPose(along_m=0.3),
    items=Items(structures=4, marks=1, barnacles=1),
)


def main() -> None:
    """Write the sample dive into the folder given, or into sample_data."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    write_package(folder, SAMPLE)
    print(folder)


if __name__ == "__main__":
    main()
