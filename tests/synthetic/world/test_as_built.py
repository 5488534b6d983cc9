# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.synthetic.built_hull import AsBuilt, build, crop
from hullrecon.synthetic.hull_patch import HullPatch, HullSkin
from hullrecon.synthetic.hull_shapes import ship_form
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import DiveSpec, Ship, spec_from

CYLINDER = Item("cylinder", 25.3, -0.2, 0.11, (0.16, 0.16))
RECESS = Item("recess", 25.9, 0.0, -0.05, (0.2, 0.2))


@pytest.fixture(scope="module")
def patch() -> HullPatch:
    return HullSkin(ship_form(Ship()), (24.6, 26.6), zero_z_m=2.2, top_z_m=3.0, down_m=1.2).patch(0)


@pytest.fixture(scope="module")
def built(patch: HullPatch) -> AsBuilt:
    return build(spec_from(deviation_sigma_m=0.01), patch, (CYLINDER, RECESS))


def test_structures_stand_their_height_over_steel(built: AsBuilt, patch: HullPatch) -> None:
    for item in (CYLINDER, RECESS):
        a, g = np.array([item.along_m]), np.array([item.girth_m])
        steel, normal = patch.sample(built.steel, a, g), patch.sample(patch.normal, a, g)
        way = Scene(built.mesh).cast(steel + 0.5 * normal, -normal)
        assert 0.5 - way[0] == pytest.approx(item.height_m, abs=2e-4)


def test_away_from_structures_steel_is_deviation_off_cad_model(
    built: AsBuilt, patch: HullPatch
) -> None:
    flat = build(spec_from(deviation_mean_m=-0.013, deviation_sigma_m=0.0), patch, ())
    offset = ((flat.steel - patch.point) * patch.normal).sum(2)
    np.testing.assert_allclose(offset, -0.013, atol=1e-9)
    np.testing.assert_allclose(
        Scene(flat.mesh).closest(flat.steel.reshape(-1, 3)).distance, 0, atol=1e-5
    )


def test_grid_is_6_mm_at_structures_and_30_mm_elsewhere(built: AsBuilt) -> None:
    corner = built.chart[built.mesh.faces].astype(float)
    width = np.ptp(corner[..., 0], axis=1)
    fine = np.hypot(*(corner.mean(1) - [CYLINDER.along_m, CYLINDER.girth_m]).T) < 0.08
    np.testing.assert_allclose(width[fine], 0.006, atol=1e-4)
    far = corner.mean(1)[:, 0] < 25.0
    np.testing.assert_allclose(width[far], 0.03, atol=1e-4)


def test_no_ray_slips_through_where_fine_meets_coarse(built: AsBuilt, patch: HullPatch) -> None:
    random = np.random.default_rng(0)
    a, g = random.uniform(25.0, 26.2, 20000), random.uniform(-0.6, 0.3, 20000)
    point, normal = patch.sample(built.steel, a, g), patch.sample(patch.normal, a, g)
    assert np.isfinite(Scene(built.mesh).cast(point + 0.5 * normal, -normal)).all()


def test_vertices_are_shared(built: AsBuilt) -> None:
    rows = np.round(built.chart.astype(float), 4)
    assert len(np.unique(rows, axis=0)) == len(rows)


def test_normals_and_faces_look_outwards(built: AsBuilt, patch: HullPatch) -> None:
    outward = patch.sample(patch.normal, *built.chart.astype(float).T)
    assert ((built.normal * outward).sum(1) > 0).all()


def test_busy_nodes_are_those_near_structures(built: AsBuilt, patch: HullPatch) -> None:
    i = int(np.argmin(np.abs(patch.along_m - CYLINDER.along_m)))
    j = int(np.argmin(np.abs(patch.girth_m - CYLINDER.girth_m)))
    assert built.busy[i, j]
    assert not built.busy[0, 0]


def test_paint_does_not_refine_grid(patch: HullPatch) -> None:
    plain, painted = (
        build(DiveSpec(), patch, items)
        for items in ((), (replace(CYLINDER, kind="ring", height_m=0.0),))
    )
    assert len(plain.mesh.vertices) == len(painted.mesh.vertices)


def test_crop_keeps_what_lies_in_window(built: AsBuilt) -> None:
    part = crop(built, (25.0, 25.6), (-0.4, 0.0))
    assert 0 < len(part.faces) < len(built.mesh.faces)
    assert part.faces.max() == len(part.vertices) - 1
    assert part.vertices[:, 0].min() >= 25.0 - 0.02
    assert part.vertices[:, 0].max() <= 25.6 + 0.02
