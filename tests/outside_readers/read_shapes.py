# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""PLY by plyfile, textured meshes by the Khronos validator."""

import json

import numpy as np
import plyfile
import pytest


@pytest.mark.parametrize("name", ["landmarks", "surface", "as_found", "chart"])
def test_plyfile_reads_points_faces_frame_and_unit(deliver, name):
    ply = plyfile.PlyData.read(deliver / f"{name}.ply")
    assert [line.split()[0] for line in ply.comments] == ["frame", "unit"]
    assert "metre" in ply.comments[1]
    points = np.stack([ply["vertex"][axis] for axis in "xyz"], axis=1)
    assert points.dtype == np.float64
    assert np.isfinite(points).all()
    if name != "landmarks":
        faces = np.vstack(ply["face"]["vertex_indices"])
        assert 0 <= faces.min() < faces.max() == len(points) - 1


@pytest.mark.parametrize("name", ["mosaic_optical", "mosaic_sonar"])
def test_the_khronos_validator_finds_nothing_in_a_mesh(deliver, node, name):
    found = node("validate_gltf.mjs", deliver / f"{name}.glb")
    assert (found["issues"]["numErrors"], found["issues"]["numWarnings"]) == (0, 0), found[
        "issues"
    ]["messages"]
    assert found["info"]["totalTriangleCount"] > 10_000
    assert found["info"]["maxAttributes"] == 3  # position, normal, texture


@pytest.mark.parametrize("kind", ["optical", "sonar"])
def test_the_khronos_validator_finds_nothing_in_the_tiles(deliver, node, kind):
    folder = deliver / "tiles" / kind
    open_tiles = [json.loads((folder / "tileset.json").read_text())["root"]]
    named = []
    while open_tiles:
        tile = open_tiles.pop()
        named.append(tile["content"]["uri"])
        open_tiles += tile.get("children", [])
    assert sorted(named) == sorted(
        path.relative_to(folder).as_posix() for path in folder.rglob("*.glb")
    )
    for name in named:
        issues = node("validate_gltf.mjs", folder / name)["issues"]
        assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
