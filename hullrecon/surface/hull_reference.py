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
    """reference: what the returns' offsets were regressed from; note: what a comparison of the
    surface with the CAD model is worth, None where there is no CAD model.
    """

    reference: str
    note: str | None


@dataclass(frozen=True, kw_only=True)
class CadHull:
    """A hull with a CAD model, in M; up (3,): roughly up there; bow and aft_perpendicular_m: as
    `chart_for_hull` has them.
    """

    mesh: Mesh
    up: Sequence[float] | Array = (0.0, 0.0, 1.0)
    bow: str | None = None
    aft_perpendicular_m: float = 0.0

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Return the ship's own chart; it depends on neither the points nor the sensors."""
        return chart_for_hull(self.mesh, self.up, self.bow, self.aft_perpendicular_m)

    def on_hull(self, label: Ints) -> Mask:
        """Return which landmarks (n,) were labelled as lying on the CAD model's surface."""
        return np.asarray(label == 1)

    def deviation(self, vertices: Array) -> Array:
        """Return the signed distance (n,) m of vertices (n, 3) from the CAD model, outward
        positive.
        """
        return Scene(self.mesh).closest(vertices).distance

    def comparison(self, reference: str, poses_are_adjusted: bool) -> Comparison:
        """Return the reference in force and how far the surface is independent of the CAD model."""
        poses = (
            " The poses that place the returns were adjusted to the CAD model."
            if poses_are_adjusted
            else ""
        )
        if reference != "cad":
            return Comparison(
                reference=reference,
                note=f"The CAD model's shape does not enter the regression of the returns.{poses}",
            )
        note = (
            "The surface is a regression of the returns' offsets from the CAD model and leans on it between and "
            "beyond returns: "
            f"a comparison with the CAD model is partly circular.{poses} "
            'surface.reference = "plane" or "none" regresses without it.'
        )
        return Comparison(reference=reference, note=note)


@dataclass(frozen=True, kw_only=True)
class UnknownHull:
    """A hull without a CAD model: everything stays in g."""

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Return a plane through points (n, 3), its normal to the side of the sensors (m, 3)."""
        return chart_for_points(points, toward=sensors)

    def on_hull(self, label: Ints) -> Mask:
        """Return True for every landmark (n,): nothing tells those on the hull from others."""
        return np.ones(len(label), bool)

    def deviation(self, vertices: Array) -> Array:
        """Return NaN (n,) for vertices (n, 3): there is nothing to deviate from."""
        return np.full(len(vertices), np.nan)

    def comparison(self, reference: str, poses_are_adjusted: bool) -> Comparison:
        """Return the reference in force, a plane unless heights alone are regressed; there is
        nothing to compare with.
        """
        return Comparison(reference="none" if reference == "none" else "plane", note=None)


HullReference = CadHull | UnknownHull
