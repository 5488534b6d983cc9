# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Say how much of the CAD model each region of dive.toml holds."""

from __future__ import annotations

from hullrecon.dive.check.messages import count_noun
from hullrecon.dive.config.schema import Hull
from hullrecon.errors import InputError
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.charts.region import chart_limits, region_cells
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_mount, up_in


def describe_regions(hull: Hull | None, mesh: Mesh | None) -> tuple[list[str], list[str]]:
    """Return a sentence for each region with its area, and one for each that holds no hull; none
    without a CAD model.
    """
    regions = () if hull is None else hull.region or ()
    if not regions or hull is None or mesh is None:
        return [], []
    try:
        chart = chart_for_hull(mesh, up_in(from_mount(hull.pose)), hull.bow, hull.aft_perpendicular)
    except InputError as error:
        return [], [f"{count_noun(len(regions), 'hull.region')} cannot be counted: {error.what}"]
    areas = {
        region: float(region_cells(chart, mesh, region.along, region.girth).area.sum())
        for region in regions
    }
    (along, girth) = (
        f"{low:.1f} to {high:.1f} m" for low, high in chart_limits(chart, mesh).round(1) + 0.0
    )
    empty = f"holds no hull: the CAD model reaches from {along} along, {girth} in girth"
    return (
        [
            f"region {region.name}: {area:.1f} m2 of the CAD model"
            for region, area in areas.items()
            if area
        ],
        [f"hull.region {region.name} {empty}" for region, area in areas.items() if not area],
    )
