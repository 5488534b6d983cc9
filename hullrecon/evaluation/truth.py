# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The truth of a simulated dive, read from its truth/ (docs/dive_package.md)."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import msgspec
import numpy as np

from hullrecon.dive.hull.mirrors import find_boundary
from hullrecon.errors import InputError
from hullrecon.evaluation.deliverables import poses_in, read_table
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.units import METRES_PER_UNIT
from hullrecon.geometry.poses import Poses, interpolate, tray_poses
from hullrecon.typing import Array, Ints, Mask

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Document = TypeVar("Document")
Point = tuple[float, float, float]
RIM_M = 0.02  # width of the rim of the true surface, as large as its faces are


class MotionEntry(msgspec.Struct, frozen=True, kw_only=True):
    """A rigid motion as truth/ states it: metres, and x y z w."""

    translation: Point
    quaternion: tuple[float, float, float, float]

    def pose(self) -> Poses:
        """Return the motion as a batch of one."""
        return Poses(np.array([self.quaternion], float), np.array([self.translation], float))


class TrueMounts(msgspec.Struct, frozen=True, kw_only=True):
    """truth/extrinsics.json: the tray's origin in the vehicle, camera and DVL in the tray."""

    tray_origin: Point
    tray_from_top: MotionEntry | None = msgspec.field(default=None, name="T_s_ct")
    tray_from_dvl: MotionEntry | None = msgspec.field(default=None, name="T_s_d")


class TrueStructure(msgspec.Struct, frozen=True, kw_only=True):
    """A row of truth/objects.json: what was put on the hull, or painted on it."""

    id: int
    kind: str
    center: Point  # m in M
    normal: Point
    height: float  # m
    extent: tuple[float, float]  # m
    views: int = 0  # frames that see it
    painted: bool = False


class _Objects(msgspec.Struct, frozen=True):
    objects: tuple[TrueStructure, ...]


class _Alignment(msgspec.Struct, frozen=True):
    global_from_hull: MotionEntry = msgspec.field(name="T_g_M")


class _HullSection(msgspec.Struct, frozen=True):
    mesh: str
    units: str = "m"


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The truth of a simulated dive."""

    t_s: Array  # (n,) times of the camera frames
    poses: Poses  # (n,) hull_from_vehicle at these
    servo_t_s: Array  # (k,) times of the servo's angle
    servo_rad: Array  # (k,) angle of the tray
    global_from_hull: Poses  # a batch of one
    mounts: TrueMounts
    objects: Sequence[TrueStructure]  # structures and painted marks
    built_mesh: Mesh  # the hull as it is, in M
    cad_model: Scene | None  # None for a dive without one

    @cached_property
    def built(self) -> Scene:
        """The hull as it is, for closest points and rays."""
        return Scene(self.built_mesh)

    @cached_property
    def _vertices(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.built_mesh.vertices)

    def near(self, points: Array, reach_m: float) -> Mask:
        """Tell which points (n, 3) are within reach of a vertex of the true surface.

        The truth says nothing of the hull elsewhere.
        """
        distance, _ = self._vertices.query(points, distance_upper_bound=reach_m)
        return np.asarray(np.isfinite(distance))

    @cached_property
    def _rim(self) -> cKDTree:
        """Index the vertices at the open boundary of the true surface."""
        from scipy.spatial import cKDTree

        return cKDTree(
            self.built_mesh.vertices[np.unique(find_boundary(self.built_mesh.faces))].reshape(-1, 3)
        )

    def on_rim(self, feet: Array) -> Mask:
        """Tell which closest points (n, 3) are on the rim of the true surface.

        The points whose closest points they are may lie beyond the surface.
        """
        distance, _ = self._rim.query(feet, distance_upper_bound=RIM_M)
        return np.asarray(np.isfinite(distance))

    def vehicle_at(self, t_s: Array) -> Poses:
        """Interpolate hull_from_vehicle at times (n,). Beyond the ends, the end's pose is taken."""
        return interpolate(_nanoseconds(self.t_s), self.poses, _nanoseconds(t_s))

    def cameras_at(self, rows: Ints) -> Poses:
        """Compute the poses hull_from_top of the top camera at frames, by their rows (n,).

        Raises InputError where truth/ states no camera.
        """
        if self.mounts.tray_from_top is None:
            raise InputError("the truth states no mount of a camera", where="truth/extrinsics.json")
        angle = np.interp(self.t_s[rows], self.servo_t_s, self.servo_rad)
        return (
            self.poses[rows]
            @ tray_poses(self.mounts.tray_origin, angle)
            @ self.mounts.tray_from_top.pose()
        )

    def structures(self) -> list[TrueStructure]:
        """List the structures that stand off the hull or are cut into it, without painted marks."""
        return [o for o in self.objects if not o.painted and abs(o.height) > 0]

    def due(self) -> list[TrueStructure]:
        """List the structures that must be found.

        They are at least 0.08 m high and seen in at least six frames.
        """
        return [o for o in self.structures() if abs(o.height) >= 0.08 and o.views >= 6]


def read_truth(package: Path) -> Truth:
    """Read the truth of a package. Raises InputError when it has none that can be read."""
    folder = package / "truth"
    if not (folder / "poses.csv").exists():
        raise InputError(
            "the package holds no truth",
            where=str(folder),
            remedy="only simulated dives can be evaluated",
        )
    poses, servo = read_table(folder / "poses.csv"), read_table(folder / "servo.csv")
    return Truth(
        t_s=poses["t"],
        poses=poses_in(poses),
        servo_t_s=servo["t"],
        servo_rad=servo["rad"],
        global_from_hull=_read_document(
            folder / "alignment.json", _Alignment
        ).global_from_hull.pose(),
        mounts=_read_document(folder / "extrinsics.json", TrueMounts),
        objects=_read_document(folder / "objects.json", _Objects).objects,
        built_mesh=read_mesh(folder / "as_built.ply"),
        cad_model=_cad_model(package),
    )


def read_mesh(path: Path, metres_per_unit: float = 1.0) -> Mesh:
    """Read a mesh file of any form, in metres. Raises InputError without a triangle."""
    import trimesh

    loaded = trimesh.load(path, force="mesh", process=False)
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise InputError("the mesh holds no triangles", where=str(path))
    return Mesh(
        np.asarray(loaded.vertices, float) * metres_per_unit, np.asarray(loaded.faces, np.int32)
    )


def _cad_model(package: Path) -> Scene | None:
    """Read the CAD model that dive.toml of a package names. None without one."""
    try:
        section = tomllib.loads((package / "dive.toml").read_text(encoding="utf-8")).get("hull")
        hull = None if section is None else msgspec.convert(section, _HullSection)
    except (OSError, tomllib.TOMLDecodeError, msgspec.ValidationError) as error:
        raise InputError(f"dive.toml cannot be read: {error}", where=str(package)) from error
    return (
        None if hull is None else Scene(read_mesh(package / hull.mesh, METRES_PER_UNIT[hull.units]))
    )


def _read_document(path: Path, kind: type[Document]) -> Document:
    """Decode a JSON document of truth/. Raises InputError where it cannot be read."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, msgspec.MsgspecError) as error:
        raise InputError(f"the file cannot be read: {error}", where=str(path)) from error


def _nanoseconds(t_s: Array) -> Ints:
    return np.rint(np.asarray(t_s) * 1e9).astype(np.int64)
