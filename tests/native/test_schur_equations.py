# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The Schur core's step against the dense normal equations, and docs/schur.md's equations against
the factors' derivatives.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, evaluate, solve
from native.test_cores import CASES, problem
from native.twins import (
    columns_with_factors,
    cost,
    damping,
    jacobian,
    moved,
    normal_equations,
    step_between,
)
from scipy.spatial.transform import Rotation

from hullrecon.native import FACTORS, Evaluation, Options

Survey = Callable[..., Draft]
ONE_STEP = {
    "max_iterations": 1,
    "function_tolerance": 0.0,
    "parameter_tolerance": 0.0,
    "gradient_tolerance": 0.0,
}


def dense_step(e: Evaluation, radius: float) -> np.ndarray:
    information, gradient = normal_equations(e)
    d = damping(information, radius)
    scale = 1 / np.sqrt(np.diag(information) + d)
    solved = np.linalg.solve((information + np.diag(d)) * np.outer(scale, scale), -gradient * scale)
    return np.asarray(solved * scale)


# "outliers" has an observation behind its camera, a constant of which no row of evaluate has a
# derivative either
@pytest.mark.parametrize(
    ("method", "radius"), [("naive", 1e2), ("geva", 1e4), ("maxmix", 1e-2), ("maxmix", 1e4)]
)
@pytest.mark.parametrize("case", CASES)
def test_a_step_solves_the_dense_normal_equations(
    case: str, method: str, radius: float, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    options = Options(method=method, initial_radius=radius, **ONE_STEP)
    e = evaluate(p, options)
    got = solve(p, options)
    expected = dense_step(e, radius)
    if not got.iterations.accepted[1]:
        assert cost(evaluate(moved(p, e, expected), options)) > 0.99 * cost(e)
        return
    step = step_between(p, got.unknowns, e)
    met = columns_with_factors(e)
    information = np.diag(normal_equations(e)[0])
    # in the unit of each unknown's own sigma: what one factor alone would leave open
    own_sigma = 1 / np.sqrt(information[met])
    np.testing.assert_allclose(
        (step - expected)[met] / own_sigma, 0, atol=2e-6 * np.abs(expected[met] / own_sigma).max()
    )
    assert (step[~met] == 0).all()


@pytest.mark.parametrize("case", CASES)
def test_start_reports_cost_and_gradient_of_the_dense_problem(
    case: str, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    options = Options(max_iterations=0)
    e = evaluate(p, options)
    record = solve(p, options).iterations
    assert record.cost[0] == pytest.approx(cost(e), rel=1e-12)
    for name, value in e.cost_by_factor.items():
        assert record.cost_by_factor[name][0] == pytest.approx(value, rel=1e-12, abs=1e-12), name
    step = moved(p, e, -normal_equations(e)[1])
    far = max(
        np.abs(getattr(step.unknowns, name) - getattr(p.unknowns, name)).max()
        for name in ("T_g_M", "T_s_ct")
        if getattr(p.unknowns, name).size
    )
    far = max(
        far,
        np.abs(step.unknowns.pose - p.unknowns.pose).max(),
        np.abs(step.unknowns.landmark - p.unknowns.landmark).max()
        if len(p.unknowns.landmark)
        else 0,
    )
    for name in (
        "deviation",
        "navigation",
        "intrinsics_top",
        "intrinsics_bottom",
        "T_ct_cb",
        "T_s_d",
    ):
        if getattr(p.unknowns, name).size:
            far = max(far, np.abs(getattr(step.unknowns, name) - getattr(p.unknowns, name)).max())
    # a turn by a large gradient is normalised, so only its size is compared
    assert record.gradient_norm[0] == pytest.approx(far, rel=1e-6)


def hat(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def chain(p: Draft, i: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vehicle's origin, P (6, 7) and Q (6, 6) of docs/schur.md (3)."""
    vehicle = Rotation.from_quat(p.unknowns.pose[i, 3:7]).as_matrix()
    tray = vehicle @ Rotation.from_rotvec([0, p.unknowns.pose[i, 7], 0]).as_matrix()
    camera = tray @ Rotation.from_quat(p.unknowns.T_s_ct[3:]).as_matrix()
    hinge, axis, origin = vehicle @ p.lever_arms.tray, vehicle[:, 1], p.unknowns.pose[i, :3]
    centre = origin + hinge + tray @ p.unknowns.T_s_ct[:3]
    by_pose, by_mount = np.zeros((6, 7)), np.zeros((6, 6))
    by_pose[:3, :3], by_pose[3:, 3:6] = -np.eye(3), -vehicle
    by_pose[:3, 6], by_pose[3:, 6] = np.cross(axis, hinge), -axis
    by_mount[:3, :3], by_mount[:3, 3:], by_mount[3:, 3:] = (
        -tray,
        -hat(centre - origin) @ camera,
        -camera,
    )
    return origin, by_pose, by_mount


def block(e: Evaluation, J: np.ndarray, name: str) -> np.ndarray:
    start, width = e.columns[name]
    return J[:, start : start + width]


@pytest.mark.parametrize("case", ["as it is", "mono", "mono beside stereo"])
def test_image_derivatives_by_pose_and_mount_follow_landmarks(
    case: str, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    e = evaluate(p)
    J = jacobian(e)
    for table in ("stereo", "mono"):
        node, landmark = getattr(p, table).node, getattr(p, table).landmark
        for k in range(0, len(node), 7):
            rows = J[(e.factor == FACTORS.index(table)) & (e.table_row == k)]
            origin, by_pose, by_mount = chain(p, node[k])
            displacement = np.hstack([np.eye(3), -hat(p.unknowns.landmark[landmark[k]] - origin)])
            by_landmark = block(e, rows, f"landmark {landmark[k]}")
            by_twist = by_landmark @ displacement
            atol = 1e-10 * np.abs(by_landmark).max()
            np.testing.assert_allclose(
                block(e, rows, f"pose {node[k]}"), by_twist @ by_pose, rtol=1e-9, atol=atol
            )
            np.testing.assert_allclose(
                block(e, rows, "T_s_ct"), by_twist @ by_mount, rtol=1e-9, atol=atol
            )


def test_a_surface_factor_meets_its_landmark_in_one_direction(
    make_survey: Survey, shaken: Survey
) -> None:
    p = problem("field", make_survey, shaken)
    e = evaluate(p)
    rows = jacobian(e)[e.factor == FACTORS.index("surface")]
    hull_from_global = Rotation.from_quat(p.unknowns.T_g_M[3:]).as_matrix().T
    for k, row in enumerate(rows):
        n = block(e, row[None], f"landmark {p.surface.landmark[k]}")[0]
        assert np.linalg.norm(n) == pytest.approx(1 / 0.02)
        turn = hull_from_global @ np.cross(
            n, p.unknowns.landmark[p.surface.landmark[k]] - p.unknowns.T_g_M[:3]
        )
        np.testing.assert_allclose(block(e, row[None], "T_g_M")[0], np.r_[-n, turn], atol=1e-9)
        expected = np.zeros(len(p.unknowns.deviation))
        np.add.at(expected, p.surface.field.index[k], -p.surface.field.weight[k] / 0.02)
        got = [
            block(e, row[None], f"deviation {m}")[0, 0] for m in range(len(p.unknowns.deviation))
        ]
        np.testing.assert_allclose(got, expected, atol=1e-12)


def test_the_twist_information_gives_the_dense_schur_complement(
    make_survey: Survey, shaken: Survey
) -> None:
    """(9) and (10) in NumPy: landmarks eliminated in twists leave what they leave in poses and
    mount.
    """
    p = problem("images alone", make_survey, shaken)
    options = Options(method="naive")
    e = evaluate(p, options)
    image = e.factor == FACTORS.index("stereo")
    rows = jacobian(e)[image] * e.weight[image, None]
    n, landmarks = len(p.unknowns.pose), len(p.unknowns.landmark)
    first = e.columns["landmark 0"][0]
    of_landmark = slice(first, first + 3 * landmarks)
    rest = np.r_[0 : 7 * n, slice(*np.cumsum(e.columns["T_s_ct"]))]
    information = rows.T @ rows + 1e-3 * np.eye(e.width)
    V, W = information[of_landmark, of_landmark], information[of_landmark][:, rest]
    expected = (rows.T @ rows)[np.ix_(rest, rest)] - W.T @ np.linalg.solve(V, W)

    chains = [chain(p, i) for i in range(n)]
    X = np.zeros((6 * n, 6 * n))
    for landmark in range(landmarks):
        at = slice(first + 3 * landmark, first + 3 * landmark + 3)
        seen = []
        for k in np.flatnonzero(p.stereo.landmark == landmark):
            own = rows[e.table_row[image] == k][:, at]
            origin = chains[p.stereo.node[k]][0]
            seen.append(
                (
                    p.stereo.node[k],
                    own.T @ own,
                    np.hstack([np.eye(3), -hat(p.unknowns.landmark[landmark] - origin)]),
                )
            )
        K = np.linalg.inv(1e-3 * np.eye(3) + sum((H for _, H, _ in seen), np.zeros((3, 3))))
        for i, Hi, Ei in seen:
            X[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] += Ei.T @ Hi @ Ei
            for j, Hj, Ej in seen:
                X[6 * i : 6 * i + 6, 6 * j : 6 * j + 6] -= Ei.T @ Hi @ K @ Hj @ Ej
    PQ = np.zeros((6 * n, 7 * n + 6))
    for i, (_, by_pose, by_mount) in enumerate(chains):
        PQ[6 * i : 6 * i + 6, 7 * i : 7 * i + 7], PQ[6 * i : 6 * i + 6, 7 * n :] = by_pose, by_mount
    np.testing.assert_allclose(PQ.T @ X @ PQ, expected, atol=1e-8 * np.abs(expected).max())
