# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import contextlib
import gzip
import json
import os
import struct

import numpy as np
import pytest
import trimesh

from hullrecon.dive.hull import mesh_files
from hullrecon.dive.hull.load import read_hull
from hullrecon.dive.hull.mesh_files import MOST_GROUPS, prepare
from hullrecon.dive.hull.orientation import orient_outward
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh

TRIANGLE = "v 0 0 0\nv 20 0 0\nv 0 9 0\n"
FACET = (
    "facet normal 0 0 1\nouter loop\nvertex 0.{0} 0 0\nvertex 20.{0} 0 0\n"
    "vertex 0.{0} 9 0\nendloop\nendfacet\n"
)
SOLID = f"solid {{0}}\n{FACET}endsolid {{0}}\n"


def refusal(path, content: bytes) -> str:
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_hull(path, "m", [])
    assert len(str(caught.value).splitlines()) == 1
    assert len(str(caught.value)) < 600
    return str(caught.value)


def glb(document: dict, binary: bytes = b"") -> bytes:
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    out = struct.pack("<II", len(text), 0x4E4F534A) + text
    out += struct.pack("<II", len(binary), 0x004E4942) + binary if binary else b""
    return struct.pack("<4sII", b"glTF", 2, 12 + len(out)) + out


def placed(times: int) -> bytes:
    """A GLB of one mesh of 2000 faces that stands in so many places."""
    faces = np.tile(np.arange(3, dtype=np.uint32), 2000)
    vertices = np.array([[0, 0, 0], [20, 0, 0], [0, 9, 0]], np.float32)
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": faces.nbytes},
    ]
    accessors = [
        {"bufferView": 0, "count": 3, "componentType": 5126, "type": "VEC3"},
        {"bufferView": 1, "count": len(faces), "componentType": 5125, "type": "SCALAR"},
    ]
    return glb(
        {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 36 + faces.nbytes}],
            "bufferViews": views,
            "accessors": accessors,
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "nodes": [{"mesh": 0}] * times,
            "scenes": [{"nodes": list(range(times))}],
            "scene": 0,
        },
        vertices.tobytes() + faces.tobytes(),
    )


@pytest.mark.parametrize(
    "text",
    [
        "v 0 0 0\nv 20 0\nv 0 9 0 1\nf 1 2 3\nf 1 2\n",
        "v 0 0\nv 20 0\nv 0 9\nf 1 2 3\n",
        TRIANGLE + "f 1 2\nf 1 3\n",
        TRIANGLE + "f 1\n",
        TRIANGLE + "f 1 2 3 x\n",
        TRIANGLE + "f 1/2 2/ 3//4\nf 1 2 3 1 2\n",
    ],
)
def test_an_obj_with_uneven_rows_is_a_mesh_or_an_input_error(tmp_path, text):
    (tmp_path / "h.obj").write_text(text)
    with contextlib.suppress(InputError):
        mesh = read_hull(tmp_path / "h.obj", "m", [])
        assert mesh.faces.shape[1] == 3


def test_an_obj_of_flat_vertices_is_an_input_error(tmp_path):
    assert "no OBJ" in refusal(tmp_path / "h.obj", b"v 0 0\nv 20 0\nv 0 9\nf 1 2 3\n")


def test_damaged_gzip_mesh_is_an_input_error(tmp_path):
    packed = bytearray(gzip.compress(os.urandom(300)))
    packed[10] ^= 0xFF
    assert "cannot be read" in refusal(tmp_path / "h.stl.gz", bytes(packed))


def test_a_gzip_bomb_is_refused_before_it_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_files, "FREE_BYTES", 1 << 20)
    assert "unpacks to more than 1 MiB" in refusal(
        tmp_path / "h.stl.gz", gzip.compress(bytes(3 << 20))
    )


def test_a_fifo_as_cad_model_is_refused_in_one_line(tmp_path):
    os.mkfifo(tmp_path / "h.stl")
    with pytest.raises(InputError, match=r"h\.stl cannot be read: it is a FIFO, not a file"):
        read_hull(tmp_path / "h.stl", "m", [])


def test_a_glb_that_claims_values_it_does_not_hold_is_refused(tmp_path):
    accessor = {"count": 500_000_000, "componentType": 5126, "type": "VEC3"}
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    document = {
        "asset": {"version": "2.0"},
        "accessors": [accessor, accessor],
        "bufferViews": [],
        "meshes": meshes,
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    assert "it claims 1000000000 values" in refusal(tmp_path / "h.glb", glb(document))


def test_a_glb_that_places_a_mesh_thousands_of_times_is_refused(tmp_path):
    assert "faces in all" in refusal(tmp_path / "h.glb", placed(1000))
    (tmp_path / "h.glb").write_bytes(placed(3))
    assert len(read_hull(tmp_path / "h.glb", "m", []).faces) == 1  # all are duplicates of one


def test_a_glb_names_no_file_of_its_own(tmp_path):
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 10, "uri": "/etc/hostname"}],
    }
    assert "no GLB" in refusal(tmp_path / "h.glb", glb(document, b"x" * 12))


def test_a_ply_of_very_many_properties_is_refused(tmp_path):
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 10\n"
    properties = b"".join(b"property list uint int p%d\n" % k for k in range(300))
    assert "properties" in refusal(
        tmp_path / "h.ply", head + properties + b"end_header\n" + bytes(5000)
    )


def test_an_obj_of_very_many_groups_is_read_as_one(tmp_path):
    content = TRIANGLE + "".join(f"o a{k}\ng b{k}\nusemtl c\nf 1 2 3\n" for k in range(MOST_GROUPS))
    assert prepare(content.encode(), "obj").count(b"\nf ") == MOST_GROUPS
    (tmp_path / "h.obj").write_text(content)
    assert len(read_hull(tmp_path / "h.obj", "m", []).faces) == 1


def test_an_stl_of_very_many_solids_is_read_as_one(tmp_path):
    content = "".join(SOLID.format(1000 + k) for k in range(MOST_GROUPS))
    assert prepare(content.encode(), "stl").count(b"endsolid") == 1
    (tmp_path / "h.stl").write_text(content)
    assert len(read_hull(tmp_path / "h.stl", "m", []).faces) == MOST_GROUPS


@pytest.mark.parametrize("kind", ["obj", "stl", "ply", "off", "glb"])
def test_a_sound_file_is_parsed_as_it_is(kind):
    data = trimesh.creation.box((20, 4, 3)).export(file_type=kind)
    data = data.encode() if isinstance(data, str) else data
    assert prepare(data, kind) is data


def test_a_short_glb_is_refused():
    with pytest.raises(ValueError, match="header"):
        prepare(b"glTF", "glb")


def test_thousands_of_separate_faces_are_oriented_in_one_search():
    """A search a piece took the square of their number: 20,000 faces took three seconds, a million
    hours.
    """
    count = 5_000
    corners = np.random.default_rng(0).normal(size=(count, 1, 3)) * [20, 4, 4]
    vertices = (corners + np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]])).reshape(-1, 3)
    notes = []
    mesh = orient_outward(
        Mesh(vertices, np.arange(3 * count).reshape(-1, 3).astype(np.int32)), notes
    )
    assert np.sort(mesh.faces, axis=1).tolist() == np.arange(3 * count).reshape(-1, 3).tolist()
