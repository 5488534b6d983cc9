# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A flight over the textured hull as found, its objects marked [KimEustice2009 IV, Fig. 6].

Frames are cast by our own mesh index, without a window or a graphics card. They are a film where
OpenCV has a codec that browsers play.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np

from hullrecon.artifacts.runner import run_chain
from hullrecon.errors import InputError
from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.objects import score_objects
from hullrecon.evaluation.trajectory import score_trajectory
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.rows import spread_rows
from hullrecon.steps.artifacts import DetectArtifact, InputArtifacts
from hullrecon.studies.dive_steps import inputs_of_step
from hullrecon.studies.figure_style import PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.methods.method_figures import stamps
from hullrecon.studies.methods.variants import read_objects
from hullrecon.studies.study import ComparedValue, StudyDive, StudyResult
from hullrecon.typing import Array, Ints32, Pixels

WIDTH, HEIGHT, FOCAL_PX = 480, 300, 400.0
FRAMES, PER_SECOND = 10, 10  # frames between two stations
FAR_M, NEAR_M, OBJECT_M = 4.5, 1.3, 0.8  # distances of an overview, a pass, an object
WATER = np.array([24.0, 56.0, 74.0])
PAINT = np.array([120.0, 126.0, 130.0])  # of hull without a picture
HAZE_M = 9.0  # distance at which two thirds of the light is the water's
CODEC = "VP80"  # in WebM, which browsers play


@dataclass(frozen=True, kw_only=True)
class Station:
    """A place over the hull's chart that the flight passes."""

    along: float  # m
    girth: float  # m
    distance_m: float


@dataclass(frozen=True, kw_only=True)
class Ortho:
    """The photomosaic on the chart."""

    rgba: Pixels  # (h, w, 4)
    pixel_from_chart: Array  # (2, 3) column and row of along, girth, 1

    def colours(self, along_girth: Array) -> tuple[Array, Array]:
        """Look up colours (n, 3), 0 to 255, at places (n, 2) m of the chart.

        Returns as well whether (n,) the mosaic has a picture there.
        """
        columns, rows = (
            self.pixel_from_chart @ np.hstack([along_girth, np.ones((len(along_girth), 1))]).T
        )
        with np.errstate(invalid="ignore"):
            at = np.nan_to_num(np.stack([rows, columns]), nan=-1.0).astype(np.int64)
        h, w = self.rgba.shape[:2]
        inside = (at[0] >= 0) & (at[0] < h) & (at[1] >= 0) & (at[1] < w)
        found = self.rgba[np.where(inside, at[0], 0), np.where(inside, at[1], 0)]
        return found[:, :3].astype(float), inside & (found[:, 3] > 0)


@dataclass(frozen=True, kw_only=True)
class TexturedHull:
    """The hull as found with its photomosaic."""

    mesh: Mesh
    chart: Chart
    ortho: Ortho

    @cached_property
    def scene(self) -> Scene:
        """Index the mesh, to cast rays at."""
        return Scene(self.mesh)

    @cached_property
    def along_girth(self) -> Array:
        """Chart coordinates (n, 2) of the vertices."""
        return np.asarray(self.chart.to_chart(self.mesh.vertices)[:, :2])

    def look(self, station: Station) -> tuple[Array, Array]:
        """Place a camera over the chart, looking at the hull, with the ship's up at its top.

        Returns its centre (3,) m in M, and its axes right, down and ahead as rows (3, 3).
        """
        point, normal = self.chart.from_chart(np.array([[station.along, station.girth]]))
        ahead = -normal[0]
        up = self.chart.ship_axes[2]
        right = np.cross(ahead, up)
        right /= np.linalg.norm(right)
        return point[0] + station.distance_m * normal[0], np.stack(
            [right, np.cross(ahead, right), ahead]
        )

    def frame(self, station: Station, marked: Array) -> Pixels:
        """Render what a camera at a station sees (HEIGHT, WIDTH, 3).

        marked: (m, 3) m in M, points around which rings are drawn.
        """
        centre, axes = self.look(station)
        u, v = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
        ray = np.stack([u.ravel() - 0.5 * WIDTH, v.ravel() - 0.5 * HEIGHT], axis=1) / FOCAL_PX
        direction = np.hstack([ray, np.ones((len(ray), 1))]) @ axes
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        distance, face = self.scene.hit(centre, direction)
        picture = np.tile(WATER, (len(ray), 1))
        met = np.flatnonzero(face >= 0)
        picture[met] = self._colours(centre, direction[met], distance[met], face[met])
        whole = np.asarray(picture.clip(0, 255), np.uint8).reshape(HEIGHT, WIDTH, 3)
        return _with_rings(whole, (marked - centre) @ axes.T)

    def _colours(self, centre: Array, direction: Array, distance: Array, face: Ints32) -> Array:
        """Colour what rays meet (n, 3): the mosaic, or paint, shaded by its slope and in haze.

        Parameters
        ----------
        centre
            (3,) m in M, from which the rays start.
        direction, distance
            Unit vectors (n, 3) in M, and how far (n,) m they reach.
        face
            (n,) of the mesh that they meet.
        """
        corners = self.mesh.faces[face]
        a, b, c = (self.mesh.vertices[corners[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        normal /= np.maximum(area, 1e-15)[:, None]
        point = centre + distance[:, None] * direction
        # Barycentric coordinates: shares of the triangles that a point makes with each edge
        share = (
            np.stack(
                [
                    np.linalg.norm(np.cross(q - point, r - point), axis=1)
                    for q, r in ((b, c), (c, a), (a, b))
                ],
                axis=1,
            )
            / np.maximum(area, 1e-15)[:, None]
        )
        place = (share[:, :, None] * self.along_girth[corners]).sum(axis=1)
        colour, pictured = self.ortho.colours(place)
        colour = np.where(pictured[:, None], colour, PAINT)
        facing = np.abs((normal * direction).sum(axis=1))[:, None]
        clear = np.exp(-distance / HAZE_M)[:, None]
        return np.asarray((0.45 + 0.55 * facing) * colour * clear + (1 - clear) * WATER)


def study(given: StudyDive) -> StudyResult:
    """Render the flight over a dive's hull, and count the structures found on it."""
    dive, truth = given.dive, given.truth
    run_chain(dive.chain.up_to("mosaic-optical"), dive.workspace, given.run_context)
    hull, inputs = read_hull(given)
    objects = read_objects(dive)
    centres = np.array([o.center for o in objects], float).reshape(-1, 3)
    places = hull.chart.to_chart(centres)[:, :2] if len(centres) else np.zeros((0, 2))
    stations = list(flight(hull, places))
    frames = [hull.frame(station, centres) for station in stations]
    assert inputs.adjust is not None  # the mosaic lies on its path
    solution = inputs.adjust.solution
    _, motion = score_trajectory(
        TimedPoses(t_s=stamps(solution), poses=solution.track().poses), truth
    )
    score = score_objects(objects, truth, motion)
    return StudyResult(
        figures=(fly_through(frames, stations),),
        compared=(
            ComparedValue(
                what="targets found, of all",
                unit="%",
                printed=100.0,
                ours=100 * float(str(score["recall"])),
                note=f"6 of 6 by eye in the mosaic; here {score['due']} structures, by height",
            ),
            ComparedValue(
                what="false targets",
                ours=float(str(score["false_reports"])),
            ),
        ),
    )


def read_hull(given: StudyDive) -> tuple[TexturedHull, InputArtifacts]:
    """Read the hull as found with its mosaic. Raises InputError where the dive has none."""
    import rasterio

    dive = given.dive
    ortho = dive.workspace.artifact("mosaic-optical") / "ortho.tif"
    found = DetectArtifact(dive.workspace.artifact("detect")).as_found
    if found is None or not ortho.is_file():
        raise InputError(
            "the dive has no photomosaic on a hull as found",
            where=str(dive.workspace.root),
            remedy="take a dive with images and a CAD model",
        )
    inputs = inputs_of_step(dive, "mosaic-optical")
    with rasterio.open(ortho) as raster:
        rgba, to_map = raster.read().transpose(1, 2, 0), raster.transform
    chart = inputs.surface.chart
    facts = _facts(ortho.parent / "mosaic.json")
    x_sign, y_sign = float(facts["along_from_x"]), float(facts["girth_from_y"])
    pixel = np.array(
        [
            [x_sign / to_map.a, 0.0, -to_map.c / to_map.a],
            [0.0, y_sign / to_map.e, -to_map.f / to_map.e],
        ]
    )
    hull = TexturedHull(
        mesh=found.mesh(), chart=chart, ortho=Ortho(rgba=rgba, pixel_from_chart=pixel)
    )
    return hull, inputs


def _facts(file: Path) -> dict[str, float]:
    """Read mosaic.json, which says how the mosaic's map coordinates lie on the chart."""
    import msgspec

    found: dict[str, float] = msgspec.json.decode(file.read_bytes())
    return found


def flight(hull: TexturedHull, objects: Array) -> Iterator[Station]:
    """Plan the flight: an overview, a pass along the mosaic, each object, an overview.

    objects: (m, 2) m on the chart. Yields a station for each frame.
    """
    rows, columns = np.nonzero(hull.ortho.rgba[::8, ::8, 3])
    pixel = 8.0 * np.stack([columns, rows]) - hull.ortho.pixel_from_chart[:, 2:]
    place = np.linalg.solve(hull.ortho.pixel_from_chart[:, :2], pixel).T
    (first, _), (last, _) = np.percentile(place, [8, 92], axis=0)
    middle = np.median(place, axis=0)
    overview = Station(along=float(middle[0]), girth=float(middle[1]), distance_m=FAR_M)
    way = [replace(overview, along=float(at), distance_m=NEAR_M) for at in (last, first)]
    seen = objects[np.argsort(objects[:, 0])] if len(objects) else objects
    near = [Station(along=float(a), girth=float(g), distance_m=OBJECT_M) for a, g in seen]
    stops = [overview, *way, *near, overview]
    for here, there in pairwise(stops):
        for k in range(FRAMES):
            t = k / FRAMES
            share = t * t * (3 - 2 * t)  # starts and ends at rest
            yield Station(
                along=here.along + share * (there.along - here.along),
                girth=here.girth + share * (there.girth - here.girth),
                distance_m=here.distance_m + share * (there.distance_m - here.distance_m),
            )
    yield stops[-1]


def _with_rings(picture: Pixels, points: Array) -> Pixels:
    """Draw a white ring of 0.2 m around points (m, 3) m, in the camera's axes, in the picture."""
    import cv2

    drawn = np.ascontiguousarray(picture)
    for x, y, z in points:
        if z > 0.1:
            at = (
                round(float(FOCAL_PX * x / z + 0.5 * WIDTH)),
                round(float(FOCAL_PX * y / z + 0.5 * HEIGHT)),
            )
            radius = round(float(FOCAL_PX * 0.2 / z))
            if abs(at[0] - WIDTH / 2) < WIDTH and abs(at[1] - HEIGHT / 2) < HEIGHT:
                cv2.circle(drawn, at, radius, (255, 255, 255), 1, cv2.LINE_AA)
    return drawn


def fly_through(frames: Sequence[Pixels], stations: Sequence[Station]) -> PublishedFigure:
    """Draw some of the frames, with the film of all of them."""
    shown = spread_rows(len(frames), 6)
    figure, axes = new_canvas(10.0, 4.4, 2, 3)
    for axis, k in zip([axis for row in axes for axis in row], shown, strict=False):
        axis.imshow(frames[k])
        axis.grid(False)
        axis.set(xticks=[], yticks=[])
        axis.set_title(f"{k / PER_SECOND:.1f} s", fontsize=8)
    table = ["t_s,along_m,girth_m,distance_m"]
    table += [
        f"{k / PER_SECOND:.2f},{s.along:.3f},{s.girth:.3f},{s.distance_m:.3f}"
        for k, s in enumerate(stations)
    ]
    made = film(frames)
    length = f"{len(frames) / PER_SECOND:.0f} s, {len(frames)} frames"
    caption = (
        f"Flight over the photomosaic on the hull as found ({length}): overview, a pass along it, "
        "the objects found (ringed), overview."
    )
    return replace(finish_figure("fly_through", figure, table, caption), film=made)


def film(frames: Sequence[Pixels]) -> bytes:
    """Encode frames (h, w, 3) as WebM. Empty where OpenCV lacks the codec."""
    import cv2

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "film.webm"
        size = (frames[0].shape[1], frames[0].shape[0])
        writer = cv2.VideoWriter(
            str(file), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*CODEC), PER_SECOND, size
        )
        if not writer.isOpened():
            return b""
        for frame in frames:
            writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
        writer.release()
        return file.read_bytes()
