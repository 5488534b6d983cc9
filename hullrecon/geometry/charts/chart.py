# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull chart: a two-dimensional coordinate (along, girth) in metres on the hull.

Every chart is left-handed about the outward normal: along x girth points inward. A raster whose
columns grow with `along` and whose rows grow downward with `girth` therefore shows the surface as a
diver outside sees it, not mirrored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array


class Chart(Protocol):
    """Coordinates on a surface.

    `along` grows forward, `girth` from the keel up, port positive (metres of arc).
    """

    @property
    def ship_axes(self) -> Array:
        """Rows forward, port, up (3, 3) in the chart's frame. In g x, -y and -z."""

    @property
    def along_of_origin(self) -> float:
        """`along` of the origin of the chart's frame, m."""

    def to_chart(self, points: Array) -> Array:
        """Convert points (n, 3) near the surface to along, girth, offset (n, 3), m.

        Points are in the chart's frame (M, or g without a CAD model). The offset is positive
        outward. NaN rows where the chart is not defined.
        """

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        """Convert along and girth (n, 2) to points on the surface and outward unit normals (n, 3).

        NaN rows outside the chart.
        """

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Collect the arrays of an artifact, which `chart_from_arrays` reads."""


def chart_for_hull(
    mesh: Mesh,
    up: ArrayLike = (0.0, 0.0, 1.0),
    bow: str | None = None,
    aft_perpendicular_m: float | None = None,
) -> Chart:
    """Build the chart of a CAD model: stations along the ship and girth from the keel.

    Parameters
    ----------
    mesh
        The CAD model.
    up
        (3,) roughly up in its frame. The nearest axis of the frame is taken. The ship lies along
        the longer of the two other axes.
    bow
        Direction of the bow along that axis, "+x" to "-z". If None, the axis points to the bow.
    aft_perpendicular_m
        Coordinate on that axis at which along is zero. If None, zero, or the aft end of a mesh that
        lies farther from zero than its length.

    Raises
    ------
    InputError
        For a bow along another axis, and when no ray from inside meets the mesh.
    """
    from hullrecon.geometry.charts.axis_chart import build_axis_chart

    return build_axis_chart(mesh, np.asarray(up, float), bow, aft_perpendicular_m)


def chart_for_points(points: ArrayLike, toward: ArrayLike) -> Chart:
    """Fit a chart to points (n, 3): a plane, or a cylinder where a plane would stretch the map.

    It serves where there is no CAD model.

    Parameters
    ----------
    points
        Points (n, 3) m of the hull in g, whose z is down.
    toward
        The side that the normal points to: a point (3,), or the sensors' positions (n, 3).

    Raises
    ------
    InputError
        With fewer than three points.
    """
    from hullrecon.geometry.charts.cylinder_chart import unroll
    from hullrecon.geometry.charts.plane_chart import SHIP_AXES_IN_G, fit_plane_chart

    points, sensors = np.asarray(points, float), np.atleast_2d(np.asarray(toward, float))
    plane = fit_plane_chart(points, sensors.mean(axis=0), up=SHIP_AXES_IN_G[2])
    return unroll(points, sensors, plane) or plane


def chart_from_arrays(arrays: Mapping[str, NDArray[np.generic]]) -> Chart:
    """Rebuild the chart from the arrays of `to_arrays`."""
    from hullrecon.geometry.charts.axis_chart import AxisChart
    from hullrecon.geometry.charts.cylinder_chart import CylinderChart
    from hullrecon.geometry.charts.plane_chart import PlaneChart

    read: dict[str, Callable[[Mapping[str, NDArray[np.generic]]], Chart]] = {
        "axis": AxisChart.from_arrays,
        "cylinder": CylinderChart.from_arrays,
        "plane": PlaneChart.from_arrays,
    }
    return read[str(arrays["kind"])](arrays)
