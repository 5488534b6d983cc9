# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a structure's footprint ends only because the survey does: what lies beyond was not
measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.regions import Region
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.typing import Array, Ints

BAND_M = 0.018  # around a footprint: one and a half edges of the mesh at structures
# root mean square, over its range, of what lies anywhere between nothing and that
UNIFORM = 1 / np.sqrt(3)


@dataclass(frozen=True, kw_only=True)
class OpenEdge:
    """share: of a narrow band around the footprint, what was not measured. beyond: unmeasured
    vertices onto which the structure may go on. height m: how high it stands beside them above the
    hull around it, signed; 0 without an open edge.
    """

    share: float
    beyond: Ints
    height: float


def find_open_edge(found: HullAsFound, region: Region, area: Array, around: Around) -> OpenEdge:
    """Return where the footprint of a region borders on vertices that no landmark decides.

    area (n,) m2 and around: of the vertices of the base. As much of a structure may be hidden as is
    seen: it may go on as far as its footprint reaches from its middle.
    """
    at, foot = found.base.vertices, region.foot
    reach = max(BAND_M, float(np.linalg.norm(at[foot] - at[foot].mean(axis=0), axis=1).max()))
    near = np.setdiff1d(around.ball(at[foot], reach), foot)
    unmeasured = ~found.measured[near]
    band = nearest(at[foot], at[near], 1)[0][:, 0] <= BAND_M
    gap = near[band & unmeasured]
    if not len(gap):
        return OpenEdge(share=0.0, beyond=np.zeros(0, np.int64), height=0.0)
    hidden = near[unmeasured]
    beside = np.isfinite(nearest(at[gap], at[foot], 1, BAND_M)[0][:, 0])
    return OpenEdge(
        share=float(area[gap].sum() / area[near[band]].sum()),
        beyond=hidden[np.isfinite(nearest(at[gap], at[hidden], 1, reach)[0][:, 0])],
        height=region.side * float(np.mean(region.rise(found, foot[beside]))),
    )
