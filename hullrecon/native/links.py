# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links of the pose graph: relative poses of two cameras from images [KimEustice2009 II-B]."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from hullrecon.native.columns import floats, integers, mask
from hullrecon.typing import Array, Ints32, Mask


class LinkKernel(IntEnum):
    """How the cost of a link is made robust. Phi is Options.link_phi, u a link's whitened square.

    - NONE: the cost is u / 2.
    - SCALING: dynamic covariance scaling [Agarwal2013]. The cost is half of u up to Phi, and half
      of 3 Phi - 4 Phi^2 / (Phi + u) beyond, which weights the link by (2 Phi / (Phi + u))^2.
    - SWITCH: the link's rows are multiplied by an unknown of their own, Unknowns.link_switch, which
      has a prior of 1 with information Phi [SunderhaufProtzel2012].
    """

    NONE = 0
    SCALING = 1
    SWITCH = 2


@dataclass(frozen=True, kw_only=True)
class LinkTable:
    """Relative poses of two cameras from a pair of images [KimEustice2009 II-B].

    T = T_g_c1^-1 T_g_c2, the second camera in the first, with T_g_c = T_g_v Trans(tray origin)
    Ry(tray) T_s_ct and, for the bottom camera, T_ct_cb. The residual is multiplied by
    sqrt_information:

    - scaled: 6 rows, (t - t_z in the axes of the first camera m, Log(R_z^-1 R) rad in those of the
      second).
    - not scaled: 5 rows, with the leading 5 x 5 of sqrt_information. The first two, rad, are the
      direction of t relative to that of t_z: the angle between them along the tangent, in the axes
      of `bearing_basis`. Then the rotation as above. The length of t_z is not used, but must not be
      zero. Two cameras at one position have no direction: both rows are then pi, without
      derivative.
    """

    first: Ints32 = integers(0)  # (m,) nodes
    second: Ints32 = integers(0)  # (m,) nodes
    camera_first: Ints32 = integers(0)  # (m,) 0 top, 1 bottom
    camera_second: Ints32 = integers(0)  # (m,) 0 top, 1 bottom
    measured: Array = floats(0, 7)  # (m, 7) first_from_second
    sqrt_information: Array = floats(0, 6, 6)  # (m, 6, 6)
    scaled: Mask = mask(0)  # (m,) whether the length of the translation is measured
    kernel: Ints32 = integers(0)  # (m,) LinkKernel


def bearing_basis(direction: Array) -> Array:
    """Build two axes perpendicular to a direction (..., 3), as columns b1 and b2 (..., 3, 2).

    The direction of a link without length is measured in them. b1 is the cross product of the
    direction and the coordinate axis of which it has the least component (the first of equals),
    b2 = direction x b1.
    """
    z = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    b1 = np.cross(z, np.eye(3)[np.argmin(np.abs(direction), axis=-1)])
    b1 /= np.linalg.norm(b1, axis=-1, keepdims=True)
    return np.stack([b1, np.cross(z, b1)], axis=-1)
