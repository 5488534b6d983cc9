# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is on the hull: the as-found mesh, objects, and what the survey covered."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.detection import coverage
from hullrecon.detection.as_found.background import Background, FieldBackground, median_background
from hullrecon.detection.as_found.hull_as_found import HullAsFound, estimate_hull_as_found
from hullrecon.detection.as_found.landmarks import SurfaceLandmarks, measure_surface
from hullrecon.detection.as_found.mesh import refine_near
from hullrecon.detection.as_found.record import as_found_surface, surface_on_cad_model
from hullrecon.detection.objects.find_objects import find_objects
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews, find_visibility
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import Chart, address, chart_from_arrays
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import ImageIndex, JointSamples, SonarPings
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.steps.cameras import cameras_file
from hullrecon.typing import Array

Facts = dict[str, object]
PIECE_M = 0.12  # edges of the hull_patches on which coverage is summed
PIECES_REACH_M = 2.0  # from what the survey saw; beyond, the CAD model's own faces are the hull_patches
DVL_REACH_M = 0.08  # from a vertex of the DVL's surface, whose edges are 0.1 m


@dataclass(frozen=True)
class Dive:
    """What the earlier steps left, in the frame x of the surface (M, or g without a CAD model)."""

    solution: Solution
    T_x_g: Poses
    T_x_v: Poses
    base: Mesh
    drawn: bool
    surface: Surface
    chart: Chart
    frame_spacing_m: float | None

    def address_of(self, point: Array) -> str:
        """Of a point (3,) in x; g has its origin at the water surface, z down."""
        depth = self.T_x_g.inverse().apply(point[None])[:, 2]
        return address(self.chart, point[None], self.frame_spacing_m, depth)[0]


def run(context: Context) -> None:
    dive = _dive(context)
    views = _views(context, dive)
    facts: Facts = {"reference": "the CAD model" if dive.drawn else "the surface step's own surface"}
    measured = _measured(dive, context.parameters) if views is not None else None
    objects: list[Facts] = []
    if views is not None and measured is not None and len(measured) >= context.parameters.least_landmarks:
        background = _background(dive, measured, context.parameters)
        found = estimate_hull_as_found(dive.base, measured, background, views, context.parameters)
        context.out.arrays("as_found.npz", to_arrays(as_found_surface(found, measured)))
        objects, more = _objects(found, measured, background, views, dive, context.parameters)
        facts.update(more)
    else:
        facts["objects"] = "no landmarks: structures are looked for with a camera"
        _without_camera(context, dive, facts)
    context.out.json("objects.json", {"objects": objects})
    context.out.json("coverage.json", _coverage(context, dive, views))
    context.out.json("detect.json", facts)


def _dive(context: Context) -> Dive:
    solution = from_arrays(Solution, load_arrays(context.inputs["adjust"] / "solution.npz"))
    surface = from_arrays(Surface, load_arrays(context.inputs["surface"] / "surface.npz"))
    chart = chart_from_arrays(load_arrays(context.inputs["surface"] / "chart.npz"))
    path, hull = context.inputs["ingest"] / "hull.npz", context.settings["hull"]
    drawn = path.exists() and hull is not None
    T_x_g = solution.result_from_global()
    base = surface.mesh()
    if drawn:
        arrays = load_arrays(path)
        base = Mesh(arrays["vertices"], arrays["faces"])
    T_x_v = solution.track().poses
    return Dive(solution, T_x_g, T_x_v, base, drawn, surface, chart, hull.frame_spacing if hull is not None else None)


def _views(context: Context, dive: Dive) -> CameraViews | None:
    """The top camera's images; None without a camera or a landmark."""
    path, solution = cameras_file(context.inputs), dive.solution
    node = np.flatnonzero(solution.image[:, 0] >= 0)
    if not path.exists() or not len(node) or not len(solution.landmarks) or solution.mounts.tray_from_camera is None:
        return None
    camera = CameraModel(**json.loads(path.read_text())["top"])
    tray = poses.tray_poses(np.array(context.settings["tray"].origin), solution.tray[node])
    T_x_c = dive.T_x_v[node] @ tray @ solution.mounts.tray_from_camera
    index = from_arrays(ImageIndex, load_arrays(context.inputs["ingest"] / "images_camera_top.npz"))
    names = tuple(f"camera_top/{t}.jpg" for t in index.t_ns[solution.image[node, 0]].tolist())
    return CameraViews(
        T_x_c, node, names, camera, _farthest(T_x_c.translation, dive.T_x_g.apply(solution.landmarks.position), camera)
    )


def _farthest(centers: Array, landmarks: Array, camera: CameraModel) -> float:
    """How far the corner of an image can lie: the usual distance of landmarks over the corner's cosine, and some more."""
    known = landmarks[np.isfinite(landmarks).all(axis=1)]
    usual = np.percentile(nearest(centers, known[:: max(1, len(known) // 5000)], 1)[0], 95)
    corner = camera.rays(np.array([[0.0, 0], [camera.width, camera.height]]))[:, 2].min()
    return float(1.25 * usual / max(corner, 0.3))


def _measured(dive: Dive, options: DetectOptions) -> SurfaceLandmarks:
    position = dive.T_x_g.apply(dive.solution.landmarks.position)
    covariance = dive.solution.landmarks.covariance
    return measure_surface(
        Scene(dive.base), position, covariance, dive.solution.landmarks.views, options.farthest, 0.5 * options.threshold
    )


def _background(dive: Dive, measured: SurfaceLandmarks, options: DetectOptions) -> Background:
    """The solution's deviation field where there is one, else running medians of the landmarks."""
    s = dive.solution
    field = s.deviation_field
    if dive.drawn and field is not None and np.isfinite(field.value).all():
        return FieldBackground(dive.chart, field.origin, field.step, field.value, field.sigma)
    return median_background(measured.foot, measured.offset, options.background)


def _objects(
    found: HullAsFound,
    measured: SurfaceLandmarks,
    background: Background,
    views: CameraViews,
    dive: Dive,
    options: DetectOptions,
) -> tuple[list[Facts], Facts]:
    height = measured.offset - background.at(measured.foot)[0]
    objects, rejected = find_objects(found, measured, height, views, dive.chart, options, dive.drawn)
    rows: list[Facts] = [
        {"id": k + 1, **item.as_json(), "address": dive.address_of(np.array(item.center))} for k, item in enumerate(objects)
    ]
    return rows, {"landmarks_used": len(measured), "not_reported": [item.as_json() for item in rejected]}


def _without_camera(context: Context, dive: Dive, facts: Facts) -> None:
    """The CAD model moved to the DVL's surface; nothing without a CAD model, where surface.ply says it all."""
    if not dive.drawn:
        facts["as_found"] = "no landmarks and no CAD model: the surface from the DVL is what was found"
        context.warn("as_found is absent: there is neither a camera nor a CAD model")
        return
    context.out.arrays("as_found.npz", to_arrays(surface_on_cad_model(dive.base, dive.surface, PIECE_M)))
    facts["as_found"] = "from the DVL's surface"


def _coverage(context: Context, dive: Dive, views: CameraViews | None) -> Facts:
    """Areas seen by each sensor on the base surface, and holes in what the camera (else the DVL) saw."""
    hull = coverage.hull_patches(_pieces(dive))
    scene = Scene(dive.base)
    by_dvl = coverage.covered_by_surface(hull, dive.surface.vertices[dive.surface.support > 0], DVL_REACH_M)
    report: Facts = {"frame": "M" if dive.drawn else "g", "dvl": coverage.area_facts(hull, by_dvl), "camera": None}
    seen = by_dvl
    if views is not None:
        by_camera = find_visibility(views, hull.mesh.vertices, hull.normal, scene)
        report["camera"] = coverage.camera_facts(hull, by_camera, views.camera.fx, len(views))
        seen = by_camera.views > 0
    report["sonar"] = _sonar(context, dive, hull, scene)
    report["holes"] = coverage.find_holes(hull, seen, dive.chart, dive.address_of)
    return report


def _pieces(dive: Dive) -> Mesh:
    return refine_near(dive.base, dive.surface.vertices[::7], PIECE_M, PIECES_REACH_M)


def _sonar(context: Context, dive: Dive, hull: coverage.HullPatches, scene: Scene) -> Facts | None:
    """None when no sonar was carry_over."""
    ingest, settings = context.inputs["ingest"], context.settings["sonar"]
    if settings is None or not (ingest / "sonar.npz").exists():
        return None
    pings = from_arrays(SonarPings, load_arrays(ingest / "sonar.npz"))
    angle = np.zeros(len(pings.t_ns))
    if (ingest / "sonar_tray.npz").exists():
        servo = from_arrays(JointSamples, load_arrays(ingest / "sonar_tray.npz"))
        angle = np.interp(pings.t_ns, servo.t_ns, servo.angle)
    T_x_v = poses.interpolate(dive.solution.t_ns, dive.T_x_v, pings.t_ns)
    T_x_o = T_x_v @ poses.tray_poses(np.array(settings.origin), angle) @ poses.from_mount(settings.mount)
    seen = coverage.visible_to_sonar(hull, pings, T_x_o, math.radians(settings.elevation_deg) / 2, scene)
    return {"pings": len(pings.t_ns), **coverage.area_facts(hull, seen)}


STAGE = Stage(
    name="detect",
    summary="find structures and remesh the hull as found",
    inputs=("ingest", "adjust", "surface"),
    parameters=DetectOptions,
    version=2,
    run=run,
    uses=("tray", "hull", "sonar"),
)
