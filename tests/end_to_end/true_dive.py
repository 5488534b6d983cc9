# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A run beside the dive that was simulated: what tests/end_to_end/sentences.py holds the report's
words against.
"""

import json
import re
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import trimesh
from end_to_end import claims
from end_to_end.true_hull import Steel, read_ply, read_poses, true_hull
from end_to_end.true_views import pieces, pieces_below, true_views
from scipy import ndimage
from scipy.spatial import cKDTree

LABEL_BOUNDARY_M = 0.04  # a landmark farther off the CAD model does not lie on it
# nearer to the boundary than this, either word is right, as `evaluate` has it
LABEL_UNCLEAR_M = 0.02
CELL_M, BAY_M = 0.1, 0.2  # of the map on which holes are sought; side of the least bay at its rim
DVL_REACH_M = (0.2, 0.4)  # from where a beam met the hull
SEEN_WITHIN_M = 4.0  # of what the camera saw lies what the sonar saw
DUE_HEIGHT_M, DUE_VIEWS = 0.08, 6  # of a structure that must be found


@dataclass
class TrueDive:
    """Truth of a package, and what a run over it left."""

    run: Path
    package: Path

    @cached_property
    def settings(self):
        return tomllib.loads((self.package / "dive.toml").read_text())

    @property
    def name(self):
        return self.settings["dive"]["name"]

    @property
    def vessel(self):
        return self.settings["dive"]["vessel"]

    @property
    def date(self):
        return self.settings["dive"]["date"].strftime("%d %B %Y, %H:%M UTC")

    @property
    def frame_spacing_m(self):
        return self.settings["hull"]["frame_spacing"]

    @cached_property
    def summary(self):
        return claims.document(self.run, "summary.json")

    @property
    def in_ship_frame(self):
        return self.summary["frame"] == "M"

    @cached_property
    def page(self):
        return (self.run / "deliver" / "report" / "index.html").read_text()

    @cached_property
    def titles(self):
        return re.findall(r'<li><a href="#[a-z]+">\d+ ([^<]*)</a></li>', self.page)

    @cached_property
    def warnings(self):
        return re.findall(
            r"<li>",
            re.split(r"<h3>Warnings of the steps</h3>", self.page + "<h3></h3>")[1].split("</ul>")[
                0
            ],
        )

    @cached_property
    def hull(self):
        return true_hull(self.run / "deliver", self.package)

    # the path

    @cached_property
    def path(self):
        return claims.path_claims(self.run, self.package)

    @property
    def node_times(self):
        return self.path.t

    @cached_property
    def measured_times(self):
        """Times (n,) s at which the dive can have a pose: of the top camera's images, of the DVL's
        pings without a camera.
        """
        table = "images_camera_top" if self.images else "dvl"
        return np.load(self.run / "ingest" / f"{table}.npz")["t_ns"] * 1e-9

    @property
    def pose_times(self):
        return read_poses(self.run / "deliver" / "trajectory.csv").t

    @property
    def true_path_m(self):
        return np.linalg.norm(np.diff(self.path.true_position, axis=0), axis=1).sum()

    def way_within(self, seconds):
        """The true way (n, 3) from each pose to where the vehicle is so many seconds later."""
        t, position = self.path.t, self.path.true_position
        later = [np.interp(t + seconds, t, axis) for axis in position.T]
        return np.column_stack(later) - position

    @property
    def path_sigma(self):
        return self.path.sigma

    @property
    def path_error(self):
        return self.path.error

    @cached_property
    def error_on_hull(self):
        """Median error of the vehicle's place along the hull or plane, and in girth or across it,
        m.
        """
        error = self.path.error[:, :3]
        if not self.in_ship_frame:
            plane = claims.document(self.run, "chart.json")["plane"]
            return tuple(np.median(error @ np.array(plane[k])) for k in ("along", "girth"))
        _, normal = self.hull.cad.closest(self.path.true_position)
        girth = np.cross(normal, [-1.0, 0, 0])
        return np.median(error[:, 0]), np.median(
            np.einsum("ij,ij->i", error, girth / np.linalg.norm(girth, axis=1, keepdims=True))
        )

    def weak_error(self, kind, name):
        axis = {
            "along the hull": 0,
            "across the hull": 1,
            "vertically": 2,
            "heel": 0,
            "trim": 1,
            "heading": 2,
        }[name]
        return claims.errors_by_axis(self.run, self.package)[kind][axis]

    # objects

    @cached_property
    def objects(self):
        return claims.object_claims(self.run, self.hull, self.in_ship_frame)

    @cached_property
    def objects_due(self):
        """How many structures must have been found, and how many there are."""
        real = [o for o in self.hull.objects if o["height"]]
        return sum(abs(o["height"]) >= DUE_HEIGHT_M and o["views"] >= DUE_VIEWS for o in real), len(
            real
        )

    def structure_of(self, number):
        """The structure that a reported object is."""
        center = {
            o["id"]: o["center"] for o in claims.document(self.run, "objects.json")["objects"]
        }[number]
        laid = self.hull.lay(np.array(center)[None])[0]
        return min(
            (o for o in self.hull.objects if o["height"]),
            key=lambda o: np.linalg.norm(laid - o["center"]),
        )

    @cached_property
    def regions_refused(self):
        """What detect looked at and did not report."""
        return json.loads((self.run / "detect" / "detect.json").read_text())["not_reported"]

    def nearest_structure_m(self, at):
        laid = self.hull.lay(at[None])[0]
        due = [
            o
            for o in self.hull.objects
            if abs(o["height"]) >= DUE_HEIGHT_M and o["views"] >= DUE_VIEWS
        ]
        return min((np.linalg.norm(laid - o["center"]) for o in due), default=np.inf)

    # the hull

    @cached_property
    def deviation(self):
        return claims.deviation_claims(self.run, self.hull)

    @cached_property
    def cad_mesh(self):
        return trimesh.load(self.package / "hull.stl", force="mesh", process=False)

    @cached_property
    def flat_faces(self):
        """Which faces of the CAD model's file are lines: lower than a hundredth of a millimetre."""
        corner = self.cad_mesh.triangles
        longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
        return 2 * self.cad_mesh.area_faces < 1e-5 * longest

    @cached_property
    def boundary_edges(self):
        """How many edges have one face only."""
        faces = self.real_faces
        edges = np.sort(np.stack([faces, np.roll(faces, 1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        return int((np.unique(edges, axis=0, return_counts=True)[1] == 1).sum())

    @cached_property
    def real_faces(self):
        """Corners (n, 3), by number, of the faces that are no lines, each once."""
        corner = np.round(self.cad_mesh.triangles[~self.flat_faces], 5).reshape(-1, 3)
        faces = np.unique(corner, axis=0, return_inverse=True)[1].reshape(-1, 3)
        return faces[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]]

    @cached_property
    def landmarks(self):
        return read_ply(self.run / "deliver" / "landmarks.ply")[0]

    @property
    def landmark_count(self):
        return len(self.landmarks)

    @cached_property
    def share_on_cad_model(self):
        """Between which shares, in percent, landmarks truly lie on the CAD model."""
        off = np.abs(self.hull.deviation(np.stack([self.landmarks[k] for k in "xyz"], axis=1)))
        return tuple(
            100 * np.mean(off < LABEL_BOUNDARY_M + d) for d in (-LABEL_UNCLEAR_M, LABEL_UNCLEAR_M)
        )

    # what was seen

    @cached_property
    def views(self):
        return true_views(self.package, self._steel())

    def _steel(self):
        """Pieces of hull around what was measured; without a CAD model nothing is known beyond the
        measured surface.
        """
        mesh, deliver = self.package / "hull.stl", self.run / "deliver"
        if not self.in_ship_frame:
            surface = Steel(deliver / "surface.ply", self.hull.lay)
            return pieces_below(mesh, surface, surface.vertices)
        vertex, _ = read_ply(deliver / "as_found.ply")
        points = self.hull.lay(np.stack([vertex[k] for k in "xyz"], axis=1))
        return pieces(mesh, points[vertex["support"] > 0][::20], SEEN_WITHIN_M)

    @cached_property
    def _seen_by(self):
        """Which pieces (n,) of hull camera and sonar saw, as far as they were carried."""
        seen = {"camera": self.views.by_camera[0] > 0} if self.images else {}
        pings = self.run / "ingest" / "sonar.npz"
        return seen | ({"sonar": self.views.by_sonar(np.load(pings))} if pings.exists() else {})

    def carried(self, sensor):
        return (
            sensor in self._seen_by
            if sensor != "DVL"
            else (self.run / "ingest" / "dvl.npz").exists()
        )

    def seen_area(self, sensor, on=slice(None)):
        return self.views.steel.area[on][self._seen_by[sensor][on]].sum()

    @cached_property
    def _from_beam_ends(self):
        """Distance (n,) m of each piece of hull to where a beam of the DVL met it."""
        ends = cKDTree(self.views.beam_ends(np.load(self.run / "ingest" / "dvl.npz")))
        return ends.query(self.views.steel.middle)[0]

    def seen_by_dvl(self, on=slice(None)):
        """Least and most area that its beams saw: what lies between them is seen as far as a
        surface can be laid over it.
        """
        return [
            self.views.steel.area[on][self._from_beam_ends[on] < reach].sum()
            for reach in DVL_REACH_M
        ]

    def within(self, along, girth):
        """Which pieces (n,) lie within limits (low, high) of the map."""
        low, high = np.array([along, girth]).T
        return ((self.on_map >= low) & (self.on_map <= high)).all(axis=1)

    @property
    def seen_twice(self):
        return self.views.steel.area[self.views.by_camera[0] > 1].sum()

    def seen_percentiles(self, name):
        views, distance, incidence = self.views.by_camera
        values = {
            "views": views,
            "incidence": incidence,
            "gsd": 1000 * distance / self.views.lens.matrix[0, 0],
        }[name]
        seen = views > 0
        return [claims.weighted(values[seen], self.views.steel.area[seen], p) for p in (5, 50, 95)]

    @cached_property
    def on_map(self):
        """Along and girth (n, 2) of the pieces of hull."""
        return self.hull.chart(self.views.steel.middle)

    def holes(self, least_m2):
        """Areas, m2, of the parts larger than that which no camera saw inside the outline of what
        was seen.
        """
        return [area for area in self._holes(self._seen_by["camera"]) if area >= least_m2]

    def holes_of_dvl(self, least_m2):
        """The same of what no beam saw, as far as a surface can be laid, farthest first: fewest
        holes and most.
        """
        return [
            [area for area in self._holes(self._from_beam_ends < reach) if area >= least_m2]
            for reach in DVL_REACH_M[::-1]
        ]

    def _holes(self, seen):
        # gaps of up to twelve cells at the rim count, if a bay fits into them, as in the report
        rim, bay = 6, np.ones((round(BAY_M / CELL_M),) * 2, bool)
        at = np.floor((self.on_map - self.on_map.min(axis=0)) / CELL_M).astype(int) + rim
        image, hull = np.zeros((2, *(at.max(axis=0) + 1 + rim)), bool)
        hull[tuple(at.T)] = True
        image[tuple(at[seen].T)] = True
        disc = np.hypot(*np.mgrid[-rim : rim + 1, -rim : rim + 1]) <= rim
        outline = ndimage.binary_fill_holes(ndimage.binary_closing(image, disc))
        label, count = ndimage.label(outline & ~image & hull)
        edge = ndimage.binary_dilation(~outline)
        gaps = [label == k for k in range(1, count + 1)]
        return [
            gap.sum() * CELL_M**2
            for gap in gaps
            if not (gap & edge).any() or ndimage.binary_opening(gap, bay).any()
        ]

    @cached_property
    def seen_extent(self):
        """Limits along and in girth of what the camera saw, or the DVL's beams without a camera."""
        seen = self._seen_by["camera"] if self.images else self._from_beam_ends < DVL_REACH_M[0]
        return self.on_map[seen].min(axis=0), self.on_map[seen].max(axis=0)

    def pixel_m(self, name):
        return json.loads((self.run / f"mosaic-{name}" / "mosaic.json").read_text())["resolution_m"]

    def mosaic_gaps(self, name):
        return json.loads((self.run / f"mosaic-{name}" / "mosaic.json").read_text())["gap_area_m2"]

    # the run

    @cached_property
    def images(self):
        """How many images each camera took that can be used."""
        files = sorted((self.run / "ingest").glob("images_*.npz"))
        return [int(np.load(file)["usable"].sum()) for file in files]

    def image_times(self, camera):
        return np.load(self.run / "ingest" / f"images_camera_{camera}.npz")["t_ns"]

    def overlaps(self, across):
        """Pairs of images compared and matched, and the 5th, 50th and 95th percentile of the
        matched ones' overlap, percent.
        """
        return self._overlaps[across]

    @cached_property
    def _overlaps(self):
        pairs, out = np.load(self.run / "links" / "pairs.npz"), {}
        for across in (False, True):
            rows = pairs["across"] == across
            joined = rows & (pairs["reason"] == 0) & ~pairs["rejected"]
            nodes = np.stack([pairs["first"][joined], pairs["second"][joined]], axis=1)
            overlap = self.views.overlaps(self.node_times[nodes]) if len(nodes) else np.zeros(1)
            out[across] = (
                int(rows.sum()),
                int(joined.sum()),
                100 * np.percentile(overlap, (5, 50, 95)),
            )
        return out

    @property
    def pairs_without_pose(self):
        return sum(compared - joined for compared, joined, _ in self._overlaps.values())

    @cached_property
    def adjust(self):
        return json.loads((self.run / "adjust" / "adjust.json").read_text())

    @cached_property
    def sensor_errors(self):
        return claims.true_sensor_errors(self.run, self.package)

    @property
    def step_runs(self):
        return self.summary["run"]["steps"]

    @property
    def ranges(self):
        return len(np.load(self.run / "navigate" / "returns.npz")["flagged"])

    @property
    def ranges_flagged(self):
        return int(np.load(self.run / "navigate" / "returns.npz")["flagged"].sum())
