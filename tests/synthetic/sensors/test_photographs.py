# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.synthetic import rendering
from hullrecon.synthetic.atlas import Atlas, PlateAtlas
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import with_options
from hullrecon.synthetic.rendering import photographs
from hullrecon.synthetic.texture import PAINT
from hullrecon.synthetic.vehicle import TRAY_ORIGIN


def test_stereo_rig_gives_two_different_images(dive: Dive) -> None:
    top, bottom = next(photographs(dive))
    assert bottom is not None
    assert top.shape == bottom.shape == (192, 240, 3)
    assert np.abs(top.astype(int) - bottom.astype(int)).mean() > 5


def test_mono_rig_gives_one(dive: Dive) -> None:
    mono = replace(dive, rig=replace(dive.rig, camera_bottom=None))
    _, bottom = next(photographs(mono))
    assert bottom is None


def test_large_hull_painted_by_plates_looks_like_small_one(
    dive: Dive, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The threshold saves memory; it must not show in the statistics of an image."""
    whole = next(photographs(dive))[0].astype(float)
    assert isinstance(rendering._choose_atlas(dive), Atlas)
    monkeypatch.setattr(rendering, "ATLAS_TEXELS", 0)
    assert isinstance(rendering._choose_atlas(dive), PlateAtlas)
    plates = next(photographs(dive))[0].astype(float)
    assert np.abs(whole - plates).mean() > 2  # another texture
    assert plates.mean() == pytest.approx(whole.mean(), rel=0.25)
    assert plates.std() == pytest.approx(whole.std(), rel=0.4)


def test_images_depend_on_frame_and_seed_alone(dive: Dive) -> None:
    first, again = photographs(dive), photographs(dive)
    for _ in range(2):
        np.testing.assert_array_equal(next(first)[0], next(again)[0])
    reseeded = next(
        photographs(replace(dive, spec=with_options(dive.spec, seed=dive.spec.seed + 1)))
    )[0]
    assert (reseeded != next(photographs(dive))[0]).any()


def test_there_are_as_many_frames_as_times(dive: Dive) -> None:
    short = replace(dive, frame_s=dive.frame_s[:3])
    assert sum(1 for _ in photographs(short)) == 3


def test_no_image_is_made_before_it_is_asked_for(
    dive: Dive, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("an image was made")

    monkeypatch.setattr(rendering, "photograph", fail)
    frames: Iterator[object] = photographs(dive)
    with pytest.raises(AssertionError, match="an image was made"):
        next(frames)


def contrast_amidships(dive: Dive) -> float:
    """Return the contrast of what is millimetres large, in the image nearest to the middle of the
    legs.
    """
    camera = dive.motion.in_hull(
        dive.motion.on_tray(dive.frame_s, dive.rig.tray_from_top, TRAY_ORIGIN)
    )
    k = int(np.argmin(np.abs(camera.translation[:, 0] - np.mean(dive.seen_along))))
    image = next(photographs(replace(dive, frame_s=dive.frame_s[k : k + 1])))[0]
    return float(
        np.std(
            cv2.GaussianBlur(image, (0, 0), 1.5).astype(float) - cv2.GaussianBlur(image, (0, 0), 6)
        )
    )


def test_images_of_bare_paint_show_light_and_particles_alone(dive: Dive) -> None:
    bare = replace(dive, spec=with_options(dive.spec, paint_bare_share=1.0))
    assert contrast_amidships(bare) < 0.5 * contrast_amidships(dive)


def test_half_legs_can_be_bare(dive: Dive) -> None:
    spec = with_options(dive.spec, paint_bare_share=0.5)
    paint = rendering._paint(replace(dive, spec=spec))
    middle = np.float32(np.mean(dive.seen_along))
    along = middle + np.tile(np.linspace(-0.7, 0.7, 71, dtype=np.float32), (5, 1))
    seen = paint.look_up(
        along,
        np.tile(np.linspace(-0.4, 0.0, 5, dtype=np.float32)[:, None], (1, 71)),
        np.ones(along.shape, bool),
    )
    assert (seen[along < middle] == PAINT).all()
    assert (seen[along > middle] != PAINT).any(axis=1).mean() > 0.9
