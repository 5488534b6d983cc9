# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Unknowns and weights of the adjustment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from hullrecon.adjustment.hull_pose.segments import Segments
from hullrecon.adjustment.problem.deviation_field import DeviationGrid
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array

POINTS = 1 << 17  # taken at a time: the chart and the mesh need some 300 bytes for each


@dataclass(frozen=True, kw_only=True)
class HullState:
    """The hull as it is estimated."""

    cad_model: CadModel
    global_from_hull: Poses  # a batch of one
    survey_center: Array  # (3,) m in M, about which the hull's rotation is perturbed
    grid: DeviationGrid | None  # of the deviation field; None: no field
    field: Array  # (size,) m, deviation from the CAD model on the grid
    segments: Segments | None = None  # of a path that outages cut; None: the path is not cut

    def to_hull(self, points: Array) -> Array:
        """Transform points (n, 3) of g to M."""
        return self.global_from_hull.inverse().apply(points)

    def to_chart(self, points: Array) -> Array:
        """Compute along and girth (n, 2) m of points (n, 3) in g."""
        chart = self.cad_model.chart
        return _in_blocks(lambda some: chart.to_chart(self.to_hull(some))[:, :2], points)

    def cad_distance(self, points: Array) -> Array:
        """Compute signed distances (n,) m of points (n, 3) in g to the CAD model, + outside."""
        index = self.cad_model.mesh.index
        return _in_blocks(lambda some: index.closest(self.to_hull(some)).distance, points)

    def deviation(self, points: Array) -> Array:
        """Compute signed distances (n,) m of points (n, 3) in g to the hull, + outside.

        The hull is the CAD model moved along its normals by the deviation field.
        """
        distance, grid = self.cad_distance(points), self.grid
        if grid is None:
            return distance
        return distance - _in_blocks(
            lambda some: grid.value(self.field, self.to_chart(some)), points
        )


def _in_blocks(work: Callable[[Array], Array], points: Array) -> Array:
    """Compute from points (n, 3) what `work` gives for each, POINTS at a time."""
    if len(points) <= POINTS:
        return work(points)
    blocks = [work(points[first : first + POINTS]) for first in range(0, len(points), POINTS)]
    return np.concatenate(blocks)


@dataclass(frozen=True, kw_only=True)
class State:
    """The unknowns of the adjustment."""

    nodes: Poses  # (n,) global_from_vehicle
    tray: Array  # (n,) rad
    landmark: Array  # (L, 3) m in g; NaN: not used
    mounts: Mounts  # of a camera None where it was not carried or saw nothing
    navigation: Array  # (6,) errors, in the order of RigPriors.navigation_sigma
    hull: HullState | None  # None without a CAD model

    @property
    def path(self) -> VehiclePath:
        """Vehicle and tray at the nodes, in g."""
        return VehiclePath(poses=self.nodes, tray=self.tray)

    def mounted(self, rig: Rig) -> Rig:
        """Replace the rig's mounts by those of this state."""
        return rig.with_mounts(self.mounts)


@dataclass(frozen=True, kw_only=True)
class ResponseSigmas:
    """Sigma of an observed image coordinate, px, as a function of the detector's response.

    It is interpolated linearly in the logarithms of response and sigma.
    """

    pixel: float  # of all observations, taken where the response gives none
    least: float  # lower limit: no feature is located better
    corner: float | None = None  # of corners, which have no response; None: not estimated
    response: Array = field(default_factory=lambda: np.zeros(0))  # (k,) sample points, ascending
    sigma: Array = field(default_factory=lambda: np.zeros(0))  # (k,) px at these responses

    def ratio(self, response: Array) -> Array:
        """Compute the ratio (m,) of observations' sigmas to `pixel`, by their responses (m,).

        response: NaN for corners.
        """
        sigma = np.full(len(response), self.pixel)
        if self.corner is not None:
            sigma[np.isnan(response)] = self.corner
        if len(self.response):
            known = np.flatnonzero(response > 0)
            at = np.log(response[known])
            sigma[known] = np.exp(np.interp(at, np.log(self.response), np.log(self.sigma)))
        return np.asarray(np.maximum(sigma, self.least) / self.pixel)


@dataclass(frozen=True, kw_only=True)
class Weights:
    """Sigmas and weights of the measurements in a round."""

    pixel: float  # px, sigma of an image coordinate
    by_response: ResponseSigmas  # sigma of each observation
    depth: float  # ratio of the sigma of depths to that which navigation states
    tray: float  # rad, sigma of a reading of the tray's angle
    range_sigma: float  # m
    surface: Array  # (L,) weight of each landmark's surface factor
    tray_direction: Array  # (n,) +1 or -1: side of its backlash on which the tray hangs
    lens: Array  # (2,) px rms, displacement of top and bottom lens; 0: none
