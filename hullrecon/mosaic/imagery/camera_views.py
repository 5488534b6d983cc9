# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive as views of the hull: their poses, footprints and light."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.grid import TexelGrid, Window, grid_around
from hullrecon.mosaic.imagery.radiometry import (
    FIELD,
    FLOOR,
    LightModel,
    LightSamples,
    Part,
    Picture,
    first_fields,
    solve_light,
)
from hullrecon.mosaic.mosaic_surface import MosaicSurface, find_visible, sample_surface
from hullrecon.mosaic.stream import Stream
from hullrecon.native import project_into
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import Rig
from hullrecon.typing import Array, Floats32, Ints, Mask


class ImageView(Protocol):
    """An image of a camera or a sonar, with its pose."""

    @property
    def center(self) -> Array:
        """Position (3,) m of the instrument in the surface's frame."""

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project points (n, 3) m into the picture. NaN where it does not show them.

        Returns
        -------
        pixel
            (n, 2) px.
        ratio
            (n,) r / R: distance of the pixel from the best place in the image (of a camera the
            middle) over the largest such distance (docs/methods.md 13, 14).
        """

    def least_ratio(self, center: Array, radius: Array) -> Array:
        """Compute a lower bound (n,) of r / R over all points of each of n balls.

        With it views are ruled out for whole blocks of texels. inf where the picture shows no point
        of a ball, 0 where nothing can be said. `center` (n, 3) m and `radius` (n,) m are those of
        the balls.
        """

    def outline(self, surface: MosaicSurface) -> Array:
        """Cast rays spread over the image onto the surface: hits (n, 3) m, NaN where they miss."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture."""

    def picture(self, part: Part) -> Floats32 | None:
        """Read a part (h, w, channels) of the image, corrected, 0 to 255. None if unreadable."""


@dataclass(frozen=True, kw_only=True)
class CameraView:
    """A camera's image as a view of the hull. An `ImageView`."""

    pose: Poses  # one result_from_camera
    camera: CameraModel
    load: Callable[[], Picture | None]  # reads the picture (h, w, channels)
    # Corrects the light in a part of the picture. None: the picture is not corrected.
    light: Callable[[Picture, Part], Floats32] | None = None

    @property
    def center(self) -> Array:
        return np.asarray(self.pose.translation[0])

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project points. The best place is the image's middle, and R is half its diagonal."""
        return project_into(
            points, self._camera_from_frame, self.center, self._parameters, self.size, self._widest
        )

    def least_ratio(self, center: Array, radius: Array) -> Array:
        """Compute a lower bound (n,) of r / R, as of `ImageView.project`, over the points of balls.

        It is r / R of a ball's centre, less how far from it in the image a point of the ball may
        be. inf where the image shows no point of the ball. center, radius: (n, 3) and (n,) m.
        """
        x, y, z = self._in_camera_axes(center)
        nearest = np.maximum(z - radius, 1e-9)
        middle = np.stack([x, y], axis=1) / np.maximum(z, 1e-9)[:, None]
        off_axis = np.linalg.norm(middle, axis=1)
        # With m = x / z of a ball's centre, a point at an offset d from the centre has x / z off m
        # by (d_xy - m d_z) / z
        spread = radius * np.sqrt(1 + off_axis**2) / nearest
        width, height = self.camera.width, self.camera.height
        from_middle = self.camera.distort(middle) - [(width - 1) / 2, (height - 1) / 2]
        least = np.linalg.norm(from_middle, axis=1) - spread * self.camera.largest_slope(
            off_axis + spread
        )
        ratio = np.maximum(least / (0.5 * np.hypot(width, height)), 0)
        ratio[z <= radius] = 0
        # inf behind the camera, or beyond the image's corners
        return np.where((z + radius <= 0) | (ratio > 1), np.inf, ratio)

    def outline(self, surface: MosaicSurface) -> Array:
        """Cast rays through 7 x 7 pixels onto the surface: hits (49, 3) m, NaN where they miss."""
        u, v = np.meshgrid(
            np.linspace(1, self.camera.width - 2, 7), np.linspace(1, self.camera.height - 2, 7)
        )
        rays = (
            self.camera.rays(np.stack([u.ravel(), v.ravel()], axis=1))
            @ self.pose.rotation.as_matrix()[0].T
        )
        # A ray that misses has no end
        distance = surface.scene.cast(np.tile(self.center, (len(rays), 1)), rays)
        return np.asarray(
            self.center + np.where(np.isfinite(distance), distance, np.nan)[:, None] * rays
        )

    @property
    def size(self) -> tuple[int, int]:
        return self.camera.width, self.camera.height

    def picture(self, part: Part) -> Floats32 | None:
        """Read a part of the image, its light evened if a model is given. None if unreadable."""
        raw = self.load()
        if raw is None:
            return None
        return np.asarray(raw[part], np.float32) if self.light is None else self.light(raw, part)

    def _in_camera_axes(self, points: Array) -> Array:
        """Transform points (n, 3) to the camera's axes, (3, n)."""
        from_center = np.ascontiguousarray(points.T) - self.center[:, None]
        return self._camera_from_frame @ from_center

    @cached_property
    def _camera_from_frame(self) -> Array:
        return np.asarray(self.pose.rotation.as_matrix()[0].T)

    @cached_property
    def _parameters(self) -> Array:
        return self.camera.parameters()

    @cached_property
    def _widest(self) -> float:
        """Compute the largest tangent (x / z) of rays that are projected.

        It is half as large again as at the image's borders: far beyond them, distortion might fold
        rays back into the image.
        """
        c = self.camera
        return 1.5 * max(
            c.cx / c.fx, (c.width - c.cx) / c.fx, c.cy / c.fy, (c.height - c.cy) / c.fy
        )


Read = Callable[[int], NDArray[np.uint8] | None]
LIGHT_STEP_M = 0.06  # side of the texels from which the light is estimated
BLOCK = 256  # side of a block of those texels
MARGIN_SHARE = 0.06  # of a footprint's extent


@dataclass(frozen=True, kw_only=True)
class CameraImages:
    """One camera of the rig and its images."""

    camera: CameraModel
    rows: Ints  # (n,) rows of the camera's index of images
    poses: Poses  # (n,) result_from_camera
    read: Read  # reads an image (h, w, 3) uint8 RGB by its row. None if it cannot be read


@dataclass(frozen=True, kw_only=True)
class Footprints:
    """Where k rays of each image meet the surface."""

    point: Array  # (views, k, 3) m, NaN where a ray does not meet it
    at: Array  # (views, k, 2) m, along and girth of these points on the chart
    distance: Array  # (views,) m, median distance from the instrument
    span_m: float  # the largest of all distances, 0 when no image meets the surface


def images_of_camera(
    rig: Rig, track: VehicleTrack, camera: Camera, usable: Mask, read: Read
) -> CameraImages:
    """Collect a camera's usable images with their poses along a track.

    Parameters
    ----------
    rig, track
        Mount and calibration of the camera, and the vehicle's poses. The images' poses, which
        follow, are in the frame of the track.
    camera
        Which camera of the rig it is.
    usable
        Whether each row of the camera's index of images is used.
    read
        Reads an image by its row.
    """
    nodes = np.flatnonzero(track.image[:, camera.column] >= 0)
    nodes = nodes[usable[track.image[nodes, camera.column]]]
    return CameraImages(
        camera=rig.camera_models[camera],
        rows=track.image[nodes, camera.column],
        poses=rig.image_poses(track, nodes, camera),
        read=read,
    )


def plain_views(cameras: Sequence[CameraImages]) -> list[CameraView]:
    """Make views without pictures, for geometry alone, in the order of the cameras."""
    return [
        CameraView(pose=s.poses[i], camera=s.camera, load=lambda: None)
        for s in cameras
        for i in range(len(s.rows))
    ]


def compute_footprints(
    surface: MosaicSurface, image_views: Sequence[ImageView], most_medians: float = float("inf")
) -> Footprints:
    """Find where rays spread over each image meet the surface.

    The footprints give the extent of the mosaic, and which texels a view may see. A view whose rays
    all miss has NaN. `most_medians`: hits farther than this multiple of a view's median distance
    are left out.
    """
    outlines = [image_view.outline(surface) for image_view in image_views]
    ranges = np.array(
        [np.linalg.norm(o - v.center, axis=1) for o, v in zip(outlines, image_views, strict=True)]
    )
    distance = np.array(
        [float(np.median(r[np.isfinite(r)])) if np.isfinite(r).any() else np.nan for r in ranges]
    )
    # Rays that miss or meet the surface too far off have no point, and no place on the chart
    points = np.stack(outlines)
    points[ranges > most_medians * distance[:, None]] = np.nan
    good = np.isfinite(points).all(axis=2)
    at = np.full((*points.shape[:2], 2), np.nan)
    at[good] = surface.chart.to_chart(points[good])[:, :2]
    return Footprints(
        point=points, at=at, distance=distance, span_m=float(ranges.max(initial=0.0, where=good))
    )


def footprint_windows(grid: TexelGrid, footprints: Footprints) -> list[Window]:
    """Find a window around the footprint of each view, outside which it sees no texel.

    It is empty for a view that does not meet the surface. MARGIN_SHARE of the footprint's extent is
    added on each side, as the footprint is known at some rays alone.
    """
    spans = []
    for at in footprints.at:
        good = at[np.isfinite(at).all(axis=1)]
        margin = MARGIN_SHARE * float(np.ptp(good, axis=0).max()) if len(good) else 0.0
        spans.append(grid.window_of(at, margin))
    return spans


def camera_views(cameras: Sequence[CameraImages], light: LightModel | None) -> list[CameraView]:
    """Make views with pictures that are corrected for the light, in the order of the cameras.

    A picture is read when it is asked for. It is not corrected if `light` is None.
    """
    image_views: list[CameraView] = []
    for k, images in enumerate(cameras):
        for i, row in enumerate(images.rows.tolist()):
            image_views.append(
                CameraView(
                    pose=images.poses[i],
                    camera=images.camera,
                    load=partial(images.read, row),
                    light=None
                    if light is None
                    else partial(light.correct, camera=k, view=len(image_views)),
                )
            )
    return image_views


def estimate_light(
    surface: MosaicSurface,
    cameras: Sequence[CameraImages],
    image_views: Sequence[CameraView],
    footprints: Footprints,
    stream: Stream,
) -> LightModel | None:
    """Estimate the light from small copies of all images, at texels LIGHT_STEP_M apart.

    With it lamp, vignetting and brightness of each image are taken out. Where no texel is seen, the
    field is the median of the images, and the gains are zero.

    Parameters
    ----------
    surface
        The hull, which says where several images show the same place.
    cameras, image_views
        Images by camera, and the views of all of them in the same order.
    footprints
        Where rays of the views meet the hull.
    stream
        Maps work over threads.

    Returns
    -------
    LightModel or None
        None when fewer than two images can be read.
    """
    camera = np.concatenate([np.full(len(s.rows), k) for k, s in enumerate(cameras)])
    places = [(k, row) for k, s in enumerate(cameras) for row in s.rows.tolist()]
    thumbnails = list(
        stream(lambda place: _thumbnail(cameras[place[0]].read, place[1]), places, "light")
    )
    good = np.array([t is not None for t in thumbnails])
    if good.sum() < 2:
        return None
    # A first guess of each camera's field, samples of texels that several views show, and the fit
    fields = first_fields([t for t in thumbnails if t is not None], camera[good])
    grid = grid_around(footprints.at.reshape(-1, 2), LIGHT_STEP_M)
    samples = sample_light(
        surface, grid, image_views, footprint_windows(grid, footprints), thumbnails, camera
    )
    return (
        solve_light(samples, fields)
        if len(samples.view)
        else LightModel(log_field=tuple(fields), log_gain=np.zeros(len(image_views)))
    )


def _thumbnail(read: Read, row: int) -> NDArray[np.uint8] | None:
    """Reduce an image to two pixels a side for each cell of the light field. None if unreadable.

    The light is smooth, so that small copies show it, which fit into memory for all images.
    """
    import cv2

    picture = read(row)
    if picture is None:
        return None
    return np.asarray(
        cv2.resize(picture, (2 * FIELD[1], 2 * FIELD[0]), interpolation=cv2.INTER_AREA), np.uint8
    )


def sample_light(
    surface: MosaicSurface,
    grid: TexelGrid,
    image_views: Sequence[CameraView],
    windows: Sequence[Window],
    thumbnails: Sequence[NDArray[np.uint8] | None],
    camera: Ints,
) -> LightSamples:
    """Sample the log intensities of each surface texel in every thumbnail that shows it.

    There are no samples where no view sees the surface.

    Parameters
    ----------
    surface, grid
        The hull, and the texels.
    image_views, windows
        Views, and the texels that each may see.
    thumbnails
        Small copy of each view's image. None where it could not be read.
    camera
        (views,) number of the camera of each view.
    """
    # For each tile and view: view, texel, cell of the light field, and log value, all (n, ...)
    parts: list[tuple[Any, ...]] = []
    for tile in grid.parts(BLOCK):
        patch = sample_surface(surface, grid, tile)
        for view, (image_view, thumbnail) in enumerate(zip(image_views, thumbnails, strict=True)):
            window = windows[view].meet(tile)
            if thumbnail is None or window.empty:
                continue
            part = window.within(tile)
            rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
            # The texels of the tile that the view sees, and where they are in its thumbnail
            known = np.isfinite(patch.point[part][..., 0])
            known[known] = find_visible(
                surface, patch.part(part), np.flatnonzero(known), image_view.center, 0.0
            )[0]
            pixel, ratio = image_view.project(patch.point[part][known])
            in_image = np.isfinite(ratio)  # NaN where the image does not show the point
            share = (pixel[in_image] + 0.5) / [image_view.camera.width, image_view.camera.height]
            texel = (rows * grid.width + columns)[known][in_image]
            log_value = _log_intensity(thumbnail, share)
            parts.append((np.full(len(texel), view), texel, _field_cell(share), log_value))
    if not parts:
        none = np.zeros(0, np.int64)
        return LightSamples(
            view=none, texel=none, cell=none, log_value=np.zeros((0, 3)), camera=camera
        )
    view_of, texel_of, cell_of, value = (np.concatenate(p) for p in zip(*parts, strict=True))
    # Number the texels that were seen from 0 on.
    _, texel_of = np.unique(texel_of, return_inverse=True)
    return LightSamples(
        view=view_of.astype(np.int64),
        texel=texel_of,
        cell=cell_of.astype(np.int64),
        log_value=value,
        camera=camera,
    )


def _field_cell(share: Array) -> Ints:
    """Find the flat cell of the light field at positions (n, 2), as shares of the image's size."""
    row = np.minimum(share[:, 1] * FIELD[0], FIELD[0] - 1).astype(np.int64)
    return row * FIELD[1] + np.minimum(share[:, 0] * FIELD[1], FIELD[1] - 1).astype(np.int64)


def _log_intensity(thumbnail: NDArray[np.uint8], share: Array) -> Array:
    """Read the logarithms (n, 3) of a thumbnail's intensities at positions (n, 2), as shares."""
    size = np.array(thumbnail.shape[1::-1])
    at = np.minimum(share * size, size - 1).astype(int)
    return np.asarray(np.log(np.maximum(thumbnail[at[:, 1], at[:, 0]].astype(float), FLOOR)))
