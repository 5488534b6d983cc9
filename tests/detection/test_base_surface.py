# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.base_surface import BaseSurface
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_mount, identity
from hullrecon.records.surface import Surface

CHART = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))


@pytest.fixture
def base(wall: Mesh) -> BaseSurface:
    n = len(wall.vertices)
    surveyed = Surface(
        vertices=wall.vertices + np.array([0, 0.01, 0]),
        faces=wall.faces,
        deviation=np.full(n, 0.01),
        sigma=np.full(n, 0.005),
        support=np.ones(n, np.int64),
    )
    return BaseSurface(
        cad_model=wall,
        surveyed=surveyed,
        chart=CHART,
        result_from_global=from_mount([0, 0, 8, 180, 0, 0]),
        frame_spacing_m=None,
    )


def test_the_cad_model_is_the_base_where_there_is_one(base: BaseSurface, wall: Mesh) -> None:
    assert base.mesh is wall
    assert base.frame is Frame.HULL
    assert base.description == "the CAD model"


def test_without_a_cad_model_the_surveyed_surface_is_the_base(base: BaseSurface) -> None:
    bare = replace(base, cad_model=None, result_from_global=identity())
    np.testing.assert_array_equal(bare.mesh.vertices, base.surveyed.vertices)
    assert bare.frame is Frame.GLOBAL
    assert "own surface" in bare.description


def test_an_address_counts_the_depth_from_the_water_surface(base: BaseSurface) -> None:
    # M lies turned over, its origin 8 m deep: a point 2 m above the keel is 6 m below the surface
    assert (
        base.address_of(np.array([1.5, 2.0, 2.0]))
        == "1.50 m along, 2.00 m across, 6.0 m below waterline"
    )
