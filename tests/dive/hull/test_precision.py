# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Coordinates of a map: what is refused, and what keeps its millimetres."""

import numpy as np
import pytest
import trimesh
from dive.hull.shapes import box, joined, moved, spindle

from hullrecon.dive.hull.load import clean_mesh, read_hull
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.geometry.meshes.mesh import Mesh

UTM = np.array([573_412.0, 6_020_155.0, -3.8])
SHIP = clean_mesh(spindle(), [])


def write(path, mesh: Mesh, decimals: int = 4, header: str = "", unit: float = 1.0):
    """Write a mesh as text: OBJ or PLY (double), ASCII STL (seven digits), or as binary STL."""
    vertices = mesh.vertices * unit
    if path.suffix == ".stl" and not header:
        trimesh.Trimesh(vertices, mesh.faces, process=False).export(path)
    elif path.suffix == ".stl":
        corners = vertices[mesh.faces]
        loops = "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x:.6e} {y:.6e} {z:.6e}\n" for x, y, z in corner)
            + "endloop\nendfacet\n"
            for corner in corners
        )
        path.write_text(f"{header}\n{loops}endsolid\n")
    elif path.suffix == ".ply":
        kind = header or "double"
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        head += "".join(f"property {kind} {axis}\n" for axis in "xyz")
        head += f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\n"
        faces = np.empty(len(mesh.faces), [("n", "u1"), ("v", "<i4", 3)])
        faces["n"], faces["v"] = 3, mesh.faces
        data = vertices.astype("<f8" if kind == "double" else "<f4").tobytes() + faces.tobytes()
        path.write_bytes(f"{head}end_header\n".encode() + data)
    else:
        lines = [f"v {x:.{decimals}f} {y:.{decimals}f} {z:.{decimals}f}" for x, y, z in vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
        path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("name", "header", "step"),
    [
        ("h.stl", "", "0.5 m"),
        ("h.stl", "solid", "1 m"),  # seven digits
        ("h.ply", "float", "0.5 m"),
    ],
)
def test_single_precision_in_map_coordinates_is_refused(tmp_path, name, header, step):
    path = write(tmp_path / name, moved(SHIP, UTM), header=header)
    with pytest.raises(InputError) as caught:
        read_hull(path, "m", [])
    assert f"stored in steps of {step} there, too coarse" in str(caught.value)


def test_single_precision_in_millimetres_of_a_map_is_refused(tmp_path):
    path = write(tmp_path / "h.stl", moved(SHIP, UTM), unit=1000.0)
    with pytest.raises(InputError, match=r"in steps of 0\.51 m there"):
        read_hull(path, "mm", [])


def test_a_barge_of_eight_corners_as_stl_is_refused(tmp_path):
    with pytest.raises(InputError, match="too coarse"):
        read_hull(write(tmp_path / "h.stl", moved(box([0, 0, 0], [40, 8, 3]), UTM)), "m", [])


@pytest.mark.parametrize(("name", "header"), [("h.obj", ""), ("h.ply", "")])
def test_double_precision_in_map_coordinates_keeps_the_hull(tmp_path, name, header):
    notes = []
    mesh = read_hull(write(tmp_path / name, moved(SHIP, UTM), header=header), "m", notes)
    assert len(mesh.faces) == len(SHIP.faces)
    np.testing.assert_allclose(
        np.sort(mesh.vertices, axis=0), np.sort(SHIP.vertices + UTM, axis=0), atol=1e-4
    )
    assert not any("steps" in line for line in sentences(notes))


def test_what_the_refusal_asks_for_is_read(tmp_path):
    assert len(read_hull(write(tmp_path / "h.stl", SHIP), "m", []).faces) == len(SHIP.faces)
    far = write(tmp_path / "h.obj", moved(SHIP, UTM))
    assert len(read_hull(far, "m", []).faces) == len(SHIP.faces)


def test_a_harbour_grid_of_20_km_is_remarked_not_refused(tmp_path):
    notes = []
    read_hull(write(tmp_path / "h.stl", moved(SHIP, [20_000.3, 4000.1, 0.2])), "m", notes)
    assert "the CAD model's coordinates reach 20020 m and are stored in steps of 0.002 m there" in (
        sentences(notes)
    )


def test_whole_metres_are_no_loss_of_precision(tmp_path):
    pontoon = box([0, 0, 0], [40, 8, 3])
    notes = []
    read_hull(write(tmp_path / "h.obj", moved(pontoon, np.round(UTM)), 0), "m", notes)
    lattice = trimesh.creation.box((40, 8, 4)).subdivide().subdivide()
    local = Mesh(np.asarray(lattice.vertices), np.asarray(lattice.faces, np.int32))
    read_hull(write(tmp_path / "i.obj", local), "m", notes)
    assert not any("stored in steps" in sentence for sentence in sentences(notes))


def test_centimetres_of_a_surveyor_are_read(tmp_path):
    mesh = read_hull(write(tmp_path / "h.obj", moved(SHIP, UTM), decimals=2), "m", [])
    assert np.abs(mesh.vertices.max(axis=0) - (SHIP.vertices + UTM).max(axis=0)).max() <= 0.005


@pytest.mark.parametrize(
    "stray",
    [
        Mesh(np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], float), np.array([[0, 1, 2]])),
        moved(box([-900, -900, 0.0], [900, 900, 0.1]), UTM),
    ],
    ids=["a mark at the origin", "a plane of water"],
)
def test_faces_that_are_no_ship_are_named_not_another_unit(tmp_path, stray):
    """One far corner makes a lattice of the whole model, on which the ship's faces merge."""
    path = write(tmp_path / "hull.obj", joined(moved(SHIP, UTM), stray))
    with pytest.raises(InputError, match=r"1?[12] of \d+ faces of hull.obj lie or reach far") as no:
        read_hull(path, "m", [])
    assert "40 m long" in no.value.what
    assert "set units" not in str(no.value.remedy)
