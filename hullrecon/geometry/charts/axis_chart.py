# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chart of a CAD model: stations along an axis inside the ship, and girth from the keel.

A point belongs to the angle phi at which a ray from the axis meets it: 0 straight down, positive to
port. Its girth is the length of the section from phi = 0 to there. Rays are cast from outside
inward, so that of several skins the outer one counts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.charts.section_casting import (
    cast_sections,
    choose_axis_height,
    first_station,
    hull_axes,
    outward_faces,
)
from hullrecon.geometry.charts.sections import Sections
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array

TABLES = ("station", "angle", "radius", "girth")  # of the sections, as stored
POINTS_AT_ONCE = 1 << 17  # points charted at once: each takes some 500 bytes meanwhile


@dataclass(frozen=True)
class AxisChart:
    """The chart of a CAD model.

    Mesh and sections are in the ship's axes (x forward, y port, z up), in metres.
    """

    axes: Array  # (3, 3) rows forward, port, up in M: rotates M into the ship's axes
    mesh: Mesh  # with faces oriented outward
    sections: Sections
    aft_perpendicular: float = 0.0  # m, x at which `along` is zero

    @property
    def ship_axes(self) -> Array:
        """See `Chart`."""
        return self.axes

    @property
    def along_of_origin(self) -> float:
        """See `Chart`."""
        return -self.aft_perpendicular

    def to_chart(self, points: Array) -> Array:
        """Compute along, girth and offset (n, 3) m of points (n, 3) m in M.

        Points are projected onto the mesh, and the sections give the girth of their feet.
        """
        turned = np.atleast_2d(np.asarray(points, float)) @ self.axes.T
        out = np.empty(turned.shape)
        for rows in blocks_of_rows(len(turned), POINTS_AT_ONCE):
            out[rows] = self._chart_turned(turned[rows])
        return out

    def _chart_turned(self, turned: Array) -> Array:
        """Compute along, girth and offset (n, 3) m of points `turned` (n, 3) m in the ship's axes.

        NaN for points that are not finite, or whose foot is not on the skin of the sections.
        """
        out = np.full(turned.shape, np.nan)
        known = np.isfinite(turned).all(axis=1)
        if known.any():
            near = self.mesh.index.closest(turned[known])
            girth = self.sections.girth_at(near.point)
            along = near.point[:, 0] - self.aft_perpendicular
            out[known] = np.stack(
                [np.where(np.isnan(girth), np.nan, along), girth, near.distance], axis=1
            )
        return out

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        """Find the points (n, 3) and outward normals at along and girth (n, 2) m.

        From each girth follows an angle about the axis, and the skin is met along that ray.
        """
        at = np.atleast_2d(np.asarray(along_girth, float)) + np.array([self.aft_perpendicular, 0.0])
        angle, radius = self.sections.angle_of(at)
        points, normals = np.full((len(at), 3), np.nan), np.full((len(at), 3), np.nan)
        known = np.isfinite(radius)
        if known.any():
            points[known], normals[known] = self._on_skin(at[known, 0], angle[known], radius[known])
        return points @ self.axes, normals @ self.axes

    def _on_skin(self, along: Array, angle: Array, radius: Array) -> tuple[Array, Array]:
        """Intersect rays with the mesh: points and outward normals (n, 3), in the ship's axes.

        Where the ray passes through a small hole, they are the point interpolated by the sections,
        and the normal of the closest face.

        Parameters
        ----------
        along, angle, radius
            (n,) x in m, angle about the axis in rad, and interpolated distance from it in m.
        """
        origin, inward = self.sections.rays(along, angle)
        hit = self.mesh.index.cast(origin, inward)
        # A hit near the radius of the sections is on the skin. Any other is through a hole.
        point = origin + inward * (self.sections.reach - radius)[:, None]
        on = np.abs(hit.range - (self.sections.reach - radius)) <= self.sections.slack_at(
            along, angle
        )
        point[on] = origin[on] + inward[on] * hit.range[on, None]
        normal = hit.normal.copy()
        if not on.all():
            normal[~on] = self.mesh.index.closest(point[~on]).gradient
        # A normal along the ray, which goes inward, is turned
        return point, np.where(np.einsum("ni,ni->n", normal, inward)[:, None] > 0, -normal, normal)

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Collect the arrays that `from_arrays` reads."""
        s = self.sections
        return {
            "kind": np.asarray("axis"),
            "axes": self.axes,
            "vertices": self.mesh.vertices,
            "faces": self.mesh.faces,
            "axis": np.array([s.axis_y, s.axis_z, s.reach]),
            **{name: getattr(s, name) for name in (*TABLES, "whole")},
            **(
                {"aft_perpendicular": np.asarray(self.aft_perpendicular)}
                if self.aft_perpendicular
                else {}
            ),
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> AxisChart:
        """Rebuild the chart from the arrays of `to_arrays`."""
        axes, vertices, axis = (
            np.asarray(arrays[name], float) for name in ("axes", "vertices", "axis")
        )
        axis_y, axis_z, reach = axis.tolist()
        sections = Sections(
            axis_y=axis_y,
            axis_z=axis_z,
            reach=reach,
            whole=np.asarray(arrays["whole"], bool),
            **{name: np.asarray(arrays[name], float) for name in TABLES},
        )
        mesh = Mesh(vertices, np.asarray(arrays["faces"], np.int32))
        return cls(axes, mesh, sections, float(arrays.get("aft_perpendicular", np.zeros(()))))


def build_axis_chart(
    mesh: Mesh, up: Array, bow: str | None = None, aft_perpendicular_m: float | None = None
) -> AxisChart:
    """Build the chart of a CAD model. Parameters and exceptions are those of `chart_for_hull`."""
    axes = hull_axes(mesh.vertices, up, bow)
    turned = Mesh(mesh.vertices @ axes.T, mesh.faces)
    sections = cast_sections(turned, choose_axis_height(turned))
    if not sections.whole.any():
        raise InputError("the CAD model has no skin that a chart can follow", where="hull.mesh")
    return AxisChart(
        axes,
        outward_faces(turned, sections),
        sections,
        first_station(mesh.vertices, axes[0], aft_perpendicular_m),
    )
