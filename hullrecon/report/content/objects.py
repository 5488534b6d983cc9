# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The objects' cards on the page, and their pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.report.content.phrases import count, length, probability, with_sigma
from hullrecon.report.figures.plan_view import nice_below
from hullrecon.report.figures.style import picture_uri
from hullrecon.report.survey import ImageSource, Survey
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Pixels

PHOTO_PX = 800  # least width of an object's photo


@dataclass(frozen=True, kw_only=True)
class Crop:
    """A part of an image that shows an object, with its contrast stretched."""

    picture: Pixels  # (h, w, 3) RGB
    outline: Array  # (n, 2) of the object, px in the picture
    pixels_per_m: float  # at the object
    camera: Camera
    row: int  # of the image in the camera's index
    t_ns: int

    @property
    def width(self) -> int:
        """Width of the picture, px."""
        return int(self.picture.shape[1])

    @property
    def height(self) -> int:
        """Height of the picture, px."""
        return int(self.picture.shape[0])

    @property
    def data(self) -> str:
        """The picture as a data URI."""
        return jpeg_uri(self.picture)


def object_crops(survey: Survey) -> dict[int, Crop]:
    """Cut out the picture of each object, by its number, if an image shows it."""
    facts, crops = survey.facts, dict[int, Crop]()
    for found in survey.findings.objects or ():
        crop = best_crop(found, survey.track, facts.rig, facts.images)
        if crop is not None:
            crops[found.id] = crop
    return crops


def photo_jpeg(crop: Crop) -> bytes:
    """Encode an object's picture, enlarged, with its outline drawn in."""
    import cv2

    factor = _enlargement(crop.width, crop.height, PHOTO_PX)
    size = (round(factor * crop.width), round(factor * crop.height))
    picture = np.ascontiguousarray(cv2.resize(crop.picture, size, interpolation=cv2.INTER_CUBIC))
    # in sixteenths of a pixel
    line = np.rint(16 * (factor * (crop.outline + 0.5) - 0.5)).astype(np.int32)
    for color, width in (((0, 0, 0), 5), ((255, 255, 255), 2)):
        cv2.polylines(picture, [line[:, None]], True, color, width, cv2.LINE_AA, shift=4)
    return _jpeg(np.asarray(picture, np.uint8), 90)


@dataclass(frozen=True, kw_only=True)
class ObjectView:
    """One image of a camera at a node of the track."""

    camera: Camera
    model: CameraModel
    camera_from_result: Poses  # T_c_M, T_c_g without a CAD model
    row: int  # of the image in the camera's index


def best_crop(
    found: ReportedObject, track: VehicleTrack, rig: Rig, images: Mapping[Camera, ImageSource]
) -> Crop | None:
    """Cut an object out of the image in which it is nearest to the middle.

    Images are those that the object lists, or all if it lists none. None if no image shows it.
    """
    views = [
        view
        for camera, source in images.items()
        for view in _ranked_views(found, track, rig, camera, source.index)
    ]
    for _, view in sorted(views, key=lambda item: item[0])[:5]:  # some may not decode
        crop = _cut_image(found, view, images[view.camera])
        if crop is not None:
            return crop
    return None


def _ranked_views(
    found: ReportedObject, track: VehicleTrack, rig: Rig, camera: Camera, index: ImageIndex
) -> list[tuple[float, ObjectView]]:
    """Find the images that show the object's centre, each with a score.

    The score is the centre's distance from the image's middle, in half diagonals. Images in which
    the centre lies outside are left out, and images that the object does not list, if it lists any.

    track, rig: poses of the camera. index: the camera's images.
    """
    rows = track.image[:, camera.column]
    # Images that the object lists, None: any
    wanted = _rows_named(found.images, camera, index)
    nodes = np.flatnonzero((rows >= 0) & (np.isin(rows, wanted) if wanted is not None else True))
    if not len(nodes):
        return []
    model = rig.camera_models[camera]
    camera_from_result = rig.image_poses(track, nodes, camera).inverse()
    center = np.tile(np.array(found.center), (len(nodes), 1))
    pixel = model.project(camera_from_result.apply(center))
    size = np.array([model.width, model.height])
    inside = np.all((pixel > 0) & (pixel < size), axis=1)
    score = np.linalg.norm(pixel - size / 2, axis=1) / np.linalg.norm(size / 2)
    return [
        (
            float(score[k]),
            ObjectView(
                camera=camera,
                model=model,
                camera_from_result=camera_from_result[[k]],
                row=int(rows[nodes[k]]),
            ),
        )
        for k in np.flatnonzero(inside)
    ]


def _rows_named(images: Sequence[str], camera: Camera, index: ImageIndex) -> Ints | None:
    """Find the rows of the images of a camera that are named in `images`.

    Names are like camera_top/1777887000468241234.jpg, with the stamp in ns. None if no image, of
    either camera, is named.
    """
    if not images:
        return None
    named = [name.split("/")[1] for name in images if name.startswith(camera.key + "/")]
    stamps = [int(name.split(".")[0]) for name in named]
    return np.flatnonzero(np.isin(index.t_ns, stamps))


def _cut_image(found: ReportedObject, view: ObjectView, source: ImageSource) -> Crop | None:
    """Cut the surroundings of an object out of an image. None if the image cannot be read.

    view: the image, and where its camera was. source: reads it.
    """
    picture = source.read(view.row) if source.index.usable[view.row] else None
    if picture is None:
        return None
    center, outline = np.array([found.center]), np.array(found.outline or [found.center], float)
    pixels = view.model.project(view.camera_from_result.apply(outline))
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    in_camera = view.camera_from_result.apply(center)
    middle = view.model.project(in_camera)[0]
    # The cut reaches over the outline with a margin, at least 0.18 m from the centre. It is 1.35
    # times as wide as high.
    scale = view.model.fx / float(np.linalg.norm(in_camera[0]))  # px a metre
    half = max(0.9 * float(np.abs(pixels - middle).max(initial=0)) + 0.12 * scale, 0.18 * scale)
    reach, size = np.array([1.35 * half, half]), np.array([view.model.width, view.model.height])
    low = np.clip(np.floor(middle - reach), 0, size - 2).astype(int)
    high = np.clip(np.ceil(middle + reach), low + 2, size).astype(int)
    cut = picture[low[1] : high[1], low[0] : high[0]]
    return Crop(
        picture=stretch_contrast(cut),
        outline=pixels - low,
        pixels_per_m=scale,
        camera=view.camera,
        row=view.row,
        t_ns=int(source.index.t_ns[view.row]),
    )


def stretch_contrast(picture: Pixels) -> Pixels:
    """Stretch the contrast from the 1st to the 99th percentile: water leaves a third of it."""
    low, high = np.percentile(picture, (1, 99))
    return np.asarray(np.clip((picture - low) * (245 / max(high - low, 20)) + 5, 0, 255), np.uint8)


def jpeg_uri(picture: Pixels, min_width: int = 560, quality: int = 88) -> str:
    """Encode a picture as a data URI, enlarged if small: a browser would enlarge it with blur."""
    import cv2

    factor = _enlargement(picture.shape[1], picture.shape[0], min_width)
    if factor > 1:
        picture = np.asarray(
            cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC), np.uint8
        )
    return picture_uri(_jpeg(np.asarray(picture, np.uint8), quality), "jpeg")


def _enlargement(width: int, height: int, min_width: int) -> float:
    """Compute the factor, at least 1, that widens a picture to min_width.

    The height stays below four times min_width: the cut of an object at an image's border may be a
    narrow strip.
    """
    return max(1.0, min(min_width / width, 4 * min_width / height))


def _jpeg(picture: Pixels, quality: int) -> bytes:
    """Encode a picture (h, w) or (h, w, 3) RGB as JPEG."""
    import cv2

    ordered = picture[..., ::-1] if picture.ndim == 3 else picture
    done, data = cv2.imencode(
        ".jpg", np.ascontiguousarray(ordered), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    if not done:
        raise ValueError("the picture could not be encoded")
    return bytes(data.tobytes())


CardContext = Mapping[str, object]


def card_context(found: ReportedObject, survey: Survey, crop: Crop | None) -> CardContext:
    """Write the texts of an object's card, with its picture. Rows of what is unknown are left out.

    crop: the picture. None, and the card has none, if no image shows the object.
    """
    rows = [
        ("Height above the hull around it", with_sigma(found.height, found.height_sigma, "m")),
        ("Extent along the hull, in girth", " × ".join(_extents(found))),
        (
            "Area, volume",
            f"{_scaled(found.area, found.area_sigma, 1e4, 'cm²')}, "
            f"{_scaled(found.volume, found.volume_sigma, 1e3, 'l')}",
        ),
    ]
    if found.open_edge:
        open_edge = f"{100 * found.open_edge:.0f} %"
        words = f"{open_edge}: it may be larger, as the sigmas of its size say"
        rows.append(("Outline beyond which nothing was measured", words))
    if found.deviation is not None:
        distance = with_sigma(found.deviation, found.deviation_sigma, "m")
        rows.append(("Largest distance to the CAD model", distance))
    if found.along is not None and found.girth is not None:
        along = with_sigma(found.along, found.sigma_along, "m")
        girth = with_sigma(found.girth, found.sigma_girth, "m")
        axes = "Along, girth" if survey.is_in_hull_frame else "Along, across"
        rows.append((axes, f"{along}, {girth}"))
    if found.depth is not None:
        depth = with_sigma(found.depth, found.depth_sigma, "m")
        rows.append(("Depth below the water surface", depth))
    sigmas = found.position_sigma or (None, None, None)
    center = ", ".join(
        with_sigma(c, s, "").strip() for c, s in zip(found.center, sigmas, strict=True)
    )
    rows += [
        ("Centre (x, y, z)", f"{center} m in {survey.track.frame}"),
        ("More than half of its top seen in", count(found.views, "view")),
        ("False-alarm probability, anywhere in the survey", probability(found.p_value)),
    ]
    return {
        "id": found.id,
        "kind": "Protrusion" if found.height >= 0 else "Recess",
        "address": found.address,
        "rows": rows,
        "crop": crop and crop_context(crop, found),
    }


@dataclass(frozen=True, kw_only=True)
class ObjectCell:
    """A cell of the table of objects."""

    text: str
    value: float | None = None  # by which the table is sorted, None for words


@dataclass(frozen=True, kw_only=True)
class ObjectRows:
    """The table of objects."""

    headings: Sequence[str]
    rows: Sequence[tuple[int, Sequence[ObjectCell]]]  # cells by each object's number


def object_rows(survey: Survey) -> ObjectRows:
    """Tabulate the objects. Columns that no object fills (a depth, a side) are left out."""
    across = "Girth" if survey.is_in_hull_frame else "Across"
    cells = {found.id: _cells(found, across) for found in survey.findings.objects or ()}
    headings = next(iter(cells.values()), {})
    names = [n for n in headings if any(row[n].text != "–" for row in cells.values())]
    rows = [(number, [row[name] for name in names]) for number, row in cells.items()]
    return ObjectRows(headings=names, rows=rows)


def _cells(found: ReportedObject, across: str) -> dict[str, ObjectCell]:
    """Write an object's cells of the table of objects, by the heading of their column."""
    area = _scaled(found.area, found.area_sigma, 1e4, "cm²")
    return {
        "No.": ObjectCell(text=str(found.id), value=found.id),
        "Kind": ObjectCell(text="protrusion" if found.height >= 0 else "recess"),
        "Height": _number(found.height, found.height_sigma, "m"),
        "Area": ObjectCell(text=area, value=found.area),
        "Along": _number(found.along, found.sigma_along, "m"),
        across: _number(found.girth, found.sigma_girth, "m"),
        "Depth": _number(found.depth, found.depth_sigma, "m"),
        "False alarm": ObjectCell(text=probability(found.p_value), value=found.p_value),
    }


def _number(value: float | None, sigma: float | None, unit: str) -> ObjectCell:
    """Write a cell of a measured value with its sigma, a dash if it was not measured."""
    if value is None:
        return ObjectCell(text="–")
    return ObjectCell(text=with_sigma(value, sigma, unit), value=value)


def _extents(found: ReportedObject) -> list[str]:
    """Write the extents of an object, along the hull and in girth, with their sigmas."""
    sigmas = found.extent_sigma or (None, None)
    return [with_sigma(size, sigma, "m") for size, sigma in zip(found.extent, sigmas, strict=True)]


def _scaled(value: float, sigma: float | None, factor: float, unit: str) -> str:
    """Write a value with its sigma in another unit, both multiplied by `factor`."""
    return with_sigma(factor * value, None if sigma is None else factor * sigma, unit)


def crop_context(crop: Crop, found: ReportedObject) -> CardContext:
    """Prepare an object's picture for the template, with outline, scale bar and source."""
    seconds, rest = divmod(crop.t_ns, 10**9)
    stamp = str(np.datetime64(seconds, "s")).replace("T", " ")
    bar = nice_below(0.35 * crop.width / crop.pixels_per_m)
    return {
        "crop": crop,
        "points": " ".join(f"{u:.1f},{v:.1f}" for u, v in crop.outline),
        "bar_px": bar * crop.pixels_per_m,
        "bar": length(bar),
        "source": f"{crop.camera.key}, image {crop.row}, {stamp}.{rest // 10**6:03d} UTC",
        "alt": f"Object {found.id} in an image of {crop.camera.key}, with its outline.",
    }
