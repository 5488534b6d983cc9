# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sections of hulls whose shape is known by hand: a cylinder and a box."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.errors import InputError
from hullrecon.geometry.charts.section_casting import (
    cast_sections,
    choose_axis_height,
    hull_axes,
    outward_faces,
)
from hullrecon.geometry.charts.sections import Sections
from hullrecon.geometry.meshes.mesh import Mesh, face_normals

QUICK = settings(max_examples=20, deadline=None, derandomize=True)
RADIUS = 3.0  # of the barge of conftest.py, whose centre line lies at z = RADIUS
BEAM, DEPTH = 4.0, 3.0  # of the box


def sections_at(mesh: Mesh, height: float) -> Sections:
    return cast_sections(mesh, height)


def box(length: float = 10.0) -> Mesh:
    """An open box along x: bottom at z = 0 and two sides, faces outward."""
    profile = np.array([[-BEAM / 2, DEPTH], [-BEAM / 2, 0], [BEAM / 2, 0], [BEAM / 2, DEPTH]])
    corner = np.array([[x, y, z] for x in (0.0, length) for y, z in profile])
    faces = np.vstack([[[k, k + 1, k + 4], [k + 1, k + 5, k + 4]] for k in range(3)])
    return Mesh(corner, faces.astype(np.int32))


@pytest.fixture(scope="session")
def round_sections(steel: Mesh) -> Sections:
    return sections_at(steel, RADIUS)


@pytest.fixture(scope="session")
def box_sections() -> Sections:
    return sections_at(box(), 2.0)


def test_the_boxs_faces_point_outward() -> None:
    normal = face_normals(box())
    np.testing.assert_allclose(normal[::2], [[0, -1, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)


def test_cylinder_has_one_radius_below_sheer(
    round_sections: Sections,
) -> None:
    below, above = (
        (np.abs(round_sections.angle) < np.pi / 2 - 0.01),
        (np.abs(round_sections.angle) > np.pi / 2 + 0.01),
    )
    np.testing.assert_allclose(round_sections.radius[:, below], RADIUS, rtol=1e-3)
    assert np.isnan(round_sections.radius[:, above]).all()


def test_the_girth_of_a_cylinder_is_radius_times_angle(round_sections: Sections) -> None:
    known = np.isfinite(round_sections.girth)
    expected = np.broadcast_to(RADIUS * round_sections.angle, known.shape)
    np.testing.assert_allclose(round_sections.girth[known], expected[known], atol=2e-3)


def test_the_girth_of_a_box_is_the_way_around_its_bilge(box_sections: Sections) -> None:
    height = np.array([0.5, 1.0, 2.5])
    side = np.stack([np.full(3, 5.0), np.full(3, BEAM / 2), height], axis=1)
    bottom = np.array([[5.0, 0.4, 0.0], [5.0, -1.5, 0.0]])
    # the corner is cut by a ray's step
    np.testing.assert_allclose(box_sections.girth_at(side), BEAM / 2 + height, atol=0.03)
    np.testing.assert_allclose(
        box_sections.girth_at(side * [1, -1, 1]), -(BEAM / 2 + height), atol=0.03
    )
    np.testing.assert_allclose(box_sections.girth_at(bottom), [0.4, -1.5], atol=2e-4)


def test_girth_grows_with_the_angle_and_is_zero_at_the_keel(box_sections: Sections) -> None:
    for girth in box_sections.girth:
        known = girth[np.isfinite(girth)]
        assert (np.diff(known) > 0).all()
    assert (box_sections.girth[:, len(box_sections.angle) // 2] == 0).all()


@QUICK
@given(along=st.floats(0.1, 9.9), girth=st.floats(-4.5, 4.5))
def test_the_angle_of_a_girth_leads_back_to_that_girth(
    box_sections: Sections, along: float, girth: float
) -> None:
    angle, radius = box_sections.angle_of(np.array([[along, girth]]))
    point = [
        along,
        radius[0] * np.sin(angle[0]),
        box_sections.axis_z - radius[0] * np.cos(angle[0]),
    ]
    assert box_sections.girth_at(np.array([point]))[0] == pytest.approx(girth, abs=1e-6)


@QUICK
@given(along=st.floats(0.1, 9.9), angle=st.floats(-np.pi, np.pi))
def test_a_ray_runs_from_outside_straight_to_the_axis(
    box_sections: Sections, along: float, angle: float
) -> None:
    origin, inward = box_sections.rays(np.array([along]), np.array([angle]))
    axis = [along, box_sections.axis_y, box_sections.axis_z]
    np.testing.assert_allclose(origin[0] + box_sections.reach * inward[0], axis, atol=1e-12)
    assert np.linalg.norm(inward[0]) == pytest.approx(1.0)
    # port is positive
    assert np.sign(origin[0, 1] - axis[1]) == pytest.approx(np.sign(np.sin(angle)), abs=1e-9)
    low, high = box().vertices.min(axis=0), box().vertices.max(axis=0)
    assert ((origin[0] < low) | (origin[0] > high)).any()


def test_girth_is_unknown_off_the_skin_and_beyond_the_ends(box_sections: Sections) -> None:
    away = np.array(
        [[5.0, 0.0, 0.6], [5.0, 0.0, -0.6], [-0.5, 0.0, 0.0], [10.5, 0.0, 0.0], [5.0, 0.0, DEPTH]]
    )
    assert np.isnan(box_sections.girth_at(away)).all()


def test_angle_beyond_sheer_and_ends_is_unknown(box_sections: Sections) -> None:
    sheer = BEAM / 2 + DEPTH
    _, radius = box_sections.angle_of(
        np.array([[5, sheer + 0.1], [5, -sheer - 0.1], [-1, 0], [11, 0], [np.nan, 0], [5, np.nan]])
    )
    assert np.isnan(radius).all()


def test_slack_is_larger_where_section_bends(
    box_sections: Sections,
) -> None:
    step = box_sections.station[1] - box_sections.station[0]
    flat, steep = box_sections.slack_at(np.array([5.0, 5.0]), np.array([0.0, 0.75]))
    assert 0.1 * step <= flat < steep < 0.3


def test_slot_in_bottom_is_bridged(
    box_sections: Sections,
) -> None:
    plain = box()
    slot = np.array([[x, y, 0.0] for x in (0.0, 10.0) for y in (0.5, 0.58)])  # a few rays wide
    corner = np.vstack([plain.vertices, slot])
    bottom = [[1, 8, 5], [8, 10, 5], [9, 2, 11], [2, 6, 11]]
    slotted = sections_at(
        Mesh(corner, np.vstack([plain.faces[[0, 1, 4, 5]], bottom]).astype(np.int32)), 2.0
    )
    np.testing.assert_allclose(slotted.radius, box_sections.radius, atol=2e-3)
    side = np.array([[5.0, BEAM / 2, 1.0]])
    np.testing.assert_allclose(slotted.girth_at(side), box_sections.girth_at(side), atol=2e-3)


def test_rays_count_the_outer_of_two_skins() -> None:
    outer, inner = box(), box()
    tank = inner.vertices * [1.0, 0.5, 0.5] + [0.0, 0.0, 0.6]
    both = Mesh(
        np.vstack([outer.vertices, tank]),
        np.vstack([outer.faces, inner.faces + len(outer.vertices)]),
    )
    np.testing.assert_allclose(
        sections_at(both, 2.0).radius, sections_at(outer, 2.0).radius, atol=1e-9
    )


@pytest.mark.parametrize("turned", [[], [0, 1], [2, 3, 4, 5], [0, 1, 2, 3, 4, 5]])
def test_pieces_that_face_inward_are_turned_and_others_stay(turned: list[int]) -> None:
    plain = box()
    apart = Mesh(
        plain.vertices[plain.faces].reshape(-1, 3), np.arange(18, dtype=np.int32).reshape(-1, 3)
    )
    # the starboard side is a piece of its own, the rest hangs together
    apart.vertices[:6, 1] -= 0.01
    faces = apart.faces.copy()
    faces[turned] = faces[turned][:, ::-1]
    found = outward_faces(
        Mesh(apart.vertices, np.ascontiguousarray(faces)), sections_at(apart, 2.0)
    )
    np.testing.assert_allclose(face_normals(found), face_normals(plain), atol=1e-2)


def test_the_axis_is_as_high_as_its_rays_see_nearly_all(steel: Mesh) -> None:
    height = choose_axis_height(box())
    assert 0.1 * DEPTH <= height <= 0.9 * DEPTH
    below_deck = choose_axis_height(steel)
    assert 0.1 * RADIUS <= below_deck <= 0.9 * RADIUS


def test_bulkheads_alone_have_no_axis() -> None:
    plate = np.array([[0.0, -1, 0], [0, 1, 0], [0, 0, 2]])
    ends = Mesh(
        np.vstack([plate, plate + np.array([10.0, 0, 0])]),
        np.array([[0, 1, 2], [3, 5, 4]], np.int32),
    )
    with pytest.raises(InputError, match="no ray from inside"):
        choose_axis_height(ends)


@pytest.mark.parametrize("vertical", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@given(size=st.permutations([1.0, 4.0, 20.0]))
def test_hull_axes_are_right_handed_axes_of_mesh(
    vertical: int, sign: float, size: list[float]
) -> None:
    up = np.full(3, 0.2)
    up[vertical] = sign
    axes = hull_axes(np.array([np.zeros(3), size]), up)
    np.testing.assert_array_equal(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[2, vertical] == sign
    along = int(np.argmax(np.abs(axes[0])))
    assert axes[0, along] == 1.0
    assert size[along] == max(size[k] for k in range(3) if k != vertical)


@pytest.mark.parametrize(("up", "bow"), [((0, 0, 1), "-x"), ((0, 1, 0), "+x"), ((0, 0, -1), "-x")])
def test_the_bow_lies_where_it_is_said_to(up: tuple[int, int, int], bow: str) -> None:
    size = [np.zeros(3), np.array([20.0, 4.0, 5.0])]
    axes, plain = (
        hull_axes(np.array(size), np.array(up), bow),
        hull_axes(np.array(size), np.array(up)),
    )
    turned = -1.0 if bow == "-x" else 1.0
    # port is on the other side, too
    np.testing.assert_array_equal(axes, np.diag([turned, turned, 1.0]) @ plain)


@pytest.mark.parametrize(
    ("bow", "words"),
    [
        (
            "+y",
            r"the bow cannot lie at \+y: the CAD model is 20.0 m along x, 4.0 m along y "
            r"\(hull.bow\): give \"\+x\" or \"-x\"",
        ),
        (
            "-z",
            r"the bow cannot lie at -z: z is up or down by hull.pose, and the CAD model is 20.0 m "
            "along x",
        ),
    ],
)
def test_a_bow_that_the_model_does_not_have_is_refused(bow: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        hull_axes(np.array([np.zeros(3), [20.0, 4.0, 5.0]]), np.array([0.0, 0.0, 1.0]), bow)
