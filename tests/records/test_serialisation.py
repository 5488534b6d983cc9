# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import exp
from hullrecon.records.sensors import DvlPings
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Mounts, Solution


def solution(with_cad_model: bool = True) -> Solution:
    rng = np.random.default_rng(5)
    return Solution(
        t_ns=np.arange(4, dtype=np.int64),
        image=np.array([[0, -1], [1, 0], [-1, -1], [2, 1]]),
        global_from_vehicle=exp(rng.normal(size=(4, 6))),
        tray=rng.normal(size=4),
        tray_sigma=np.full(4, 0.01),
        pose_covariance=np.tile(np.eye(6), (4, 1, 1)),
        landmarks=Landmarks(
            position=rng.normal(size=(3, 3)),
            covariance=np.tile(np.eye(3), (3, 1, 1)),
            label=np.array([1, 0, 1]),
            deviation=rng.normal(size=3),
            views=np.array([2, 3, 4]),
            color=np.zeros((3, 3), np.uint8),
        ),
        mounts=Mounts(
            tray_from_dvl=exp(rng.normal(size=(1, 6))),
            tray_from_top=exp(rng.normal(size=(1, 6))),
            top_from_bottom=None,
        ),
        navigation_errors=rng.normal(size=6),
        hull_pose=HullPose(
            global_from_hull=exp(rng.normal(size=(1, 6))),
            covariance=np.eye(6),
            survey_center=np.ones(3),
        )
        if with_cad_model
        else None,
        deviation_field=DeviationField(
            origin=np.zeros(2), step=np.ones(2), value=np.zeros((2, 2)), sigma=np.ones((2, 2))
        )
        if with_cad_model
        else None,
    )


@pytest.mark.parametrize("with_cad_model", [True, False])
def test_a_record_of_records_survives_the_disk(tmp_path: Path, with_cad_model: bool) -> None:
    before = solution(with_cad_model)
    np.savez(tmp_path / "solution.npz", **to_arrays(before))
    with np.load(tmp_path / "solution.npz") as arrays:
        after = from_arrays(Solution, arrays)
    written, read = to_arrays(before), to_arrays(after)
    assert written.keys() == read.keys()
    assert all(np.array_equal(written[name], read[name]) for name in written)
    assert after.mounts.top_from_bottom is None
    assert (after.hull_pose is None) is not with_cad_model


def test_members_are_named_by_part_and_field() -> None:
    assert {"tray", "landmarks.position", "hull_pose.global_from_hull.quaternion"} <= to_arrays(
        solution()
    ).keys()


def test_a_missing_member_is_named() -> None:
    arrays = to_arrays(solution())
    del arrays["landmarks.label"]
    with pytest.raises(KeyError, match="label"):
        from_arrays(Solution, arrays)


def test_a_flat_record_has_its_fields_as_members() -> None:
    pings = DvlPings(
        t_ns=np.zeros(1, np.int64),
        velocity=np.zeros((1, 3)),
        velocity_sigma=np.ones(1),
        ranges=np.ones((1, 4)),
        beams=np.eye(4, 3),
    )
    assert list(to_arrays(pings)) == [f.name for f in fields(DvlPings)]


def test_a_part_that_was_not_carried_leaves_nothing_to_read() -> None:
    assert not [
        name
        for name in to_arrays(solution(with_cad_model=False))
        if name.startswith(("hull_pose", "deviation_field"))
    ]


def test_track_is_in_hull_frame_with_known_hull() -> None:
    known, unknown = solution(), solution(with_cad_model=False)
    assert known.hull_pose is not None
    hull = known.hull_pose.global_from_hull
    assert known.track().frame is Frame.HULL
    np.testing.assert_allclose(
        (hull @ known.track().poses).matrix(), known.global_from_vehicle.matrix(), atol=1e-12
    )
    assert unknown.track().frame is Frame.GLOBAL
    np.testing.assert_allclose(
        unknown.track().poses.matrix(), unknown.global_from_vehicle.matrix(), atol=1e-12
    )


def test_sigma_along_a_direction_is_that_of_the_covariance() -> None:
    track = replace(
        solution(), pose_covariance=np.tile(np.diag([4.0, 9.0, 16.0, 1, 1, 1]), (4, 1, 1))
    ).track()
    assert track.sigma[0].tolist() == [2, 3, 4, 1, 1, 1]
    assert track.sigma_towards(np.tile([0.0, 1.0, 0.0], (4, 1))).tolist() == [3.0] * 4


def test_nested_record_is_found_by_annotation() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Plain:
        value: np.ndarray

    assert from_arrays(Plain, to_arrays(Plain(value=np.arange(3)))).value.tolist() == [0, 1, 2]
