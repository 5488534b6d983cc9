# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The dive in sample_data/: `python -m hullrecon.synthetic.sample [FOLDER]` makes it again, byte for byte."""

from __future__ import annotations

import sys
from pathlib import Path

from hullrecon.synthetic.package import write_package
from hullrecon.synthetic.spec import DiveSpec

SAMPLE = DiveSpec(
    name="sample",
    seed=7,
    legs=3,
    leg_length_m=2.8,
    leg_spacing_m=0.5,
    standoff_m=1.05,
    speed=0.3,
    views=6.5,
    image_width=480,
    image_height=384,
    jpeg_quality=80,
    structures=3,
    marks=1,
    barnacles=1,
    guess_along_m=0.3,
)


def main() -> None:
    home = Path(__file__).resolve().parents[2] / "sample_data"
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else home
    write_package(folder, SAMPLE)
    print(folder)


if __name__ == "__main__":
    main()
