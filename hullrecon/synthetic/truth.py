# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""truth/ of a simulated dive: `evaluate` compares results with it, and no step may read it."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.dive_toml import cameras_of
from hullrecon.synthetic.items import MARKS, Item, height_of
from hullrecon.synthetic.logs import write_table
from hullrecon.synthetic.rendering import lens_error
from hullrecon.synthetic.vehicle import SONAR_ORIGIN, TRAY_ORIGIN
from hullrecon.typing import Array

LENS_GRID = 9  # samples of a lens's error along either side
BEHIND_M = (
    1.35  # a point that much farther than the standoff is round the bilge, hidden by the hull
)


def write_truth(folder: Path, dive: Dive) -> None:
    """Write poses, alignment, servos, extrinsics, objects and the surface as built."""
    motion = dive.motion
    at = motion.in_hull(motion.vehicle(dive.frame_s))
    rows = np.hstack([at.translation, at.quaternion])
    write_table(folder / "poses.csv", ["x", "y", "z", "qx", "qy", "qz", "qw"], dive.frame_s, rows)
    often = np.arange(0, motion.t_s[-1], 0.05)
    write_table(folder / "servo.csv", ["rad"], often, motion.angle(motion.tray, often)[:, None])
    write_table(
        folder / "sonar_servo.csv", ["rad"], often, motion.angle(motion.sonar_tray, often)[:, None]
    )
    _json(folder / "alignment.json", {"T_g_M": _pose_document(motion.global_from_hull)})
    _json(folder / "extrinsics.json", _extrinsics(dive))
    _json(folder / "objects.json", _objects(dive))
    if errors := _camera_errors(dive):
        _json(folder / "camera_errors.json", errors)
    write_ply(folder / "as_built.ply", dive.hull.window(dive.seen_along, dive.seen_girth))


def write_ply(path: Path, pieces: Iterable[Mesh]) -> None:
    """Write pieces of a mesh as one binary PLY, float32, with one piece in memory at a time."""
    # In the file all faces follow all vertices, so both are collected apart
    vertices = faces = 0
    with (
        tempfile.TemporaryFile(dir=path.parent) as corners,
        tempfile.TemporaryFile(dir=path.parent) as triangles,
    ):
        for mesh in pieces:
            rows = np.zeros(len(mesh.faces), np.dtype([("n", "u1"), ("corner", "<i4", 3)]))
            rows["n"], rows["corner"] = 3, mesh.faces + vertices
            corners.write(mesh.vertices.astype("<f4").tobytes())
            triangles.write(rows.tobytes())
            vertices, faces = vertices + len(mesh.vertices), faces + len(mesh.faces)
        with path.open("wb") as file:
            file.write(_ply_header(vertices, faces).encode())
            for part in (corners, triangles):
                part.seek(0)
                shutil.copyfileobj(part, file)


def _ply_header(vertices: int, faces: int) -> str:
    """Write the header of a binary PLY with that many vertices and triangles."""
    return f"""ply
format binary_little_endian 1.0
comment as built, frame M, metres
element vertex {vertices}
property float x
property float y
property float z
element face {faces}
property list uchar int vertex_indices
end_header
"""


def _extrinsics(dive: Dive) -> dict[str, Any]:
    """List the true mounts and origins for extrinsics.json."""
    rig = dive.rig
    mounts = {
        "T_s_d": rig.tray_from_dvl,
        "T_s_ct": rig.tray_from_top,
        "T_ct_cb": rig.top_from_bottom,
        "T_sonarservo_o": rig.servo_from_sonar,
    }
    if dive.spec.cameras.carried == "none":
        mounts = {name: mounts[name] for name in ("T_s_d", "T_sonarservo_o")}
    placed: dict[str, Any] = {name: _pose_document(mount) for name, mount in mounts.items()}
    return {"tray_origin": list(TRAY_ORIGIN), "sonar_origin": list(SONAR_ORIGIN), **placed}


def _camera_errors(dive: Dive) -> dict[str, Any]:
    """List the errors of the cameras that were simulated; empty where there are none.

    A lens's error is sampled on a grid: pixel (u, v) sees what its calibration puts at
    (u + du, v + dv).
    """
    cameras = dive.spec.cameras
    known = (cameras.readout_s, cameras.camera_offset_s, cameras.pair_offset_s)
    if not (cameras.lens_error_px or any(known)):
        return {}
    out: dict[str, Any] = {
        "readout_s": cameras.readout_s,
        "camera_offset_s": cameras.camera_offset_s,
        "pair_offset_s": cameras.pair_offset_s,
        "lens_error_px": cameras.lens_error_px,
        "lenses": {},
    }
    for name, camera in cameras_of(dive).items():
        error = lens_error(dive.spec, name, camera)
        if error is not None:
            u = np.linspace(0, camera.width - 1, LENS_GRID).round().astype(int)
            v = np.linspace(0, camera.height - 1, LENS_GRID).round().astype(int)
            du, dv = np.moveaxis(error[np.ix_(v, u)].round(5), -1, 0).tolist()
            out["lenses"][name] = {"u": u.tolist(), "v": v.tolist(), "du": du, "dv": dv}
    return out


def _objects(dive: Dive) -> dict[str, Any]:
    """List the items for objects.json, barnacles apart, as these are no objects."""
    # Described in their order along the hull, so that each block is built once.
    along = sorted(range(len(dive.items)), key=lambda k: dive.items[k].along_m)
    made = {k: _object(dive, dive.items[k], k + 1) for k in along}
    rows = [made[k] for k in range(len(dive.items))]
    rough = [row for row in rows if row["kind"] == "barnacles"]
    return {"objects": [row for row in rows if row["kind"] != "barnacles"], "not_objects": rough}


def _object(dive: Dive, item: Item, number: int) -> dict[str, Any]:
    """Describe an item for objects.json.

    Its centre lies on the visible surface: a protrusion's top, a recess's floor.
    """
    a, g = np.array([item.along_m]), np.array([item.girth_m])
    block = dive.hull.near(item.along_m)
    normal = block.patch.sample(block.patch.normal, a, g)[0]
    normal /= np.linalg.norm(normal)
    steel = block.patch.sample(block.built.steel, a, g)[0]
    top = float(height_of(item, a, g)[0]) if item.kind != "barnacles" else item.height_m
    center = steel + top * normal
    return {
        "id": number,
        "kind": item.kind,
        "center": [round(float(v), 5) for v in center],
        "normal": [round(float(v), 6) for v in normal],
        "height": round(top, 5),
        "extent": [round(float(v), 4) for v in item.size_m],
        "views": _views(dive, center),
        "painted": item.kind in MARKS,
    }


def _views(dive: Dive, point: Array) -> int:
    """Count the frames in which the top camera sees a point (3,), unless the hull hides it."""
    if dive.spec.cameras.carried == "none":
        return 0
    camera = dive.rig.camera_top
    hull_from_camera = dive.motion.in_hull(
        dive.motion.on_tray(dive.frame_s, dive.rig.tray_from_top, TRAY_ORIGIN)
    )
    in_camera = hull_from_camera.inverse().apply(np.tile(point, (len(hull_from_camera), 1)))
    pixel = camera.project(in_camera)
    with np.errstate(invalid="ignore"):
        seen = (pixel >= 0).all(1) & (pixel[:, 0] < camera.width) & (pixel[:, 1] < camera.height)
    return int((seen & (in_camera[:, 2] < dive.spec.survey.standoff_m + BEHIND_M)).sum())


def _pose_document(motion: Poses) -> dict[str, Any]:
    """Write a pose (a batch of one) as translation, quaternion and matrix."""
    return {
        "translation": motion.translation[0].tolist(),
        "quaternion": motion.quaternion[0].tolist(),
        "matrix": motion.matrix()[0].tolist(),
    }


def _json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=1) + "\n")
