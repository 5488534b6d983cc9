# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The outer loop of hard EM against labels inside the solve, on a plane of landmarks."""

import dataclasses

import numpy as np
import pytest

from hullrecon import native
from hullrecon.adjustment.problem.selection import label_boundary
from hullrecon.geometry import poses
from hullrecon.studies.methods import hard_em

OPTIONS = native.Options(function_tolerance=1e-10)


@pytest.fixture
def wall():
    """Eight nodes before the CAD model's wall at z = 1; sixty landmarks, every sixth 0.1 m off it;
    started 3 cm wrong.
    """
    rng = np.random.default_rng(5)
    n, count = 8, 60
    nodes = poses.from_rpy(np.c_[0.15 * np.arange(n), np.zeros(n), np.zeros(n)], np.zeros((n, 3)))
    off = np.arange(count) % 6 == 0
    true = np.c_[rng.uniform(0, 1, count), rng.uniform(-0.4, 0.4, count), np.where(off, 0.9, 1.0)]
    pose = np.hstack([nodes.translation, nodes.quaternion])
    node, landmark = np.repeat(np.arange(n), count), np.tile(np.arange(count), n)
    at = true[landmark] - nodes.translation[node]
    pixel = 500 * at[:, :2] / at[:, 2:] + [320, 240]
    pixel = pixel + 0.3 * rng.standard_normal(pixel.shape)
    first = np.zeros(len(node), np.int32)
    problem = native.Problem(
        unknowns=native.Unknowns(
            pose=np.hstack([pose, np.zeros((n, 1))]),
            landmark=true + 0.03 * rng.standard_normal(true.shape),
            intrinsics_top=np.array([500.0, 500, 320, 240, 0, 0, 0, 0, 0]),
        ),
        constant=(
            "T_s_ct",
            "T_ct_cb",
            "T_s_d",
            "T_g_M",
            "navigation",
            "intrinsics_top",
            "intrinsics_bottom",
            "tray",
        ),
        cad_mesh=native.CadMesh(
            vertices=np.array([[-3.0, -3, 1], [4, -3, 1], [4, 3, 1], [-3, 3, 1]]),
            faces=np.array([[0, 2, 1], [0, 3, 2]], np.int32),
        ),
        priors=native.Priors(
            pose=native.PosePriors(
                node=np.arange(n, dtype=np.int32),
                value=pose,
                sqrt_information=np.tile(np.eye(6) / 0.02, (n, 1, 1)),
            )
        ),
        mono=native.MonoTable(
            node=node.astype(np.int32),
            landmark=landmark.astype(np.int32),
            camera=first,
            pixel=pixel,
        ),
        surface=native.SurfaceTable(
            landmark=np.arange(count, dtype=np.int32), weight=np.ones(count)
        ),
    )
    return problem, off


def test_both_ways_reach_the_same_cost_and_labels(wall) -> None:
    problem, off = wall
    inside, outer = native.solve(problem, OPTIONS), hard_em.solve(problem, OPTIONS)
    assert outer.converged
    np.testing.assert_array_equal(outer.label == 0, off)
    np.testing.assert_array_equal(inside.label, outer.label)
    assert outer.iterations.cost[-1] == pytest.approx(inside.iterations.cost[-1], rel=1e-6)


def test_the_cost_never_rises_from_turn_to_turn(wall) -> None:
    record = hard_em.solve(wall[0], OPTIONS).iterations
    assert (np.diff(record.cost[record.accepted]) <= 1e-9 * record.cost[0]).all()
    assert all(len(values) == len(record.cost) for values in record.cost_by_factor.values())


def test_em_turns_keep_intrinsics_prior_at_calibration(wall, monkeypatch) -> None:
    begun, solve = [], native.solve

    def watched(problem, options):
        begun.append(problem.unknowns.intrinsics_top[0])
        done = solve(problem, options)
        moved = dataclasses.replace(
            done.unknowns, intrinsics_top=done.unknowns.intrinsics_top + 1.0
        )
        return dataclasses.replace(done, unknowns=moved)

    monkeypatch.setattr(native, "solve", watched)
    found = hard_em.solve(wall[0], OPTIONS)
    assert len(begun) > 1
    assert set(begun) == {500.0}
    assert found.unknowns.intrinsics_top[0] == 501.0


def test_seconds_run_on_from_turn_to_turn(wall, monkeypatch) -> None:
    turns, solve = [], native.solve

    def a_second_an_iteration(problem, options):
        done = solve(problem, options)
        turns.append(len(done.iterations.cost))
        return dataclasses.replace(
            done,
            iterations=dataclasses.replace(done.iterations, seconds=np.arange(float(turns[-1]))),
        )

    monkeypatch.setattr(native, "solve", a_second_an_iteration)
    record = hard_em.solve(wall[0], OPTIONS).iterations
    assert len(turns) > 1
    assert record.seconds.tolist() == np.arange(1 + sum(turns) - len(turns)).tolist()


def test_labels_that_change_between_solves_are_counted(wall) -> None:
    problem, _ = wall
    started = native.solve(
        problem, dataclasses.replace(OPTIONS, labels_in_solve=False, max_iterations=1)
    ).label
    got = hard_em.solve(problem, OPTIONS)
    changed = int((started != got.label).sum())
    assert got.iterations.label_changes.sum() >= changed
    assert "0 labels changed after the last" in got.message


def test_a_loop_that_is_cut_short_says_that_it_did_not_settle(wall) -> None:
    problem, _ = wall
    problem.unknowns.landmark[:, 2] += 0.2
    got = hard_em.solve(problem, dataclasses.replace(OPTIONS, max_iterations=2), most_turns=1)
    assert not got.converged
    assert got.message.startswith("1 turns of EM")


def test_labels_are_those_that_the_solver_gives_with_a_field_too(wall) -> None:
    problem, _ = wall
    count = len(problem.surface.landmark)
    nodes = native.FieldNodes(
        index=np.tile(np.array([0, 1, 0, 1], np.int32), (count, 1)),
        weight=np.tile([0.5, 0.5, 0.0, 0.0], (count, 1)),
    )
    problem = dataclasses.replace(
        problem,
        unknowns=dataclasses.replace(problem.unknowns, deviation=np.array([0.0, -0.03])),
        surface=dataclasses.replace(problem.surface, field=nodes),
    )
    got = native.solve(problem, OPTIONS)
    np.testing.assert_array_equal(
        hard_em.likelier_labels(problem.started_from(got.unknowns), got.distance, OPTIONS),
        got.label,
    )
    assert (got.label == 0).sum() > 5


def test_at_the_boundary_both_labels_cost_the_same() -> None:
    h = label_boundary(0.02, 1.0)
    assert h == pytest.approx(0.05595, abs=1e-5)
    assert (h / 0.02) ** 2 == pytest.approx((h / 1.0) ** 2 + 2 * np.log(1.0 / 0.02))
