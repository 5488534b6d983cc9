# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is on the hull: the as-found mesh, objects, and what the survey covered."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np

from hullrecon.artifacts.stage import Context
from hullrecon.detection.as_found.hull_as_found import Fusion, fuse_heights
from hullrecon.detection.base_surface import BaseSurface
from hullrecon.detection.coverage import summarise_coverage
from hullrecon.detection.find_structures import Structures, find_structures
from hullrecon.detection.hull_patches import Facts
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.sonar_visibility import SonarSurvey
from hullrecon.detection.views import CameraViews, views_of_top_camera
from hullrecon.dive.config.schema import HullRegion
from hullrecon.errors import StageError
from hullrecon.geometry.charts.address import AddressSigma
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.frames import Camera
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.solution import Solution
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import AdjustArtifact, InputArtifacts
from hullrecon.steps.keys import TRAY_KEYS
from hullrecon.steps.sonar import ping_poses
from hullrecon.threads import in_threads


def run(context: Context[DetectOptions], fusion: Fusion = fuse_heights) -> None:
    """Find the hull as found, the objects on it and what was covered, and write them.

    With neither a camera nor a CAD model there is no hull as found, and a warning says so. Without
    a CAD model there is no deviation.

    `fusion`: how shapes from single views are combined to heights. hullrecon/studies has published
    variants.
    """
    inputs = InputArtifacts(context.inputs)
    settings = inputs.mounted(context.settings)
    adjusted, surface = _adjusted(inputs), inputs.surface
    solution = adjusted.solution
    depth_sigma_m = adjusted.depth_sigma_m if solution.hull_pose is not None else None
    base = BaseSurface(
        cad_model=inputs.ingest.hull if solution.hull_pose is not None else None,
        surveyed=surface.surface,
        chart=surface.chart,
        result_from_global=solution.result_from_global(),
        frame_spacing_m=settings.read_optional("hull.frame_spacing", float),
        hull_pose=solution.hull_pose,
        depth_known=inputs.ingest.pressure is not None,
        from_dvl=bool(surface.facts.get("returns")),
        position_sigma=_sigma_of_survey(solution, surface.chart, depth_sigma_m),
        depth_sigma_m=depth_sigma_m,
    )
    views = _views(context, inputs, solution)
    sonar, regions = _sonar_survey(context, inputs, solution), _regions(context, base)
    # They run at the same time: neither needs the other, and each uses one core.
    work: dict[str, Callable[[], Any]] = {
        "structures": lambda: find_structures(
            base, solution.landmarks, solution.deviation_field, views, context.parameters, fusion
        ),
        "coverage": lambda: summarise_coverage(base, views, sonar, solution.track(), regions),
    }
    found = context.stream(lambda part: work[part](), list(work), "parts", by=in_threads)
    structures, coverage = cast(tuple[Structures, Facts], tuple(found))
    if structures.as_found is not None:
        context.out.arrays("as_found.npz", to_arrays(structures.as_found))
        if structures.deviation is not None:
            context.out.arrays("deviation.npz", to_arrays(structures.deviation))
    else:
        context.warn("as_found is absent: there is neither a camera nor a CAD model")
    context.out.json("objects.json", {"objects": structures.objects})
    context.out.json("coverage.json", coverage)
    context.out.json("detect.json", structures.facts)


def _adjusted(inputs: InputArtifacts) -> AdjustArtifact:
    """Narrow the artifact of adjust, which is optional for other steps, to one that is there."""
    if inputs.adjust is None:
        raise RuntimeError("the step detect is declared to have the artifact of adjust")
    return inputs.adjust


def _sigma_of_survey(solution: Solution, chart: Chart, depth_sigma_m: float | None) -> AddressSigma:
    """Compute the sigmas of the whole survey's position on the hull and below the water.

    Addresses of objects are given with them. `depth_sigma_m`: sigma of the water surface's height
    in g, given where poses are in M, as their sigmas say nothing of the water. None without a CAD
    model: the depth then has the vertical sigma of the poses.
    """
    track = solution.track()
    along, girth = track.sigma_on_chart(chart)
    if depth_sigma_m is not None:
        return AddressSigma(along=along, girth=girth, depth=depth_sigma_m)
    down = solution.result_from_global().rotation.as_matrix()[:, :, 2]
    depth = track.sigma_towards(np.broadcast_to(down, (len(track.t_ns), 3)))
    return AddressSigma(along=along, girth=girth, depth=float(np.median(depth)))


def _views(
    context: Context[DetectOptions], inputs: InputArtifacts, solution: Solution
) -> CameraViews | None:
    """Place the top camera's images, which show structures and count as covered hull.

    None without a camera, an image or a landmark.
    """
    index = inputs.ingest.image_index(Camera.TOP)
    if index is None or Camera.TOP not in inputs.camera_models:
        return None
    settings = inputs.mounted(context.settings)
    rig = rig_from_settings({key: settings[key] for key in TRAY_KEYS}, inputs.camera_models)
    positions = solution.result_from_global().apply(solution.landmarks.position)
    return views_of_top_camera(
        rig.with_mounts(solution.mounts), solution.track(), index.t_ns, positions
    )


def _sonar_survey(
    context: Context[DetectOptions], inputs: InputArtifacts, solution: Solution
) -> SonarSurvey | None:
    """Place the sonar's pings, to tell which hull they covered.

    None without a sonar. None with a warning if its servo was not logged.
    """
    settings, pings = inputs.mounted(context.settings), inputs.ingest.sonar
    elevation_deg = settings.read_optional("sonar.elevation_deg", float)
    if elevation_deg is None or pings is None:
        return None
    try:
        poses = ping_poses(inputs, settings, solution.track())
    except StageError as error:
        context.warn(f"coverage by sonar is unknown: {error}")
        return None
    return SonarSurvey(pings=pings, poses=poses, half_elevation_rad=math.radians(elevation_deg) / 2)


def _regions(context: Context[DetectOptions], base: BaseSurface) -> tuple[HullRegion, ...]:
    """Read the regions of dive.toml. Without a CAD model there are none, with a warning."""
    regions: tuple[HullRegion, ...] = context.settings.read_optional("hull.region", tuple) or ()
    if regions and base.cad_model is None:
        context.warn(
            "coverage is not counted by hull.region: the CAD model was refused, and regions are "
            "parts of it"
        )
        return ()
    return regions
