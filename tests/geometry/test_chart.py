# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import gzip
import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.errors import InputError
from hullrecon.geometry.charts.address import address
from hullrecon.geometry.charts.chart import (
    Chart,
    chart_for_hull,
    chart_for_points,
    chart_from_arrays,
)
from hullrecon.geometry.charts.region import chart_limits
from hullrecon.geometry.meshes.mesh import Mesh

QUICK = settings(max_examples=30, deadline=None, derandomize=True)

RADIUS = 3.0


@pytest.fixture(scope="session")
def chart(steel: Mesh) -> Chart:
    return chart_for_hull(steel)


def metric(chart: Chart, along_girth: np.ndarray, step_m: float) -> np.ndarray:
    """Metres on the surface per metre of the chart, along and girth, at (n, 2): (n, 2), NaN where a
    neighbour is missing.
    """
    half = 0.5 * step_m * np.eye(2)
    gaps = [
        chart.from_chart(along_girth + axis)[0] - chart.from_chart(along_girth - axis)[0]
        for axis in half
    ]
    return np.stack([np.linalg.norm(gap, axis=1) / step_m for gap in gaps], axis=1)


def on_barge(along: float, girth: float, offset: float = 0.0) -> np.ndarray:
    angle = girth / RADIUS
    reach = RADIUS + offset
    return np.array([along, reach * np.sin(angle), RADIUS - reach * np.cos(angle)])


def test_girth_is_arc_from_the_keel_and_port_is_positive(chart: Chart) -> None:
    points = np.stack([on_barge(5.0, 2.0), on_barge(5.0, -2.0), on_barge(7.5, 0.0)])
    assert np.allclose(chart.to_chart(points), [[5, 2, 0], [5, -2, 0], [7.5, 0, 0]], atol=2e-3)


def test_offset_is_positive_outside_the_steel(chart: Chart) -> None:
    found = chart.to_chart(np.stack([on_barge(5.0, 1.0, 0.4), on_barge(5.0, 1.0, -0.4)]))
    assert np.allclose(found[:, 2], [0.4, -0.4], atol=2e-3)


def test_normals_point_outward_even_when_the_faces_do_not(steel: Mesh) -> None:
    inverted = chart_for_hull(Mesh(steel.vertices, steel.faces[:, ::-1].copy()))
    points, normals = inverted.from_chart(np.array([[5.0, 1.0]]))
    assert np.allclose(normals[0], [0, np.sin(1 / RADIUS), -np.cos(1 / RADIUS)], atol=0.03)
    assert inverted.to_chart(points + 0.2 * normals)[0, 2] == pytest.approx(0.2, abs=1e-6)


def test_there_is_no_chart_above_the_sheer_nor_beyond_the_ends(chart: Chart) -> None:
    sheer = RADIUS * np.pi / 2
    points, _ = chart.from_chart(
        np.array([[5.0, sheer + 0.3], [-1.0, 0.5], [21.0, 0.5], [5.0, sheer - 0.3]])
    )
    assert np.isnan(points[:3]).all()
    assert np.isfinite(points[3]).all()


def test_points_that_are_not_numbers_stay_so(chart: Chart) -> None:
    assert np.isnan(chart.to_chart(np.full((1, 3), np.nan))).all()
    assert np.isnan(chart.from_chart(np.full((1, 2), np.nan))[0]).all()


@QUICK
@given(along=st.floats(0.3, 19.7), girth=st.floats(-4.4, 4.4))
def test_from_chart_and_back(chart: Chart, along: float, girth: float) -> None:
    points, _ = chart.from_chart(np.array([[along, girth]]))
    assert np.allclose(chart.to_chart(points), [[along, girth, 0]], atol=1e-9)


@QUICK
@given(along=st.floats(0.3, 19.7), girth=st.floats(-4.4, 4.4), offset=st.floats(-0.5, 0.5))
def test_a_point_off_the_hull_is_its_offset_from_its_foot(
    chart: Chart, along: float, girth: float, offset: float
) -> None:
    point = on_barge(along, girth, offset)
    found = chart.to_chart(point[None])
    foot, _ = chart.from_chart(found[:, :2])
    assert np.linalg.norm(foot[0] - point) == pytest.approx(abs(found[0, 2]), abs=1e-6)


def test_arrays_give_the_same_chart_back(chart: Chart) -> None:
    arrays = {name: np.asarray(value) for name, value in chart.to_arrays().items()}
    at = np.array([[3.3, 1.1], [9.0, -2.2]])
    again = chart_from_arrays(arrays)
    assert np.array_equal(again.from_chart(at)[0], chart.from_chart(at)[0])
    assert np.array_equal(
        again.to_chart(chart.from_chart(at)[0]), chart.to_chart(chart.from_chart(at)[0])
    )


def test_a_half_hull_has_girth_from_the_middle_plane(half_steel: Mesh) -> None:
    half = chart_for_hull(half_steel)
    assert np.allclose(half.to_chart(on_barge(5.0, 2.0)[None])[0], [5, 2, 0], atol=2e-3)
    assert np.isnan(half.from_chart(np.array([[5.0, -1.0]]))[0]).all()


def test_a_cad_model_with_another_axis_up_has_the_same_girth(steel: Mesh) -> None:
    # x fwd, y port, z up to z fwd, x port, y up
    turn = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    turned = chart_for_hull(Mesh(steel.vertices @ turn.T, steel.faces), up=(0.1, 0.9, 0.0))
    assert np.allclose(turned.to_chart((turn @ on_barge(5.0, 2.0))[None])[0], [5, 2, 0], atol=2e-3)


def test_a_hole_in_the_plating_is_bridged_only_where_it_is_small(steel: Mesh) -> None:
    middle = steel.vertices[steel.faces].mean(axis=1)
    hole = np.linalg.norm(middle - on_barge(10.0, 2.0), axis=1) < 1.2
    holed = chart_for_hull(Mesh(steel.vertices, steel.faces[~hole]))
    beyond = on_barge(10.0, 4.0)[None]
    assert np.isnan(holed.from_chart(np.array([[10.0, 2.0]]))[0]).all()
    assert holed.to_chart(beyond)[0, 1] == pytest.approx(4.0, abs=0.1)


def test_a_mesh_that_no_ray_meets_is_refused() -> None:
    speck = Mesh(np.array([[0.0, 0, 0], [10, 0, 0], [10, 0, 1]]), np.array([[0, 1, 2]], np.int32))
    with pytest.raises(InputError, match="CAD model"):
        chart_for_hull(speck)


def test_the_metric_of_a_cylinder_is_one(chart: Chart) -> None:
    assert np.allclose(metric(chart, np.array([[5.0, 1.0], [12.0, -3.0]]), 0.2), 1.0, atol=2e-3)


def test_the_metric_of_a_wedge_is_its_slope() -> None:
    x = np.array([0.0, 10.0])
    corners = np.array(
        [[u, y, z] for u in x for y, z in ((0, 0), (1, 0), (1 + u, 6.0), (-1 - u, 6.0), (-1, 0))]
    )
    section = np.array([[1, 2], [4, 1], [3, 4]])
    faces = np.vstack([[[a, b, a + 5], [b, b + 5, a + 5]] for a, b in section])
    wedge = chart_for_hull(Mesh(corners, faces.astype(np.int32)))
    at = wedge.to_chart(np.array([[5.0, 1 + 5 * 0.5, 3.0]]))[:, :2]
    assert metric(wedge, at, 0.1)[0, 1] == pytest.approx(1.0, abs=0.01)
    assert metric(wedge, at, 0.1)[0, 0] > 1.03


def test_addresses_are_words(chart: Chart) -> None:
    points = np.stack(
        [on_barge(5.22, 2.31), on_barge(5.22, -2.31), on_barge(3.0, 0.0), [50.0, 50.0, 90.0]]
    )
    words = address(chart, points, frame_spacing_m=0.6, depths_m=[1.8, np.nan, -0.2, np.nan])
    assert (
        words[0] == "frame 8.7 (5.2 m from AP), port, 2.31 m girth from keel, 1.8 m below waterline"
    )
    assert words[1] == "frame 8.7 (5.2 m from AP), starboard, 2.31 m girth from keel"
    assert words[2] == "frame 5.0 (3.0 m from AP), keel, 0.2 m above waterline"
    assert address(chart, points[1])[0] == "5.2 m from AP, starboard, 2.31 m girth from keel"


def wall(normal: np.ndarray, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    side = np.cross(normal, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    spread = rng.uniform(-1, 1, (400, 2)) * [6, 2]
    return (
        2.0 * normal
        + spread[:, :1] * side
        + spread[:, 1:] * np.cross(normal, side)
        + rng.normal(0, 0.01, (400, 1)) * normal
    )


def test_a_plane_looks_toward_the_sensors() -> None:
    normal = np.array([0.0, 1.0, 0.0])
    for sensors, offset in (
        (np.array([0.0, 0, 0]), 2.0),
        (np.array([[0.0, 5, 0], [0, 7, 0]]), -2.0),
    ):
        chart = chart_for_points(wall(normal), sensors)
        assert chart.to_chart(np.zeros((1, 3)))[0, 2] == pytest.approx(offset, abs=0.01)


def test_girth_of_standing_plane_grows_upward() -> None:
    chart = chart_for_points(wall(np.array([0.0, 1.0, 0.0])), np.zeros(3))
    deep, shallow = chart.to_chart(np.array([[0.0, 2, 5], [0, 2, 3]]))  # z is down in g
    assert shallow[1] - deep[1] == pytest.approx(2.0, abs=0.02)
    origin, along, girth = (
        chart.from_chart(np.array([at]))[0][0] for at in ([0.0, 0], [1.0, 0], [0.0, 1])
    )
    _, normals = chart.from_chart(np.zeros((1, 2)))
    assert np.allclose(np.cross(along - origin, girth - origin), -normals[0])


def test_a_level_plane_lies_along_the_longest_spread() -> None:
    rng = np.random.default_rng(2)
    floor = np.hstack([rng.uniform(-1, 1, (300, 2)) * [1, 9], np.full((300, 1), 4.0)])
    along = chart_for_points(floor, np.zeros(3)).from_chart(np.array([[0.0, 0], [1.0, 0]]))[0]
    assert abs((along[1] - along[0])[1]) == pytest.approx(1.0, abs=0.01)


def test_stray_returns_do_not_tilt_the_plane() -> None:
    points = np.vstack([wall(np.array([0.0, 1.0, 0.0])), np.tile([3.0, 30.0, 1.0], (20, 1))])
    assert np.allclose(
        chart_for_points(points, np.zeros(3)).from_chart(np.zeros((1, 2)))[1],
        [[0, -1, 0]],
        atol=0.01,
    )


def test_a_plane_survives_its_arrays() -> None:
    chart = chart_for_points(wall(np.array([0.6, 0.8, 0.0])), np.zeros(3))
    again = chart_from_arrays(
        {name: np.asarray(value) for name, value in chart.to_arrays().items()}
    )
    points = np.array([[1.0, 2.0, 3.0]])
    assert np.array_equal(again.to_chart(points), chart.to_chart(points))
    assert address(again, points)[0].endswith("m across")


def test_two_points_make_no_plane() -> None:
    with pytest.raises(InputError, match="three points"):
        chart_for_points(np.array([[0.0, 0, 0], [1, 0, 0], [np.nan, 0, 0]]), np.zeros(3))


def real_hull(path: Path) -> trimesh.Trimesh:
    raw = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    kind = path.name.removesuffix(".gz").rsplit(".", 1)[1]
    return trimesh.load(io.BytesIO(raw), file_type=kind, force="mesh")


@pytest.mark.parametrize(
    "name",
    [
        "dive-a/hull.stl",
        "hulls/kvlcc2_lq_3dpea.stl",
        "hulls/DTC-scaled_decimated30k.stl",
        "hulls/wigley.stl.gz",
        "hulls/JBC_rigidBodyHull_HULL.obj.gz",
    ],
)
def test_real_hulls_are_charted_without_garbage(data: Path, name: str) -> None:
    hull = real_hull(data / name)
    length = float(np.ptp(hull.vertices[:, 0]))
    chart = chart_for_hull(Mesh(np.asarray(hull.vertices, float), np.asarray(hull.faces, np.int32)))
    points, face = trimesh.sample.sample_surface(hull, 5000, seed=1)
    steel = hull.face_normals[face]
    shell = (np.abs(steel[:, 0]) < 0.9) & (
        (np.abs(steel[:, 2]) < 0.7) | (points[:, 2] < hull.vertices[:, 2].mean())
    )
    at = chart.to_chart(points)
    charted = np.isfinite(at[:, 1])
    assert charted[shell].mean() > 0.97  # the shell without transoms and decks
    back, normals = chart.from_chart(at[charted, :2])
    miss = np.linalg.norm(back - points[charted], axis=1)
    assert np.percentile(miss, 99) < 1e-5 * length
    lifted = chart.to_chart(back + 0.002 * length * normals)
    assert np.median(np.abs(lifted[:, 2] - 0.002 * length)) < 1e-6 * length
    assert np.mean(lifted[:, 2] > 0) > 0.99
    assert np.nanpercentile(metric(chart, at[charted, :2], length / 1000), 99) < 3.0


def test_bow_on_negative_axis_gives_same_addresses(steel: Mesh) -> None:
    plain = chart_for_hull(steel)
    turn = np.diag([-1.0, -1.0, 1.0])
    turned = chart_for_hull(Mesh(steel.vertices @ turn, steel.faces), bow="-x")
    points = np.array([[5.0, 3.0, 2.7], [7.0, -3.0, 2.5]])
    np.testing.assert_allclose(turned.to_chart(points @ turn), plain.to_chart(points), atol=1e-9)
    assert address(turned, points @ turn, 0.6) == address(plain, points, 0.6)
    assert address(turned, points @ turn)[0].startswith("5.0 m from AP, port")


@pytest.mark.parametrize(("bow", "sign"), [("+x", 1.0), ("-x", -1.0)])
def test_stations_count_from_the_aft_perpendicular(steel: Mesh, bow: str, sign: float) -> None:
    turn = np.diag([sign, sign, 1.0])
    # a file whose zero lies 10 m ahead of it
    amidships = Mesh((steel.vertices - [10.0, 0, 0]) @ turn, steel.faces)
    chart = chart_for_hull(amidships, bow=bow, aft_perpendicular_m=-10.0 * sign)
    points = np.array([[5.0, 3.0, 2.7], [7.0, -3.0, 2.5]])
    at, plain = (points - [10.0, 0, 0]) @ turn, chart_for_hull(steel)
    found = chart.to_chart(at)
    np.testing.assert_allclose(found, plain.to_chart(points), atol=1e-9)
    on_skin = plain.from_chart(found[:, :2])[0]
    np.testing.assert_allclose(
        chart.from_chart(found[:, :2])[0], (on_skin - [10.0, 0, 0]) @ turn, atol=1e-9
    )
    assert address(chart, at, 0.6) == address(plain, points, 0.6)
    again = chart_from_arrays(chart.to_arrays())
    np.testing.assert_array_equal(again.to_chart(at), found)
    np.testing.assert_allclose(chart_limits(chart, amidships), chart_limits(plain, steel), atol=0.1)
    # artifacts made before are read as they were
    assert "aft_perpendicular" not in plain.to_arrays()
