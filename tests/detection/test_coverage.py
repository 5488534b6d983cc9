# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from end_to_end.json_schema import violations

from hullrecon.detection import coverage, coverage_holes, hull_patches, sonar_visibility
from hullrecon.detection.base_surface import BaseSurface
from hullrecon.detection.views import find_visibility
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.poses import Poses, from_mount, from_rpy
from hullrecon.records.sensors import SonarPings
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import VehicleTrack

SCHEMA = (
    Path(__file__).resolve().parents[2]
    / "hullrecon"
    / "report"
    / "schemas"
    / "coverage.schema.json"
)


@pytest.fixture
def hull(wall) -> hull_patches.HullPatches:
    return hull_patches.hull_patches(refine(wall, 0.06)[0])


def test_pieces_hold_the_whole_area(hull) -> None:
    assert hull.area.sum() == pytest.approx(8.0)
    assert np.allclose(hull.normal, [0, 1, 0])


def test_the_cameras_area_is_its_footprint(hull, wall, views_at) -> None:
    views = views_at([1.5, 2.5])
    facts = coverage.camera_facts(
        hull, find_visibility(views, hull.mesh.vertices, hull.normal, Scene(wall)), 640.0, 2
    )
    # each image shows 1.3 m by 1.04 m; they overlap by 0.3 m
    assert facts["area_m2"] == pytest.approx((1.3 + 1.0) * 1.04, rel=0.05)
    assert facts["area_twice_m2"] == pytest.approx(0.3 * 1.04, rel=0.2)
    assert facts["images"] == 2


def test_gsd_is_distance_over_focal_length(hull, wall, views_at) -> None:
    facts = coverage.camera_facts(
        hull,
        find_visibility(views_at([2.0]), hull.mesh.vertices, hull.normal, Scene(wall)),
        640.0,
        1,
    )
    assert facts["gsd_m"]["p05"] == pytest.approx(1.3 / 640, rel=0.02)
    assert facts["incidence_deg"]["p95"] < np.degrees(np.arctan(np.hypot(0.65, 0.52) / 1.3))


def test_a_camera_that_saw_nothing_has_no_percentiles(hull, wall, views_at) -> None:
    facts = coverage.camera_facts(
        hull,
        find_visibility(views_at([40.0]), hull.mesh.vertices, hull.normal, Scene(wall)),
        640.0,
        1,
    )
    assert facts["area_m2"] == 0
    assert facts["gsd_m"] is None


def test_the_dvls_area_lies_near_its_surface(hull) -> None:
    covered = coverage.covered_by_surface(hull, np.array([[1.0, 2.0, 1.0]]), 0.3)
    assert coverage.area_facts(hull, covered)["area_m2"] == pytest.approx(np.pi * 0.09, rel=0.1)
    assert not coverage.covered_by_surface(hull, np.zeros((0, 3)), 0.3).any()


def _pings(half_bearing: float) -> SonarPings:
    bearing = np.linspace(-half_bearing, half_bearing, 5)
    directions = np.column_stack([np.zeros(5), np.sin(bearing), np.cos(bearing)])
    return SonarPings(
        t_ns=np.array([0]),
        image=np.zeros((1, 5, 3), np.uint8),
        directions=directions,
        range_m=np.array([0.5, 1.5, 2.5]),
    )


def _sonar_at(x: float, y: float) -> Poses:
    """Looking at the wall: z along -y; x, out of the fan, up; so beams spread along the wall."""
    from scipy.spatial.transform import Rotation

    turn = np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]).T
    return Poses(Rotation.from_matrix(turn).as_quat()[None], np.array([[x, y, 1.0]]))


def _survey(poses: Poses) -> sonar_visibility.SonarSurvey:
    return sonar_visibility.SonarSurvey(
        pings=_pings(np.radians(30)), poses=poses, half_elevation_rad=np.radians(7)
    )


def test_sonar_sees_strip_of_its_fan_and_elevation(hull, wall) -> None:
    seen = sonar_visibility.visible_to_sonar(hull, _survey(_sonar_at(2.0, 4.0)), Scene(wall))
    x, _, z = hull.mesh.vertices[seen].T
    assert np.abs(x - 2).max() == pytest.approx(2 * np.tan(np.radians(30)), abs=0.1)
    assert (
        np.abs(z - 1).max()
        <= np.hypot(2, 2 * np.tan(np.radians(30))) * np.tan(np.radians(7)) + 1e-9
    )
    assert seen.sum() > 50


def test_beyond_its_range_and_from_behind_the_sonar_sees_nothing(hull, wall) -> None:
    assert not sonar_visibility.visible_to_sonar(
        hull, _survey(_sonar_at(2.0, 5.0)), Scene(wall)
    ).any()
    behind = Poses(from_rpy([0, 0, 0], [0, 0, 0]).quaternion, np.array([[2.0, 2.0, -1.0]]))
    assert not sonar_visibility.visible_to_sonar(hull, _survey(behind), Scene(wall)).any()


def test_area_seen_by_sonar_has_sigma_of_hull_pose(hull, wall) -> None:
    """A fan that looks past the wall's edge: half a metre off sideways, the strip seen is a quarter
    of its width off.
    """
    survey, still = _survey(_sonar_at(0.0, 4.0)), np.diag(np.full(6, 1e-12))
    hull_pose = HullPose(
        global_from_hull=from_rpy([0, 0, 0], [0, 0, 0]), covariance=still, survey_center=np.zeros(3)
    )
    certain = coverage.sonar_facts(hull, survey, Scene(wall), hull_pose)
    assert certain["area_sigma_m2"] < 0.02
    assert "area_sigma_m2" not in coverage.sonar_facts(hull, survey, Scene(wall), None)
    sideways = replace(hull_pose, covariance=np.diag([0.25, 0, 0, 0, 0, 0]))
    left, right = (
        sonar_visibility.visible_to_sonar(hull, _survey(_sonar_at(x, 4.0)), Scene(wall)) @ hull.area
        for x in (-0.5, 0.5)
    )
    found = coverage.sonar_facts(hull, survey, Scene(wall), sideways)
    assert found["area_sigma_m2"] == pytest.approx((right - left) / 2, abs=0.03)
    assert found["area_sigma_m2"] > 0.1
    assert found["area_m2"] == certain["area_m2"]


def _address(point: np.ndarray) -> dict[str, Any]:
    return {"address": f"x {point[0]:.1f}"}


def test_hole_in_survey_has_address_and_area(hull, scenery) -> None:
    x, _, z = hull.mesh.vertices.T
    seen = (np.abs(x - 2) < 1.2) & (np.abs(z - 1) < 0.8)
    seen &= np.maximum(np.abs(x - 2.5), np.abs(z - 1.0)) > 0.25
    (hole,) = coverage_holes.find_holes(hull, seen, scenery.chart, _address)
    assert hole["address"] == "x 2.5"
    assert hole["area_m2"] == pytest.approx(0.25, rel=0.1)
    assert np.allclose(hole["center"], [2.5, 2, 1], atol=0.1)


def test_the_largest_hole_comes_first_and_specks_are_left_out(hull, scenery) -> None:
    x, _, z = hull.mesh.vertices.T
    seen = (np.abs(x - 2) < 1.5) & (np.abs(z - 1) < 0.8)
    for at, half in ((1.2, 0.2), (2.4, 0.3), (3.2, 0.04)):
        seen &= np.maximum(np.abs(x - at), np.abs(z - 1.0)) > half
    assert [
        hole["address"] for hole in coverage_holes.find_holes(hull, seen, scenery.chart, _address)
    ] == ["x 2.4", "x 1.2"]


def test_a_notch_in_the_rim_of_the_dvls_surface_is_no_hole(base: BaseSurface, hull) -> None:
    """Its surface ends 0.4 m from a return, wherever that lies; a camera's image has an edge of its
    own.
    """
    x, _, z = base.surveyed.vertices.T
    for half, holes in ((0.15, 0), (0.4, 1)):
        measured = refine(base.mesh, 0.06)[0]
        x, _, z = measured.vertices.T
        on = np.maximum(np.abs(x - 2.0), np.abs(z - 1.0)) > half
        n = len(x)
        surveyed = Surface(
            vertices=measured.vertices,
            faces=measured.faces,
            deviation=np.zeros(n),
            sigma=np.ones(n),
            support=on.astype(int),
        )
        found = coverage.summarise_coverage(
            replace(base, surveyed=surveyed), None, None, _track((0.3, 0.3))
        )
        assert found["min_hole_m2"] == 0.16
        assert found["min_bay_m"] == 0.2
        assert len(found["holes"]) == holes


@pytest.mark.parametrize(("depth_m", "holes"), [(0.2, 0), (0.3, 1)])
def test_bay_of_the_rim_is_a_hole_if_deeper_than_a_cell(depth_m, holes, hull, scenery) -> None:
    """One of 0.2 m lacks a single row of whole cells."""
    x, _, z = hull.mesh.vertices.T
    seen = (np.abs(x - 2) < 1.2) & (np.abs(z - 1) < 0.6)
    seen &= (np.abs(x - 2) > 0.3) | (z < 1.6 - depth_m)
    assert len(coverage_holes.find_holes(hull, seen, scenery.chart, _address)) == holes


def test_what_lies_outside_the_survey_is_no_hole(hull, scenery) -> None:
    seen = np.abs(hull.mesh.vertices[:, 0] - 2) < 1
    assert coverage_holes.find_holes(hull, seen, scenery.chart, _address) == []
    assert coverage_holes.find_holes(hull, np.zeros(len(seen), bool), scenery.chart, _address) == []


def test_a_part_without_any_surface_inside_the_survey_is_a_hole(hull, scenery) -> None:
    """Without a CAD model the hull itself ends where nothing was measured; so do its patches."""
    middle = hull.mesh.vertices[hull.mesh.faces].mean(axis=1)
    gap = np.maximum(np.abs(middle[:, 0] - 2.0), np.abs(middle[:, 2] - 1.0)) < 0.75
    rest = hull_patches.hull_patches(Mesh(hull.mesh.vertices, hull.mesh.faces[~gap]))
    torn = np.isin(np.arange(len(hull.mesh.vertices)), rest.mesh.faces)
    rows = np.flatnonzero(torn)
    number = np.full(len(torn), -1)
    number[rows] = np.arange(len(rows))
    rest = hull_patches.hull_patches(
        Mesh(hull.mesh.vertices[rows], number[rest.mesh.faces].astype(np.int32))
    )
    (hole,) = coverage_holes.find_holes(rest, np.ones(len(rows), bool), scenery.chart, _address)
    assert hole["area_m2"] == pytest.approx(1.5**2, rel=0.3)
    assert hole["address"] == "x 2.0"


def test_patches_wider_than_a_cell_leave_no_holes_between_them(wall, scenery) -> None:
    coarse = hull_patches.hull_patches(refine(wall, 0.12)[0])
    seen = np.abs(coarse.mesh.vertices[:, 0] - 2) < 1.2
    assert coverage_holes.find_holes(coarse, seen, scenery.chart, _address) == []


@pytest.fixture
def base(wall, scenery) -> BaseSurface:
    n = len(wall.vertices)
    return BaseSurface(
        cad_model=wall,
        surveyed=Surface(
            vertices=wall.vertices,
            faces=wall.faces,
            deviation=np.zeros(n),
            sigma=np.ones(n),
            support=np.ones(n, np.int64),
        ),
        chart=scenery.chart,
        result_from_global=from_mount([0, 0, 8, 180, 0, 0]),
        frame_spacing_m=None,
    )


def _track(along_sigma: tuple[float, float]) -> VehicleTrack:
    """Two poses a metre off the wall, at x = 1 and x = 3, with those sigmas along x."""
    covariance = np.stack([np.diag([along, 0.02, 0.05, 1, 1, 1]) ** 2 for along in along_sigma])
    poses = Poses(np.tile([0.0, 0, 0, 1], (2, 1)), np.array([[1.0, 3, 1], [3, 3, 1]]))
    return VehicleTrack(
        t_ns=np.arange(2),
        poses=poses,
        tray=np.zeros(2),
        covariance=covariance,
        image=np.zeros((2, 2), int),
        frame=Frame.HULL,
    )


def test_a_hole_is_known_as_well_as_the_path_beside_it(base: BaseSurface) -> None:
    hole = coverage_holes.locate_hole(np.array([2.8, 2.0, 1.0]), base, _track((9.0, 0.3)))
    cell = coverage_holes.CELL_M / 12**0.5
    assert (hole["along"], hole["girth"], hole["side"], hole["frame"], hole["depth"]) == (
        2.8,
        1.0,
        None,
        None,
        7.0,
    )
    assert hole["sigma_along"] == pytest.approx(np.hypot(0.3, cell), rel=0.02)
    assert hole["sigma_girth"] == pytest.approx(np.hypot(0.05, cell), rel=0.02)
    assert hole["depth_sigma"] == pytest.approx(np.hypot(0.05, cell), abs=1e-3)
    assert hole["address"] == "2.8 ± 0.3 m along, 1.00 ± 0.06 m across, 7.0 ± 0.1 m below waterline"


def test_hole_keeps_to_schema_and_has_position_sigma(base: BaseSurface, hull, scenery) -> None:
    x, _, z = hull.mesh.vertices.T
    seen = (
        (np.abs(x - 2) < 1.2)
        & (np.abs(z - 1) < 0.8)
        & (np.maximum(np.abs(x - 2.5), np.abs(z - 1.0)) > 0.25)
    )
    holes = [
        coverage_holes.find_holes(
            hull,
            seen,
            scenery.chart,
            lambda center, on=on: coverage_holes.locate_hole(center, on, _track((0.3, 0.3))),
        )
        for on in (base, replace(base, depth_known=False))
    ]
    schema = json.loads(SCHEMA.read_text())["properties"]["holes"]
    for found in holes:
        assert len(found) == 1
        assert violations(found, schema) == []
        assert all(sigma > 0 for sigma in found[0]["position_sigma"])
    assert holes[1][0]["depth"] is None
