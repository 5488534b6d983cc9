# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What structures stand off from: the CAD model, or the survey's own surface where there is none."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.charts.chart import Chart, address
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.surface import Surface
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class BaseSurface:
    """The hull without structures, in the frame of the results (M, or g without a CAD model).

    surveyed: the surface from the DVL, which is the base itself where there is no CAD model. result_from_global: T_M_g, a batch
    of one (the identity without a CAD model). frame_spacing_m: between the ship's frames, None where it is not known.
    """

    cad_model: Mesh | None
    surveyed: Surface
    chart: Chart
    result_from_global: Poses
    frame_spacing_m: float | None

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
        """Return what heights are counted from, in words."""
        return "the surface step's own surface" if self.cad_model is None else "the CAD model"

    def address_of(self, point: Array) -> str:
        """Return where a point (3,) lies on the hull, in words; g has its origin at the water surface, z down."""
        depth = self.result_from_global.inverse().apply(point[None])[:, 2]
        return address(self.chart, point[None], self.frame_spacing_m, depth)[0]
