# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import legs
from benchmarks.legs import nearest_frames


def test_node_stamped_just_after_its_frame_belongs_to_it() -> None:
    frame_s = 1777887000.0 + 0.5 * np.arange(4)
    found = nearest_frames(frame_s, frame_s + np.array([-3e-7, 3e-7, 3e-7, 3e-7]))
    np.testing.assert_array_equal(found, [0, 1, 2, 3])


def test_times_before_and_behind_the_frames_are_of_the_outermost() -> None:
    np.testing.assert_array_equal(
        nearest_frames(np.array([1.0, 2.0, 4.0]), np.array([-5.0, 2.9, 3.1, 9.0])), [0, 1, 2, 2]
    )


@pytest.mark.parametrize("cameras", ["stereo", "mono"])
def test_dive_of_another_drift_reuses_images_and_equals_simulate(
    cameras: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = {
        "legs": 1,
        "leg_length_m": 0.7,
        "cameras": cameras,
        "image_width": 160,
        "image_height": 128,
        "views": 1.0,
        "structures": 1,
        "marks": 0,
        "barnacles": 0,
    }
    monkeypatch.setitem(legs.DIVES, "small", small)
    alone = legs.simulate("small", 3, 300.0, tmp_path / "alone")
    first = legs.simulate("small", 3, 1.0, tmp_path)
    assert (first / "logs" / "dive.mcap").read_bytes() != (
        alone / "logs" / "dive.mcap"
    ).read_bytes()
    monkeypatch.setattr(
        "hullrecon.synthetic.recorder.photographs",
        lambda dive: pytest.fail("an image was rendered"),
    )
    other = legs.simulate("small", 3, 300.0, tmp_path, first)
    files = [p.relative_to(alone) for p in alone.rglob("*") if p.is_file()]
    assert [f for f in files if (alone / f).read_bytes() != (other / f).read_bytes()] == []
