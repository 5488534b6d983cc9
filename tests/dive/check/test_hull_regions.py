# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `check` says of the regions of the hull."""

import numpy as np
import pytest

from hullrecon.dive.check.hull_checks import describe_regions
from hullrecon.dive.config.schema import Hull, HullRegion
from hullrecon.findings.finding import sentences
from hullrecon.geometry.meshes.mesh import Mesh
from tests.geometry.conftest import barge

BOW = HullRegion(name="bow", along=(15.0, 19.0), girth=(0.0, 2.0))


def told(*words):
    areas, empty = describe_regions(*words)
    return sentences(areas), sentences(empty)


def hull(*regions, **more):
    return Hull(mesh="h.stl", region=regions, **more)


def test_a_model_with_y_up_is_counted_by_the_pose_that_says_so():
    mesh = barge()
    # y of the file is up
    turned = Mesh(mesh.vertices @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), mesh.faces)
    lines, _ = told(hull(BOW, pose=(0, 0, 0, -90, 0, 0)), turned)
    assert lines == ["region bow: 8.0 m2 of the CAD model"]


def test_regions_are_told_with_area_or_how_far_the_hull_reaches():
    far = HullRegion(name="far", along=(30.0, 40.0))
    lines, (warning,) = told(hull(BOW, far), barge())
    assert lines == ["region bow: 8.0 m2 of the CAD model"]
    assert warning.startswith("hull.region far holds no hull: the CAD model reaches from 0.")
    assert warning.endswith("4.7 m in girth")


@pytest.mark.parametrize("mesh", [None, Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))])
def test_without_a_hull_nothing_is_counted(mesh):
    lines, warnings = told(hull(BOW), mesh)
    assert lines == []
    assert len(warnings) == (mesh is not None)


def test_region_is_counted_from_bow_and_aft_perpendicular():
    mesh = barge()
    turned = Mesh(mesh.vertices @ np.diag([-1.0, -1.0, 1.0]), mesh.faces)
    astern = HullRegion(name="bow", along=(19.0, 23.0), girth=(0.0, 2.0))
    found = told(hull(astern, bow="-x", aft_perpendicular=4.0), turned)
    assert found == (["region bow: 8.0 m2 of the CAD model"], [])
    assert told(hull(BOW), turned)[0] == []
