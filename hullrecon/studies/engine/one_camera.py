# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated dive as a vehicle with one camera sees it: its top camera, with truth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.artifacts.runner import run_chain
from hullrecon.artifacts.stage import settings_for
from hullrecon.dive.config.schema import Tray
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.links import NodePairs
from hullrecon.rig import rig_with_priors
from hullrecon.studies.dive_steps import inputs_of_step
from hullrecon.studies.study import StudyDive
from hullrecon.typing import Array, Ints, Mask, Pixels
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import CameraTrack, depth_priors, track_cameras
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import NodeView

OUTLINE_STEPS = 40  # of an image's side


@dataclass(frozen=True, kw_only=True)
class TrueCamera:
    """A camera along its true path before the hull as it is."""

    model: CameraModel
    hull_from_camera: Poses  # (n) at the nodes
    built: Scene

    def seen_again(self, first: int, second: int, xy: Array) -> Array:
        """Project what pixels of one node's image show into another's, by the truth.

        Parameters
        ----------
        first, second
            The nodes.
        xy
            (n, 2) ideal coordinates in the first.

        Returns
        -------
        Array
            (n, 2) px in the second image, NaN outside of it or where the ray meets no hull.
        """
        ahead = self._points_in_camera_of(first, second, np.hstack([xy, np.ones((len(xy), 1))]))
        with np.errstate(invalid="ignore"):
            pixel = self.model.project(ahead)
            inside = (pixel >= -0.5) & (pixel <= [self.model.width - 0.5, self.model.height - 0.5])
            kept = inside.all(axis=1) & (ahead[:, 2] > 0)
        return np.asarray(np.where(kept[:, None], pixel, np.nan))

    def outline_of(self, second: int, first: int) -> Array:
        """Compute the outline (m, 2) px, in the first image, of the steel in the second image.

        first, second: numbers of the nodes.
        """
        w, h = self.model.width - 1.0, self.model.height - 1.0
        t = np.linspace(0, 1, OUTLINE_STEPS)
        edge = np.vstack(
            [
                np.column_stack([w * t, 0 * t]),
                np.column_stack([w + 0 * t, h * t]),
                np.column_stack([w * (1 - t), h + 0 * t]),
                np.column_stack([0 * t, h * (1 - t)]),
            ]
        )
        ahead = self._points_in_camera_of(second, first, self.model.rays(edge))
        return np.asarray(self.model.project(ahead[ahead[:, 2] > 0.05]))  # not where none is met

    def _points_in_camera_of(self, first: int, second: int, ray: Array) -> Array:
        """Find where rays of a camera meet the hull, in the axes of the camera at another node.

        first, second: the two nodes. ray (n, 3): in the axes of the camera at the first one.
        """
        here, there = self.hull_from_camera[first], self.hull_from_camera[second]
        direction = here.rotation.apply(ray / np.linalg.norm(ray, axis=1, keepdims=True))
        origin = np.tile(here.translation, (len(ray), 1))
        point = origin + self.built.cast(origin, direction)[:, None] * direction
        return there.inverse().apply(point)

    def are_right(self, nodes: tuple[int, int], xy: Array, pixel: Array, within_px: float) -> Mask:
        """Test matches of two nodes' images against the truth.

        Parameters
        ----------
        nodes
            The two nodes.
        xy
            (n, 2) ideal coordinates in the first image.
        pixel
            (n, 2) px in the second image.
        within_px
            Distance from the true place up to which a match is right.
        """
        with np.errstate(invalid="ignore"):
            off = np.linalg.norm(self.seen_again(*nodes, xy) - pixel, axis=1)
        return np.asarray(off < within_px)


@dataclass(frozen=True, kw_only=True)
class OneCameraDive:
    """The images of the top camera, prepared for matching, with what is true of them."""

    worker: MatchWorker
    nodes: list[MatchNode]  # without matches between two cameras
    track: CameraTrack  # dead reckoned
    camera: TrueCamera
    images: ImageStore
    pairs: NodePairs  # as the run compared them

    def view(self, node: int) -> NodeView:
        """Prepare a node's features for matching."""
        return self.worker.view(self.nodes[node])

    def image(self, node: int) -> Pixels:
        """Read a node's image as grey levels."""
        picture = self.images.read(self.nodes[node].image[0])
        if picture is None:
            raise InputError("an image that was matched cannot be read", where=str(node))
        return np.asarray(picture if picture.ndim == 2 else picture.mean(axis=2), np.uint8)

    def pixels(self, view: NodeView, rows: Ints) -> Array:
        """Compute the pixels (n, 2) at which a view's features, given by row, were found."""
        return self.camera.model.distort(view.xy[rows])

    @cached_property
    def across(self) -> list[tuple[int, int]]:
        """Pairs of nodes of different legs that the run joined, or of one leg if there are none."""
        joined = self.pairs.joined
        chosen = joined & self.pairs.across if (joined & self.pairs.across).any() else joined
        return [
            (int(a), int(b))
            for a, b in zip(self.pairs.first[chosen], self.pairs.second[chosen], strict=True)
        ]


def read_one_camera(given: StudyDive) -> OneCameraDive:
    """Bring a dive up to date as far as `links` and read its top camera's images.

    Raises InputError where the dive has no images, or joins no pair of them.
    """
    dive, truth = given.dive, given.truth
    run_chain(dive.chain.up_to("links"), dive.workspace, given.run_context)
    inputs = inputs_of_step(dive, "matches")
    settings = inputs.mounted(settings_for(dive.chain.stage("links"), dive.chain.sections))
    rig = rig_with_priors(settings, inputs.ingest.camera_models)
    pairs = None if inputs.links is None else inputs.links.compared
    if Camera.TOP not in rig.cameras or pairs is None or not pairs.joined.any():
        raise InputError(
            "no two images of the dive were joined",
            where=str(dive.workspace.root),
            remedy="take a dive with images that overlap",
        )
    navigate = inputs.navigate
    path = navigate.trajectory
    none_leads = np.zeros(len(path.t_ns), bool)
    tray_sigma = float(np.radians(settings.read("tray", Tray).sigma_deg))
    track = track_cameras(path, navigate.error_model, rig, tray_sigma, none_leads)
    depths = (
        [None] * len(track)
        if navigate.returns is None
        else depth_priors(track, path, navigate.returns, rig)
    )
    images = path.image.copy()
    images[:, 1:] = -1
    frames = np.abs(truth.t_s[None] - path.t_ns[:, None] / 1e9).argmin(axis=1)
    return OneCameraDive(
        worker=MatchWorker(
            features=dive.workspace.artifact("features"),
            rig=rig,
            options=settings.read("matches", MatchOptions),
        ),
        nodes=[
            MatchNode(image=(int(row[0]), -1), depth=depth, stereo=no_matches())
            for row, depth in zip(images, depths, strict=True)
        ],
        track=track,
        camera=TrueCamera(
            model=rig.model(Camera.TOP),
            hull_from_camera=truth.cameras_at(frames),
            built=truth.built,
        ),
        images=inputs.ingest.images(Camera.TOP, dive.chain.package),
        pairs=pairs,
    )
