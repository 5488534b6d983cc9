# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""CAD models of the chart are seen from outside, upright."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from hullrecon.geometry.charts.viewing_side import flips

Array = NDArray[np.float64]


class Tube:
    """A hull like a tube about x, radius 2 m: girth from the keel (-z), port (y) positive."""

    ship_axes = np.eye(3)

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        angle = along_girth[:, 1] / 2
        normal = np.stack([0 * angle, np.sin(angle), -np.cos(angle)], axis=1)
        return normal * 2 + np.array([1.0, 0, 0]) * along_girth[:, :1], normal


@pytest.mark.parametrize(("girth", "want"), [(3.0, (True, False)), (-3.0, (False, True))])
def test_port_is_mirrored_along_and_starboard_in_girth(
    girth: float, want: tuple[bool, bool]
) -> None:
    at = np.array([[1.0, girth], [2.0, girth + 0.1], [np.nan, 0.0]])
    assert flips(Tube(), at) == want  # type: ignore[arg-type]


def test_a_chart_seen_from_outside_and_upright_is_left_as_it_is() -> None:
    class Wall:
        ship_axes = np.diag([1.0, -1.0, -1.0])

        def from_chart(self, at: Array) -> tuple[Array, Array]:
            # along x, girth up (-z of g), outward towards the viewer at -y: x cross -z is +y, hence
            # along runs against x
            return np.stack([-at[:, 0], 0 * at[:, 0], -at[:, 1]], axis=1), np.tile(
                [0.0, -1.0, 0.0], (len(at), 1)
            )

    assert flips(Wall(), np.array([[0.0, -1.0], [1.0, -2.0]])) == (False, False)  # type: ignore[arg-type]


def test_a_chart_without_a_known_point_is_left_as_it_is() -> None:
    class Nowhere:
        ship_axes = np.eye(3)

        def from_chart(self, at: Array) -> tuple[Array, Array]:
            return np.full((len(at), 3), np.nan), np.full((len(at), 3), np.nan)

    assert flips(Nowhere(), np.zeros((2, 2))) == (False, False)  # type: ignore[arg-type]
