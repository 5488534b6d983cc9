# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A round hull whose CAD model is drawn in coarse facets: these are not structures, and structures
on them are found.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from detection.conftest import Scenery, landmarks_on_wall, reported, views_along

from hullrecon.detection.as_found.hull_as_found import estimate_hull_as_found
from hullrecon.detection.as_found.landmarks import median_background
from hullrecon.detection.find_structures import BACKGROUND_WIDTH_M
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.tessellation import facet_sagitta

OPTIONS = DetectOptions()
ON_EDGE = (1.2, 1.0)


def faceted(radius_m: float, width_m: float) -> Mesh:
    """A cylinder about z whose outside is +y at (2, 2), in facets of that width; an edge is at x =
    1.2.
    """
    step = width_m / radius_m
    angle = np.arcsin((1.2 - 2) / radius_m) + step * np.arange(-6, 7)
    angle = angle[np.abs(angle) < 1.2]
    z = np.array([0.0, 2.0])
    around = np.stack(
        [2 + radius_m * np.sin(angle), 2 - radius_m + radius_m * np.cos(angle)], axis=1
    )
    vertices = np.concatenate([np.c_[around, np.full(len(around), level)] for level in z])
    n = len(around)
    a = np.arange(n - 1)
    faces = np.concatenate(
        [np.stack([a, a + n, a + 1], axis=1), np.stack([a + 1, a + n, a + n + 1], axis=1)]
    )
    return Mesh(vertices, faces.astype(np.int32))


def round_hull(
    radius_m: float, width_m: float, at: tuple[float, float], height_m: float
) -> Scenery:
    """The smooth hull, with a disc 0.3 m wide of that height at (x, z)."""
    rng = np.random.default_rng(7)
    x, z = rng.uniform(0.4, 3.6, 12000), rng.uniform(0.5, 1.5, 12000)
    smooth = np.stack([x - 2, np.sqrt(radius_m**2 - (x - 2) ** 2)], axis=1) / radius_m
    rise = height_m * (np.hypot(x - at[0], z - at[1]) < 0.15) + rng.normal(0, 0.003, len(x))
    point = np.c_[(radius_m + rise)[:, None] * smooth + [2, 2 - radius_m], z]
    base = faceted(radius_m, width_m)
    near = Scene(base).closest(point)
    measured = replace(
        landmarks_on_wall(x, z, rise),
        position=point,
        foot=near.foot,
        normal=near.normal,
        offset=near.distance,
    )
    chart = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    views = views_along(np.arange(0.5, 3.6, 0.25))
    return Scenery(
        base,
        measured,
        median_background(near.foot, near.distance, BACKGROUND_WIDTH_M),
        views,
        chart,
    )


def heights(
    radius_m: float, width_m: float, at: tuple[float, float], height_m: float
) -> list[float]:
    """Return those of the objects found."""
    scenery = round_hull(radius_m, width_m, at, height_m)
    found = estimate_hull_as_found(
        scenery.base, scenery.measured, scenery.background, scenery.views, OPTIONS
    )
    return [o.height for o in reported(scenery, found)[0]]


@pytest.mark.parametrize(("radius_m", "width_m"), [(2.5, 1.6), (8.0, 2.4), (20.0, 4.0)])
def test_facets_are_no_structures(radius_m: float, width_m: float) -> None:
    assert facet_sagitta(faceted(radius_m, width_m)).max() > OPTIONS.min_height_m
    assert heights(radius_m, width_m, ON_EDGE, 0.0) == []


@pytest.mark.parametrize("at", [ON_EDGE, (2.0, 1.0)])
def test_structure_lower_than_sagitta_of_facets_is_found(
    at: tuple[float, float],
) -> None:
    """They are turned by 11 degrees: over the third of a metre around the disc the curve parts from
    them by 4 cm at most.
    """
    assert facet_sagitta(faceted(20.0, 4.0)).max() == pytest.approx(0.1, abs=0.005)
    assert heights(20.0, 4.0, at, 0.1) == pytest.approx([0.1], abs=0.01)
