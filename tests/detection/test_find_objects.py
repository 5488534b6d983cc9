# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import asdict, fields, replace

import numpy as np
import pytest
from detection.conftest import reported

from hullrecon.detection.as_found.landmarks import SurfaceLandmarks

WALL_OFFSET_M = -0.012  # of the wall from its CAD model


def test_disc_and_recess_alone_are_reported_once(scenery, found) -> None:
    objects, _ = reported(scenery, found)
    assert [round(o.height, 2) for o in objects] == [0.10, -0.05]


def test_the_center_lies_on_the_visible_surface(scenery, found) -> None:
    disc, recess = reported(scenery, found)[0]
    # the wall is 12 mm behind its CAD model at y = 2
    assert np.allclose(disc.center, [1.2, 2 - 0.012 + 0.10, 1.0], atol=0.02)
    assert np.allclose(recess.center, [2.2, 2 - 0.012 - 0.05, 1.0], atol=0.02)
    assert disc.center[1] == pytest.approx(2.088, abs=0.005)


def test_size_area_and_volume_are_those_of_the_structure(scenery, found) -> None:
    disc, recess = reported(scenery, found)[0]
    assert np.allclose(disc.extent, [0.24, 0.24], atol=0.025)
    assert np.allclose(recess.extent, [0.20, 0.20], atol=0.025)
    assert disc.area == pytest.approx(np.pi * 0.12**2, rel=0.15)
    assert disc.volume == pytest.approx(np.pi * 0.12**2 * 0.10, rel=0.15)
    assert recess.volume == pytest.approx(-0.04 * 0.05, rel=0.2)
    assert np.allclose(disc.normal, [0, 1, 0], atol=1e-6)


def test_object_deviation_needs_a_cad_model(scenery, found) -> None:
    disc, recess = reported(scenery, found)[0]
    assert disc.deviation == pytest.approx(0.10 - 0.012, abs=0.005)
    assert recess.deviation == pytest.approx(-0.05 - 0.012, abs=0.005)
    assert reported(scenery, found, with_cad_model=False)[0][0].deviation is None


def test_images_are_counted_and_the_best_named(scenery, found) -> None:
    disc, _ = reported(scenery, found)[0]
    # cameras every 0.25 m from 0.5; the disc's top, 0.09 m in half, fits the footprint within about
    # 0.6 m
    assert disc.views == 5
    assert disc.images[0] == "camera_top/3.jpg"  # at x = 1.25, the nearest to 1.2


def test_the_outline_runs_around_the_footprint(scenery, found) -> None:
    disc, _ = reported(scenery, found)[0]
    line = np.array(disc.outline)
    radius = np.hypot(line[:, 0] - 1.2, line[:, 2] - 1.0)
    assert len(line) >= 12
    assert np.abs(radius - 0.12).max() < 0.03


def test_both_are_certain(scenery, found) -> None:
    for item in reported(scenery, found)[0]:
        assert item.p_value < 1e-12
        assert 0.0005 < item.height_sigma < 0.006


def test_rough_top_has_larger_height_sigma(scenery, found) -> None:
    (even, _), _ = reported(scenery, found)
    at = scenery.measured.foot
    top = np.hypot(at[:, 0] - 1.2, at[:, 2] - 1.0) < 0.12
    rough = scenery.measured.offset + np.where(
        top, np.random.default_rng(1).normal(0, 0.01, len(at)), 0.0
    )
    (uneven, _), _ = reported(
        replace(scenery, measured=replace(scenery.measured, offset=rough)), found
    )
    assert uneven.height == even.height
    assert uneven.height_sigma == pytest.approx(np.hypot(0.01, even.height_sigma), rel=0.25)


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("min_height_m", 0.08, "m off the hull"),
        ("min_area_m2", 0.042, "cm2 above half"),
        ("min_views", 6, "images show it"),
        ("min_landmarks", 120, "landmarks"),
    ],
)
def test_what_is_not_certain_is_named_with_its_reason(
    option: str, value: float, words: str, scenery, found
) -> None:
    objects, rejected = reported(scenery, found, **{option: value})
    assert len(objects) < 2
    assert any(words in item.reason for item in rejected)


def test_a_height_within_its_own_uncertainty_is_not_reported(scenery, found) -> None:
    objects, rejected = reported(scenery, replace(found, sigma=np.full(len(found.sigma), 0.05)))
    assert objects == []
    assert "bare hull" in rejected[0].reason


def test_structure_must_stand_out_from_coarse_facets(scenery, found) -> None:
    objects, rejected = reported(
        scenery,
        replace(found, sagitta=np.full(len(found.sagitta), 0.04), turn=np.ones(len(found.turn))),
    )
    assert [round(o.height, 2) for o in objects] == [0.10]
    assert rejected[0].reason.endswith("flat facets may account for 0.040 m")


def test_a_structure_on_which_landmarks_disagree_is_not_reported(scenery, found) -> None:
    at = scenery.measured.foot
    half = (np.hypot(at[:, 0] - 1.2, at[:, 2] - 1.0) < 0.13) & (
        np.random.default_rng(0).random(len(at)) < 0.5
    )
    mixed = replace(scenery.measured, offset=np.where(half, WALL_OFFSET_M, scenery.measured.offset))
    objects, rejected = reported(replace(scenery, measured=mixed), found)
    assert [round(o.height, 2) for o in objects] == [-0.05]
    assert "agree" in rejected[0].reason


def test_landmarks_at_foot_of_edge_are_not_of_structure(scenery, found) -> None:
    on_disc = np.flatnonzero(
        np.hypot(scenery.measured.foot[:, 0] - 1.2, scenery.measured.foot[:, 2] - 1.0) < 0.1
    )
    angle = np.linspace(0, 2 * np.pi, 2 * len(on_disc))
    ring = scenery.measured.take(np.resize(on_disc, len(angle)))
    foot = np.stack(
        [1.2 + 0.132 * np.cos(angle), np.full(len(angle), 2.0), 1.0 + 0.132 * np.sin(angle)], axis=1
    )
    joined = {
        f.name: np.concatenate([getattr(scenery.measured, f.name), getattr(ring, f.name)])
        for f in fields(ring)
    }
    joined["foot"] = np.concatenate([scenery.measured.foot, foot])
    joined["offset"] = np.concatenate([scenery.measured.offset, np.full(len(angle), WALL_OFFSET_M)])
    beside = replace(scenery, measured=SurfaceLandmarks(**joined))
    assert [round(o.height, 2) for o in reported(beside, found)[0]] == [0.10, -0.05]


@pytest.mark.parametrize(("radius_m", "seen"), [(0.03, True), (0.012, False)])
def test_enough_views_must_show_a_structures_top(
    radius_m: float, seen: bool, scenery, found
) -> None:
    """A disc of 28 cm2 holds the 8 cm2 of a top, one of 5 cm2 does not."""
    off = np.hypot(found.base.vertices[:, 0] - 1.2, found.base.vertices[:, 2] - 1.0)
    shown = replace(found, shapes=np.where((off > radius_m) & (off < 0.2), 0, found.shapes))
    objects, rejected = reported(scenery, shown)
    assert (0.10 in [round(o.height, 2) for o in objects]) == seen
    assert any("images show it" in item.reason for item in rejected) != seen


def test_objects_are_plain_values_for_json(scenery, found) -> None:
    row = asdict(reported(scenery, found)[0][0])
    assert {
        "center",
        "normal",
        "height",
        "height_sigma",
        "deviation",
        "extent",
        "area",
        "volume",
        "views",
        "p_value",
    } <= set(row)
    assert isinstance(row["center"], tuple)
    assert all(isinstance(v, float) for v in row["center"])
