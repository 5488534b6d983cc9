# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hullrecon.detection.options import DetectOptions
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import identity
from hullrecon.records.deliverables import ReportedObject
from hullrecon.studies.structures.thresholds import (
    Remeshed,
    count_raised,
    count_reported,
    patch_areas,
)
from hullrecon.studies.surfaces.regression import fuse_shapes


def lattice(side: int = 21, step_m: float = 0.05) -> Mesh:
    x, y = np.meshgrid(step_m * np.arange(side), step_m * np.arange(side))
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = (
        n.ravel() for n in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(
        np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)]), faces.astype(np.int32)
    )


def test_patches_apart_are_counted_apart_by_their_area() -> None:
    mesh = lattice()
    x, y = mesh.vertices[:, :2].T
    marked = ((x < 0.21) & (y < 0.11)) | ((x > 0.69) & (y > 0.79))
    areas = np.sort(patch_areas(mesh, marked))
    np.testing.assert_allclose(areas, [0.2 * 0.1, 0.3 * 0.2], rtol=1e-9)
    assert len(patch_areas(mesh, np.zeros(len(x), bool))) == 0


def test_a_threshold_of_zero_moves_what_stands_hardly_off(views_at) -> None:  # type: ignore[no-untyped-def]
    """The source's preferred threshold: details, and bare hull with them."""
    x, z = np.meshgrid(np.linspace(-0.12, 0.12, 9), np.linspace(-0.12, 0.12, 9))
    features = np.column_stack([2 + x.ravel(), np.full(81, 2.01), 1 + z.ravel()])
    vertex = np.array([[2.0, 2, 1], [2.05, 2, 1.02]])
    height = np.full(81, 0.01)
    none = fuse_shapes(views_at([2.0]), features, height, vertex, DetectOptions(), 0.0)
    some = fuse_shapes(views_at([2.0]), features, height, vertex, DetectOptions(), 0.02)
    assert none.count.tolist() == [1, 1]
    assert some.count.tolist() == [0, 0]


def test_structures_are_counted_and_bare_hull_that_moved(package: Path) -> None:
    truth = read_truth(package)
    structure = truth.structures()[0]
    axis = np.array(structure.normal)
    across = np.linalg.svd(axis[None])[2][1:]
    flat = lattice(41, 0.05)
    foot = np.array(structure.center) - structure.height * axis
    at = foot + (flat.vertices[:, :2] - 1.0) @ across
    mesh = Mesh(at, flat.faces)
    away = np.linalg.norm(flat.vertices[:, :2] - 1.0, axis=1)
    top = away < 0.5 * min(structure.extent)
    far = np.abs(flat.vertices[:, :2] - [0.1, 0.1]).max(axis=1) < 0.12
    for moved, found, area in ((top, 1, 0.0), (far, 0, 0.2**2), (top | far, 1, 0.2**2)):
        remeshed = Remeshed(
            threshold_m=0.0,
            mesh=mesh,
            raised_m=np.where(moved, structure.height, 0.0),
            moved=moved,
        )
        count = count_raised(remeshed, truth, identity())
        assert count.found == found
        assert count.missed == len(truth.structures()) - found
        assert count.false_area_m2 == pytest.approx(area, abs=0.02)


def test_reported_objects_are_counted_above_the_threshold(package: Path) -> None:
    truth = read_truth(package)
    structure = truth.structures()[0]
    high = ReportedObject(center=structure.center, height=0.09, id=1, views=5, area=0.1)
    x, y, z = structure.center
    false = ReportedObject(center=(x + 9, y, z), height=0.03, id=2, views=5, area=0.02)
    low, mid, top = (count_reported([high, false], t, truth, identity()) for t in (0.0, 0.05, 0.1))
    assert (low.found, low.false, low.false_area_m2) == (1, 1, 0.02)
    assert (mid.found, mid.false) == (1, 0)
    assert (top.found, top.missed) == (0, len(truth.structures()))
