# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The sources of poses that [Ozog2016 3.3.2] compares, each path registered to the CAD model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hullrecon.adjustment.options import PRODUCT
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import Returns, VehicleTrack
from hullrecon.rig import Rig
from hullrecon.steps import adjust
from hullrecon.steps.artifacts import AdjustArtifact, IngestArtifact, LinksArtifact
from hullrecon.steps.chain import stage
from hullrecon.studies.dive_steps import build_beside, with_stages
from hullrecon.studies.methods.variants import run_to_detect
from hullrecon.studies.paths.path_figures import linked_track, path_by_planes, place_on_cad_model
from hullrecon.studies.study import StudyDive
from hullrecon.typing import Array

RECKONED, PLANES, CAMERA = "dead reckoned", "planes", "planes and camera"
WITHOUT_HULL, ADJUSTED = "bundle adjusted, no hull", "bundle adjusted to the CAD model"
WITHOUT_HULL_STAGE = replace(
    stage("adjust"), run=partial(adjust.run_adjustment, strategy=replace(PRODUCT, hull=False))
)


@dataclass(frozen=True, kw_only=True)
class PlacedPath:
    """A path with the CAD model registered to its returns."""

    track: VehicleTrack  # in M
    rig: Rig  # with the mounts that the source found
    before: Array  # (n, 3) m in M, returns where the truth's pose of the hull puts them
    points: Array  # (n, 3) m in M, returns once registered


@dataclass(frozen=True, kw_only=True)
class PlacedPaths:
    """The paths by their source, and what they have in common."""

    paths: dict[str, PlacedPath]
    returns: Returns
    cad_model: Mesh


def place_paths(given: StudyDive) -> PlacedPaths:
    """Solve the dive by every source of poses, and register each to the CAD model.

    Raises InputError for a dive without a CAD model, DVL ranges or links.
    """
    dive, start = given.dive, given.start
    run_to_detect(dive, given.run_context)
    mesh = IngestArtifact(dive.workspace.artifact("ingest")).hull
    if mesh is None or start.returns is None or dive.workspace.manifest("links") is None:
        raise InputError(
            "sources of poses are compared on a dive with a CAD model, DVL ranges and images",
            where=str(dive.workspace.root),
            remedy="take such a dive",
        )
    links = LinksArtifact(dive.workspace.artifact("links"))
    planar = path_by_planes(dive)
    tracks = {RECKONED: (start.trajectory.track(), start.rig)}
    if planar is not None:
        tracks[PLANES] = (linked_track(start.trajectory, planar), start.rig)
    tracks[CAMERA] = (linked_track(start.trajectory, links.path), start.rig)
    for name, artifact in (
        (WITHOUT_HULL, _adjusted_without_hull(given)),
        (ADJUSTED, AdjustArtifact(dive.workspace.artifact("adjust"))),
    ):
        solution = artifact.solution
        in_global = replace(
            solution.track(), poses=solution.global_from_vehicle, frame=Frame.GLOBAL
        )
        tracks[name] = (in_global, start.rig.with_mounts(solution.mounts))
    hull = given.truth.global_from_hull
    return PlacedPaths(
        paths={
            name: _place(track, rig, start.returns, mesh, hull)
            for name, (track, rig) in tracks.items()
        },
        returns=start.returns,
        cad_model=mesh,
    )


def _place(
    track: VehicleTrack, rig: Rig, returns: Returns, mesh: Mesh, global_from_hull: Poses
) -> PlacedPath:
    """Register the returns on a path to the CAD model, and move the path with them."""
    points = rig.dvl_points(returns, track.path).points[~returns.flagged]
    points = points[np.isfinite(points).all(axis=1)]
    onto = place_on_cad_model(points, mesh, global_from_hull).inverse()
    return PlacedPath(
        track=replace(track, poses=onto @ track.poses, frame=Frame.HULL),
        rig=rig,
        before=global_from_hull.inverse().apply(points),
        points=onto.apply(points),
    )


def _adjusted_without_hull(given: StudyDive) -> AdjustArtifact:
    """Adjust images and navigation alone, where that is out of date."""
    chain = with_stages(given.dive.chain, WITHOUT_HULL_STAGE)
    workspace = build_beside(given.dive, "without hull", "adjust", chain, given.run_context)
    return AdjustArtifact(workspace.artifact("adjust"))
