# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.hull_shapes import hull_from_mesh, hull_shape, ship_form, write_stl
from hullrecon.synthetic.options import DiveSpec, Ship, spec_from


@pytest.fixture(scope="module")
def form() -> Mesh:
    return ship_form(Ship())


def test_form_is_closed_and_faces_outwards(form: Mesh) -> None:
    mesh = trimesh.Trimesh(form.vertices, form.faces, process=True)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0


def test_form_has_asked_length_beam_and_depth(form: Mesh) -> None:
    spec = DiveSpec()
    np.testing.assert_allclose(form.vertices.min(0), [0, -spec.ship.beam_m / 2, 0], atol=1e-9)
    np.testing.assert_allclose(
        form.vertices.max(0),
        [spec.ship.length_m, spec.ship.beam_m / 2, spec.ship.depth_m],
        atol=1e-9,
    )


def test_both_sides_are_mirror_images(form: Mesh) -> None:
    rows = {tuple(v) for v in np.round(form.vertices, 6)}
    assert all((x, -y if y else y, z) in rows for x, y, z in rows)


def test_bilge_amidships_has_asked_radius() -> None:
    spec = spec_from(bilge_radius_m=1.5)
    vertices = ship_form(spec.ship).vertices
    middle = vertices[np.abs(vertices[:, 0] - 25) < 1.0]
    middle = middle[np.abs(middle[:, 0] - middle[0, 0]) < 1e-9]
    y, z = middle[middle[:, 1] > 0][:, 1:].T
    arc = (y > spec.ship.beam_m / 2 - 1.5) & (z < 1.5) & (z > 0)
    assert arc.sum() > 10
    np.testing.assert_allclose(
        np.hypot(y[arc] - (spec.ship.beam_m / 2 - 1.5), z[arc] - 1.5), 1.5, atol=1e-9
    )


def test_bow_curves_along_hull(form: Mesh) -> None:
    breadth = [
        np.ptp(form.vertices[np.abs(form.vertices[:, 0] - x) < 0.6][:, 1]) for x in (30, 38, 44, 49)
    ]
    assert breadth[0] == pytest.approx(9.0)
    assert breadth == sorted(breadth, reverse=True)
    assert breadth[3] < 2


def test_stl_reads_back_as_it_was(form: Mesh, tmp_path: Path) -> None:
    write_stl(tmp_path / "hull.stl", form)
    back = trimesh.load(tmp_path / "hull.stl", process=False)
    np.testing.assert_allclose(back.triangles, form.vertices[form.faces], atol=1e-5)


def test_mesh_is_put_on_its_keel_and_scaled(tmp_path: Path) -> None:
    box = trimesh.creation.box((2.0, 1.0, 0.5))
    box.apply_translation([10, 0, -3])
    box.export(tmp_path / "box.ply")
    mesh = hull_from_mesh(tmp_path / "box.ply", length_m=20)
    np.testing.assert_allclose(mesh.vertices.min(0), [0, -5, 0], atol=1e-5)
    np.testing.assert_allclose(mesh.vertices.max(0), [20, 5, 5], atol=1e-5)


def test_hull_of_takes_mesh_by_its_path(tmp_path: Path) -> None:
    trimesh.creation.box((2.0, 1.0, 0.5)).export(tmp_path / "box.stl")
    mesh = hull_shape(Ship(hull=str(tmp_path / "box.stl"), length_m=8.0))
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(8.0)


def test_mesh_without_triangles_is_refused(tmp_path: Path) -> None:
    (tmp_path / "points.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n"
    )
    with pytest.raises(InputError, match="no triangles"):
        hull_from_mesh(tmp_path / "points.ply")


FLAT = "OFF\n3 1 0\n0 0 0\n0 1 0\n0 0 1\n3 0 1 2\n"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gone.stl", None, "there is no such hull mesh .*gone.stl.: correct --hull"),
        ("hull.txt", "hello", "cannot be read, NotImplementedError file_type 'txt' not supported"),
        ("hull.glb", "hello", "cannot be read, "),
        ("hull.stl", "solid hull\nnonsense", "no triangles"),
        ("hull.off", FLAT, "no length along x"),
    ],
)
def test_file_that_is_no_hull_is_one_line(
    tmp_path: Path, name: str, content: str | None, message: str
) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=message) as refused:
        hull_from_mesh(tmp_path / name, length_m=20)
    assert str(tmp_path / name) in str(refused.value)
    assert "\n" not in str(refused.value)


def test_folder_is_no_hull(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such hull mesh"):
        hull_from_mesh(tmp_path)
