# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surface that structures stand off: the CAD model, else the survey's own."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.charts.address import AddressSigma, address
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class BaseSurface:
    """The hull without structures, in the frame of the results (M, or g without a CAD model)."""

    cad_model: Mesh | None  # None where there is none, or it was refused
    surveyed: Surface  # the surface from the DVL, which is the base where there is no CAD model
    chart: Chart
    result_from_global: Poses  # a batch of one; the identity without a CAD model
    frame_spacing_m: float | None  # between the ship's frames, None where it is not known
    # where the hull lies in the dive's frame, None without a CAD model
    hull_pose: HullPose | None = None
    # whether z = 0 of g is the water surface: a pressure sensor was logged
    depth_known: bool = True
    from_dvl: bool = True  # whether the surveyed surface is the DVL's, else it is of landmarks
    position_sigma: AddressSigma | None = None  # of the survey as a whole
    # of the water surface in g, which covariances in M lack; None in g or if unknown
    depth_sigma_m: float | None = None

    @property
    def mesh(self) -> Mesh:
        """Return the CAD model, else the surveyed surface."""
        return self.surveyed.mesh() if self.cad_model is None else self.cad_model

    @property
    def frame(self) -> Frame:
        """Return the frame of all points: M, or g without a CAD model."""
        return Frame.GLOBAL if self.cad_model is None else Frame.HULL

    @property
    def description(self) -> str:
        """Name in words what heights are counted from."""
        return "the surface step's own surface" if self.cad_model is None else "the CAD model"

    def address_of(self, point: Array, sigma: AddressSigma | None = None) -> str:
        """Say in words where a point (3,) lies on the hull, no finer than its sigma.

        `sigma`: of the point; that of the survey as a whole if none is given.
        """
        depth = self.depth_of(point)
        depths = None if depth is None else [depth]
        return address(
            self.chart, point[None], self.frame_spacing_m, depths, sigma or self.position_sigma
        )[0]

    def depth_of(self, point: Array) -> float | None:
        """Compute the depth of a point (3,) below the water, m. None if not measured."""
        return (
            float(self.result_from_global.inverse().apply(point[None])[0, 2])
            if self.depth_known
            else None
        )
