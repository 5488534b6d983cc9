# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.evaluation.deliverables import (
    deliver_folder,
    read_cloud,
    read_table,
    read_trajectory,
)


def test_empty_cells_are_nan(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x\n1,2\n3,\n")
    table = read_table(tmp_path / "a.csv")
    np.testing.assert_array_equal(table["x"], [2, np.nan])


def test_a_column_of_words_beside_the_numbers_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "words.csv").write_text("t,side,depth_m\n1,port,2.5\n2,,3.5\n")
    table = read_table(tmp_path / "words.csv")
    assert set(table) == {"t", "depth"}
    np.testing.assert_array_equal(table["depth"], [2.5, 3.5])


def test_a_column_is_known_by_its_name_with_or_without_a_unit(tmp_path: Path) -> None:
    (tmp_path / "bare.csv").write_text("t,x,sigma_x,sigma_roll,tray\n1,2,3,4,5\n")
    (tmp_path / "units.csv").write_text("t_s,x_m,sigma_x_m,sigma_roll_rad,tray_rad\n1,2,3,4,5\n")
    assert read_table(tmp_path / "units.csv") == read_table(tmp_path / "bare.csv")


@pytest.mark.parametrize("text", ["", "t,x\n", "t,x\n1,two\n"])
def test_a_table_that_cannot_be_read_is_named(text: str, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError, match=r"bad\.csv"):
        read_table(tmp_path / "bad.csv")


def test_a_track_reads_as_it_was_written(deliver) -> None:  # type: ignore[no-untyped-def]
    deliver.track(sigma=(0.1, 0.2, 0.3))
    track = read_trajectory(deliver.folder / "trajectory.csv")
    assert len(track.poses) == 41
    np.testing.assert_allclose(track.sigma[0], [0.1, 0.2, 0.3])
    assert track.t_s[1] - track.t_s[0] == pytest.approx(0.5)


def test_a_track_without_sigmas_has_none(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("t,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n")
    assert read_trajectory(tmp_path / "t.csv").sigma is None


def test_a_cloud_keeps_its_fields(deliver, wall_points: np.ndarray) -> None:  # type: ignore[no-untyped-def]
    deliver.cloud("c.ply", wall_points, label=np.ones(400, "u1"), sigma=np.full(400, 0.01, "<f4"))
    cloud = read_cloud(deliver.folder / "c.ply")
    np.testing.assert_array_equal(cloud.points, wall_points)
    assert cloud.fields["label"].dtype == np.uint8
    np.testing.assert_allclose(cloud.fields["sigma"], 0.01)


def test_faces_after_the_vertices_are_passed_over(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.ply")
    assert read_cloud(tmp_path / "box.ply").points.shape == (8, 3)


def test_a_ply_cut_short_is_named(deliver, wall_points: np.ndarray) -> None:  # type: ignore[no-untyped-def]
    deliver.cloud("c.ply", wall_points)
    path = deliver.folder / "c.ply"
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(InputError, match="cut short"):
        read_cloud(path)


def test_something_else_than_a_binary_ply_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text("ply\nformat ascii 1.0\nelement vertex 0\nend_header\n")
    with pytest.raises(InputError, match="not a binary"):
        read_cloud(tmp_path / "a.ply")


def test_a_run_or_its_deliver_folder_will_do(deliver) -> None:  # type: ignore[no-untyped-def]
    deliver.track()
    assert deliver_folder(deliver.folder) == deliver.folder
    assert deliver_folder(deliver.folder.parent) == deliver.folder


def test_a_folder_without_deliverables_is_refused_with_advice(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="hullrecon run"):
        deliver_folder(tmp_path)
