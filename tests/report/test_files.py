# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The deliverables that other programs read."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hullrecon.dive.config.schema import Hull
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.trajectory import Trajectory
from hullrecon.report.export.geometry import (
    alignment_document,
    landmarks_ply,
    ply_bytes,
    surface_ply,
)
from hullrecon.report.export.tables import (
    csv_metadata,
    csv_text,
    numbers,
    objects_table,
    seconds,
    trajectory_table,
    trajectory_tum,
)
from hullrecon.report.survey import Survey

Reader = Callable[[bytes], tuple[np.ndarray, np.ndarray | None]]


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_seconds_keep_all_nanoseconds() -> None:
    assert seconds(np.array([1_777_887_000_468_241_234, 5])) == [
        "1777887000.468241234",
        "0.000000005",
    ]


def test_a_lost_value_is_an_empty_cell() -> None:
    assert numbers(np.array([1.5, np.nan]), ".2f") == ["1.50", ""]


def test_cells_with_commas_and_quotes_are_read_back_as_they_were() -> None:
    table = {"a": ['frame 3, "port"', "plain"], "b": [1, None]}
    assert rows_of(csv_text(table)) == [{"a": 'frame 3, "port"', "b": "1"}, {"a": "plain", "b": ""}]


def test_the_trajectory_is_in_the_hull_frame(survey: Survey) -> None:
    row = rows_of(trajectory_table(survey).csv)[1]
    # T_g_M turns by 180 degrees about x and moves by (10, 20, 3): (10.5, 21, 2) of g is (0.5, -1,
    # 1) of M
    np.testing.assert_allclose([float(row[f"{k}_m"]) for k in "xyz"], [0.5, -1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(
        [abs(float(row[k])) for k in ("qx", "qy", "qz", "qw")], [1, 0, 0, 0], atol=1e-9
    )
    np.testing.assert_allclose(
        [float(row[f"sigma_{k}"]) for k in ("x_m", "y_m", "z_m", "roll_rad", "yaw_rad")],
        [0.5, 0.02, 0.01, 0.001, 0.002],
    )
    assert row["t_s"] == "1777887001.468241234"
    assert float(row["tray_rad"]) == 0.1


def test_the_trajectory_says_where_on_the_ship_and_how_deep(survey: Survey) -> None:
    row = rows_of(trajectory_table(survey).csv)[1]
    assert (float(row["along_m"]), float(row["girth_m"]), float(row["depth_m"])) == pytest.approx(
        (0.5, -1.0, 2.0)
    )
    dry = replace(survey, facts=replace(survey.facts, has_depth=False))
    assert rows_of(trajectory_table(dry).csv)[1]["depth_m"] == ""


def test_where_on_the_ship_and_how_deep_have_their_sigmas(survey: Survey) -> None:
    row = rows_of(trajectory_table(survey).csv)[1]
    # without a sigma of the pressure sensor's bias, that towards the water
    assert [
        float(row[k]) for k in ("sigma_along_m", "sigma_girth_m", "depth_sigma_m")
    ] == pytest.approx([0.5, 0.02, 0.01])
    assert survey.adjusted is not None
    known = replace(survey, adjusted=replace(survey.adjusted, depth_sigma_m=0.095))
    assert float(rows_of(trajectory_table(known).csv)[1]["depth_sigma_m"]) == pytest.approx(0.095)
    dry = replace(survey, facts=replace(survey.facts, has_depth=False))
    assert rows_of(trajectory_table(dry).csv)[1]["depth_sigma_m"] == ""


def test_a_dead_reckoned_depth_has_the_sigma_of_the_position(bare: Survey) -> None:
    row = rows_of(trajectory_table(bare).csv)[4]
    assert row["sigma_along_m"] == row["sigma_girth_m"] == ""
    assert row["depth_sigma_m"] == row["sigma_z_m"]


def test_the_metadata_name_unit_and_meaning_of_every_column(
    survey: Survey, found: ReportedObject
) -> None:
    tables = [trajectory_table(survey), objects_table([found])]
    for table, entry in zip(tables, csv_metadata(tables)["tables"], strict=True):  # type: ignore[arg-type]
        columns = entry["tableSchema"]["columns"]
        assert entry["url"] == table.file
        assert [c["name"] for c in columns] == list(rows_of(table.csv)[0])
        assert all(c["dc:description"] for c in columns)
        units = {c["name"]: c.get("unit") for c in columns}
        assert units.get("x_m", "m") == units.get("height_m", "m") == "m"
        assert all(
            units[name] == name.rsplit("_", 1)[1]
            for name in units
            if name.endswith(("_m", "_m2", "_m3"))
        )


def test_without_a_solution_the_trajectory_is_dead_reckoned_in_g(bare: Survey) -> None:
    track = bare.track
    row = rows_of(trajectory_table(bare).csv)[4]
    assert track.frame == "g"
    assert row["along_m"] == row["side"] == ""
    np.testing.assert_allclose([float(row[f"{k}_m"]) for k in "xyz"], [12.0, 21.0, 2.0])
    assert float(row["sigma_x_m"]) == pytest.approx(0.1 * 5**0.5, rel=1e-5)


def test_without_a_cad_model_the_trajectory_is_adjusted_in_g(
    trajectory: Trajectory, solution: Solution
) -> None:
    track = replace(solution, hull_pose=None).track()
    assert track.frame == "g"
    np.testing.assert_allclose(track.poses.translation, solution.global_from_vehicle.translation)


def test_the_tum_file_holds_the_same_poses(survey: Survey) -> None:
    lines = [line.split() for line in trajectory_tum(survey.track).splitlines()]
    table = rows_of(trajectory_table(survey).csv)
    assert [line[0] for line in lines] == [row["t_s"] for row in table]
    assert [line[1:] for line in lines] == [
        [row[k] for k in ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")] for row in table
    ]


def test_sigma_towards_a_direction_uses_the_whole_covariance(trajectory: Trajectory) -> None:
    covariance = trajectory.covariance.copy()
    covariance[:, 0, 1] = covariance[:, 1, 0] = covariance[:, 0, 0]  # x and y err together
    track = replace(trajectory, covariance=covariance).track()
    across = np.tile([2**-0.5, -(2**-0.5), 0.0], (5, 1))
    np.testing.assert_allclose(track.sigma_towards(across), 0, atol=1e-9)
    np.testing.assert_allclose(
        track.sigma_towards(-across * [1, -1, 1])[0], 0.1 * 2**0.5, rtol=1e-6
    )


def test_landmarks_ply_is_in_the_hull_frame_with_its_fields(
    survey: Survey, solution: Solution, ply_reader: Reader
) -> None:
    vertices, faces = ply_reader(landmarks_ply(survey, solution))
    assert faces is None
    np.testing.assert_allclose([vertices[k][1] for k in "xyz"], [1.0, -1.5, 0.1], atol=1e-9)
    np.testing.assert_array_equal(vertices["label"], [1, 0, 1])
    np.testing.assert_allclose(vertices["deviation"], [0, 0.1, -0.004], rtol=1e-6)
    np.testing.assert_allclose(vertices["sigma"], np.sqrt((1 + 4 + 4) / 3) * 1e-3, rtol=1e-6)
    np.testing.assert_array_equal(vertices["track"], [4, 6, 2])
    np.testing.assert_array_equal([vertices[k][2] for k in ("red", "green", "blue")], [70, 80, 90])


def test_a_ply_says_its_frame_and_its_units(survey: Survey, plate: Surface) -> None:
    head = surface_ply(survey, plate).split(b"end_header")[0].decode()
    assert "comment frame M: the hull frame" in head
    assert "comment unit metre" in head


def test_the_hull_as_found_carries_its_form(
    survey: Survey, plate: Surface, split: DeviationSplit, ply_reader: Reader
) -> None:
    vertices, _ = ply_reader(surface_ply(survey, plate, split))
    np.testing.assert_allclose(vertices["form"], split.form, rtol=1e-6)
    np.testing.assert_allclose(vertices["form_sigma"], split.form_sigma, rtol=1e-6)
    assert "form" not in ply_reader(surface_ply(survey, replace(plate)))[0].dtype.names


def test_a_surface_keeps_its_faces_and_values(
    survey: Survey, plate: Surface, ply_reader: Reader
) -> None:
    vertices, faces = ply_reader(surface_ply(survey, plate))
    np.testing.assert_array_equal(faces, plate.faces)
    np.testing.assert_allclose(np.stack([vertices[k] for k in "xyz"], axis=1), plate.vertices)
    np.testing.assert_array_equal(vertices["support"], plate.support)


def test_open3d_reads_the_ply(survey: Survey, plate: Surface, tmp_path: Any) -> None:
    open3d = pytest.importorskip("open3d")
    (tmp_path / "s.ply").write_bytes(surface_ply(survey, plate))
    mesh = open3d.io.read_triangle_mesh(str(tmp_path / "s.ply"))
    assert (len(mesh.vertices), len(mesh.triangles)) == (15, 16)


def test_a_property_of_another_type_is_refused() -> None:
    with pytest.raises(KeyError, match="int64"):
        ply_bytes({"x": np.array([1])})


def test_the_alignment_names_its_prior_and_its_weak_directions(solution: Solution) -> None:
    hull = Hull(mesh="hull.stl", pose=(1.0, 2.0, 3.0, 180.0, 0.0, 0.0))
    document = alignment_document(solution.hull_pose, hull, [{"sigma": 0.5, "sentence": "along"}])
    assert document["T_g_M"]["translation"] == [10.0, 20.0, 3.0]
    np.testing.assert_allclose(np.abs(document["prior"]["quaternion"]), [1, 0, 0, 0], atol=1e-9)
    assert document["covariance"] == solution.hull_pose.covariance.tolist()
    # as Solution has it: added in the parent frame
    assert document["covariance_order"].startswith("translation x y z in g")
    assert document["weak_directions"][0]["sentence"] == "along"


def test_objects_have_one_line_each(found: ReportedObject) -> None:
    (row,) = rows_of(objects_table([found]).csv)
    assert row["address"] == "frame 3 + 0.2 m, port"
    values = [
        row[name] for name in ("center_x_m", "height_m", "height_sigma_m", "views", "image_count")
    ]
    assert values == ["1", "0.1", "0.004", "6", "1"]
    assert (row["sigma_along_m"], row["sigma_girth_m"], row["along_m"], row["side"]) == (
        "0.3",
        "0.02",
        "1",
        "starboard",
    )
