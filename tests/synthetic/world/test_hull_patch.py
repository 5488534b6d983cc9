# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.hull_patch import HullPatch, HullSkin
from hullrecon.synthetic.hull_shapes import ship_form
from hullrecon.synthetic.options import Ship


@pytest.fixture(scope="module")
def cad_model() -> Mesh:
    return ship_form(Ship())


@pytest.fixture(scope="module")
def patch(cad_model: Mesh) -> HullPatch:
    return HullSkin(cad_model, (24.0, 27.0), zero_z_m=2.0, top_z_m=4.0, down_m=4.0).patch(0)


def test_every_point_lies_on_cad_model(patch: HullPatch, cad_model: Mesh) -> None:
    distance = Scene(cad_model).closest(patch.point.reshape(-1, 3)).distance
    assert np.abs(distance).max() < 1e-4


def test_girth_is_arc_length(patch: HullPatch) -> None:
    step = np.linalg.norm(np.diff(patch.point, axis=1), axis=2)
    np.testing.assert_allclose(step, 0.03, atol=3e-4)
    np.testing.assert_allclose(patch.girth_m, np.round(patch.girth_m / 0.03) * 0.03)


def test_normals_point_away_from_ship(patch: HullPatch) -> None:
    np.testing.assert_allclose(np.linalg.norm(patch.normal, axis=2), 1)
    side = patch.point[..., 2] > 2.0
    bottom = (patch.point[..., 2] < 1e-3) & (np.abs(patch.point[..., 1]) < 2)
    assert side.any()
    assert bottom.any()
    assert (patch.normal[side][:, 1] > 0.99).all()
    assert (patch.normal[bottom][:, 2] < -0.99).all()


def test_girth_is_nothing_at_waterline_asked_for(patch: HullPatch) -> None:
    zero = int(np.argmin(np.abs(patch.girth_m)))
    np.testing.assert_allclose(patch.point[:, zero, 2], 2.0, atol=1e-3)


def test_girth_down_to_flat_is_side_plus_bilge(patch: HullPatch) -> None:
    # radius 1.3: 0.7 of side, then a quarter circle, which is a polygon of 28 points
    flat = patch.girth_m < -(0.7 + 0.5 * np.pi * 1.3) - 0.01
    assert flat.any()
    assert np.abs(patch.point[:, flat, 2]).max() < 1e-3
    assert patch.point[:, ~flat, 2][:, 1:].min() > 1e-4


def test_line_of_constant_girth_keeps_depth_at_bow(cad_model: Mesh) -> None:
    bow = HullSkin(cad_model, (40.0, 46.0), zero_z_m=2.6, top_z_m=4.0, down_m=2.0).patch(0)
    zero = int(np.argmin(np.abs(bow.girth_m)))
    assert np.ptp(bow.point[:, zero, 1]) > 0.8
    assert np.ptp(bow.point[:, zero, 2]) < 5e-3


def test_sheet_stops_at_height_asked_for(patch: HullPatch) -> None:
    assert patch.point[..., 2].max() == pytest.approx(4.0, abs=0.03)


def test_sheet_has_no_more_girth_than_asked_for(patch: HullPatch) -> None:
    assert -4.0 <= patch.girth_m.min() < -3.9


def test_sampling_is_linear_between_nodes(patch: HullPatch) -> None:
    a, g = np.array([0.5 * (patch.along_m[3] + patch.along_m[4])]), np.array([patch.girth_m[7]])
    expected = 0.5 * (patch.point[3, 7] + patch.point[4, 7])
    np.testing.assert_allclose(patch.sample(patch.point, a, g)[0], expected, atol=1e-9)


def test_sampling_outside_holds_edge(patch: HullPatch) -> None:
    out = patch.sample(patch.point, np.array([-100.0]), np.array([-100.0]))
    np.testing.assert_allclose(out[0], patch.point[0, 0], atol=1e-6)


def test_smoothing_turns_facets_into_slow_turn_of_normal(patch: HullPatch) -> None:
    jump = lambda s: np.linalg.norm(np.diff(s.normal, axis=1), axis=2).max()  # noqa: E731
    # a step over the bilge's radius
    assert jump(patch.smooth(0.5)) <= 0.03 / 1.3 < 0.9 * jump(patch)
    np.testing.assert_allclose(np.linalg.norm(patch.smooth(0.5).normal, axis=2), 1)


def test_no_hull_where_dive_is_is_said(cad_model: Mesh) -> None:
    with pytest.raises(InputError, match="no section"):
        HullSkin(cad_model, (80.0, 82.0), zero_z_m=2.0, top_z_m=3.0, down_m=3.0).patch(0)


def test_too_little_skin_is_said(cad_model: Mesh) -> None:
    with pytest.raises(InputError, match="too little skin"):
        HullSkin(cad_model, (24.0, 25.0), zero_z_m=3.0, top_z_m=3.1, down_m=0.1).patch(0)


def test_half_hull_gives_its_own_side() -> None:
    plate = np.array([[0, 0, 0], [10, 0, 0], [10, 3, 0], [0, 3, 0], [10, 3, 4], [0, 3, 4]], float)
    mesh = Mesh(plate, np.array([[0, 2, 1], [0, 3, 2], [3, 4, 2], [3, 5, 4]], np.int32))
    patch = HullSkin(mesh, (4.0, 5.0), zero_z_m=2.0, top_z_m=3.9, down_m=20.0).patch(0)
    assert patch.point[..., 1].min() > -0.05
    assert np.ptp(patch.girth_m) == pytest.approx(6.9, abs=0.1)
