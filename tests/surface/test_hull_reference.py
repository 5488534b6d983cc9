# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.surface.from_returns import CadHull, UnknownHull
from tests.geometry.conftest import barge

SLAB = Mesh(  # the square z = 1, its outside up
    np.array([[0.0, 0, 1], [4, 0, 1], [4, 4, 1], [0, 4, 1]]),
    np.array([[0, 1, 2], [0, 2, 3]], np.int32),
)


def test_deviation_is_signed_outward_and_nan_without_model() -> None:
    points = np.array([[1.0, 1, 1.2], [2.0, 3, 0.9]])
    np.testing.assert_allclose(CadHull(mesh=SLAB).deviation(points), [0.2, -0.1], atol=1e-9)
    assert np.isnan(UnknownHull().deviation(points)).all()


def test_labels_count_only_where_there_is_a_cad_model() -> None:
    label = np.array([1, 0, 1])
    assert CadHull(mesh=SLAB).on_hull(label).tolist() == [True, False, True]
    assert UnknownHull().on_hull(label).tolist() == [True, True, True]


def test_chart_without_model_is_a_plane_facing_sensors() -> None:
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(0, 4, 50), np.full(50, 2.0), rng.uniform(0, 2, 50)])
    chart = UnknownHull().chart(wall, np.array([[1.0, 0.5, 1], [3.0, 0.5, 1]]))
    offset = chart.to_chart(np.array([[2.0, 1.5, 1.0], [2.0, 2.0, 1.0]]))[:, 2]
    np.testing.assert_allclose(offset, [0.5, 0.0], atol=1e-9)


def test_comparison_with_a_cad_model_is_called_circular() -> None:
    comparison = CadHull(mesh=SLAB).comparison(poses_are_adjusted=False)
    assert comparison["reference"] == "cad"
    assert "circular" in str(comparison["comparison"])
    assert "poses" not in str(comparison["comparison"])
    assert "poses" in str(CadHull(mesh=SLAB).comparison(poses_are_adjusted=True)["comparison"])


def test_comparison_without_a_cad_model_has_no_note() -> None:
    comparison = UnknownHull().comparison(poses_are_adjusted=True)
    assert comparison["reference"] == "survey"
    assert comparison["comparison"] is None


def test_chart_is_upright_whichever_file_axis_is_up() -> None:
    mesh = barge()
    # y is up
    turned = Mesh(mesh.vertices @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), mesh.faces)
    place = np.array([[5.0, 1.0, 3.0 - np.sqrt(8.0)]])
    upright, lying = (
        CadHull(mesh=mesh).chart(place, place),
        CadHull(mesh=turned, up=(0.1, 0.9, 0.0)).chart(place, place),
    )
    found = lying.to_chart(place @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    np.testing.assert_allclose(found, upright.to_chart(place), atol=1e-6)
