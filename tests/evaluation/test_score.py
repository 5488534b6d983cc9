# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Each figure worked out by hand on the wall; see conftest.py."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.score import score_run, table_rows, unit_of, without_nan
from hullrecon.evaluation.trajectory import hull_from_start
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.poses import Poses

STEEL_M = 0.012


def by_hand(deliver: Any, package: Path) -> dict[str, Any]:
    return score_run(deliver.folder, package)


@pytest.fixture
def path() -> np.ndarray:
    frames = np.arange(41)
    return np.stack([0.1 * frames, 1.5 + 0 * frames, 0.2 * np.sin(0.3 * frames)], 1)


def test_the_true_track_has_no_error(deliver: Any, package: Path) -> None:
    deliver.track()
    figures = by_hand(deliver, package)["trajectory"]
    assert figures["poses"] == 41
    assert figures["share_of_true_frames_with_a_pose"] == 1
    for name in ("along", "girth", "normal", "rigid"):
        assert figures[f"{name}_rmse_m"] == pytest.approx(0, abs=1e-6)


def test_shift_is_scored_by_direction_and_gone_aligned(
    deliver: Any, package: Path, path: np.ndarray
) -> None:
    deliver.track(np.add(path, [0.3, 0.02, -0.05]), sigma=(0.3, 0.01, 0.1))
    figures = by_hand(deliver, package)["trajectory"]
    assert figures["along_rmse_m"] == pytest.approx(0.3, abs=1e-6)
    assert figures["girth_rmse_m"] == pytest.approx(0.05, abs=1e-6)
    assert figures["normal_rmse_m"] == pytest.approx(0.02, abs=1e-6)
    assert figures["rigid_rmse_m"] == pytest.approx(0, abs=1e-6)
    assert figures["error_over_sigma_y"] == pytest.approx(2, abs=1e-4)
    assert figures["median_sigma_z_m"] == pytest.approx(0.1)
    assert (figures["share_within_1_sigma_y"], figures["share_within_1_sigma_z"]) == (0, 1)


def test_a_turn_is_an_angle(deliver: Any, package: Path) -> None:
    deliver.track(turn_deg=0.5)
    figures = by_hand(deliver, package)["trajectory"]
    assert figures["rotation_rmse_deg"] == pytest.approx(0.5, abs=1e-6)
    assert figures["rotation_rigid_rmse_deg"] == pytest.approx(0.5, abs=1e-3)


def test_half_a_track_covers_half_of_the_frames(deliver: Any, package: Path) -> None:
    deliver.track()
    file = deliver.folder / "trajectory.csv"
    file.write_text("\n".join(file.read_text().splitlines()[:21]) + "\n")
    figures = by_hand(deliver, package)["trajectory"]
    assert figures["poses"] == 20
    assert figures["share_of_true_frames_with_a_pose"] == pytest.approx(20 / 41)


def test_a_surface_a_centimetre_off_is_a_centimetre_off(
    deliver: Any, package: Path, wall_points: np.ndarray
) -> None:
    deliver.track()
    off = np.add(wall_points, [0, 0.01, 0])
    deliver.cloud("surface.ply", off, support=np.ones(400, "<i4"), sigma=np.full(400, 0.006, "<f4"))
    figures = by_hand(deliver, package)["surface"]
    assert figures["vertices"] == 400
    for name in ("rmse_m", "p95_m", "aligned_rmse_m", "aligned_median_m"):
        assert figures[name] == pytest.approx(0.01, abs=1e-5)
    assert figures["cad_model_alone_rmse_m"] == pytest.approx(STEEL_M, abs=1e-5)
    assert figures["share_within_1.96_sigma"] == 1
    assert figures["share_within_1_sigma"] == 0


def test_surface_shifted_with_track_is_right_aligned(
    deliver: Any, package: Path, wall_points: np.ndarray, path: np.ndarray
) -> None:
    shift = [0.0, 0.03, 0.0]
    deliver.track(path + shift)
    deliver.cloud("as_found.ply", wall_points + shift, support=np.full(400, 2, "<i4"))
    figures = by_hand(deliver, package)["as_found"]
    assert figures["rmse_m"] == pytest.approx(0.03, abs=1e-5)
    assert figures["aligned_rmse_m"] == pytest.approx(0, abs=1e-5)


def test_as_found_needs_two_views_and_surface_one_return(
    deliver: Any, package: Path, wall_points: np.ndarray
) -> None:
    support = np.repeat([0, 1, 2, 3], 100).astype("<i4")
    for name in ("surface", "as_found"):
        deliver.cloud(f"{name}.ply", wall_points, support=support)
    figures = by_hand(deliver, package)
    assert figures["surface"]["vertices"] == 300
    assert figures["as_found"]["vertices"] == 200


def test_nothing_is_judged_where_the_truth_is_unknown(
    deliver: Any, package: Path, wall_points: np.ndarray
) -> None:
    deliver.cloud("surface.ply", np.add(wall_points, [50, 0, 0]), support=np.ones(400, "<i4"))
    assert by_hand(deliver, package)["surface"] == {"vertices": 0}


def test_labels_are_scored_where_steel_leaves_cad_clearly(
    deliver: Any, package: Path, wall_points: np.ndarray, block_points: np.ndarray
) -> None:
    deliver.track()
    label = np.ones(500, "u1")
    label[:40] = 0  # of the wall, wrongly
    label[400:480] = 0  # of the block, rightly
    deliver.cloud("landmarks.ply", np.vstack([wall_points, block_points]), label=label)
    figures = by_hand(deliver, package)["landmarks"]
    assert figures["landmarks"] == 500
    assert figures["far_from_hull"] == 0
    assert figures["off_cad_model"] == 100
    assert figures["off_recall"] == pytest.approx(0.8)
    assert figures["off_precision"] == pytest.approx(80 / 120)
    assert figures["median_m"] == pytest.approx(0, abs=1e-5)


def test_an_object_is_matched_and_its_height_compared(deliver: Any, package: Path) -> None:
    deliver.track()
    deliver.objects({"id": 7, "center": [1.05, 0.11, 0.02], "height": 0.09, "height_sigma": 0.005})
    figures = by_hand(deliver, package)["objects"]
    assert (figures["reported"], figures["due"], figures["recall"]) == (1, 1, 1)
    assert figures["height_error_worst_m"] == pytest.approx(0.01)
    assert figures["height_error_over_sigma"] == pytest.approx(2)
    assert figures["missed"] == []


def test_twice_false_on_paint_and_lesser_are_told_apart(deliver: Any, package: Path) -> None:
    deliver.track()
    block = {"center": [1.0, 0.11, 0.0], "height": 0.1}
    deliver.objects(
        block,
        {**block, "height": 0.12},
        {"center": [2.0, 0.02, 0.05], "height": 0.03},  # on the painted ring
        {"center": [3.05, 0.06, 0.5], "height": 0.05},  # the lesser lump
        {"center": [4.0, 0.0, -0.5], "height": 0.1},  # nothing there
    )
    figures = by_hand(deliver, package)["objects"]
    assert figures["reported_twice"] == 1
    assert figures["false_reports"] == 2
    assert figures["false_on_paint"] == 1
    assert figures["lesser_structures_found"] == 1
    assert figures["height_error_worst_m"] == pytest.approx(0)


def test_what_was_missed_is_named(deliver: Any, package: Path) -> None:
    deliver.track()
    deliver.objects()
    figures = by_hand(deliver, package)["objects"]
    assert figures["missed"] == [1]
    assert figures["recall"] == 0
    assert math.isnan(figures["height_error_median_m"])


def test_what_was_not_delivered_is_missing(deliver: Any, package: Path) -> None:
    deliver.track()
    figures = by_hand(deliver, package)
    assert [k for k, v in figures.items() if v == "missing"] == [
        "surface",
        "as_found",
        "landmarks",
        "objects",
        "cameras",
    ]


def test_deliverables_in_g_are_moved_by_the_true_alignment(
    deliver: Any, package: Path, wall_points: np.ndarray
) -> None:
    """g is M shifted by (1, 2, 3) there."""
    (deliver.folder / "summary.json").write_text(json.dumps({"frame": "g"}))
    deliver.cloud("surface.ply", np.add(wall_points, [1, 2, 3]), support=np.ones(400, "<i4"))
    assert by_hand(deliver, package)["surface"]["rmse_m"] == pytest.approx(0, abs=1e-5)


def test_path_in_g_is_scored_from_its_begin_by_axis(
    deliver: Any, package: Path, path: np.ndarray, tmp_path: Path
) -> None:
    """g is turned by a right angle against M, and the path's origin is not quite where the dive
    began.
    """
    turned = tmp_path / "turned"
    shutil.copytree(package, turned)
    half = math.sqrt(0.5)
    # x of M is y of g, y of M is -x
    pose = {"translation": [0.0, 0.0, 0.0], "quaternion": [0.0, 0.0, half, half]}
    (turned / "truth" / "alignment.json").write_text(json.dumps({"T_g_M": pose}))
    (deliver.folder / "summary.json").write_text(json.dumps({"frame": "g"}))
    # along M's x, and so along y of g
    bent = path + np.linspace(0, 1, 41)[:, None] * [0.3, 0.0, 0.0]
    in_g = np.add(np.column_stack([-bent[:, 1], bent[:, 0], bent[:, 2]]), [5.0, -2.0, 0.0])
    deliver.track(in_g, sigma=(0.01, 0.3, 0.1), turned=Rotation.from_euler("z", 90, degrees=True))
    figures = score_run(deliver.folder, turned)["trajectory"]
    assert figures["along_rmse_m"] == pytest.approx(
        0.3 * math.sqrt(np.mean(np.linspace(0, 1, 41) ** 2)), rel=1e-6
    )
    assert figures["error_over_sigma_x"] == pytest.approx(0, abs=1e-6)
    assert figures["error_over_sigma_y"] == pytest.approx(0.586, abs=0.01)


@pytest.mark.parametrize(("has_depth", "off_m"), [(True, 1.4), (False, 0.0)])
def test_a_depth_counts_where_it_was_measured(package: Path, has_depth: bool, off_m: float) -> None:
    truth = read_truth(package)
    true = truth.global_from_hull @ truth.vehicle_at(truth.t_s)
    told = Poses(true.quaternion, true.translation - [0.0, 0.0, 1.4])
    track = TimedPoses(t_s=truth.t_s, poses=told, has_depth=has_depth)
    found = truth.global_from_hull @ hull_from_start(track, truth) @ told
    np.testing.assert_allclose(
        true.translation - found.translation, np.tile([0.0, 0.0, off_m], (len(told), 1)), atol=1e-9
    )


def test_without_a_cad_model_what_needs_one_is_left_out(
    deliver: Any, package: Path, wall_points: np.ndarray, tmp_path: Path
) -> None:
    bare = tmp_path / "bare"
    bare.mkdir()
    shutil.copytree(package / "truth", bare / "truth")
    (bare / "dive.toml").write_text("")
    deliver.track()
    deliver.cloud("landmarks.ply", wall_points, label=np.zeros(400, "u1"))
    figures = score_run(deliver.folder, bare)
    assert "rigid_rmse_m" in figures["trajectory"]
    assert "normal_rmse_m" not in figures["trajectory"]
    assert "off_recall" not in figures["landmarks"]


def test_rows_have_units_and_four_digits() -> None:
    figures = {
        "cameras": {"images": 5, "rmse_m": 0.00123456, "scale_error_percent": 0.5},
        "objects": "missing",
    }
    assert table_rows(figures) == [
        ("cameras.images", "5", ""),
        ("cameras.rmse_m", "0.001235", "m"),
        ("cameras.scale_error_percent", "0.5", "%"),
        ("objects", "missing", ""),
    ]
    assert unit_of("rotation_rmse_deg") == "deg"


def test_json_has_null_for_nan() -> None:
    assert without_nan({"a": {"b": float("nan"), "c": 1.5, "d": [1]}}) == {
        "a": {"b": None, "c": 1.5, "d": [1]}
    }
