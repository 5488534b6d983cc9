# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which image shows an object, and what is cut out of it."""

from __future__ import annotations

from base64 import b64decode
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from hullrecon.geometry.frames import Camera
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.sensors import ImageIndex
from hullrecon.report.content.objects import best_crop, jpeg_uri, stretch_contrast
from hullrecon.report.survey import ImageSource, Survey


@dataclass(frozen=True)
class Unreadable:
    """Images that do not decode, but for some rows."""

    index: ImageIndex
    readable: tuple[int, ...] = ()

    def read(self, row: int) -> np.ndarray | None:
        return np.full((320, 400, 3), 90, np.uint8) if row in self.readable else None


def crop_of(survey: Survey, found: ReportedObject, source: ImageSource | None = None):  # type: ignore[no-untyped-def]
    images = survey.facts.images if source is None else {Camera.TOP: source}
    return best_crop(found, survey.track, survey.facts.rig, images)


def test_the_named_image_is_shown(survey: Survey, found: ReportedObject) -> None:
    crop = crop_of(survey, found)
    assert crop is not None
    assert crop.row == 2
    assert crop.t_ns == survey.track.t_ns[2]


def test_without_names_the_most_central_view_is_shown(
    survey: Survey, found: ReportedObject
) -> None:
    crop = crop_of(survey, replace(found, images=(), center=(1.5, -1.0, 0.0), outline=()))
    assert crop is not None
    assert crop.row == 3  # x = 0.5 k of the plate: the fourth stands straight before 1.5


def test_an_image_that_does_not_decode_gives_way_to_the_next(
    survey: Survey, found: ReportedObject
) -> None:
    index = survey.facts.images[Camera.TOP].index
    central = replace(found, images=(), center=(1.0, -1.0, 0.0), outline=())
    crop = crop_of(survey, central, Unreadable(index, readable=(1, 3)))
    assert crop is not None
    assert crop.row in (1, 3)


def test_no_readable_image_gives_no_picture(survey: Survey, found: ReportedObject) -> None:
    assert crop_of(survey, found, Unreadable(survey.facts.images[Camera.TOP].index)) is None


def test_an_unusable_image_is_not_read(survey: Survey, found: ReportedObject) -> None:
    index = replace(survey.facts.images[Camera.TOP].index, usable=np.zeros(5, bool))
    assert crop_of(survey, found, Unreadable(index, readable=(0, 1, 2, 3, 4))) is None


def test_an_object_outside_every_image_gives_no_picture(
    survey: Survey, found: ReportedObject
) -> None:
    assert crop_of(survey, replace(found, images=(), center=(50.0, -1.0, 0.0))) is None


def test_an_image_of_another_camera_is_not_taken_for_this_one(
    survey: Survey, found: ReportedObject
) -> None:
    stamp = int(survey.track.t_ns[2])
    assert crop_of(survey, replace(found, images=(f"camera_bottom/{stamp}.jpg",))) is None


def test_a_point_without_outline_gets_a_fixed_field(survey: Survey, found: ReportedObject) -> None:
    crop = crop_of(survey, replace(found, center=(1.0, -1.0, 0.0), outline=()))
    assert crop is not None
    assert crop.outline.shape == (1, 2)
    assert crop.pixels_per_m == pytest.approx(500.0)  # 500 px of focal length at 1 m
    assert crop.height == pytest.approx(2 * 0.18 * 500, abs=3)


def test_contrast_is_stretched_over_the_range() -> None:
    dull = np.linspace(100, 140, 10_000).reshape(100, 100).astype(np.uint8)
    stretched = stretch_contrast(dull)
    assert stretched.min() <= 8
    assert stretched.max() >= 248


def test_an_even_picture_is_not_blown_up_to_noise() -> None:
    even = np.full((40, 40), 100, np.uint8)
    even[0, 0] = 101
    assert np.ptp(stretch_contrast(even).astype(int)) < 20


def test_a_small_cut_is_enlarged_and_a_large_one_kept() -> None:
    def size(width: int) -> tuple[int, int]:
        uri = jpeg_uri(np.full((width // 2, width, 3), 90, np.uint8))
        assert uri.startswith("data:image/jpeg;base64,")
        with Image.open(BytesIO(b64decode(uri.split(",")[1]))) as picture:
            return picture.size

    assert size(100) == (560, 280)
    assert size(800) == (800, 400)


def test_colours_stay_red_green_blue() -> None:
    red = np.zeros((40, 600, 3), np.uint8)
    red[..., 0] = 200
    with Image.open(BytesIO(b64decode(jpeg_uri(red).split(",")[1]))) as picture:
        r, g, b = np.asarray(picture.convert("RGB"))[20, 300]
    assert r > 180
    assert max(g, b) < 30
