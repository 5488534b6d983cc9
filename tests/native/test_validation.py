# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every refusal of a table or an option: its name, and words that say what is wrong with it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from drafts import Draft, change, covariance, evaluate, leaves, solve
from native.test_cores import field, links, mono_beside_stereo, planes, positions
from native.test_lens import lenses
from native.twins import array_fields

from hullrecon.errors import InputError, UsageError
from hullrecon.native import MotionPrior, Options

Survey = Callable[..., Draft]
Ints = np.int32


@pytest.fixture
def whole(make_survey: Survey) -> Draft:
    """A survey with every table filled."""
    p = make_survey()
    field(p)
    mono_beside_stereo(p)
    links(p)
    planes(p)
    positions(p)
    lenses(p)
    p.priors.T_ct_cb = MotionPrior(value=p.unknowns.T_ct_cb.copy(), sqrt_information=np.eye(6))
    return p


def test_a_problem_with_every_table_filled_is_accepted(whole: Draft) -> None:
    assert set(array_fields(whole)) >= set(leaves(whole)) - {"constant", "sigma_px"}
    assert len(evaluate(whole).residual) > 0


# field, what becomes of it, what is said
REFUSALS: list[tuple[str, Callable[[np.ndarray], Any], str]] = [
    ("unknowns.pose", lambda x: x[:0], "there are no poses"),
    ("unknowns.pose", lambda x: x[:, :7], r"the shape is \(8, 7, \), expected \(8, 8, \)"),
    ("unknowns.pose", lambda x: x * 1.01, "row 0 is not of unit length"),
    ("unknowns.landmark", lambda x: x[:, :2], "expected"),
    ("unknowns.T_g_M", lambda x: x[:6], "expected"),
    ("unknowns.T_s_ct", lambda x: x * 2, "the quaternion is not of unit length"),
    ("unknowns.T_ct_cb", lambda x: 0 * x, "the quaternion is not of unit length"),
    ("unknowns.T_s_d", lambda x: x[None], "expected"),
    ("odometry.mount", lambda x: -3 * x, "the quaternion is not of unit length"),
    ("unknowns.lens_top", lambda x: x[:5], "expected"),
    ("lenses.image_size", lambda x: x[:1], "expected"),
    ("lenses.image_size", lambda x: 0 * x, "not positive"),
    ("lenses.expected_px", lambda x: x[:, :3], "expected"),
    ("lenses.sigma_px", lambda x: 0 * x, "not positive"),
    ("unknowns.navigation", lambda x: x[:5], r"expected \(6, \)"),
    ("unknowns.deviation", lambda x: x[:, None], "expected"),
    ("unknowns.intrinsics_top", lambda x: x[:8], r"expected \(9, \)"),
    (
        "unknowns.intrinsics_top",
        lambda x: x * np.r_[-1, np.ones(8)],
        "a focal length is not positive",
    ),
    (
        "unknowns.intrinsics_bottom",
        lambda x: x * np.r_[1, 0, np.ones(7)],
        "a focal length is not positive",
    ),
    ("lever_arms.tray", lambda x: x[:2], r"expected \(3, \)"),
    ("lever_arms.pressure", lambda x: x[:2], r"expected \(3, \)"),
    ("cad_mesh.vertices", lambda x: x[:, :2], "expected"),
    ("cad_mesh.faces", lambda x: x[:, :2], "expected"),
    ("cad_mesh.faces", lambda x: x + 10000, "index .* is not below 625"),
    ("cad_mesh.faces", lambda x: x[:0], "ranges and surface factors need a CAD model"),
    ("priors.pose.node", lambda x: x - 1, "index -1 of entry 0 is not below 8"),
    ("priors.pose.node", lambda x: x + 8, "index 8 of entry 0 is not below 8"),
    ("priors.pose.value", lambda x: x[:, :6], "expected"),
    ("priors.pose.value", lambda x: x * 1.1, "row 0 is not of unit length"),
    ("priors.pose.sqrt_information", lambda x: x[:, :5], "expected"),
    ("priors.T_g_M.value", lambda x: x * 1.1, "the quaternion is not of unit length"),
    ("priors.T_s_ct.sqrt_information", lambda x: x[:5], r"expected \(6, 6, \)"),
    ("priors.T_ct_cb.sqrt_information", lambda x: x[0], r"expected \(6, 6, \)"),
    ("priors.navigation_sigma", lambda x: 0 * x, "sigma 0 is not positive"),
    ("priors.navigation_sigma", lambda x: x[:5], "expected"),
    ("priors.intrinsics_sigma", lambda x: -x, "sigma 0 is not positive"),
    ("attitude.node", lambda x: x + 1, "index 8 of entry 7 is not below 8"),
    ("attitude.measured", lambda x: x[:, :2], "expected"),
    ("attitude.measured", lambda x: x[:4], "expected"),
    ("attitude.sigma", lambda x: x * [1, 0, 1], "sigma 1 is not positive"),
    ("tray.node", lambda x: x + 8, "is not below 8"),
    ("tray.measured", lambda x: x[:3], "expected"),
    ("tray.direction", lambda x: x[:3], "expected"),
    ("tray.sigma", lambda x: -x, "sigma 0 is not positive"),
    ("odometry.first", lambda x: x - 1, "index -1"),
    ("odometry.second", lambda x: x - 1, "row 0 joins a pose to itself"),
    ("odometry.measured", lambda x: x[:, :6], "expected"),
    ("odometry.measured", lambda x: 2 * x, "row 0 is not of unit length"),
    ("odometry.sqrt_information", lambda x: x[:, 0], "expected"),
    ("odometry.by_navigation", lambda x: x[:, :, :1], "expected"),
    ("odometry.by_mount", lambda x: x[:, :, :1], "expected"),
    ("odometry.by_tray", lambda x: x[:, :5], "expected"),
    ("odometry.tray", lambda x: x[:5], "expected"),
    ("stereo.node", lambda x: x - 1, "index -1"),
    ("stereo.landmark", lambda x: x + 1, "is not below 60"),
    ("stereo.pixel", lambda x: x[:, :2], "expected"),
    ("stereo.sigma_ratio", lambda x: x[:-1], "expected"),
    ("stereo.sigma_ratio", lambda x: -x, "sigma 0 is not positive"),
    ("mono.sigma_ratio", lambda x: x[:-1], "expected"),
    ("mono.sigma_ratio", lambda x: 0 * x, "sigma 0 is not positive"),
    ("mono.node", lambda x: x + 8, "is not below 8"),
    ("mono.landmark", lambda x: -x - 1, "is not below 60"),
    ("mono.camera", lambda x: x + 1, "is not below 2"),
    ("mono.pixel", lambda x: x[:-1], "expected"),
    ("ranges.node", lambda x: x + 8, "is not below 8"),
    ("ranges.offset", lambda x: x * 2, "row 0 is not of unit length"),
    ("ranges.beam", lambda x: x * 0.99, "row 0 is not of unit length"),
    ("ranges.measured", lambda x: x[:-1], "expected"),
    ("ranges.tray_offset", lambda x: x[:-1], "expected"),
    ("ranges.sigma", lambda x: 0 * x, "sigma 0 is not positive"),
    ("ranges.field.index", lambda x: x + 5, "is not below 5"),
    ("ranges.field.weight", lambda x: x[:, :3], "expected"),
    ("surface.landmark", lambda x: x + 1, "is not below 60"),
    ("surface.weight", lambda x: -x, "weight 0 is negative"),
    ("surface.weight", lambda x: x[:-1], "expected"),
    ("surface.field.index", lambda x: x - 1, "index -1"),
    ("surface.field.weight", lambda x: x[:-1], "expected"),
    ("priors.deviation.start", lambda x: x[:-1], "the rows do not cover the entries"),
    ("priors.deviation.start", lambda x: x + 1, "the rows do not cover the entries"),
    ("priors.deviation.start", lambda x: x[[0, 2, 1, 3, 4, 5]], "the rows' starts descend at 2"),
    ("priors.deviation.index", lambda x: x + 5, "is not below 5"),
    ("priors.deviation.value", lambda x: x[:-1], "expected"),
    ("links.first", lambda x: x + 8, "is not below 8"),
    ("links.second", lambda x: x - 8, "index -"),
    ("links.second", lambda x: x[:-1], "expected"),
    ("links.camera_first", lambda x: x + 2, "is not below 2"),
    ("links.camera_second", lambda x: x[:0], "expected"),
    ("links.measured", lambda x: x[:, :6], "expected"),
    ("links.measured", lambda x: x * 2, "row 0 is not of unit length"),
    ("links.measured", lambda x: x * np.r_[0, 0, 0, np.ones(4)], "row 1 has no direction"),
    ("links.sqrt_information", lambda x: x[:, :5, :5], "expected"),
    ("links.sqrt_information", lambda x: x * np.nan, "is not finite"),
    ("links.scaled", lambda x: x.astype(np.int32), "the numbers are of the wrong type"),
    ("links.scaled", lambda x: x[:-1], "expected"),
    ("links.kernel", lambda x: x + 1, "index 3 of entry 4 is not below 3"),
    ("unknowns.link_switch", lambda x: x[:-1], r"expected \(8, \)"),
    ("unknowns.plane", lambda x: x[:, :2], "expected"),
    ("unknowns.plane", lambda x: 0 * x, "row 0 passes through its anchor"),
    ("planes.anchor", lambda x: x + 8, "is not below 8"),
    ("planes.anchor", lambda x: x[:-1], "expected"),
    ("plane_sightings.node", lambda x: x - 8, "index -"),
    ("plane_sightings.plane", lambda x: x + 6, "is not below 6"),
    ("plane_sightings.plane", lambda x: x[:-1], "expected"),
    ("plane_sightings.measured", lambda x: x[:, :2], "expected"),
    ("plane_sightings.sqrt_information", lambda x: x[:, :2], "expected"),
    ("plane_pairs.first", lambda x: x + 6, "is not below 6"),
    ("plane_pairs.second", lambda x: np.zeros_like(x), "row 0 joins a plane to itself"),
    ("plane_pairs.measured", lambda x: x[:-1], "expected"),
    ("plane_pairs.sqrt_information", lambda x: x[:-1], "expected"),
    ("plane_pairs.point", lambda x: x[:-1], "expected"),
    ("plane_pairs.place", lambda x: x[:, :2], "expected"),
    ("plane_pairs.by_place", lambda x: x[:, :2], "expected"),
    ("plane_pairs.by_place", lambda x: x * np.nan, "is not finite"),
    ("plane_ranges.node", lambda x: x + 8, "is not below 8"),
    ("plane_ranges.plane", lambda x: x + 6, "is not below 6"),
    ("plane_ranges.offset", lambda x: x * 2, "row 0 is not of unit length"),
    ("plane_ranges.beam", lambda x: x * 2, "row 0 is not of unit length"),
    ("plane_ranges.tray_offset", lambda x: x[:-1], "expected"),
    ("plane_ranges.measured", lambda x: x[:-1], "expected"),
    ("plane_ranges.sigma", lambda x: 0 * x, "sigma 0 is not positive"),
    ("velocities.first", lambda x: x - 1, "index -1"),
    ("velocities.second", lambda x: x - 1, "row 0 names a pose twice"),
    ("velocities.third", lambda x: x + 8, "is not below 8"),
    ("velocities.before", lambda x: 0 * x, "interval 0 is not positive"),
    ("velocities.after", lambda x: x[:-1], "expected"),
    ("velocities.sigma", lambda x: -x, "sigma 0 is not positive"),
    ("unknowns.world", lambda x: x[:2], r"expected \(3, \)"),
    ("unknowns.world", lambda x: x * np.nan, "is not finite"),
    ("priors.world_sigma", lambda x: 0 * x, "sigma 0 is not positive"),
    ("positions.node", lambda x: x - 1, "index -1"),
    ("positions.antenna", lambda x: x[:, :2], "expected"),
    ("positions.measured", lambda x: x[:-1], "expected"),
    ("positions.sigma", lambda x: -x, "sigma 0 is not positive"),
    ("sigma_px", lambda _: -1.0, "it is not positive"),
    ("sigma_px", lambda _: np.nan, "it is not positive"),
    ("constant", lambda _: ("T_g_m",), "there is no block of the name T_g_m"),
]


@pytest.mark.parametrize(
    ("name", "damage", "words"), REFUSALS, ids=[f"{n}-{k}" for k, (n, _, _) in enumerate(REFUSALS)]
)
def test_a_table_that_cannot_be_used_is_named_with_what_is_wrong(
    name: str, damage: Callable[[np.ndarray], Any], words: str, whole: Draft
) -> None:
    value = damage(leaves(whole)[name])
    change(
        whole,
        name,
        value.astype(Ints) if isinstance(value, np.ndarray) and value.dtype.kind == "i" else value,
    )
    with pytest.raises(InputError, match=words) as caught:
        evaluate(whole)
    assert caught.value.where == name


def test_every_table_of_numbers_is_refused_with_a_nan_in_it(whole: Draft) -> None:
    for name in list(array_fields(whole)):
        table = leaves(whole)[name]
        if table.dtype.kind != "f":
            continue
        spoilt = table.copy()
        spoilt.flat[spoilt.size // 2] = np.nan
        change(whole, name, spoilt)
        with pytest.raises(InputError, match=f"entry {spoilt.size // 2} is not finite") as caught:
            evaluate(whole)
        assert caught.value.where == name
        change(whole, name, table)


def test_table_of_text_or_complex_numbers_is_refused(whole: Draft) -> None:
    for name in list(array_fields(whole)):
        table = leaves(whole)[name]
        for wrong in (table.astype(complex), table.astype(str), table.astype(object)):
            change(whole, name, wrong)
            with pytest.raises(InputError, match="the numbers are of the wrong type") as caught:
                evaluate(whole)
            assert caught.value.where == name
        change(whole, name, table)


def test_index_of_any_integer_width_is_taken_floats_are_refused(
    whole: Draft,
) -> None:
    before = evaluate(whole).residual
    for name in list(array_fields(whole)):
        table = leaves(whole)[name]
        if table.dtype.kind != "i":
            continue
        change(whole, name, table.astype(float))
        with pytest.raises(InputError, match="the numbers are of the wrong type"):
            evaluate(whole)
        for kind in (np.int64, np.uint16):
            change(whole, name, table.astype(kind))
            np.testing.assert_array_equal(evaluate(whole).residual, before, err_msg=name)
        change(whole, name, table)


@pytest.mark.parametrize("layout", ["Fortran", "strided", "float32 where exact"])
def test_tables_in_another_layout_give_the_same_rows(layout: str, whole: Draft) -> None:
    whole.stereo.pixel = np.round(whole.stereo.pixel)
    before = evaluate(whole).residual
    if layout == "Fortran":
        for name in list(array_fields(whole)):
            change(whole, name, np.asfortranarray(leaves(whole)[name]))
    elif layout == "strided":
        for name in list(array_fields(whole)):
            change(whole, name, np.repeat(leaves(whole)[name], 2, axis=0)[::2])
    else:
        whole.stereo.pixel = whole.stereo.pixel.astype(np.float32)
    np.testing.assert_array_equal(evaluate(whole).residual, before)


def test_a_root_without_its_prior_is_refused(whole: Draft) -> None:
    whole.priors.T_s_d.value = None
    with pytest.raises(InputError, match="the square root stands without its prior") as caught:
        evaluate(whole)
    assert caught.value.where == "priors.T_s_d.sqrt_information"


@pytest.mark.parametrize("table", ["ranges", "surface"])
def test_field_nodes_without_a_field_are_refused(table: str, whole: Draft) -> None:
    other = {"ranges": "surface", "surface": "ranges"}[table]
    whole.unknowns.deviation = np.zeros(0)
    for name in (
        f"{other}.field.index",
        f"{other}.field.weight",
        "priors.deviation.start",
        "priors.deviation.index",
        "priors.deviation.value",
    ):
        change(whole, name, leaves(whole)[name][:0])
    with pytest.raises(InputError, match="there is no deviation field to refer to") as caught:
        evaluate(whole)
    assert caught.value.where == f"{table}.field.index"
    assert "give deviation" in str(caught.value.remedy)


@pytest.mark.parametrize("call", [solve, evaluate, covariance])
def test_every_call_validates_tables_and_options(call: Callable[..., Any], whole: Draft) -> None:
    with pytest.raises(UsageError, match="it must be naive, geva or maxmix"):
        call(whole, Options(method="none"))
    whole.tray.sigma = -whole.tray.sigma
    with pytest.raises(InputError, match="sigma 0 is not positive"):
        call(whole)


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("method", "", "it must be naive, geva or maxmix"),
        ("core", "cuda", "it must be schur or ceres"),
        ("sigma_on", np.inf, "it must be positive"),
        ("sigma_off", 0.02, "it must be larger than sigma_on"),
        ("huber_stereo", np.nan, "inf switches it off"),
        ("huber_mono", 0.0, "inf switches it off"),
        ("huber_range", -1.0, "inf switches it off"),
        ("gradient_tolerance", -1e-9, "it must not be negative"),
        ("parameter_tolerance", np.nan, "it must not be negative"),
        ("initial_radius", 0.0, "it must be positive"),
        ("threads", 257, "it must be 1 to 256"),
        ("threads", 1.5, "it is of the wrong type"),
        ("max_iterations", None, "it is of the wrong type"),
        ("labels_in_solve", "yes", "it is of the wrong type"),
        ("sigma_on", "thin", "it is of the wrong type"),
    ],
)
def test_an_option_that_cannot_be_meant_says_what_it_must_be(
    option: str, value: Any, words: str, whole: Draft
) -> None:
    with pytest.raises(UsageError, match=words) as caught:
        evaluate(whole, dataclasses.replace(Options(), **{option: value}))
    assert caught.value.where == option
