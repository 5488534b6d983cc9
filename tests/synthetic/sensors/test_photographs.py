# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import with_options
from hullrecon.synthetic.sensors import photographs as photographs_module
from hullrecon.synthetic.sensors.photographs import photographs
from hullrecon.synthetic.world.plate_atlas import PlateAtlas
from hullrecon.synthetic.world.texture import Atlas


def test_a_stereo_rig_gives_two_different_images(dive: Dive) -> None:
    top, bottom = next(photographs(dive))
    assert bottom is not None
    assert top.shape == bottom.shape == (192, 240, 3)
    assert np.abs(top.astype(int) - bottom.astype(int)).mean() > 5


def test_a_mono_rig_gives_one(dive: Dive) -> None:
    mono = replace(dive, rig=replace(dive.rig, camera_bottom=None))
    _, bottom = next(photographs(mono))
    assert bottom is None


def test_a_large_hull_is_painted_plate_by_plate_and_looks_as_a_small_one(dive: Dive, monkeypatch: pytest.MonkeyPatch) -> None:
    """The threshold saves memory; it must not show in the statistics of an image."""
    whole = next(photographs(dive))[0].astype(float)
    assert isinstance(photographs_module._atlas(dive), Atlas)
    monkeypatch.setattr(photographs_module, "ATLAS_TEXELS", 0)
    assert isinstance(photographs_module._atlas(dive), PlateAtlas)
    plates = next(photographs(dive))[0].astype(float)
    assert np.abs(whole - plates).mean() > 2  # another texture
    assert plates.mean() == pytest.approx(whole.mean(), rel=0.25)
    assert plates.std() == pytest.approx(whole.std(), rel=0.4)


def test_images_depend_on_the_frame_and_the_seed_alone(dive: Dive) -> None:
    first, again = photographs(dive), photographs(dive)
    for _ in range(2):
        np.testing.assert_array_equal(next(first)[0], next(again)[0])
    reseeded = next(photographs(replace(dive, spec=with_options(dive.spec, seed=dive.spec.seed + 1))))[0]
    assert (reseeded != next(photographs(dive))[0]).any()


def test_there_are_as_many_frames_as_times(dive: Dive) -> None:
    short = replace(dive, frame_s=dive.frame_s[:3])
    assert sum(1 for _ in photographs(short)) == 3


def test_no_image_is_made_before_it_is_asked_for(dive: Dive, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("an image was made")

    monkeypatch.setattr(photographs_module, "photograph", fail)
    frames: Iterator[object] = photographs(dive)
    with pytest.raises(AssertionError, match="an image was made"):
        next(frames)
