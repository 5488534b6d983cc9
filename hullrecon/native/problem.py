# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A bundle adjustment problem as tables: unknowns, priors, measurements [Ozog2016 4.2].

Quaternions are x y z w, and motions are 7 numbers x y z qx qy qz qw. The tangent of a motion is
(translation, rotation): the translation is added in the parent frame, the rotation is perturbed on
the right. The tangent of a pose block is (translation 3, rotation 3, tray 1). The hull frame of a
problem may be shifted from M to the middle of the survey, and the mesh is in that frame.
sqrt_information (6, 6) is the square root of an information matrix, by which a residual is
multiplied.

In shapes, m is the number of rows of a table, and differs from table to table. A table that is left
out has no rows.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from hullrecon.native.columns import floats, integers, motion, pinhole
from hullrecon.native.links import LinkTable
from hullrecon.native.planes import PlanePairTable, PlaneRangeTable, PlaneSightingTable, PlaneTable
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints32

# The displacement of a lens is, for either axis, a sum of products of Legendre polynomials over the
# image, of unit rms. They are ordered by total degree, 2 to LENS_DEGREE, then by that along u.
LENS_DEGREE = 5
LENS_MODES = (LENS_DEGREE + 1) * (LENS_DEGREE + 2) // 2 - 3  # of one axis


@dataclass(frozen=True, kw_only=True)
class Unknowns:
    """Start values, or a solution."""

    pose: Array  # (n, 8) global_from_vehicle and the tray's angle, x y z qx qy qz qw tray
    landmark: Array = floats(0, 3)  # (L, 3) m in g
    T_g_M: Array = motion()  # (7,)
    T_s_ct: Array = motion()  # (7,)
    T_ct_cb: Array = motion()  # (7,)
    T_s_d: Array = motion()  # (7,)
    # (6,) DVL scale, heading drift rad/s, roll and pitch bias rad, depth bias m, tray backlash rad
    navigation: Array = floats(6)
    # (F,) m, normal offsets of the hull from the CAD model, outward positive, at the nodes of the
    # deviation field; empty: no field
    deviation: Array = floats(0)
    intrinsics_top: Array = pinhole()  # (9,) fx fy cx cy k1 k2 p1 p2 k3
    intrinsics_bottom: Array = pinhole()  # (9,)
    # (s,) for each row of links under LinkKernel.SWITCH, in their order; 1 is closed, 0 open
    link_switch: Array = floats(0)
    plane: Array = floats(0, 3)  # (p, 3) m, each in the vehicle frame of its anchor (planes.py)
    # (3,) north and east of g's origin m, heading of its x axis rad; unknown where there are
    # positions
    world: Array = floats(3)
    # (2 LENS_MODES,) px, amplitudes of the modes for u, then for v: pixel p shows what the
    # intrinsics put at p + displacement. Unknown where Problem.lenses is given
    lens_top: Array = floats(2 * LENS_MODES)
    lens_bottom: Array = floats(2 * LENS_MODES)


@dataclass(frozen=True, kw_only=True)
class CadMesh:
    """The CAD model in the problem's hull frame."""

    vertices: Array = floats(0, 3)  # (n, 3) m
    faces: Ints32 = integers(0, 3)  # (m, 3)


@dataclass(frozen=True, kw_only=True)
class LeverArms:
    """Positions of the tray's axis and of the pressure sensor in the vehicle frame."""

    tray: Array = floats(3)  # (3,) m
    pressure: Array = floats(3)  # (3,) m


@dataclass(frozen=True, kw_only=True)
class MotionPrior:
    """A prior on a motion x [Ozog2016 eq. 4.8].

    Its residual is sqrt_information times (translation, rotation vector) of value^-1 x, so that the
    translation is in the axes of the child.
    """

    value: Array  # (7,)
    sqrt_information: Array  # (6, 6)


@dataclass(frozen=True, kw_only=True)
class PosePriors:
    """Priors as MotionPrior on poses."""

    node: Ints32 = integers(0)  # (m,)
    value: Array = floats(0, 7)  # (m, 7)
    sqrt_information: Array = floats(0, 6, 6)  # (m, 6, 6)


@dataclass(frozen=True, kw_only=True)
class SparseRows:
    """Rows of a sparse matrix, compressed."""

    start: Ints32 = integers(0)  # (rows + 1,)
    index: Ints32 = integers(0)  # (k,) of the column
    value: Array = floats(0)  # (k,)


@dataclass(frozen=True, kw_only=True)
class Priors:
    """Priors by unknown. None: there is no prior. Priors of held blocks are ignored."""

    pose: PosePriors = PosePriors()
    T_g_M: MotionPrior | None = None
    T_s_ct: MotionPrior | None = None
    T_ct_cb: MotionPrior | None = None
    T_s_d: MotionPrior | None = None
    navigation_sigma: Array = field(default_factory=lambda: np.ones(6))  # (6,) about zero
    intrinsics_sigma: Array = field(default_factory=lambda: np.ones(9))  # (9,) about the start
    # (3,) about zero, so wide as to have no effect
    world_sigma: Array = field(default_factory=lambda: np.array([1e4, 1e4, 10.0]))
    deviation: SparseRows = SparseRows()  # square root of the deviation field's information


@dataclass(frozen=True, kw_only=True)
class AttitudeTable(Rows):
    """Depth, roll, pitch [Ozog2016 eq. 4.9]: (predicted - measured) / sigma.

    Predicted are z of the pressure sensor, roll and pitch, each plus its bias.
    """

    node: Ints32 = integers(0)  # (m,)
    measured: Array = floats(0, 3)  # (m, 3) depth m, roll, pitch rad
    sigma: Array = floats(0, 3)  # (m, 3)


@dataclass(frozen=True, kw_only=True)
class TrayTable(Rows):
    """The tray's angle [Ozog2016 eq. 4.10]: (angle + backlash * direction - measured) / sigma."""

    node: Ints32 = integers(0)  # (m,)
    measured: Array = floats(0)  # (m,) rad
    direction: Array = floats(0)  # (m,) +1 or -1
    sigma: Array = floats(0)  # (m,) rad


@dataclass(frozen=True, kw_only=True)
class OdometryTable(Rows):
    """Relative motion of two poses [Ozog2016 eq. 4.11].

    sqrt_information @ (e - by_navigation @ (scale, drift) - by_mount @ Log(R_mount^-1 R_s_d) -
    by_tray * (mean tray angle - tray)), with e = (t_ij - t_z in the axes of vehicle i, Log(R_z^-1
    R_ij)) and T_ij = T_i^-1 T_j. Each by_* is a derivative of the measured motion z in these
    coordinates.
    """

    first: Ints32 = integers(0)  # (m,) nodes
    second: Ints32 = integers(0)  # (m,) nodes
    measured: Array = floats(0, 7)  # (m, 7)
    sqrt_information: Array = floats(0, 6, 6)  # (m, 6, 6)
    by_navigation: Array = floats(0, 6, 2)  # (m, 6, 2) by DVL scale error and heading drift
    by_mount: Array = floats(0, 6, 3)  # (m, 6, 3) by the rotation of T_s_d away from mount
    by_tray: Array = floats(0, 6)  # (m, 6) by the mean tray angle of the two nodes away from tray
    tray: Array = floats(0)  # (m,) rad, mean tray angle that dead reckoning used
    mount: Array = motion()  # (7,) T_s_d that dead reckoning used

    SHARED: ClassVar = frozenset({"mount"})


@dataclass(frozen=True, kw_only=True)
class VelocityTable(Rows):
    """Constant velocity over three poses in a row, across a gap of sensors [KimEustice2009 II-A].

    (mean velocity from the second to the third - mean velocity from the first to the second) /
    sigma. Its translation is in the axes of the second vehicle. Its rotation is the rotation vector
    of each step over the step's time. With a white acceleration of density q, (m/s^2)^2 s, sigma^2
    = q (before + after) / 3.
    """

    first: Ints32 = integers(0)  # (m,) nodes
    second: Ints32 = integers(0)  # (m,) nodes
    third: Ints32 = integers(0)  # (m,) nodes
    before: Array = floats(0)  # (m,) s, from first to second
    after: Array = floats(0)  # (m,) s, from second to third
    sigma: Array = floats(0, 6)  # (m, 6) m/s, rad/s


@dataclass(frozen=True, kw_only=True)
class PositionTable(Rows):
    """Position fixes (USBL, GNSS): (predicted - measured) / sigma, north and east.

    Huber's loss is on the norm of both rows (Options.huber_position). The predicted position is
    that of the antenna, with g placed by Unknowns.world.
    """

    node: Ints32 = integers(0)  # (m,)
    antenna: Array = floats(0, 3)  # (m, 3) m in the vehicle at the node
    measured: Array = floats(0, 2)  # (m, 2) m north, east
    sigma: Array = floats(0)  # (m,) m of each of them


@dataclass(frozen=True, kw_only=True)
class StereoTable(Rows):
    """Observations of landmarks by both cameras of a node [Ozog2016 eq. 4.12].

    One Huber loss is on the norm of the 4 rows (Options.huber_stereo). A landmark behind the camera
    has a residual of 10^4 px in each row, without derivative.
    """

    node: Ints32 = integers(0)  # (m,)
    landmark: Ints32 = integers(0)  # (m,)
    pixel: Array = floats(0, 4)  # (m, 4) raw: top u v, bottom u v
    sigma_ratio: Array = floats(0)  # (m,) sigma of a coordinate over Problem.sigma_px; empty: 1


@dataclass(frozen=True, kw_only=True)
class MonoTable(Rows):
    """Observations of landmarks by one camera of a node [Ozog2016 eq. 4.13].

    Loss and sigma_ratio are as in StereoTable, for 2 rows (Options.huber_mono).
    """

    node: Ints32 = integers(0)  # (m,)
    landmark: Ints32 = integers(0)  # (m,)
    camera: Ints32 = integers(0)  # (m,) 0 top, 1 bottom
    pixel: Array = floats(0, 2)  # (m, 2) raw
    sigma_ratio: Array = floats(0)  # (m,)


@dataclass(frozen=True, kw_only=True)
class LensTable:
    """The prior of the displacements of top and bottom lens; empty: they are no unknowns."""

    image_size: Array = floats(0, 2)  # (2, 2) px, width and height of each camera
    sigma_px: Array = floats(0, 2 * LENS_MODES)  # (2, 2 LENS_MODES) of each mode's amplitude
    expected_px: Array = floats(0, 2 * LENS_MODES)  # (2, 2 LENS_MODES) mean of the prior


@dataclass(frozen=True, kw_only=True)
class FieldNodes(Rows):
    """The nodes of the deviation field around each row's point; empty without a field."""

    index: Ints32 = integers(0, 4)  # (m, 4) nodes
    weight: Array = floats(0, 4)  # (m, 4) bilinear weights


@dataclass(frozen=True, kw_only=True)
class RangeTable(Rows):
    """Ray-cast ranges [Ozog2016 eq. 4.14]: (predicted - measured) / sigma.

    The predicted range is the distance along the beam to the CAD model, moved outward by the
    deviation field: cast - field / cos(incidence).
    """

    node: Ints32 = integers(0)  # (m,)
    offset: Array = floats(0, 7)  # (m, 7) vehicle at the ping in vehicle at the node
    tray_offset: Array = floats(0)  # (m,) rad
    beam: Array = floats(0, 3)  # (m, 3) unit, in dvl
    measured: Array = floats(0)  # (m,) m
    sigma: Array = floats(0)  # (m,) m
    field: FieldNodes = FieldNodes()


@dataclass(frozen=True, kw_only=True)
class SurfaceTable(Rows):
    """Distances of landmarks to the hull: to the CAD model, minus the deviation field.

    Their cost is that of a mixture of two labels [Ozog2016 eqs 4.4, 4.5, 4.7].
    """

    landmark: Ints32 = integers(0)  # (m,)
    weight: Array = floats(0)  # (m,) multiplies the cost of the mixture
    field: FieldNodes = FieldNodes()


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Unknowns at their start values, priors and measurements."""

    unknowns: Unknowns
    # Blocks that are held, any of "T_g_M", "T_s_ct", "T_ct_cb", "T_s_d", "navigation", "deviation",
    # "intrinsics_top", "intrinsics_bottom", "world", "lens_top", "lens_bottom", "tray" (every
    # pose's tray angle)
    constant: tuple[str, ...] = ()
    cad_mesh: CadMesh = CadMesh()
    lever_arms: LeverArms = LeverArms()
    priors: Priors = Priors()
    attitude: AttitudeTable = AttitudeTable()
    tray: TrayTable = TrayTable()
    odometry: OdometryTable = OdometryTable()
    stereo: StereoTable = StereoTable()
    mono: MonoTable = MonoTable()
    lenses: LensTable = LensTable()
    sigma_px: float = 1.0  # of an image coordinate, times the row's sigma_ratio
    ranges: RangeTable = RangeTable()
    surface: SurfaceTable = SurfaceTable()
    links: LinkTable = LinkTable()
    planes: PlaneTable = PlaneTable()
    plane_sightings: PlaneSightingTable = PlaneSightingTable()
    plane_pairs: PlanePairTable = PlanePairTable()
    plane_ranges: PlaneRangeTable = PlaneRangeTable()
    velocities: VelocityTable = VelocityTable()
    positions: PositionTable = PositionTable()

    def hold(self, *blocks: str) -> Problem:
        """Hold further blocks."""
        return replace(self, constant=tuple(sorted({*self.constant, *blocks})))

    def free(self, *blocks: str) -> Problem:
        """Make blocks unknown that were held."""
        return replace(self, constant=tuple(name for name in self.constant if name not in blocks))

    def started_from(self, unknowns: Unknowns) -> Problem:
        """Take other start values of the unknowns."""
        return replace(self, unknowns=unknowns)
