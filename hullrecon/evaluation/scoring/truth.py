# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The truth of a simulated dive, read from its truth/ (docs/dive_package.md)."""

from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.errors import InputError
from hullrecon.evaluation.scoring.deliverables import poses_in, read_table
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, interpolate, tray_poses
from hullrecon.typing import Array, Ints, Mask

_UNIT_M = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "ft": 0.3048, "in": 0.0254}


@dataclass(frozen=True)
class Truth:
    """t_s (n,) and T_M_v at the camera frames; built: the hull as it is; CAD model: None without a CAD; objects as in
    objects.json (painted marks among them); mounts as in extrinsics.json."""

    t_s: Array
    poses: Poses
    servo_t_s: Array
    servo_rad: Array
    T_g_M: Poses
    mounts: dict[str, Any]
    objects: list[dict[str, Any]]
    built_mesh: Mesh
    cad_model: Scene | None

    @cached_property
    def built(self) -> Scene:
        return Scene(self.built_mesh)

    @cached_property
    def _vertices(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self.built_mesh.vertices)

    def near(self, points: Array, reach_m: float) -> Mask:
        """Which points (n, 3) lie that close to a vertex of the true surface: elsewhere nothing is known of it."""
        distance, _ = self._vertices.query(points, distance_upper_bound=reach_m)
        return np.asarray(np.isfinite(distance))

    def vehicle_at(self, t_s: Array) -> Poses:
        """T_M_v at those times, held at both ends."""
        return interpolate(_ns(self.t_s), self.poses, _ns(t_s))

    def cameras_at(self, rows: Ints) -> Poses:
        """T_M_ct at frames by row."""
        angle = np.interp(self.t_s[rows], self.servo_t_s, self.servo_rad)
        return self.poses[rows] @ tray_poses(self.mounts["tray_origin"], angle) @ _pose(self.mounts["T_s_ct"])

    def structures(self) -> list[dict[str, Any]]:
        """What stands out of the hull or is cut into it; no paint."""
        return [o for o in self.objects if not o.get("painted") and abs(o["height"]) > 0]

    def due(self) -> list[dict[str, Any]]:
        """Structures that must be found: at least 0.08 m high and seen in at least six frames."""
        return [o for o in self.structures() if abs(o["height"]) >= 0.08 and o["views"] >= 6]


def read_truth(package: Path) -> Truth:
    """InputError when the package has no truth."""
    folder = package / "truth"
    if not (folder / "poses.csv").exists():
        raise InputError("the package holds no truth", where=str(folder), remedy="only simulated dives can be evaluated")
    poses, servo = read_table(folder / "poses.csv"), read_table(folder / "servo.csv")
    objects = _json(folder / "objects.json")
    return Truth(
        t_s=poses["t"],
        poses=poses_in(poses),
        servo_t_s=servo["t"],
        servo_rad=servo["rad"],
        T_g_M=_pose(_json(folder / "alignment.json")["T_g_M"]),
        mounts=_json(folder / "extrinsics.json"),
        objects=objects["objects"] if isinstance(objects, dict) else objects,
        built_mesh=read_mesh(folder / "as_built.ply"),
        cad_model=_cad_model(package),
    )


def read_mesh(path: Path, scale: float = 1.0) -> Mesh:
    """Any mesh file, in metres."""
    import trimesh

    loaded = trimesh.load(path, force="mesh", process=False)
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise InputError("the mesh holds no triangles", where=str(path))
    return Mesh(np.asarray(loaded.vertices, float) * scale, np.asarray(loaded.faces, np.int32))


def _cad_model(package: Path) -> Scene | None:
    try:
        hull = tomllib.loads((package / "dive.toml").read_text()).get("hull")
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"dive.toml cannot be read: {error}", where=str(package)) from error
    return None if hull is None else Scene(read_mesh(package / hull["mesh"], _UNIT_M[hull.get("units", "m")]))


def _pose(entry: dict[str, Any]) -> Poses:
    return Poses(np.array([entry["quaternion"]], float), np.array([entry["translation"]], float))


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise InputError(f"the file cannot be read: {error}", where=str(path)) from error


def _ns(t_s: Array) -> Ints:
    return np.rint(np.asarray(t_s) * 1e9).astype(np.int64)
