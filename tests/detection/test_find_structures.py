# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.base_surface import BaseSurface
from hullrecon.detection.find_structures import find_structures
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import views_of_top_camera
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera, Frame
from hullrecon.geometry.poses import from_rpy, identity
from hullrecon.records.solution import DeviationField, Landmarks
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import rig_from_settings

FIELD = DeviationField(
    origin=np.zeros(2),
    step=np.array([4.0, 2.0]),
    value=np.full((2, 2), -0.012),
    sigma=np.full((2, 2), 0.003),
)


@pytest.fixture
def base(scenery) -> BaseSurface:
    n = len(scenery.base.vertices)
    surveyed = Surface(
        vertices=scenery.base.vertices - [0, 0.012, 0],
        faces=scenery.base.faces,
        deviation=np.full(n, -0.012),
        sigma=np.full(n, 0.005),
        support=np.ones(n, np.int64),
    )
    return BaseSurface(
        cad_model=scenery.base,
        surveyed=surveyed,
        chart=scenery.chart,
        result_from_global=identity(),
        frame_spacing_m=None,
    )


@pytest.fixture
def landmarks(scenery) -> Landmarks:
    m = len(scenery.measured)
    return Landmarks(
        position=scenery.measured.position,
        covariance=np.tile(1e-5 * np.eye(3), (m, 1, 1)),
        label=np.ones(m, np.int64),
        deviation=scenery.measured.offset,
        views=scenery.measured.views,
        color=np.zeros((m, 3), np.uint8),
    )


def test_structures_on_the_wall_are_found_from_its_landmarks(
    scenery, base: BaseSurface, landmarks: Landmarks
) -> None:
    structures = find_structures(base, landmarks, FIELD, scenery.views, DetectOptions())
    assert [row["id"] for row in structures.objects] == [1, 2]
    assert [round(float(str(row["height"])), 2) for row in structures.objects] == [0.10, -0.05]
    assert structures.facts["reference"] == "the CAD model"
    assert structures.as_found is not None
    assert np.nanmax(structures.as_found.deviation) > 0.07


def test_without_views_cad_model_moves_to_dvl_surface(
    base: BaseSurface, landmarks: Landmarks
) -> None:
    structures = find_structures(base, landmarks, FIELD, None, DetectOptions())
    assert structures.objects == []
    assert structures.facts["objects"] == "no camera was carried"
    assert structures.facts["as_found"] == "from the DVL's surface"
    assert structures.as_found is not None
    known = structures.as_found.support > 0
    np.testing.assert_allclose(structures.as_found.vertices[known, 1], 2 - 0.012, atol=1e-9)


def test_too_few_landmarks_are_as_none(scenery, base: BaseSurface, landmarks: Landmarks) -> None:
    options = DetectOptions(min_landmarks=len(landmarks.position) + 1)
    facts = find_structures(base, landmarks, FIELD, scenery.views, options).facts
    assert facts["objects"] == "the images gave too few landmarks on the surface"


def test_without_views_and_model_survey_stays_as_it_is(
    base: BaseSurface, landmarks: Landmarks
) -> None:
    structures = find_structures(
        replace(base, cad_model=None), landmarks, None, None, DetectOptions()
    )
    assert structures.as_found is None
    assert "no CAD model" in str(structures.facts["as_found"])


def _track(image: list[int]) -> VehicleTrack:
    n = len(image)
    return VehicleTrack(
        t_ns=np.arange(n),
        poses=from_rpy([[float(k), 0, 0] for k in range(n)], np.zeros((n, 3))),
        tray=np.zeros(n),
        covariance=np.zeros((n, 6, 6)),
        image=np.column_stack([image, np.full(n, -1)]),
        frame=Frame.GLOBAL,
    )


def test_the_top_cameras_images_are_named_by_their_stamps() -> None:
    camera = CameraModel(width=640, height=512, fx=640.0, fy=640.0, cx=319.5, cy=255.5)
    settings = {"tray.origin": (0.5, 0.0, 0.0), "camera.top.mount": (0.0,) * 6}
    rig, stamps = rig_from_settings(settings, {Camera.TOP: camera}), np.array([70, 80, 90])
    marks = np.array([[0.5, 0.0, 1.0], [2.5, 0.0, 1.0], [np.nan, 0, 0]])
    views = views_of_top_camera(rig, _track([0, -1, 2]), stamps, marks)
    assert views is not None
    assert views.name == ("camera_top/70.jpg", "camera_top/90.jpg")
    assert views.node.tolist() == [0, 2]
    np.testing.assert_allclose(views.result_from_camera.translation[:, 0], [0.5, 2.5])
    assert 1.25 < views.farthest_m < 1.7  # landmarks 1 m away, seen in the image's corner
    assert views_of_top_camera(rig, _track([-1, -1]), stamps, marks) is None
    assert views_of_top_camera(rig, _track([0, 1]), stamps, marks[:0]) is None
    blind = rig_from_settings(settings | {"camera.top.mount": None}, {Camera.TOP: camera})
    assert views_of_top_camera(blind, _track([0, 1]), stamps, marks) is None
