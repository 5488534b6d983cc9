# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures that show nothing, or stand still, are told before other sensors are held to them."""

import numpy as np
import pytest

from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import ImageIndex
from hullrecon.steps.image_check import check_images

COUNT = 30
RANDOM = np.random.default_rng(2)
HULL = np.kron(RANDOM.integers(0, 255, (COUNT, 16, 16)), np.ones((8, 8))).astype(np.uint8)


def found(pictures):
    none = np.zeros(COUNT, np.int64)
    index = ImageIndex(
        t_ns=np.arange(COUNT) * 10**9,
        file=np.array([""] * COUNT),
        offset=none,
        size=none,
        usable=np.ones(COUNT, bool),
    )
    return check_images({Camera.TOP: index}, lambda _, row: pictures[row])


def test_pictures_of_a_hull_are_not_accused():
    assert found(HULL) == []


@pytest.mark.parametrize(
    ("pictures", "code"),
    [
        (np.zeros_like(HULL), "images-blank"),
        (np.full_like(HULL, 255), "images-blank"),
        (np.repeat(HULL[:1], COUNT, axis=0), "images-frozen"),
        (np.concatenate([HULL[:20], 0 * HULL[:10]]), "images-blank-some"),
        (np.concatenate([HULL[:15], np.repeat(HULL[:1], 15, axis=0)]), "images-frozen-some"),
    ],
    ids=["black", "white", "frozen", "dark in the end", "frozen in the end"],
)
def test_pictures_that_tell_no_motion_are_named(pictures, code):
    (finding,) = found(pictures)
    assert finding.code == code
    assert finding.where == "camera_top"
