# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A comparison of two dives made by hand: one object of each kind, and bare hull that moved."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.poses import exp
from hullrecon.records.change import ChangeMap, HullChange, ObjectChange, SurfaceMove, SurveyOffset

T_NS = 1_780_000_000_000_000_000
SQUARE = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]])


def object_change(
    status, first, second, along, before, after, *, outline=True, change=None
) -> ObjectChange:
    known = change is None or np.isfinite(change)
    at = np.array([along, 5.0])
    return ObjectChange(
        status=status,
        first_id=first,
        second_id=second,
        center=np.array([along, 4.5, 2.0]),
        along_girth=at,
        outline=at + SQUARE if outline else np.zeros((0, 2)),
        height_before=before,
        height_after=after,
        height_before_sigma=0.003,
        height_after_sigma=0.004 if np.isfinite(after) else np.nan,
        change=after - before if change is None else change,
        change_sigma=0.004 if known else np.nan,
        p_value=1e-9 if known else np.nan,
        area=0.04 if known else np.nan,
        sigma=np.array([0.2, 0.05, 0.02]),
        address=f"frame {along / 0.6:.0f}, port",
    )


def hull_change(objects=(), moves=()) -> HullChange:
    lattice = Lattice(origin=np.array([30.0, 4.0]), step_m=0.05, shape=(80, 40))
    value = np.full(lattice.shape, 0.002)
    value[:4] = np.nan
    offset = SurveyOffset(
        first_from_second=exp(np.array([[0.05, 0, -0.01, 0, 0.001, 0]])),
        covariance=np.diag([1e-6] * 6),
        prior_covariance=np.diag([0.04] * 3 + [1e-4] * 3),
        center=np.zeros(3),
        chi_square=2.5,
        p_value=0.87,
    )
    return HullChange(
        first="may", second="june", offset=offset, objects=tuple(objects), moves=tuple(moves),
        map=ChangeMap(lattice=lattice, change=value, sigma=np.full(lattice.shape, 0.003),
                      first_seen=np.ones(lattice.shape, bool), second_seen=np.isfinite(value)),
        area_both=7.6, area_first=8.0, area_second=7.8, detectable_m=0.015, places=3040,
    )  # fmt: skip


MOVE = SurfaceMove(
    along_girth=np.array([32.0, 5.5]),
    outline=np.array([32.0, 5.5]) + 3 * SQUARE,
    move=-0.012,
    move_sigma=0.003,
    p_value=2e-4,
    area=0.36,
    address="frame 53, port",
)


def each_kind() -> HullChange:
    return hull_change(
        [
            object_change("gone", 4, None, 33.4, 0.14, 0.001),
            object_change("new", None, 5, 31.2, 0.0, 0.09),
            object_change("new", None, None, 32.4, 0.001, -0.041, outline=False),
            object_change("grown", 1, 1, 30.6, 0.11, 0.141),
            object_change("not seen again", 7, None, 33.9, 0.08, np.nan, change=np.nan),
            object_change("unchanged", 2, 3, 31.8, 0.12, 0.121),
        ],
        [MOVE],
    )


def seen_from_port() -> OutsideMap:
    """The port side, seen from outside: the bow is on the left."""
    return OutsideMap(x_sign=-1, y_sign=1, frame="M")


@pytest.fixture
def change() -> HullChange:
    return each_kind()


@pytest.fixture
def outside() -> OutsideMap:
    return seen_from_port()
