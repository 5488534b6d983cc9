# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A model stands upright in glTF, whichever axis of its file is up."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.meshes.gltf_axes import gltf_from


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_up_is_y_and_nothing_is_mirrored(axis: int, sign: float) -> None:
    up = sign * np.eye(3)[axis]
    turn = gltf_from(up)
    np.testing.assert_array_equal(turn[:3, :3] @ up, [0, 1, 0])
    assert np.linalg.det(turn) == pytest.approx(1.0)
    assert not (np.signbit(turn) & (turn == 0)).any()


def test_a_model_with_y_up_is_left_as_its_file_has_it() -> None:
    np.testing.assert_array_equal(gltf_from(np.array([0.0, 1, 0])), np.eye(4))
