# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a real hull leaves its CAD model: a smooth random field of normal offsets."""

from __future__ import annotations

import numpy as np

from hullrecon.synthetic.spec import DiveSpec
from hullrecon.typing import Array


def deviation_m(spec: DiveSpec, along_m: Array, girth_m: Array, waves: int = 300) -> Array:
    """Return offsets (...) along the outward normal: a stationary Gaussian field with Matern 5/2
    correlation, half as long over the girth as along, drawn by its spectrum (a sum of plane waves,
    so it can be asked anywhere).
    """
    random = spec.hull_random("deviation")
    stretch = np.sqrt(5.0 / random.chisquare(5.0, waves))
    length = np.array([spec.deviation.length_m, 0.5 * spec.deviation.length_m])
    wave = random.standard_normal((waves, 2)) * stretch[:, None] / length
    phase = random.uniform(0, 2 * np.pi, waves)
    total = np.zeros(np.broadcast(along_m, girth_m).shape)
    for k, p in zip(wave, phase, strict=True):
        total += np.cos(k[0] * along_m + k[1] * girth_m + p)
    return np.asarray(spec.deviation.mean_m + spec.deviation.sigma_m * np.sqrt(2.0 / waves) * total)
