# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a simulated dive truly saw of the hull, from its truth alone; shares no code
with what it judges.

Areas are those of the hull as in its CAD model: the truth holds the steel of a patch only, and
structures have no part in them.
"""

import json
import tomllib
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import trimesh
from end_to_end.true_hull import Path, Steel, read_numbers, read_poses
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

EDGE_M = 0.14  # of the pieces on which areas are summed
EDGE_OF_MEASURED_M = 0.07  # of those of a measured surface, whose parts are narrow
# as far along the normal a measured surface is looked for above and below the steel
PROJECTED_M = 0.2
GRAZING = 0.2  # cosine of the incidence beyond which steel shows nothing to a camera
SONAR_GRAZING = 0.05
FARTHEST_M = 12.0


@dataclass
class Steelwork:
    """Pieces of hull: middle (n, 3), outward normal (n, 3) and area (n,)."""

    middle: np.ndarray
    normal: np.ndarray
    area: np.ndarray


def pieces(mesh_path, near, reach_m, edge_m=EDGE_M):
    """The hull of a mesh within reach of points (m, 3), in pieces."""
    triangle = trimesh.load(mesh_path, force="mesh").triangles
    low, high = near.min(axis=0) - reach_m, near.max(axis=0) + reach_m
    triangle = triangle[((triangle.max(axis=1) > low) & (triangle.min(axis=1) < high)).all(axis=1)]
    vertices, faces = trimesh.remesh.subdivide_to_size(
        triangle.reshape(-1, 3), np.arange(3 * len(triangle)).reshape(-1, 3), edge_m
    )
    corner = vertices[faces]
    middle, cross = (
        corner.mean(axis=1),
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]),
    )
    length = np.linalg.norm(cross, axis=1)
    keep = (length > 1e-12) & np.isfinite(
        cKDTree(near).query(middle, distance_upper_bound=reach_m)[0]
    )
    return Steelwork(middle[keep], cross[keep] / length[keep, None], length[keep] / 2)


def pieces_below(mesh_path, surface, near):
    """The hull of a mesh over which a surface lies that was measured, in pieces; near (m, 3): the
    surface's corners.
    """
    steel = pieces(mesh_path, near, PROJECTED_M, EDGE_OF_MEASURED_M)
    over = surface.along(steel.middle + PROJECTED_M * steel.normal, -steel.normal) < 2 * PROJECTED_M
    return Steelwork(steel.middle[over], steel.normal[over], steel.area[over])


@dataclass
class Lens:
    """A pinhole camera with distortion, as its calibration file states it."""

    matrix: np.ndarray
    distortion: np.ndarray
    size: np.ndarray

    def shows(self, local):
        """Which points (n, 3) of the camera's frame fall into the image."""
        ahead = local[:, 2] > 0.05
        at = np.where(ahead[:, None], local, [0, 0, 1.0])
        pixel = cv2.projectPoints(at, np.zeros(3), np.zeros(3), self.matrix, self.distortion)[0][
            :, 0
        ]
        # beyond, the distortion's polynomial turns back
        wide = np.abs(at[:, :2] / at[:, 2:]).max(axis=1) < 2
        return ahead & wide & (pixel > -0.5).all(axis=1) & (pixel < self.size - 0.5).all(axis=1)


def read_lens(path):
    text = "\n".join(line for line in path.read_text().splitlines() if not line.startswith("%"))
    read = cv2.FileStorage(
        "%YAML:1.0\n---\n" + text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY
    )

    def numbers(name):
        node = read.getNode(name).getNode("data")
        return np.array([node.at(k).real() for k in range(node.size())])

    size = np.array([read.getNode(f"image_{k}").real() for k in ("width", "height")])
    return Lens(numbers("camera_matrix").reshape(3, 3), numbers("distortion_coefficients"), size)


@dataclass
class TrueViews:
    """A dive as it truly was; steel: the pieces of hull that count."""

    package: object
    path: Path
    hull: Steel
    steel: Steelwork

    @cached_property
    def mounts(self):
        return json.loads((self.package / "truth" / "extrinsics.json").read_text())

    @cached_property
    def settings(self):
        return tomllib.loads((self.package / "dive.toml").read_text())

    @cached_property
    def _servos(self):
        tables = {name: self.package / "truth" / f"{name}.csv" for name in ("servo", "sonar_servo")}
        return {
            name: (read_numbers(table, "t"), read_numbers(table, "rad"))
            for name, table in tables.items()
        }

    def _on_servo(self, t, servo, origin, mount):
        """Position (n, 3) and attitude in the ship's frame of what sits on a servo that tilts about
        y.
        """
        position, attitude = self.path.at(t)
        tilt = Rotation.from_euler("y", np.interp(t, *self._servos[servo])[:, None])
        arm = np.array(self.mounts[origin]) + tilt.apply(mount["translation"])
        return position + attitude.apply(arm), attitude * tilt * Rotation.from_quat(
            mount["quaternion"]
        )

    def cameras(self, t=None):
        """Position and attitude of the top camera at times, at its frames without any."""
        return self._on_servo(
            self.path.t if t is None else t, "servo", "tray_origin", self.mounts["T_s_ct"]
        )

    def sonar(self, t):
        return self._on_servo(t, "sonar_servo", "sonar_origin", self.mounts["T_sonarservo_o"])

    def dvl(self, t):
        return self._on_servo(t, "servo", "tray_origin", self.mounts["T_s_d"])

    @cached_property
    def lens(self):
        return read_lens(self.package / self.settings["camera"]["top"]["calibration"])

    @cached_property
    def by_camera(self):
        """Views (n,) of each piece, distance (n,) m and incidence (n,) deg of the nearest."""
        views, distance = np.zeros(len(self.steel.area), int), np.full(len(self.steel.area), np.inf)
        incidence = np.full(len(self.steel.area), np.nan)
        for center, turn in zip(*self.cameras(), strict=True):
            rows, away, cosine = self._seen(
                center, GRAZING, lambda ray, turn=turn: self.lens.shows(turn.inv().apply(ray))
            )
            views[rows] += 1
            nearer = away < distance[rows]
            distance[rows[nearer]] = away[nearer]
            incidence[rows[nearer]] = np.degrees(np.arccos(cosine[nearer]))
        return views, distance, incidence

    def frames_that_show(self, structure, most=0.5):
        """How many frames have more than that share of a structure's top in them."""
        normal = np.array(structure["normal"])
        along = np.array([1.0, 0, 0]) - normal * normal[0]
        along /= np.linalg.norm(along)
        u, v = (0.4 * w.ravel() for w in np.meshgrid(*(np.linspace(-1, 1, 9),) * 2))
        disc = np.hypot(u, v) <= 0.4
        sides = np.stack([along, np.cross(normal, along)])
        top = structure["center"] + (np.stack([u, v], axis=1)[disc] * structure["extent"]) @ sides
        shares = [
            self.lens.shows(turn.inv().apply(top - center)).mean()
            for center, turn in zip(*self.cameras(), strict=True)
            if np.linalg.norm(top.mean(axis=0) - center) < 2.5
        ]
        return int((np.array(shares) > most).sum())

    def by_sonar(self, pings):
        """Which pieces (n,) lay in the fan of some ping; pings: times, bearings and ranges as
        logged.
        """
        bearing = np.arctan2(pings["directions"][:, 1], pings["directions"][:, 2])
        half = np.radians(self.settings["sonar"]["elevation_deg"]) / 2
        seen = np.zeros(len(self.steel.area), bool)
        for center, turn in zip(*self.sonar(pings["t_ns"] * 1e-9), strict=True):

            def shows(ray, turn=turn):
                local, away = turn.inv().apply(ray), np.linalg.norm(ray, axis=1)
                at = np.arctan2(local[:, 1], local[:, 2])
                fits = (
                    (np.abs(np.arcsin(local[:, 0] / away)) < half)
                    & (at > bearing.min())
                    & (at < bearing.max())
                )
                return fits & (away > pings["range_m"][0]) & (away < pings["range_m"][-1])

            seen[self._seen(center, SONAR_GRAZING, shows)[0]] = True
        return seen

    def beam_ends(self, pings):
        """Where the DVL's beams met the steel (m, 3), of those that were measured."""
        position, attitude = self.dvl(pings["t_ns"] * 1e-9)
        ends = []
        for beam, ranges in zip(pings["beams"], pings["ranges"].T, strict=True):
            way = attitude.apply(beam / np.linalg.norm(beam))
            away = self.hull.along(position, way)
            came = np.isfinite(ranges) & np.isfinite(away)
            ends.append(position[came] + away[came, None] * way[came])
        return np.concatenate(ends)

    def overlaps(self, t, grid=8):
        """The share (n,) of a grid on each of two images, taken at times t (n, 2), that lies in the
        other: the smaller.
        """
        width, height = self.lens.size
        u, v = np.meshgrid(
            (np.arange(grid) + 0.5) / grid * width - 0.5,
            (np.arange(grid) + 0.5) / grid * height - 0.5,
        )
        pixel = np.stack([u.ravel(), v.ravel()], axis=1)
        ray = np.column_stack(
            [
                cv2.undistortPoints(pixel[:, None], self.lens.matrix, self.lens.distortion)[:, 0],
                np.ones(grid**2),
            ]
        )
        ray /= np.linalg.norm(ray, axis=1, keepdims=True)
        centers, turns = self.cameras(t.ravel())
        poses = list(zip(centers, turns.as_matrix(), strict=True))
        shares = [self._share(ray, poses[k], poses[k ^ 1]) for k in range(t.size)]
        return np.reshape(shares, (-1, 2)).min(axis=1)

    def _share(self, ray, source, target):
        """How many rays (n, 3) of one camera meet steel that another's image shows; position (3,)
        and axes (3, 3) of each.
        """
        (center, turn), (there, turn_there) = source, target
        way = ray @ turn.T
        away = self.hull.along(np.broadcast_to(center, way.shape), way)
        foot = center + np.where(np.isfinite(away), away, 0.0)[:, None] * way
        return np.mean(self.lens.shows((foot - there) @ turn_there) & np.isfinite(away))

    def _seen(self, center, grazing, shows):
        """Rows of the pieces that face a place, that it shows and nothing hides, with distance and
        cosine of incidence.
        """
        ray = self.steel.middle - center
        away = np.linalg.norm(ray, axis=1)
        cosine = -np.einsum("ni,ni->n", ray, self.steel.normal) / away
        rows = np.flatnonzero((cosine > grazing) & (away < FARTHEST_M))
        rows = rows[shows(ray[rows])]
        clear = (
            self.hull.along(np.broadcast_to(center, (len(rows), 3)), ray[rows] / away[rows, None])
            > away[rows] - 0.02
        )
        rows = rows[clear]
        return rows, away[rows], cosine[rows]


def true_views(package, steel):
    """The truth of a package; steel: the pieces of its hull that count."""
    return TrueViews(
        package, read_poses(package / "truth" / "poses.csv"), Steel(package / "hull.stl"), steel
    )
