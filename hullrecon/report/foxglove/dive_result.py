# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive_result.mcap: the dive in 3-D and in time, for Foxglove."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.gltf_axes import gltf_from
from hullrecon.geometry.meshes.local_origin import local_origin
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals
from hullrecon.geometry.meshes.thinning import thin_mesh
from hullrecon.geometry.poses import from_matrix, from_rpy, tray_poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.surface import Surface
from hullrecon.report.export.geometry import color_columns, landmarks_in_hull
from hullrecon.report.foxglove import messages
from hullrecon.report.foxglove.messages import Message
from hullrecon.report.survey import Survey
from hullrecon.typing import Array

MAX_FACES = 200_000  # triangles that a viewer still turns smoothly; finer models are decimated
# Foxglove turns glTF's y to the z of the frame, whichever axis of M is up
Z_UP = np.array([0.0, 0.0, 1.0])
STEEL = (150, 160, 170, 255)


def ship_glb(mesh: Mesh) -> bytes:
    """Encode a CAD model in M as a GLB of at most about MAX_FACES triangles."""
    import trimesh

    shown = thin_mesh(mesh, MAX_FACES)
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=STEEL,
        metallicFactor=0.0,
        roughnessFactor=1.0,
        doubleSided=True,
        name="cad_model",
    )
    ship = trimesh.Trimesh(
        shown.vertices,
        shown.faces,
        vertex_normals=vertex_normals(shown),
        visual=trimesh.visual.TextureVisuals(material=material),
        process=False,
    )
    scene = trimesh.Scene()
    scene.add_geometry(ship, node_name="ship", geom_name="ship", transform=gltf_from(Z_UP))
    return bytes(scene.export(file_type="glb", include_normals=True))


FILE = "dive_result.mcap"
ORANGE, WHITE = (1.0, 0.5, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0)
LABEL_OFF_M = 0.15  # in front of an object, along the hull's normal
TOPICS: Mapping[str, messages.Schema] = {
    "/tf": messages.FRAME_TRANSFORM,
    "/vehicle/pose": messages.POSE_IN_FRAME,
    "/vehicle/path": messages.POSES_IN_FRAME,
    "/vehicle/sigma": messages.POSE_SIGMA,
    "/dvl/returns": messages.POINT_CLOUD,
    "/landmarks": messages.POINT_CLOUD,
    "/hull/as_found": messages.POINT_CLOUD,
    "/hull/cad_model": messages.SCENE_UPDATE,
    "/objects": messages.SCENE_UPDATE,
}
FRAMES = {"M": "hull", "g": "global"}


@dataclass(frozen=True, kw_only=True)
class LocalFrame:
    """The frame in which single-precision data (clouds, CAD model) is written.

    It is the survey's frame, moved to near the data where that is far from the origin.
    """

    name: str
    origin: Array  # (3,) m in the survey's frame, zero if that is the same frame


@dataclass(frozen=True, kw_only=True)
class TimedMessage:
    """A message of a topic and its time."""

    t_ns: int
    topic: str
    value: Message


def dive_result_mcap(survey: Survey) -> bytes:
    """Write the dive's messages as MCAP. The same survey gives the same bytes."""
    from mcap.writer import CompressionType, Writer

    found = sorted(survey_messages(survey), key=lambda message: message.t_ns)
    file = BytesIO()
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start(profile="", library="hullrecon")
    channels: dict[str, int] = {}
    for name, schema in TOPICS.items():
        if any(message.topic == name for message in found):
            number = writer.register_schema(
                str(schema["title"]), "jsonschema", json.dumps(schema).encode()
            )
            channels[name] = writer.register_channel(name, "json", number)
    about = {
        "dive": survey.facts.dive.name,
        "frame": survey.frame_in_words,
        "unit": "metre, second, radian",
    }
    local = _local_frame(survey)
    if local.origin.any():
        offset = ", ".join(f"{value:.0f}" for value in local.origin)
        about[local.name] = f"clouds and CAD model; its origin lies at {offset} m in that frame"
    writer.add_metadata("hullrecon", about)
    for message in found:
        data = json.dumps(message.value, allow_nan=False, separators=(",", ":")).encode()
        writer.add_message(
            channels[message.topic], log_time=message.t_ns, publish_time=message.t_ns, data=data
        )
    writer.finish()
    return file.getvalue()


def survey_messages(survey: Survey) -> Iterator[TimedMessage]:
    """Yield a survey's messages: moving things at their time, fixed ones at the first pose's."""
    start, frame = int(survey.track.t_ns[0]), FRAMES[survey.track.frame]
    local = _local_frame(survey)
    if local.origin.any():
        place = from_rpy(local.origin[None], np.zeros((1, 3)))
        value = messages.frame_transform(start, frame, local.name, place)
        yield TimedMessage(t_ns=start, topic="/tf", value=value)
    for value in _fixed_frames(survey, start, frame):
        yield TimedMessage(t_ns=start, topic="/tf", value=value)
    for topic, value in _fixed_content(survey, start, frame, local):
        yield TimedMessage(t_ns=start, topic=topic, value=value)
    yield from _vehicle(survey, frame)
    yield from _dvl_returns(survey, local)


def _local_frame(survey: Survey) -> LocalFrame:
    """Choose the frame of single-precision data: moved to the path, if that is far away."""
    frame, origin = FRAMES[survey.track.frame], local_origin(survey.track.poses.translation)
    return LocalFrame(name=f"{frame}_local" if origin.any() else frame, origin=origin)


def _fixed_frames(survey: Survey, t_ns: int, frame: str) -> Iterator[Message]:
    """Yield the sensors' mounts on the tray, and the pose of the global frame in the hull frame.

    A viewer takes z as up. If the frame's z is not up, a frame `global_z_up` or `hull_z_up` is
    added, in which the frame is turned upright.
    """
    rig = survey.facts.rig
    yield messages.frame_transform(t_ns, "tray", "dvl", rig.tray_from_dvl)
    for camera in rig.cameras:
        yield messages.frame_transform(t_ns, "tray", camera.key, rig.tray_from(Camera(camera)))
    if frame == "global":  # its z points down: half a turn about x
        yield messages.frame_transform(
            t_ns, "global_z_up", frame, from_rpy(np.zeros((1, 3)), np.array([[np.pi, 0, 0]]))
        )
        return
    if survey.adjusted is not None:
        yield messages.frame_transform(
            t_ns, frame, "global", survey.adjusted.solution.result_from_global()
        )
    chart = survey.surfaces.chart
    if chart is not None and chart.ship_axes[2, 2] < 1:
        # From M to glTF's axes, y up, then from these to axes with z up
        upright = from_matrix(gltf_from(Z_UP).T @ gltf_from(chart.ship_axes[2]))
        yield messages.frame_transform(t_ns, "hull_z_up", frame, upright)


def _fixed_content(
    survey: Survey, t_ns: int, frame: str, local: LocalFrame
) -> Iterator[tuple[str, Message]]:
    """Yield topic and message of what does not move: path, landmarks, hull, CAD model, objects."""
    poses, surfaces, objects = survey.track.poses, survey.surfaces, survey.findings.objects
    path = [messages.pose(poses, row) for row in range(len(poses))]
    yield "/vehicle/path", {"timestamp": messages.time(t_ns), "frame_id": frame, "poses": path}
    if survey.adjusted is not None and len(survey.adjusted.solution.landmarks):
        landmarks = survey.adjusted.solution.landmarks
        columns = {
            **_columns(landmarks_in_hull(survey.adjusted.solution), local),
            **color_columns(landmarks.color),
            "alpha": np.full(len(landmarks), 255, np.uint8),
            "label": landmarks.label.astype(np.uint8),
        }
        yield "/landmarks", messages.point_cloud(t_ns, local.name, columns)
    if surfaces.as_found is not None:
        yield "/hull/as_found", _as_found(surfaces.as_found, t_ns, local)
    if surfaces.cad_model is not None and survey.is_in_hull_frame:
        yield "/hull/cad_model", _cad_model(surfaces.cad_model, t_ns, local)
    if objects is not None:
        yield "/objects", messages.scene_update([_object(found, t_ns, frame) for found in objects])


def _vehicle(survey: Survey, frame: str) -> Iterator[TimedMessage]:
    """Yield the vehicle's and the tray's poses at the nodes, with sigmas where these are known."""
    track, names = survey.track, ("x", "y", "z", "roll", "pitch", "yaw")
    tray = tray_poses(survey.facts.rig.tray_origin, track.tray)
    for row, (t_ns, sigma) in enumerate(
        zip(track.t_ns.tolist(), track.sigma.tolist(), strict=True)
    ):
        at = messages.time(t_ns)
        values: dict[str, Message] = {
            "/tf": messages.frame_transform(t_ns, frame, "vehicle", track.poses, row),
            "/vehicle/pose": {
                "timestamp": at,
                "frame_id": frame,
                "pose": messages.pose(track.poses, row),
            },
        }
        if np.isfinite(sigma).all():  # JSON has no NaN
            values["/vehicle/sigma"] = {
                "timestamp": at,
                **dict(zip(names, sigma, strict=True)),
                "tray": float(track.tray[row]),
            }
        yield TimedMessage(
            t_ns=t_ns,
            topic="/tf",
            value=messages.frame_transform(t_ns, "vehicle", "tray", tray, row),
        )
        for topic, value in values.items():
            yield TimedMessage(t_ns=t_ns, topic=topic, value=value)


def _dvl_returns(survey: Survey, local: LocalFrame) -> Iterator[TimedMessage]:
    """Yield the points where the DVL's beams hit, as one cloud per ping.

    Returns that disagree with their neighbours are flagged.
    """
    returns = survey.facts.returns
    if returns is None or not len(returns.t_ns):
        return
    points = survey.facts.rig.dvl_points(returns, survey.track.path).points
    order = np.argsort(returns.t_ns, kind="stable")
    # Rows of one ping at a time, which have the same stamp
    for rows in np.split(order, np.flatnonzero(np.diff(returns.t_ns[order])) + 1):
        t_ns = int(returns.t_ns[rows[0]])
        columns = {
            **_columns(points[rows], local),
            "range": returns.range_m[rows].astype(np.float32),
            "flagged": returns.flagged[rows].astype(np.uint8),
        }
        value = messages.point_cloud(t_ns, local.name, columns)
        yield TimedMessage(t_ns=t_ns, topic="/dvl/returns", value=value)


def _columns(points: Array, local: LocalFrame) -> dict[str, NDArray[np.generic]]:
    """Split points (n, 3) into x, y, z of single precision: 0.1 mm at a ship's length."""
    near = (points - local.origin).astype(np.float32)
    return {name: near[:, k] for k, name in enumerate("xyz")}


def _as_found(surface: Surface, t_ns: int, local: LocalFrame) -> Message:
    """Make the cloud of the hull as found, of the vertices that were seen."""
    seen = surface.support > 0
    columns = {
        **_columns(surface.vertices[seen], local),
        "deviation": surface.deviation[seen].astype(np.float32),
        "sigma": surface.sigma[seen].astype(np.float32),
    }
    return messages.point_cloud(t_ns, local.name, columns)


def _cad_model(mesh: Mesh, t_ns: int, local: LocalFrame) -> Message:
    """Make the entity of the CAD model."""
    model = messages.model(ship_glb(Mesh(mesh.vertices - local.origin, mesh.faces)))
    return messages.scene_update([messages.entity(t_ns, local.name, "cad_model", models=[model])])


def _object(found: ReportedObject, t_ns: int, frame: str) -> Message:
    """Make the entity of an object: outline, a label in front of it, facts shown on selection."""
    sigma = "" if found.height_sigma is None else f" ± {1000 * found.height_sigma:.0f}"
    text = f"{found.id}: {1000 * found.height:.0f}{sigma} mm"
    facts = {"height_m": f"{found.height:.4f}", "views": found.views, "address": found.address}
    if found.height_sigma is not None:
        facts["height_sigma_m"] = f"{found.height_sigma:.4f}"
    return messages.entity(
        t_ns,
        frame,
        str(found.id),
        facts=facts,
        lines=[messages.line_loop(np.array(found.outline), ORANGE, 3.0)] if found.outline else [],
        texts=[
            messages.label(
                text, np.array(found.center) + LABEL_OFF_M * np.array(found.normal), WHITE, 16.0
            )
        ],
    )
