# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from dive.hull.shapes import box, joined, moved, spindle

from hullrecon.dive.hull.hidden_faces import leave_out_hidden
from hullrecon.dive.hull.load import clean_mesh
from hullrecon.findings.finding import Finding, sentences
from hullrecon.geometry.meshes.mesh import Mesh

PORT, BELOW = (-np.pi / 2, np.pi / 2), (np.pi, 2 * np.pi)  # plated alone
HULL = box([0, 0, 0], [40, 8, 5])  # 40 m long, with deck


def kept(mesh: Mesh) -> tuple[Mesh, list[Finding]]:
    notes: list[Finding] = []
    return leave_out_hidden(clean_mesh(mesh, []), notes), notes


def corners(mesh: Mesh) -> set[tuple[tuple[float, ...], ...]]:
    return {tuple(sorted(map(tuple, face))) for face in mesh.vertices[mesh.faces].round(6).tolist()}


def with_tunnel(hull: Mesh) -> Mesh:
    """Put a bow thruster's tunnel through the box, 8 m long and 2 m wide, in place of its sides."""
    sides = np.ptp(hull.vertices[hull.faces][:, :, 1], axis=1) == 0
    around = np.linspace(0, 2 * np.pi, 17)
    ring = np.stack([20 + np.cos(around), 0 * around, 2 + np.sin(around)], axis=1)
    points = np.concatenate([ring + np.array([0, y, 0]) for y in np.linspace(0, 8, 9)])
    a = (np.arange(8)[:, None] * 17 + np.arange(16)).ravel()
    faces = np.vstack([np.stack([a, a + 1, a + 17], 1), np.stack([a + 1, a + 18, a + 17], 1)])
    return joined(Mesh(hull.vertices, hull.faces[~sides]), Mesh(points, faces.astype(np.int32)))


@pytest.mark.parametrize(
    "skin",
    [
        HULL,
        spindle(),
        spindle(PORT),
        spindle(BELOW),
        spindle((1.2 * np.pi, 1.9 * np.pi)),
        joined(HULL, box([10, -0.8, 1], [30, -0.3, 1.012])),  # a fin of 12 mm at its side
        joined(HULL, moved(HULL, [0, 8 + 3, 0]), box([0, 0, 6], [40, 19, 8])),  # a catamaran
    ],
)
def test_a_skin_that_is_seen_is_the_same_mesh(skin):
    whole = clean_mesh(skin, [])
    notes: list[Finding] = []
    assert leave_out_hidden(whole, notes) is whole
    assert notes == []


@pytest.mark.parametrize("thickness_m", [0.004, 0.012, 0.05, 1.2])
def test_inner_sides_of_plates_and_double_bottoms_are_left_out(thickness_m):
    inner = box(np.full(3, thickness_m), np.array([40, 8, 5]) - thickness_m)
    mesh, notes = kept(joined(inner, HULL))
    assert corners(mesh) == corners(HULL)
    assert sentences(notes) == [
        "12 of 24 faces were left out, as nothing outside sees them: inner sides of plates, tanks, "
        "structure"
    ]


def test_frames_and_tanks_within_are_left_out():
    frames = [box([x, 0.5, 0.02], [x + 0.01, 7.5, 4.5]) for x in np.arange(1, 39, 2.0)]
    tank = box([5, 2, 1], [15, 6, 3])
    assert corners(kept(joined(HULL, *frames, tank))[0]) == corners(HULL)


@pytest.mark.parametrize("arc", [PORT, BELOW])
def test_half_and_open_hulls_lose_the_inner_sides_of_plates(arc):
    outer, inner = clean_mesh(spindle(arc), []), spindle(arc, inset_m=0.01)
    assert corners(kept(joined(inner, outer))[0]) == corners(outer)


def test_a_hull_in_pieces_with_gaps_between_is_kept_whole():
    """Plates of 2 m with 1 mm between them, and their inner sides 10 mm behind."""
    plates, backs = [], []
    for x in np.arange(0, 40, 2.0):
        for y, z, wide in ((0, 0, (8, 0)), (0, 5, (8, 0)), (0, 0, (0, 5)), (8, 0, (0, 5))):
            low = np.array([x + 5e-4, y, z])
            high = low + np.array([2 - 1e-3, *wide])
            plates.append(sheet(low, high))
            at = np.array([0, 4, 2.5])
            inward = np.where(np.array([0, *wide]) == 0, np.sign(at - low), 0) * [0, 1, 1]
            backs.append(moved(plates[-1], 0.01 * inward))
    ends = [sheet(np.array([x, 0, 0]), np.array([x, 8, 5])) for x in (0.0, 40.0)]
    outer = joined(*plates, *ends)
    mesh, _ = kept(joined(outer, *backs))
    assert corners(mesh) == corners(outer)


def sheet(low, high) -> Mesh:
    """A flat rectangle between two corners that share one coordinate."""
    flat = int(np.argmin(np.abs(high - low)))
    a, b = (k for k in range(3) if k != flat)
    points = np.array([low, low, low, low], float)
    points[1:3, a], points[2:, b] = high[a], high[b]
    return Mesh(points, np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def test_a_tunnel_through_the_hull_is_followed_inward():
    mesh, _ = kept(with_tunnel(HULL))
    tunnel = np.abs(np.hypot(*(mesh.vertices[mesh.faces].mean(axis=1)[:, [0, 2]] - [20, 2]).T) - 1)
    assert (tunnel < 0.03).sum() == 16 * 8 * 2


def test_a_hull_in_map_coordinates_is_seen_alike():
    outer, inner = clean_mesh(spindle(), []), spindle(inset_m=0.01)
    far = moved(joined(inner, outer), [573_412.0, 6_020_155.0, -3.8])
    assert len(kept(far)[0].faces) == len(kept(joined(inner, outer))[0].faces) == len(outer.faces)


def test_the_same_mesh_gives_the_same_bytes():
    mesh = joined(spindle(inset_m=0.01), spindle())
    one, two = kept(mesh)[0], kept(mesh)[0]
    assert one.faces.tobytes() == two.faces.tobytes()
    assert one.vertices.tobytes() == two.vertices.tobytes()
