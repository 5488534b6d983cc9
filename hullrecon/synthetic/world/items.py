# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What stands on a hull, is cut into it, painted on it or grows on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["cylinder", "dome", "box", "lump", "recess", "barnacles", "digits", "stripe", "ring"]
STRUCTURES: tuple[Kind, ...] = ("cylinder", "dome", "box", "lump", "recess")
MARKS: tuple[Kind, ...] = ("digits", "stripe", "ring")


@dataclass(frozen=True)
class Item:
    """Describe something added to the CAD model: a structure, a painted mark (no height) or a patch
    of barnacles.

    along_m, girth_m: its middle in the chart; height_m: over the steel, negative for a recess;
    size_m: full extent along and across; turn_rad: its turn in the chart.
    """

    kind: Kind
    along_m: float
    girth_m: float
    height_m: float
    size_m: tuple[float, float]
    turn_rad: float = 0.0

    def reach_m(self) -> float:
        """Return the radius of a circle around it."""
        return 0.5 * float(np.hypot(*self.size_m))
