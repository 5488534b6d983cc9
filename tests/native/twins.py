# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plain NumPy twins of what native does: steps on the manifolds, dense Jacobians, the dense normal
equations of one step.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator

import numpy as np
from drafts import Draft, change, leaves
from scipy.sparse import csr_matrix
from scipy.spatial.transform import Rotation

from hullrecon.native import Evaluation, Options, Unknowns

Array = np.ndarray
LEAST_DIAGONAL, MOST_DIAGONAL = 1e-6, 1e32  # Ceres' bounds of the damping


def copied(p: Draft) -> Draft:
    """The same with arrays of its own."""
    out = Draft(p.build())
    for path, value in leaves(out).items():
        change(out, path, copy.copy(value))
    return out


def unknown_of(name: str) -> tuple[str, tuple[int, ...]]:
    """Field of Problem and index of the block of this name in Evaluation.columns."""
    kind, _, number = name.partition(" ")
    return kind, (int(number),) if number else ()


def moved_numbers(x: Array, delta: Array) -> Array:
    """x [+] delta for a block of pose (8, delta of 6 or 7), motion (7) or plain numbers."""
    out = np.array(x, float)
    if out.size not in (7, 8):
        return np.asarray(out + delta.reshape(out.shape))
    out[:3] += delta[:3]
    out[3:7] = (Rotation.from_quat(x[3:7]) * Rotation.from_rotvec(delta[3:6])).as_quat()
    if len(delta) == 7:
        out[7] += delta[6]
    return out


def difference(y: Array, x: Array, width: int) -> Array:
    """y [-] x, the inverse of moved_numbers."""
    if np.size(x) not in (7, 8):
        return np.atleast_1d(y - x)
    turn = (Rotation.from_quat(x[3:7]).inv() * Rotation.from_quat(y[3:7])).as_rotvec()
    return np.r_[y[:3] - x[:3], turn, (y[7:] - x[7:])[: width - 6]]


def moved(p: Draft, e: Evaluation, delta: Array) -> Draft:
    """The problem with its free unknowns moved by delta (width,), laid out as e.columns says."""
    out = copied(p)
    for name, (start, width) in e.columns.items():
        field, index = unknown_of(name)
        table = getattr(out.unknowns, field)
        table[index or ...] = moved_numbers(
            getattr(p.unknowns, field)[index or ...], delta[start : start + width]
        )
    return out


def step_between(p: Draft, unknowns: Unknowns, e: Evaluation) -> Array:
    """What moved p's unknowns to these, (width,)."""
    out = np.zeros(e.width)
    for name, (start, width) in e.columns.items():
        field, index = unknown_of(name)
        at = index or ...
        out[start : start + width] = difference(
            getattr(unknowns, field)[at], getattr(p.unknowns, field)[at], width
        )
    return out


def jacobian(e: Evaluation) -> Array:
    """(R, width), whitened, without the loss's weights."""
    matrix = csr_matrix(
        (e.jacobian_value, e.jacobian_column, e.jacobian_start), shape=(len(e.residual), e.width)
    )
    return np.asarray(matrix.toarray())


def normal_equations(e: Evaluation) -> tuple[Array, Array]:
    """Information (width, width) and gradient (width,) of the robustified problem."""
    rows, r = jacobian(e) * e.weight[:, None], e.residual * e.weight
    return rows.T @ rows, rows.T @ r


def damping(information: Array, radius: float) -> Array:
    """Diagonal of Levenberg-Marquardt at the start, with Ceres' scaling of the columns and its
    bounds.
    """
    diagonal = np.diag(information)
    scale = (1 + np.sqrt(diagonal)) ** 2
    return np.asarray(np.clip(diagonal / scale, LEAST_DIAGONAL, MOST_DIAGONAL) * scale / radius)


def columns_with_factors(e: Evaluation) -> Array:
    """Mask (width,) of the columns that any factor meets."""
    return np.asarray(
        np.bincount(e.jacobian_column, np.abs(e.jacobian_value) > 0, minlength=e.width) > 0
    )


def array_fields(p: Draft) -> Iterator[str]:
    """Paths of the tables that hold numbers."""
    for path, value in leaves(p).items():
        if isinstance(value, np.ndarray) and value.size:
            yield path


def cost(e: Evaluation) -> float:
    return float(sum(e.cost_by_factor.values()))


def robust_off() -> Options:
    return Options(huber_stereo=np.inf, huber_mono=np.inf, huber_range=np.inf)
