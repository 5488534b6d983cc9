# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import as_found_surface, surface_on_cad_model
from hullrecon.records.surface import Surface


def test_support_is_zero_where_nothing_was_measured(scenery, found) -> None:
    surface = as_found_surface(found, scenery.measured)
    assert (surface.support[~found.measured] == 0).all()
    assert np.median(surface.support[found.measured]) >= 3
    assert np.allclose(surface.deviation, surface.vertices[:, 1] - 2)


def test_sigma_holds_what_all_landmarks_share(scenery, found) -> None:
    surface = as_found_surface(found, scenery.measured)
    assert surface.sigma[found.measured].min() >= 0.004
    assert np.allclose(
        surface.sigma[found.measured] ** 2, found.sigma[found.measured] ** 2 + 0.004**2
    )


def _dvl(deviation: float) -> Surface:
    x, z = np.meshgrid(np.arange(1, 2.01, 0.1), np.arange(0.5, 1.51, 0.1))
    vertices = np.column_stack([x.ravel(), np.full(x.size, 2 + deviation), z.ravel()])
    n = len(vertices)
    return Surface(
        vertices=vertices,
        faces=np.zeros((0, 3), np.int32),
        deviation=np.full(n, deviation),
        sigma=np.full(n, 0.01),
        support=np.full(n, 4),
    )


def test_the_cad_model_is_moved_to_the_dvls_surface_where_there_is_one(wall) -> None:
    moved = surface_on_cad_model(wall, _dvl(0.03), 0.12)
    x, y, z = moved.vertices.T
    inside = (x > 1) & (x < 2) & (z > 0.5) & (z < 1.5)
    assert np.allclose(y[inside], 2.03)
    assert (moved.support[inside] == 4).all()
    assert np.allclose(moved.sigma[inside], np.hypot(0.01, 0.01))


def test_far_from_the_dvls_surface_the_cad_model_stays_and_is_unseen(wall) -> None:
    moved = surface_on_cad_model(wall, _dvl(0.03), 0.12)
    far = moved.vertices[:, 0] > 2.5
    assert np.allclose(moved.vertices[far, 1], 2.0)
    assert (moved.support[far] == 0).all()
    assert np.isnan(moved.sigma[far]).all()
    assert moved.deviation[far] == pytest.approx(0.0)
