# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's surface of a long survey: python -m benchmarks.surface [--legs N] [--leg-length-m L]
[--json FILE]

Legs half a metre apart along a flat plate that bulges by centimetres over metres, four beams, five
pings a second at 0.3 m/s. Prints JSON: returns, observations, tiles, seconds, peak memory, and how
far the surface lies off the plate in its own sigmas. The default is an hour: 10 legs of 100 m.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.bundle import peak_mb
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.surface.build import SurfacePoints, build_surface
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Array

LEG_SPACING_M, PING_M, BEAM_M, RANGE_SIGMA_M = 0.5, 0.06, 0.4, 0.01
BULGES = 40  # waves that the plate's shape is made of
SHAPE_SIGMA_M, SHAPE_SEED = 0.02, 2


def shape(at: Array, rng: np.random.Generator) -> Array:
    """Return the plate's bulge (n,) m at (n, 2): waves of 10 to 40 m along and 3 to 10 m in
    girth.
    """
    out = np.zeros(len(at))
    for _ in range(BULGES):
        wave = 2 * np.pi / np.array([rng.uniform(10, 40), rng.uniform(3, 10)])
        out += np.cos(at @ (wave * rng.choice([-1, 1], 2)) + rng.uniform(0, 2 * np.pi))
    return SHAPE_SIGMA_M * np.sqrt(2 / BULGES) * out


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("--legs", type=int, default=10)
    parser.add_argument("--leg-length-m", type=float, default=100.0)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rng = np.random.default_rng(1)
    along = np.arange(0, args.leg_length_m, PING_M)
    beams = BEAM_M * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    legs = [
        np.column_stack([along, np.full(len(along), LEG_SPACING_M * k)]) for k in range(args.legs)
    ]
    at = (np.concatenate(legs)[:, None] + beams).reshape(-1, 2)
    plate = PlaneChart(origin=np.zeros(3), axes=np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    base, normal = plate.from_chart(at)
    off = shape(at, np.random.default_rng(SHAPE_SEED)) + RANGE_SIGMA_M * rng.standard_normal(
        len(at)
    )
    point = base + normal * off[:, None]
    row = measure(plate, at, point)
    print(json.dumps(row, indent=1))
    keep(row, args.json)
    return 0


def measure(plate: PlaneChart, at: Array, point: Array) -> dict[str, object]:
    """Score one survey."""
    everything = np.ones(len(at), bool)
    observed = SurfacePoints(
        point=point,
        noise=np.full(len(at), RANGE_SIGMA_M),
        pose_sigma=np.zeros(len(at)),
        gives_support=everything,
    )
    began = time.perf_counter()
    surface, facts = build_surface(observed, plate, SurfaceOptions())
    seconds = time.perf_counter() - began
    charted = plate.to_chart(surface.vertices)
    off = (charted[:, 2] - shape(charted[:, :2], np.random.default_rng(SHAPE_SEED))) / surface.sigma
    return {
        "returns": len(at),
        "observations": facts["observations"],
        "tiles": facts["tiles"],
        "lengths_m": facts["lengths_m"],
        "vertices": len(surface.vertices),
        "seconds": round(seconds, 1),
        "peak_mb": peak_mb(),
        "error_in_sigmas_rms": float(np.sqrt((off**2).mean())),
    }


if __name__ == "__main__":
    sys.exit(main())
