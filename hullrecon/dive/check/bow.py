# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say which end of the CAD model is taken for the bow, and from where stations and frames count."""

from __future__ import annotations

import numpy as np

from hullrecon.dive.config.schema import Hull
from hullrecon.geometry.charts.section_casting import AXES, hull_axes
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_mount, up_in

AFT_SHARE = 0.25  # of the length: farther from the aft end no aft perpendicular lies


def describe_bow(hull: Hull, mesh: Mesh) -> tuple[str, list[str]]:
    """Return a sentence, and one more where stations count from a place that can be no aft
    perpendicular.

    Raises InputError for a bow that the CAD model does not have.
    """
    forward = hull_axes(mesh.vertices, up_in(from_mount(hull.pose)), hull.bow)[0]
    axis = AXES[int(np.argmax(np.abs(forward)))]
    aft, bow = np.sort(mesh.vertices @ forward)[[0, -1]]
    zero = hull.aft_perpendicular
    ahead = zero * forward.sum() - aft
    why = "hull.bow" if hull.bow is not None else f"where {axis} grows, as hull.bow is not given"
    counted = f"its {axis} = {zero:g}{' m' if zero else ''}"
    end = f"{abs(ahead):.1f} m {'forward' if ahead >= 0 else 'aft'} of its aft end"
    at = round(float(bow * forward.sum()), 1) + 0.0  # no "-0.0"
    line = f"bow: at {axis} = {at:+.1f} m of the CAD model ({why}); stations count from {counted}, {end}"
    if abs(ahead) <= AFT_SHARE * (bow - aft):
        return line, []
    return line, [
        f"stations and frames count from {axis} = {zero:g} m of the CAD model, {end}: if its bow is the other end, give "
        "hull.bow; if its aft perpendicular lies elsewhere, hull.aft_perpendicular"
    ]
