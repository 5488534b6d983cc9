# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive_result.mcap, read back: topics, schemas, frames, points."""

from __future__ import annotations

import base64
import json
from collections import defaultdict
from dataclasses import replace
from io import BytesIO
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from end_to_end.json_schema import violations
from mcap.reader import make_reader
from report.conftest import NODES, START, FlatChart

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, from_mount, from_rpy
from hullrecon.records.trajectory import Returns
from hullrecon.report.foxglove import dive_result
from hullrecon.report.foxglove.dive_result import TOPICS, dive_result_mcap
from hullrecon.report.survey import Survey

BOX = trimesh.creation.box((6.0, 4.0, 2.0))
CAD_MODEL = Mesh(np.array(BOX.vertices), np.array(BOX.faces, np.int32))
KINDS = {1: "u1", 7: "<f4"}


@pytest.fixture
def returns() -> Returns:
    """Five beams straight down from two pings near the second and the third node; the last one is
    flagged.
    """
    return Returns(
        t_ns=START + np.array([1, 1, 1, 2, 2]) * 10**9,
        node=np.array([1, 1, 1, 2, 2]),
        quaternion=np.tile([0.0, 0, 0, 1], (5, 1)),
        translation=np.zeros((5, 3)),
        tray_offset=np.zeros(5),
        beam=np.tile([0.0, 0, 1], (5, 1)),
        range_m=np.array([1.0, 1.1, 1.2, 1.3, 1.4]),
        flagged=np.array([False, False, False, False, True]),
    )


@pytest.fixture
def whole(survey: Survey, returns: Returns) -> Survey:
    """With returns, a CAD model, and sensors that sit askew."""
    rig = replace(
        survey.facts.rig,
        tray_origin=np.array([0.4, 0.1, 0.2]),
        tray_from_dvl=from_mount([0.1, -0.2, 0.05, 4, -3, 30]),
        tray_from_top=from_mount([0.2, 0.0, 0.1, 1, 2, 90]),
    )
    facts = replace(survey.facts, rig=rig, returns=returns)
    return replace(survey, facts=facts, surfaces=replace(survey.surfaces, cad_model=CAD_MODEL))


def read(data: bytes) -> dict[str, list[dict]]:
    """Messages by topic, checked against the schemas in the file."""
    found = defaultdict(list)
    for schema, channel, message in make_reader(BytesIO(data), validate_crcs=True).iter_messages():
        value = json.loads(message.data)
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert violations(value, json.loads(schema.data)) == []
        at = value.get("timestamp") or value["entities"][0]["timestamp"]
        assert at["sec"] * 10**9 + at["nsec"] == message.log_time
        found[channel.topic].append(value)
    return found


def cloud(value: dict) -> np.ndarray:
    """The points as a structured array."""
    kind = np.dtype(
        {
            "names": [f["name"] for f in value["fields"]],
            "formats": [KINDS[f["type"]] for f in value["fields"]],
            "offsets": [f["offset"] for f in value["fields"]],
            "itemsize": value["point_stride"],
        }
    )
    return np.frombuffer(base64.b64decode(value["data"]), kind)


def xyz(points: np.ndarray) -> np.ndarray:
    return np.stack([points[axis] for axis in "xyz"], axis=1)


def chain(transforms: list[dict], *frames: str, t_ns: int) -> Poses:
    """The pose of the last frame in the first, by the transforms of that time or, where nothing
    moves, of the start.
    """
    pose = from_rpy(np.zeros((1, 3)), np.zeros((1, 3)))
    for parent, child in pairwise(frames):
        (found,) = (
            t
            for t in transforms
            if (t["parent_frame_id"], t["child_frame_id"]) == (parent, child)
            and (
                child not in ("vehicle", "tray")
                or t["timestamp"]["sec"] * 10**9 + t["timestamp"]["nsec"] == t_ns
            )
        )
        step = Poses(
            *(
                np.array([[found[part][k] for k in names]])
                for part, names in (("rotation", "xyzw"), ("translation", "xyz"))
            )
        )
        pose = pose @ step
    return pose


def test_a_whole_survey_has_every_topic_and_foxgloves_names(whole: Survey) -> None:
    assert read(dive_result_mcap(whole)).keys() == TOPICS.keys()
    names = {str(schema["title"]) for schema in TOPICS.values()}
    assert {name.split(".")[0] for name in names - {"hullrecon.PoseSigma"}} == {"foxglove"}


def test_the_pose_at_a_node_is_the_tracks(whole: Survey) -> None:
    found = read(dive_result_mcap(whole))
    assert len(found["/vehicle/pose"]) == len(found["/vehicle/path"][0]["poses"]) == NODES
    for row, value in enumerate(found["/vehicle/pose"]):
        assert value["frame_id"] == "hull"
        assert value["pose"] == found["/vehicle/path"][0]["poses"][row]
        at = [value["pose"]["position"][axis] for axis in "xyz"]
        np.testing.assert_allclose(at, whole.track.poses.translation[row])
    sigma = found["/vehicle/sigma"][2]
    np.testing.assert_allclose(
        [sigma["x"], sigma["yaw"], sigma["tray"]],
        [*whole.track.sigma[2, [0, 5]], whole.track.tray[2]],
    )


def test_a_node_whose_sigma_was_lost_has_its_pose_alone(whole: Survey) -> None:
    covariance = whole.track.covariance.copy()
    covariance[1, 0, 0] = np.nan
    found = read(
        dive_result_mcap(replace(whole, track=replace(whole.track, covariance=covariance)))
    )
    assert (len(found["/vehicle/pose"]), len(found["/vehicle/sigma"])) == (NODES, NODES - 1)


def test_the_frames_lead_from_the_ship_to_the_sensors(whole: Survey) -> None:
    transforms, rig = read(dive_result_mcap(whole))["/tf"], whole.facts.rig
    expected = {
        "camera_top": rig.poses_along(whole.track.path, rig.cameras[0]),
        "dvl": rig.poses_along(whole.track.path, "dvl"),
    }
    for row, t_ns in enumerate(whole.track.t_ns.tolist()):
        for sensor, poses in expected.items():
            found = chain(transforms, "hull", "vehicle", "tray", sensor, t_ns=t_ns)
            np.testing.assert_allclose(
                found.apply([[0.1, 0.2, 0.3]]), poses[[row]].apply([[0.1, 0.2, 0.3]]), atol=1e-9
            )


def test_a_beams_end_lies_its_range_along_the_dvls_axis(whole: Survey) -> None:
    found = read(dive_result_mcap(whole))
    pings = [cloud(value) for value in found["/dvl/returns"]]
    assert [len(points) for points in pings] == [3, 2]
    np.testing.assert_array_equal(pings[1]["flagged"], [0, 1])
    dvl = chain(found["/tf"], "hull", "vehicle", "tray", "dvl", t_ns=START + 10**9)
    np.testing.assert_allclose(
        xyz(pings[0]), dvl.apply([[0, 0, 1.0], [0, 0, 1.1], [0, 0, 1.2]]), atol=1e-5
    )
    np.testing.assert_allclose(pings[0]["range"], [1.0, 1.1, 1.2], rtol=1e-6)


def test_landmarks_lie_in_the_hull_frame_with_their_colours(whole: Survey) -> None:
    found = read(dive_result_mcap(whole))
    points = cloud(found["/landmarks"][0])
    assert whole.adjusted is not None
    solution = whole.adjusted.solution
    np.testing.assert_array_equal(points["green"], solution.landmarks.color[:, 1])
    np.testing.assert_array_equal(points["label"], solution.landmarks.label)
    hull_from_global = chain(found["/tf"], "hull", "global", t_ns=START)
    np.testing.assert_allclose(
        xyz(points), hull_from_global.apply(solution.landmarks.position), atol=1e-5
    )


def test_only_what_was_seen_of_the_hull_is_in_its_cloud(whole: Survey) -> None:
    points, plate = (
        cloud(read(dive_result_mcap(whole))["/hull/as_found"][0]),
        whole.surfaces.as_found,
    )
    assert plate is not None
    np.testing.assert_allclose(xyz(points), plate.vertices[plate.support > 0], atol=1e-6)
    np.testing.assert_allclose(points["deviation"], 0.006, rtol=1e-6)


def test_an_object_has_outline_label_and_address(whole: Survey) -> None:
    (shown,) = read(dive_result_mcap(whole))["/objects"][0]["entities"]
    assert whole.findings.objects is not None
    (row,) = whole.findings.objects
    assert shown["id"] == str(row.id)
    assert shown["texts"][0]["text"].startswith(f"{row.id}: {1000 * row.height:.0f}")
    assert {"key": "address", "value": row.address} in shown["metadata"]
    assert len(shown["lines"]) == bool(row.outline)


def foxglove_sees(glb: bytes) -> np.ndarray:
    """Vertices as Foxglove shows them: glTF's scene turned by 90 degrees about x, so that its y
    points up.
    """
    scene = trimesh.load(BytesIO(glb), file_type="glb")
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0])
    return trimesh.transform_points(scene.to_geometry().vertices, turn)


def test_the_cad_model_stands_where_it_is_in_the_hull_frame(whole: Survey) -> None:
    (entity,) = read(dive_result_mcap(whole))["/hull/cad_model"][0]["entities"]
    (model,) = entity["models"]
    assert (entity["frame_id"], model["media_type"]) == ("hull", "model/gltf-binary")
    seen = foxglove_sees(base64.b64decode(model["data"]))
    np.testing.assert_allclose(
        np.sort(seen, axis=0), np.sort(CAD_MODEL.vertices, axis=0), atol=1e-6
    )


def test_a_fine_cad_model_is_thinned_and_keeps_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dive_result, "MAX_FACES", 200)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    seen = foxglove_sees(
        dive_result.ship_glb(Mesh(np.array(ball.vertices), np.array(ball.faces, np.int32)))
    )
    assert len(seen) < 150
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), 2.0, atol=0.1)


def test_dead_reckoning_alone_stands_upright_in_a_viewer(bare: Survey) -> None:
    found = read(dive_result_mcap(bare))
    assert found.keys() == {"/tf", "/vehicle/pose", "/vehicle/path", "/vehicle/sigma"}
    up = chain(found["/tf"], "global_z_up", "global", t_ns=START)
    np.testing.assert_allclose(up.apply([[1.0, 2.0, 3.0]]), [[1, -2, -3]], atol=1e-12)


def test_equal_surveys_give_equal_bytes(whole: Survey) -> None:
    assert dive_result_mcap(whole) == dive_result_mcap(whole)


def test_a_cad_model_with_y_up_has_an_upright_frame(whole: Survey) -> None:
    class Lying(FlatChart):
        ship_axes = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])

    assert not any(
        tf["parent_frame_id"] == "hull_z_up" for tf in read(dive_result_mcap(whole))["/tf"]
    )
    found = read(dive_result_mcap(replace(whole, surfaces=replace(whole.surfaces, chart=Lying()))))
    np.testing.assert_allclose(
        chain(found["/tf"], "hull_z_up", "hull", t_ns=START).apply([[1.0, 2, 3]]), [[1, -3, 2]]
    )
    (model,) = found["/hull/cad_model"][0]["entities"][0]["models"]
    seen = foxglove_sees(base64.b64decode(model["data"]))  # in the frame `hull`, as all else
    np.testing.assert_allclose(
        np.sort(seen, axis=0), np.sort(CAD_MODEL.vertices, axis=0), atol=1e-6
    )


def far_from_zero(whole: Survey) -> Survey:
    """The survey of a ship in map coordinates."""
    shift = np.array([573_412.25, 6_020_155.5, -3.75])
    poses = whole.track.poses
    as_found = whole.surfaces.as_found
    moved = Poses(poses.quaternion, poses.translation + shift)
    surfaces = replace(
        whole.surfaces,
        as_found=replace(as_found, vertices=as_found.vertices + shift),
        cad_model=Mesh(CAD_MODEL.vertices + shift, CAD_MODEL.faces),
    )
    return replace(whole, track=replace(whole.track, poses=moved), surfaces=surfaces)


def test_clouds_in_map_coordinates_keep_tenths_of_a_millimetre(whole: Survey) -> None:
    far = far_from_zero(whole)
    found = read(dive_result_mcap(far))
    (value,) = found["/hull/as_found"]
    assert value["frame_id"] == "hull_local"
    place = chain(found["/tf"], "hull", "hull_local", t_ns=START)
    seen = far.surfaces.as_found.vertices[far.surfaces.as_found.support > 0]
    np.testing.assert_allclose(place.apply(xyz(cloud(value))), seen, atol=1e-4)
    (entity,) = found["/hull/cad_model"][0]["entities"]
    assert entity["frame_id"] == "hull_local"
    glb = base64.b64decode(entity["models"][0]["data"])
    model = trimesh.load(BytesIO(glb), file_type="glb").to_mesh()
    assert np.abs(model.vertices).max() < 20
    assert {value["frame_id"] for value in found["/dvl/returns"]} == {"hull_local"}
    assert found["/vehicle/pose"][0]["frame_id"] == "hull"


def test_a_ship_near_zero_needs_no_local_frame(whole: Survey) -> None:
    found = read(dive_result_mcap(whole))
    assert "hull_local" not in {value["child_frame_id"] for value in found["/tf"]}
