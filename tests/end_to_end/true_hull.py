# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a simulated dive's truth says about the things that a report tells; shares no code with what
it judges.
"""

import csv
import json
import re
import tomllib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import open3d as o3d
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation, Slerp


class Steel:
    """Distances to a triangle mesh; lay: what moves its vertices (n, 3) first."""

    def __init__(self, path, lay=np.asarray):
        mesh = o3d.io.read_triangle_mesh(str(path))
        faces = np.asarray(mesh.triangles)
        mesh.vertices = o3d.utility.Vector3dVector(lay(np.asarray(mesh.vertices)))
        self.vertices, self.edges = (
            np.asarray(mesh.vertices),
            np.sort(np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])),
        )
        self.bounds = np.array([mesh.get_min_bound(), mesh.get_max_bound()])
        self.scene = o3d.t.geometry.RaycastingScene()
        self.scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(mesh))

    def closest(self, points):
        """Feet (n, 3) and outward normals (n, 3)."""
        answer = self.scene.compute_closest_points(o3d.core.Tensor(points.astype(np.float32)))
        return answer["points"].numpy().astype(float), answer["primitive_normals"].numpy().astype(
            float
        )

    def along(self, origin, direction):
        """Distances (n,) to what rays meet, inf where nothing."""
        rays = np.hstack([origin, np.broadcast_to(direction, origin.shape)]).astype(np.float32)
        return self.scene.cast_rays(o3d.core.Tensor(rays))["t_hit"].numpy().astype(float)


@dataclass
class TrueHull:
    """The hull as it is, its CAD model, and the motion that lays the run's results onto them: what
    a run says of a piece of steel is held against that piece, wherever the run believes it to be.
    """

    built: Steel
    cad: Steel
    rotation: np.ndarray
    shift: np.ndarray
    global_from_hull: np.ndarray
    objects: list

    def depth(self, point):
        """Depth of a point (3,) of the ship below the water surface."""
        return float((self.global_from_hull[:3, :3] @ point + self.global_from_hull[:3, 3])[2])

    def lay(self, points):
        return points @ self.rotation.T + self.shift

    @cached_property
    def rim(self):
        """The corners along the edge of the true steel, to be asked for the nearest one."""
        edges, times = np.unique(self.built.edges, axis=0, return_counts=True)
        return cKDTree(self.built.vertices[np.unique(edges[times == 1])])

    def lay_back(self, points):
        """Points (n, 3) of the ship in the frame of the run."""
        return (points - self.shift) @ self.rotation

    def chart(self, points, step_m=0.1):
        """Along and girth (n, 2) of the ship's points: girth is the arc from the keel on the
        section of the CAD model.
        """
        foot, _ = self.cad.closest(points)
        out = np.column_stack([points[:, 0], np.zeros(len(points))])
        number = np.round(foot[:, 0] / step_m).astype(int)
        for k in np.unique(number):
            arc, at = self.section(
                k * step_m if (number == k).sum() > 1 else foot[number == k, 0][0]
            )
            out[number == k, 1] = arc[cKDTree(at).query(foot[number == k, 1:])[1]]
        return out

    def section(self, x):
        """Arc lengths (n,) from the keel, port positive, and the points (n, 2), y and z, of the CAD
        model's section at x.
        """
        z = np.linspace(*self.cad.bounds[:, 2], 4000)[:-1] + 1e-4
        arcs, places = [], []
        for side in (1, -1):
            origin = np.column_stack(
                [np.full(len(z), x), np.full(len(z), 2 * side * self.cad.bounds[1, 1]), z]
            )
            y = origin[:, 1] - side * self.cad.along(origin, np.array([0.0, -side, 0]))
            met = np.isfinite(y)
            line = np.column_stack([y, z])[met]
            keel = np.column_stack([np.linspace(0, line[0, 0], 200)[:-1], np.full(199, line[0, 1])])
            line = np.vstack([keel, line])
            arcs.append(
                side * np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
            )
            places.append(line)
        return np.concatenate(arcs), np.concatenate(places)

    def deviation(self, points):
        """Signed distance (n,) from the CAD model of the steel nearest to points (n, 3)."""
        foot, _ = self.built.closest(self.lay(points))
        on_cad, normal = self.cad.closest(foot)
        gap = foot - on_cad
        return np.linalg.norm(gap, axis=1) * np.sign(np.einsum("ni,ni->n", gap, normal))

    def relief(self, center, half_m=0.4, step_m=0.005):
        """Heights of the steel on a square of the tangent plane around a true center: along (n, n),
        across, deviation.
        """
        on_cad, normal = (a[0] for a in self.cad.closest(np.array([center])))
        along = np.array([1.0, 0, 0]) - normal * normal[0]
        along /= np.linalg.norm(along)
        u, v = np.meshgrid(*(np.arange(-half_m, half_m + step_m, step_m),) * 2, indexing="ij")
        start = (
            on_cad + u[..., None] * along + v[..., None] * np.cross(normal, along) + 0.5 * normal
        )
        built, cad = (
            0.5 - mesh.along(start.reshape(-1, 3), -normal).reshape(u.shape)
            for mesh in (self.built, self.cad)
        )
        return u, v, built - cad

    def footprint(self, center, height, reach):
        """Extents (2,), area and volume of the part above a quarter of its height."""
        u, v, deviation = self.relief(center)
        side = np.sign(height)
        ring = (np.hypot(u, v) > 0.3) & np.isfinite(deviation)
        above = deviation - np.median(deviation[ring])
        foot = (side * above > 0.25 * abs(height)) & (np.hypot(u, v) < reach)
        ends = [np.percentile(w[foot], 99) - np.percentile(w[foot], 1) for w in (u, v)]
        return np.array(ends), foot.sum() * 0.005**2, above[foot].sum() * 0.005**2


def read_table(path):
    """Columns of cells by name without its unit."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return {re.sub(r"_(m|m2|m3|rad|s)$", "", name): [row[name] for row in rows] for name in rows[0]}


def read_numbers(path, name):
    return np.array([float(text or "nan") for text in read_table(path)[name]])


@dataclass
class Path:
    """Poses over time: t (n,) s, position (n, 3) m, attitude (n)."""

    t: np.ndarray
    position: np.ndarray
    attitude: Rotation

    def at(self, t):
        """Position (n, 3) and attitude at times, held at both ends."""
        t = np.clip(t, self.t[0], self.t[-1])
        position = np.stack([np.interp(t, self.t, self.position[:, k]) for k in range(3)], axis=1)
        return position, Slerp(self.t, self.attitude)(t)


def read_poses(path):
    """The path of a table with columns t x y z qx qy qz qw."""
    table = read_table(path)
    position, quaternion = (
        np.array([table[k] for k in names], float).T for names in ("xyz", ("qx", "qy", "qz", "qw"))
    )
    return Path(np.array(table["t"], float), position, Rotation.from_quat(quaternion))


def read_ply(path):
    """Vertices as a structured array, and triangles (m, 3), of a binary file; none of a cloud."""
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    count = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
    dtype = [
        (line[2], kinds[line[1]]) for line in lines if line[0] == "property" and line[1] != "list"
    ]
    vertices = np.frombuffer(body, dtype, count["vertex"])
    if not count.get("face"):
        return vertices, np.zeros((0, 3), int)
    return vertices, np.frombuffer(body[vertices.nbytes :], [("n", "u1"), ("v", "<i4", 3)])["v"]


def true_hull(deliver, package):
    """The truth of a package beside what `deliver` holds."""
    truth = package / "truth"
    ours = read_poses(deliver / "trajectory.csv")
    rotation, shift = rigid(ours.position, read_poses(truth / "poses.csv").at(ours.t)[0])
    objects = json.loads((truth / "objects.json").read_text())
    hull = (
        tomllib.loads((package / "dive.toml").read_text()).get("hull", {}).get("mesh", "hull.stl")
    )
    return TrueHull(
        built=Steel(truth / "as_built.ply"),
        cad=Steel(package / hull),
        rotation=rotation,
        shift=shift,
        global_from_hull=np.array(
            json.loads((truth / "alignment.json").read_text())["T_g_M"]["matrix"]
        ),
        objects=objects["objects"] if isinstance(objects, dict) else objects,
    )


def rigid(a, b):
    """Rotation and shift that lay points a on b."""
    u, _, vt = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    rotation = vt.T @ np.diag([1, 1, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    return rotation, b.mean(0) - rotation @ a.mean(0)
