# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is known of the hull before the survey: a CAD model, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart, chart_for_hull, chart_for_points
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How far the surface depends on the CAD model that it is compared with."""

    reference: str  # what the returns' offsets were regressed from
    note: str | None  # what a comparison with the CAD model is worth, None without one


@dataclass(frozen=True, kw_only=True)
class CadHull:
    """A hull with a CAD model, in M."""

    mesh: Mesh
    up: Sequence[float] | Array = (0.0, 0.0, 1.0)  # (3,) roughly up
    bow: str | None = None  # as `chart_for_hull` has it
    aft_perpendicular_m: float | None = None  # as `chart_for_hull` has it

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Unroll the CAD model, whatever points and sensors are."""
        return chart_for_hull(self.mesh, self.up, self.bow, self.aft_perpendicular_m)

    def on_hull(self, label: Ints) -> Mask:
        """Mark the landmarks (n,) labelled as lying on the CAD model's surface."""
        return np.asarray(label == 1)

    def deviation(self, vertices: Array) -> Array:
        """Measure the signed distance (n,) m of vertices (n, 3), outward positive."""
        return Scene(self.mesh).closest(vertices).distance

    def comparison(self, poses_are_adjusted: bool) -> Comparison:
        """Say how far the surface depends on the CAD model that it is compared with."""
        note = (
            "The surface is a regression of the returns' offsets from the CAD model and leans on "
            "it between and beyond returns: a comparison with the CAD model is partly circular."
        )
        if poses_are_adjusted:
            note += " The poses that place the returns were adjusted to the CAD model."
        return Comparison(reference="cad", note=note)


@dataclass(frozen=True, kw_only=True)
class UnknownHull:
    """A hull without a CAD model: everything stays in g."""

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Fit a plane through points (n, 3), its normal towards the sensors (m, 3)."""
        return chart_for_points(points, toward=sensors)

    def on_hull(self, label: Ints) -> Mask:
        """Mark every landmark (n,): nothing tells those on the hull from others."""
        return np.ones(len(label), bool)

    def deviation(self, vertices: Array) -> Array:
        """Return NaN (n,), as there is nothing to deviate from."""
        return np.full(len(vertices), np.nan)

    def comparison(self, poses_are_adjusted: bool) -> Comparison:
        """Say that offsets are from a plane, with no CAD model to compare with."""
        return Comparison(reference="plane", note=None)


HullReference = CadHull | UnknownHull
