# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import gzip
import re
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.hull.load import clean_mesh, find_degenerate, merge_corners, read_hull
from hullrecon.dive.hull.mesh_files import GLB_HEAD
from hullrecon.dive.hull.mirrors import find_boundary, find_possible_cuts, reflect_mesh
from hullrecon.dive.hull.orientation import orient_outward
from hullrecon.errors import HullreconError, InputError
from hullrecon.findings.finding import Finding, sentences
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.hull_shapes import hull_shape
from hullrecon.synthetic.options import Ship

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


def tube(
    length: float = 40.0,
    sections: int = 30,
    around: int = 24,
    arc=(0.0, 2 * np.pi),
    caps: bool = True,
) -> Mesh:
    """A spindle along x with its axis at the origin: a toy hull. arc: the part of the girth that is
    plated.
    """
    x = np.linspace(-length / 2, length / 2, sections)
    radius = np.maximum(0.02, 4.0 * (1 - (2 * x / length) ** 2))
    angle = np.linspace(*arc, around + 1)
    points = np.stack(
        [
            np.broadcast_to(x[:, None], (sections, around + 1)),
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
        ],
        axis=-1,
    ).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(sections - 1), np.arange(around), indexing="ij")
    a = (i * (around + 1) + j).ravel()
    b, c, d = a + around + 1, a + 1, a + around + 2
    faces = np.vstack([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    if caps:
        ends = np.array([[-length / 2, 0, 0], [length / 2, 0, 0]])
        last = (sections - 1) * (around + 1)
        k, n = np.arange(around), len(points)
        faces = np.vstack(
            [
                faces,
                np.stack([np.full(around, n), k + 1, k], 1),
                np.stack([np.full(around, n + 1), last + k, last + k + 1], 1),
            ]
        )
        points = np.vstack([points, ends])
    return Mesh(points, faces.astype(np.int32))


def faces_away(mesh: Mesh) -> float:
    """Share of the area whose normal points away from the x axis."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = corners.mean(axis=1) * [0, 1, 1]
    size = np.linalg.norm(normal, axis=1)
    away = np.einsum("ni,ni->n", normal, middle) > 0
    return float(size[away].sum() / size.sum())


def save(path: Path, mesh: Mesh, scale: float = 1.0) -> Path:
    trimesh.Trimesh(mesh.vertices * scale, mesh.faces, process=False).export(path)
    return path


@pytest.mark.parametrize("kind", ["stl", "ply", "obj", "off", "glb"])
def test_every_format_gives_the_same_hull(tmp_path, kind):
    notes = []
    mesh = read_hull(save(tmp_path / f"hull.{kind}", tube()), "m", notes)
    assert len(mesh.faces) == len(clean_mesh(tube(), []).faces)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([40, 8, 8], abs=0.1)
    assert "the mesh is watertight" in sentences(notes)
    assert faces_away(mesh) > 0.99


def test_a_gzipped_cad_model_is_read(tmp_path):
    plain = save(tmp_path / "hull.stl", tube())
    (tmp_path / "hull.stl.gz").write_bytes(gzip.compress(plain.read_bytes()))
    assert len(read_hull(tmp_path / "hull.stl.gz", "m", []).faces) == len(
        read_hull(plain, "m", []).faces
    )


@pytest.mark.parametrize("coding", ["utf-16", "utf-8-sig"])
def test_text_in_a_coding_of_windows_is_read(tmp_path, coding):
    text = trimesh.Trimesh(tube().vertices, tube().faces).export(file_type="stl_ascii")
    (tmp_path / "hull.stl").write_bytes(text.encode(coding))
    assert len(read_hull(tmp_path / "hull.stl", "m", []).faces) == len(clean_mesh(tube(), []).faces)


def test_units_are_converted(tmp_path):
    mesh = read_hull(save(tmp_path / "hull.stl", tube(), 1000), "mm", [])
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(40, abs=1e-3)


@pytest.mark.parametrize(
    ("scale", "declared", "guess"),
    [
        (1000, "m", "millimetres (it would be 40.0 m)"),
        (1, "mm", "metres (it would be 40.0 m)"),
        (100, "m", "centimetres"),
    ],
)
def test_cad_model_in_wrong_units_is_refused_with_likely_ones(tmp_path, scale, declared, guess):
    path = save(tmp_path / "hull.stl", tube(), scale)
    with pytest.raises(InputError) as caught:
        read_hull(path, declared, [])
    assert f"looks like {guess}" in str(caught.value)
    advised = re.findall(r'units = "(\w+)"', caught.value.remedy)
    assert advised
    for unit in advised:
        read_hull(path, unit, [])


def test_a_small_model_is_remarked_not_refused(tmp_path):
    notes = []
    read_hull(save(tmp_path / "hull.stl", tube(), 1 / 40), "m", notes)
    assert any("is it a model?" in line for line in sentences(notes))


def test_axes_in_degrees_are_refused_until_all_are_in_metres(tmp_path):
    hull = tube()
    in_degrees = Mesh(hull.vertices / [64_900.0, 111_300.0, 1.0], hull.faces)
    with pytest.raises(InputError, match="in degrees") as caught:
        read_hull(save(tmp_path / "hull.obj", in_degrees), "m", [])
    assert "all axes in metres" in caught.value.remedy
    assert len(read_hull(save(tmp_path / "metres.obj", hull), "m", []).faces)


def test_corners_within_single_precision_become_one():
    mesh = Mesh(
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e-8, 0, 0], [1, 1, 0]], float),
        np.array([[0, 1, 2], [3, 4, 2]]),
    )
    vertices, faces = merge_corners(mesh.vertices, mesh.faces, 1e-6)
    assert len(vertices) == 4
    assert faces.tolist() == [[0, 1, 2], [0, 3, 2]]


def test_degenerate_and_duplicate_faces_are_removed_and_counted():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    notes = []
    mesh = clean_mesh(
        Mesh(vertices, np.array([[0, 1, 2], [2, 0, 1], [0, 2, 1], [0, 1, 3], [1, 1, 2]], np.int32)),
        notes,
    )
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert len(mesh.vertices) == 3
    assert sentences(notes) == ["2 degenerate faces were removed", "2 duplicate faces were removed"]


def test_a_sliver_is_degenerate_by_its_height_not_by_its_area():
    vertices = np.array([[0, 0, 0], [100, 0, 0], [50, 1e-8, 0], [0, 1e-3, 0], [1e-3, 0, 0]], float)
    assert find_degenerate(
        Mesh(vertices, np.array([[0, 1, 2], [0, 4, 3]], np.int32)), 1e-6
    ).tolist() == [True, False]


def test_holes_are_counted(tmp_path):
    mesh = tube()
    notes = []
    read_hull(
        save(tmp_path / "hull.stl", Mesh(mesh.vertices, np.delete(mesh.faces, 500, axis=0))),
        "m",
        notes,
    )
    assert "the mesh is not watertight: 3 boundary edges" in sentences(notes)


def flipped(mesh: Mesh, which: np.ndarray) -> Mesh:
    faces = mesh.faces.copy()
    faces[which] = faces[which][:, ::-1]
    return Mesh(mesh.vertices, faces)


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_faces_wound_any_way_come_out_outward(share):
    mesh = clean_mesh(tube(), [])
    which = np.random.default_rng(3).random(len(mesh.faces)) < share
    notes = []
    assert faces_away(orient_outward(flipped(mesh, which), notes)) > 0.99
    assert (notes == []) == (share == 0.0)


@pytest.mark.parametrize(
    "arc", [(0, np.pi), (-np.pi / 2, np.pi / 2), (np.pi, 2 * np.pi), (np.pi * 1.2, np.pi * 1.9)]
)
@pytest.mark.parametrize("inverted", [False, True])
def test_open_hull_is_oriented_outward_for_any_winding(arc, inverted):
    mesh = clean_mesh(tube(arc=arc, caps=False), [])
    mesh = flipped(mesh, np.full(len(mesh.faces), inverted))
    assert faces_away(orient_outward(mesh, [])) > 0.99


def test_separate_patches_of_one_hull_each_come_out_outward():
    """As in a CAD model whose plates share no corners; every second one is inverted."""
    parts = [
        tube(arc=(a, a + np.pi / 4), around=6, caps=False)
        for a in np.arange(0, 2 * np.pi, np.pi / 4)
    ]
    shift = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    faces = [(p.faces[:, ::-1] if k % 2 else p.faces) + shift[k] for k, p in enumerate(parts)]
    mesh = Mesh(np.vstack([p.vertices for p in parts]), np.vstack(faces).astype(np.int32))
    assert faces_away(orient_outward(mesh, [])) > 0.99


def test_a_half_hull_stays_one_and_that_is_said(tmp_path):
    half = tube(arc=(-np.pi / 2, np.pi / 2), caps=False)
    cut = Finding("mesh-cut")
    notes = []
    mesh = read_hull(save(tmp_path / "half.stl", half), "m", notes)
    assert len(mesh.faces) == len(clean_mesh(half, []).faces)
    assert cut in notes
    notes = []
    read_hull(save(tmp_path / "whole.stl", tube()), "m", notes)
    # open at its bow, by faces without an area
    read_hull(save(tmp_path / "seam.stl", hull_shape(Ship())), "m", notes)
    assert any("not watertight" in message for message in sentences(notes))
    assert cut not in notes


def test_half_hull_is_cut_at_centreline_and_whole_if_reflected():
    half = clean_mesh(tube(arc=(-np.pi / 2, np.pi / 2), caps=False), [])  # y >= 0
    cuts = find_possible_cuts(half)
    assert cuts[0][0] == 1
    assert cuts[0][1] == pytest.approx(0, abs=1e-9)
    whole = reflect_mesh(half, cuts[:1])
    assert len(whole.faces) == 2 * len(half.faces)
    assert np.ptp(whole.vertices[:, 1]) == pytest.approx(2 * np.ptp(half.vertices[:, 1]))


def test_a_flat_bottom_is_plating_not_a_cut():
    box = trimesh.creation.box((40, 8, 6))
    open_top = Mesh(
        np.asarray(box.vertices),
        np.asarray(box.faces)[np.asarray(box.face_normals)[:, 2] < 0.5].astype(np.int32),
    )
    assert find_possible_cuts(open_top) == [(2, 3.0)]


def test_the_boundary_of_one_triangle_is_its_three_edges():
    assert find_boundary(np.array([[0, 1, 2]], np.int32)).tolist() == [[0, 1], [0, 2], [1, 2]]


def test_a_missing_cad_model_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match=r"hull\.stl is missing"):
        read_hull(tmp_path / "hull.stl", "m", [])
    assert len(read_hull(save(tmp_path / "there.stl", tube()), "m", []).faces)


def test_unread_mesh_format_is_refused_with_the_formats_read(tmp_path):
    (tmp_path / "hull.step").write_text("x")
    with pytest.raises(InputError, match="stl, ply, obj, off, glb"):
        read_hull(tmp_path / "hull.step", "m", [])
    for kind in ("stl", "ply", "obj", "off", "glb"):
        assert len(read_hull(save(tmp_path / f"hull.{kind}", tube()), "m", []).faces)
    with pytest.raises(InputError) as caught:
        read_hull(tmp_path / "hull.gltf", "m", [])
    assert caught.value.remedy.startswith("save it as GLB")


@pytest.mark.parametrize("kind", ["glb", "ply", "off", "stl"])
def test_a_file_that_is_cut_off_is_read_once_it_is_whole(tmp_path, kind):
    path = save(tmp_path / f"hull.{kind}", tube())
    whole = path.read_bytes()
    if kind == "stl":
        mesh = trimesh.Trimesh(tube().vertices, tube().faces, process=False)
        whole = mesh.export(file_type="stl_ascii").encode()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"damaged|cut off") as caught:
        read_hull(path, "m", [])
    assert caught.value.remedy == "copy or export it again"
    path.write_bytes(whole)
    assert len(read_hull(path, "m", []).faces)


@pytest.mark.parametrize("name", ["h.stl", "h.ply", "h.obj", "h.off", "h.glb", "h.stl.gz"])
@pytest.mark.parametrize(
    "content", [b"", b"solid nothing\nendsolid\n", b"\x00" * 84, b"OFF\n1 1 0\n0 0 0\n3 0 7 9\n"]
)
def test_a_file_without_a_mesh_is_an_input_error(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError):
        read_hull(tmp_path / name, "m", [])


def test_coordinates_that_are_not_finite_are_an_input_error(tmp_path):
    mesh = tube()
    mesh.vertices[5] = np.nan
    with pytest.raises(InputError, match="not finite"):
        read_hull(save(tmp_path / "hull.stl", mesh), "m", [])


@QUICK
@given(st.data())
def test_any_damage_to_a_file_gives_a_mesh_or_a_typed_error(tmp_path, data):
    content = bytearray(save(tmp_path / "h.ply", tube(sections=4, around=5)).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (tmp_path / "h.ply").write_bytes(content[: data.draw(st.integers(1, len(content)))])
    try:
        mesh = read_hull(tmp_path / "h.ply", "m", [])
    except HullreconError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.faces.max() < len(mesh.vertices)


def outer_share(mesh: Mesh, middle_y: float) -> float:
    """Share of the area of steep side plating whose normal points away from the middle plane."""
    corners = mesh.vertices[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    off = corners.mean(axis=1)[:, 1] - middle_y
    side = (np.abs(normal[:, 1]) > 0.7 * size) & (np.abs(off) > 0.2 * np.abs(off).max())
    return float(size[side & (normal[:, 1] * off > 0)].sum() / size[side].sum())


@pytest.mark.parametrize(
    ("name", "faces", "said"),
    [
        ("kvlcc2_lq_3dpea.stl", 7060, "degenerate faces"),
        ("wigley.stl.gz", 12892, "12888 of 12892 faces had their normals inward"),
        ("DTC-scaled_decimated30k.stl", 30000, "the mesh is watertight"),
    ],
)
def test_real_hulls_come_out_clean_and_outward(data, name, faces, said):
    notes = []
    mesh = read_hull(data / "hulls" / name, "m", notes)
    assert len(mesh.faces) == faces
    assert any(said in line for line in sentences(notes))
    assert outer_share(mesh, 0.0) > 0.998


def test_one_removed_face_is_told_in_the_singular():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    notes = []
    clean_mesh(Mesh(vertices, np.array([[0, 1, 2], [1, 2, 3], [0, 1, 1]], np.int32)), notes)
    assert sentences(notes) == ["1 degenerate face was removed"]


def test_moebius_strip_has_an_edge_of_inconsistent_winding():
    """A Moebius strip of 10 quads: no orientation agrees across all of its edges."""
    turn = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    along = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(10)])
    across = 0.3 * np.column_stack(
        [np.cos(turn / 2) * along[:, 0], np.cos(turn / 2) * along[:, 1], np.sin(turn / 2)]
    )
    vertices = np.vstack([along - across, along + across])
    faces = []
    for k in range(10):
        low, high = (k, k + 10), (k + 1, k + 11) if k < 9 else (10, 0)
        faces += [[low[0], high[0], high[1]], [low[0], high[1], low[1]]]
    notes = []
    orient_outward(Mesh(vertices, np.array(faces, np.int32)), notes)
    assert any(
        "cannot have a consistent winding on both sides" in line for line in sentences(notes)
    )


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a pointer of Git LFS"),
        (b"ISO-10303-21;\nHEADER;\n", "a STEP file"),
        (b" " * 72 + b"S      1\n1H,,1H;,4HSLOT,37H\n", "an IGES file"),
        (b"<!DOCTYPE html><html>", "a page of the web"),
        (b"# exported\nmtllib a.mtl\nv 0 0 0\n", "an obj file"),
        (b"ply\nformat ascii 1.0\n", "a ply file"),
    ],
)
def test_a_file_that_is_not_what_its_name_says_is_named(tmp_path, data, words):
    (tmp_path / "hull.stl").write_bytes(data)
    with pytest.raises(InputError, match=words):
        read_hull(tmp_path / "hull.stl", "m", [])


def test_a_binary_stl_that_is_cut_off_is_named(tmp_path):
    whole = trimesh.Trimesh(*tube_arrays()).export(file_type="stl")
    (tmp_path / "hull.stl").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"is cut off: it holds \d+ of \d+ faces"):
        read_hull(tmp_path / "hull.stl", "m", [])
    (tmp_path / "hull.stl").write_bytes(whole)  # copied again
    assert len(read_hull(tmp_path / "hull.stl", "m", []).faces)


@pytest.mark.parametrize(
    "form",
    [
        lambda binary, _: b"solid by a yard".ljust(80) + binary[80:] + b"\0its own marks",
        lambda _, text: b"\r\n  " + text,
        lambda _, text: text.replace(b"e+", b"D+").replace(b"e-", b"D-"),
    ],
    ids=["binary that begins with solid and goes on", "after a blank line", "numbers of Fortran"],
)
def test_an_stl_of_an_unusual_form_is_read(tmp_path, form):
    ship = trimesh.Trimesh(*tube_arrays())
    text = re.sub(
        r"-?\d+\.?\d*(?:e[-+]\d+)?",
        lambda number: f"{float(number[0]):e}",
        ship.export(file_type="stl_ascii"),
    )
    (tmp_path / "hull.stl").write_bytes(form(ship.export(file_type="stl"), text.encode()))
    mesh = read_hull(tmp_path / "hull.stl", "m", [])
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([40, 8, 8], abs=0.1)


def test_a_compressed_glb_is_refused_with_what_to_do(tmp_path):
    scene = b'{"extensionsRequired": ["KHR_draco_mesh_compression"]}'
    (tmp_path / "hull.glb").write_bytes(GLB_HEAD.pack(b"glTF", 2, 74, len(scene), 0) + scene)
    with pytest.raises(InputError, match="export it without compression"):
        read_hull(tmp_path / "hull.glb", "m", [])


def test_decimal_commas_of_an_stl_are_named(tmp_path):
    text = trimesh.exchange.stl.export_stl_ascii(trimesh.Trimesh(*tube_arrays()))
    (tmp_path / "hull.stl").write_text(text.replace(".", ","))
    with pytest.raises(InputError, match="decimal commas"):
        read_hull(tmp_path / "hull.stl", "m", [])


def test_an_obj_that_counts_from_zero_is_refused(tmp_path):
    vertices, faces = tube_arrays()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    for first, refused in ((0, True), (1, False)):
        of_faces = [f"f {a}//1 {b}//1 {c}//1" for a, b, c in faces + first]
        (tmp_path / "hull.obj").write_text("\n".join([*lines, *of_faces]))
        with pytest.raises(InputError, match="from 0") if refused else nullcontext():
            assert len(read_hull(tmp_path / "hull.obj", "m", []).faces)


def test_a_binary_stl_of_the_other_order_of_bytes_is_named(tmp_path):
    whole = trimesh.Trimesh(*tube_arrays()).export(file_type="stl")
    count = len(tube_arrays()[1])
    (tmp_path / "hull.stl").write_bytes(whole[:80] + count.to_bytes(4, "big") + whole[84:])
    with pytest.raises(InputError, match="begin with their high bytes"):
        read_hull(tmp_path / "hull.stl", "m", [])


def test_a_body_far_from_the_ship_is_refused(tmp_path):
    ship = trimesh.Trimesh(*tube_arrays())
    box = trimesh.creation.box((2.0, 2.0, 1.0))
    box.apply_translation((90.0, 0.0, 0.0))
    trimesh.util.concatenate([ship, box]).export(tmp_path / "hull.stl")
    with pytest.raises(InputError, match=r"12 of .* faces of hull\.stl lie or reach far"):
        read_hull(tmp_path / "hull.stl", "m", [])
    ship.export(tmp_path / "hull.stl")  # what is no hull was removed
    assert len(read_hull(tmp_path / "hull.stl", "m", []).faces)


def test_two_ships_in_one_file_are_told(tmp_path):
    ship = trimesh.Trimesh(*tube_arrays())
    other = ship.copy()
    other.apply_translation((0.0, 30.0, 0.0))
    said = []
    trimesh.util.concatenate([ship, other]).export(tmp_path / "hull.stl")
    read_hull(tmp_path / "hull.stl", "m", said)
    (words,) = (note.sentence for note in said if note.code == "mesh-bodies")
    assert "two bodies" in words
    assert "(the one is 40.0 m long, the other 40.0 m)" in words


def tube_arrays():
    mesh = tube()
    return mesh.vertices, mesh.faces
