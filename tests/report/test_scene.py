# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the 3-D view is given: the hull without its form plus its form is the hull as found, block
and document agree.
"""

from __future__ import annotations

import json
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest
from report.conftest import FlatChart
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.poses import Poses
from hullrecon.report import scene_view as parts
from hullrecon.report.figures.hull_map import hull_map
from hullrecon.report.scene_view import SceneView, make_scene, relief_of, scene_parts
from hullrecon.report.survey import Survey


def scene_of(survey: Survey) -> SceneView:
    scene = make_scene(survey, hull_map(survey))
    assert scene is not None
    return scene


def arrays(scene: SceneView, name: str) -> dict[str, np.ndarray]:
    """The arrays of a part as the script reads them."""
    part, raw = scene.document[name], b64decode(scene.block)
    n, m = part["count"], part["triangles"]  # type: ignore[index]

    def at(member: str, kind: str, count: int) -> np.ndarray:
        return np.frombuffer(raw, kind, count, part[member])  # type: ignore[index]

    step = part["form_step_m"]  # type: ignore[index]
    return {
        "vertices": np.array(part["low"])
        + at("vertices", "<u2", 3 * n).reshape(n, 3) * np.array(part["step"]),  # type: ignore[index]
        "form": at("form", "<i2", n) * step,
        "relief": at("relief", "<i2", n) * step,
        "normals": at("normals", "i1", 3 * n).reshape(n, 3) / 127,
        "map": at("map", "<f4", 2 * n).reshape(n, 2),
        "faces": at("faces", "<u4", 3 * m).reshape(m, 3),
    }


def test_hull_without_form_plus_form_is_the_hull_as_found(survey: Survey) -> None:
    surveyed, rest = scene_parts(survey.surfaces)
    assert surveyed is not None
    assert rest is not None
    plate = survey.surfaces.as_found
    assert plate is not None
    for part in (surveyed, rest):
        there = {tuple(point) for point in np.round(plate.vertices, 9)}
        assert {tuple(point) for point in np.round(part.as_found(), 9)} <= there
    assert np.abs(surveyed.form).max() == 0.003
    assert len(surveyed.faces) + len(rest.faces) == len(plate.faces)


def test_what_nobody_saw_has_no_form_and_stays_as_drawn(survey: Survey) -> None:
    _, rest = scene_parts(survey.surfaces)
    assert rest is not None
    unseen = rest.vertices[:, 0] >= 2
    assert unseen.any()
    assert (rest.form[unseen] == 0).all()


def test_the_block_holds_what_the_document_says(survey: Survey) -> None:
    surveyed, _ = scene_parts(survey.surfaces)
    assert surveyed is not None
    read = arrays(scene_of(survey), "surveyed")
    np.testing.assert_allclose(read["vertices"], surveyed.vertices, atol=1e-4)
    np.testing.assert_allclose(read["form"], surveyed.form, atol=1e-6)
    np.testing.assert_allclose(read["normals"], surveyed.normals, atol=1 / 127)
    np.testing.assert_array_equal(read["faces"], surveyed.faces)
    # the test's map has x = -along
    np.testing.assert_allclose(read["map"], surveyed.chart * [-1, 1], atol=1e-4)


def test_without_a_cad_model_the_scene_has_no_form(survey: Survey) -> None:
    surfaces = replace(survey.surfaces, as_found=None, deviation=None)
    scene = scene_of(replace(survey, surfaces=surfaces))
    assert scene.document["has_form"] is False
    assert (arrays(scene, "surveyed")["form"] == 0).all()


def test_a_dive_without_a_surface_has_no_view(bare: Survey) -> None:
    assert make_scene(bare, hull_map(bare)) is None


def test_objects_and_path_are_in_the_frame_of_the_survey(survey: Survey) -> None:
    document = scene_of(survey).document
    assert document["objects"][0]["at"] == [1.0, -1.2, -0.1]  # type: ignore[index]
    np.testing.assert_allclose(document["path"], survey.track.poses.translation, atol=1e-4)  # type: ignore[arg-type]
    assert (document["up"], document["forward"]) == ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    assert document["forward_name"] == "bow"


def test_the_scene_is_upright_whichever_axis_is_up(survey: Survey) -> None:
    class Lying(FlatChart):
        ship_axes = np.array([[0.0, 0, -1], [1, 0, 0], [0, -1, 0]])

    document = scene_of(replace(survey, surfaces=replace(survey.surfaces, chart=Lying()))).document
    assert (document["up"], document["forward"]) == ([0.0, -1.0, 0.0], [0.0, 0.0, -1.0])


def wavy(n: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """A square of 6 m with a wave of 20 mm over 6 m, and a box of 0.2 m that stands out 0.1 m."""
    x, y = np.meshgrid(np.linspace(0, 6, n), np.linspace(0, 6, n))
    form = 0.02 * np.sin(2 * np.pi * x / 6)
    form[(abs(x - 3) < 0.1) & (abs(y - 3) < 0.1)] += 0.1
    return np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]), form.ravel()


def test_relief_keeps_waves_and_leaves_out_objects() -> None:
    points, form = wavy()
    relief = relief_of(points, form)
    wave = 0.02 * np.sin(2 * np.pi * points[:, 0] / 6)
    inside = ((points[:, :2] > 0.6) & (points[:, :2] < 5.4)).all(axis=1)
    assert np.abs(relief - wave)[inside].max() < 0.005
    assert np.abs(relief).max() < 0.025


def test_relief_does_not_depend_on_the_mesh_of_an_object() -> None:
    points, form = wavy()
    box = (np.abs(points[:, :2] - 3) < 0.15).all(axis=1)
    dense = np.vstack([points, *[points[box] + [dx, 0, 0] for dx in np.linspace(0.001, 0.02, 20)]])
    relief = relief_of(dense, np.concatenate([form, *[form[box]] * 20]))
    assert np.abs(relief).max() < 0.025


def wavy_part(n: int = 60) -> parts.ScenePart:
    points, form = wavy(n)
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = (
        index[:-1, :-1].ravel(),
        index[:-1, 1:].ravel(),
        index[1:, :-1].ravel(),
        index[1:, 1:].ravel(),
    )
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    return parts.ScenePart(
        vertices=points,
        form=form,
        normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)),
        faces=faces.astype(np.int32),
        chart=points[:, :2],
    )


def test_a_large_mesh_is_thinned_to_the_same_bytes() -> None:
    whole = wavy_part()
    thin = parts._decimate(whole, 4000)
    assert thin is not None
    assert len(thin.faces) <= 4000
    assert np.ptp(thin.vertices[:, 0]) > 5.8
    again = parts._decimate(whole, 4000)
    assert again is not None
    np.testing.assert_array_equal(thin.vertices, again.vertices)
    np.testing.assert_array_equal(thin.faces, again.faces)


def test_stripes_of_a_large_mesh_are_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "MAX_AT_ONCE", 2000)
    thin = parts._decimate(wavy_part(), 1000)
    assert thin is not None
    assert len(thin.faces) <= 1000
    # one piece, of the whole's area
    edges, count = np.vstack([thin.faces[:, :2], thin.faces[:, 1:]]).T, len(thin.vertices)
    graph = coo_array((np.ones(edges.shape[1]), edges), shape=(count, count))
    assert connected_components(graph, directed=False)[0] == 1
    area = face_areas(Mesh(thin.vertices * [1, 1, 0], thin.faces)).sum()
    np.testing.assert_allclose(area, 36.0, rtol=0.01)


def test_a_long_path_is_thinned_small_outlines_are_kept(
    survey: Survey, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hullrecon.report.scene_view.MAX_PATH", 2)
    document = scene_of(survey).document
    assert len(document["path"]) == 2  # type: ignore[arg-type]
    outline = document["objects"][0]["outline"]  # type: ignore[index]
    np.testing.assert_allclose(outline, (survey.findings.objects or ())[0].outline, atol=1e-4)


def test_the_scene_has_no_nan_and_arrays_are_aligned_to_four(
    survey: Survey,
) -> None:
    document = scene_of(survey).document
    assert json.loads(json.dumps(document, allow_nan=False))["block"] == "scene-block"
    for part in (document["surveyed"], document["rest"]):
        starts = [part[name] for name in ("vertices", "form", "relief", "normals", "map", "faces")]  # type: ignore[index]
        assert starts == sorted(starts)
        assert all(start % 4 == 0 for start in starts)


def test_an_object_without_a_place_is_left_out(survey: Survey) -> None:
    (one,) = survey.findings.objects or ()
    lost = replace(one, id=2, center=(float("nan"),) * 3)
    document = scene_of(
        replace(survey, findings=replace(survey.findings, objects=(one, lost)))
    ).document
    assert [shown["id"] for shown in document["objects"]] == [1]  # type: ignore[attr-defined]


def test_a_form_of_nothing_has_no_relief() -> None:
    assert (relief_of(np.zeros((4, 3)), np.zeros(4)) == 0).all()
    assert relief_of(np.zeros((0, 3)), np.zeros(0)).shape == (0,)


UTM = np.array([573_412.0, 6_020_155.0, -4.0])


class FarChart(FlatChart):
    """The same chart of a plate in map coordinates."""

    def to_chart(self, points: np.ndarray) -> np.ndarray:
        return super().to_chart(points - UTM)

    def from_chart(self, along_girth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points, normals = super().from_chart(along_girth)
        return points + UTM, normals


def test_a_scene_in_map_coordinates_is_about_an_origin_of_its_own(survey: Survey) -> None:
    survey = replace(survey, findings=replace(survey.findings, objects=()))
    plate, poses = survey.surfaces.as_found, survey.track.poses
    assert plate is not None
    far = replace(
        survey,
        surfaces=replace(
            survey.surfaces,
            chart=FarChart(),
            as_found=replace(plate, vertices=plate.vertices + UTM),
        ),
        track=replace(survey.track, poses=Poses(poses.quaternion, poses.translation + UTM)),
    )
    one, two = scene_of(survey), scene_of(far)
    assert one.document["origin"] == [0.0, 0.0, 0.0]
    shift = UTM - np.array(two.document["origin"])
    assert np.abs(shift).max() < 20
    for name in ("path", "surveyed"):
        near, moved = (
            np.array(v.document["path"]) if name == "path" else arrays(v, name)["vertices"]
            for v in (one, two)
        )
        np.testing.assert_allclose(moved, near + shift, atol=2e-4)
