# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Through the tables: every derivative against numeric ones, every measurement's sign, the loss's
slope as the cost's.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, built, change, evaluate, leaves
from native.test_cores import CASES, problem
from native.twins import cost, jacobian, moved, normal_equations

from hullrecon import native
from hullrecon.native import FACTORS, Evaluation, Options

Survey = Callable[..., Draft]
NAIVE = Options(method="naive")


def numeric_column(p: Draft, e: Evaluation, column: int, options: Options, h: float) -> np.ndarray:
    """Five-point difference of all residuals along one tangent coordinate."""

    def at(step: float) -> np.ndarray:
        delta = np.zeros(e.width)
        delta[column] = step
        return np.asarray(evaluate(moved(p, e, delta), options).residual)

    return np.asarray((8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h))


def representatives(e: Evaluation, rng: np.random.Generator) -> list[int]:
    """A column of each kind of block, each coordinate once."""
    chosen: dict[tuple[str, int], int] = {}
    for name in rng.permutation(list(e.columns)):
        start, width = e.columns[str(name)]
        for k in range(width):
            chosen.setdefault((str(name).split()[0], k), start + k)
    return list(chosen.values())


# The mesh is bumpy: distance and range have kinks at its edges, so only the linear parts of those
# factors are exact to order h.
@pytest.mark.parametrize(
    "case", ["everything free, mono", "tray held", "everything free, planes", "links, tray held"]
)
def test_derivatives_equal_numeric_ones(case: str, make_survey: Survey, shaken: Survey) -> None:
    p = problem(case, make_survey, shaken)
    options = Options(method="maxmix")
    e = evaluate(p, options)
    J = jacobian(e)
    smooth = ~np.isin(e.factor, [FACTORS.index("range"), FACTORS.index("surface")])
    blocks = [
        e.columns[name] for name in ("intrinsics_top", "intrinsics_bottom") if name in e.columns
    ]
    intrinsics = {start + k for start, width in blocks for k in range(width)}
    for column in representatives(e, np.random.default_rng(1)):
        numeric = numeric_column(p, e, column, options, 1e-4)
        if column in intrinsics:  # their prior is about the start, which moves along
            numeric[e.factor == FACTORS.index("prior")] = J[
                e.factor == FACTORS.index("prior"), column
            ]
        scale = np.abs(J[:, column]).max()
        np.testing.assert_allclose(
            J[smooth, column], numeric[smooth], rtol=0, atol=2e-7 * (scale + 1), err_msg=str(column)
        )


def flat(p: Draft) -> Draft:
    """The plate without its bumps: one plane, where distance and range are smooth."""
    p.cad_mesh.vertices = p.cad_mesh.vertices * [1, 1, 0]
    p.ranges.measured = p.ranges.measured + 0.3
    return p


@pytest.mark.parametrize("table", ["range", "surface"])
def test_derivatives_by_the_mesh_equal_numeric_ones_on_a_plane(
    table: str, make_survey: Survey, shaken: Survey
) -> None:
    p = flat(problem("everything free", make_survey, shaken))
    e = evaluate(p)
    J, mine = jacobian(e), e.factor == FACTORS.index(table)
    assert mine.any()
    for column in representatives(e, np.random.default_rng(2)):
        numeric = numeric_column(p, e, column, Options(), 1e-4)
        scale = np.abs(J[mine, column]).max()
        np.testing.assert_allclose(
            J[mine, column], numeric[mine], rtol=0, atol=2e-7 * (scale + 1), err_msg=str(column)
        )


@pytest.mark.parametrize("method", ["naive", "geva", "maxmix"])
@pytest.mark.parametrize(
    "case", ["as it is", "mono beside stereo", "outliers", "two surfaces", "links", "planes"]
)
def test_the_gradient_is_that_of_the_robust_cost(
    case: str, method: str, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    if case != "outliers":
        p = flat(p)
    options = Options(method=method)
    e = evaluate(p, options)
    gradient = normal_equations(e)[1]
    rng = np.random.default_rng(3)
    for _ in range(6):
        along = rng.normal(size=e.width) * (rng.random(e.width) < 0.1)
        h = 1e-6
        there, back = (cost(evaluate(moved(p, e, sign * h * along), options)) for sign in (1, -1))
        scale = np.abs(gradient * along).sum()
        assert (there - back) / (2 * h) == pytest.approx(gradient @ along, abs=1e-4 * scale)


# table, field, entry of a row, rows of the residual that it lowers by one over its sigma
MEASURED = [
    ("attitude", "attitude.measured", 0, 0),
    ("attitude", "attitude.measured", 1, 1),
    ("attitude", "attitude.measured", 2, 2),
    ("tray", "tray.measured", None, 0),
    ("stereo", "stereo.pixel", 0, 0),
    ("stereo", "stereo.pixel", 1, 1),
    ("stereo", "stereo.pixel", 2, 2),
    ("stereo", "stereo.pixel", 3, 3),
    ("mono", "mono.pixel", 0, 0),
    ("mono", "mono.pixel", 1, 1),
    ("range", "ranges.measured", None, 0),
]


@pytest.mark.parametrize(("table", "field", "entry", "row"), MEASURED)
def test_larger_measurement_lowers_its_own_residual_only(
    table: str, field: str, entry: int | None, row: int, make_survey: Survey, shaken: Survey
) -> None:
    p = problem("mono beside stereo", make_survey, shaken)
    before = evaluate(p, NAIVE)
    values = leaves(p)[field].copy()
    k = 4
    values[(k, entry) if entry is not None else k] += 1e-3
    change(p, field, values)
    moved_by = evaluate(p, NAIVE).residual - before.residual
    sigma = {
        "attitude": p.attitude.sigma[k],
        "tray": p.tray.sigma[k : k + 1],
        "range": p.ranges.sigma[k : k + 1],
    }
    sigma |= {
        name: np.full(4, of.sigma_ratio[k]) for name, of in (("stereo", p.stereo), ("mono", p.mono))
    }
    mine = np.flatnonzero((before.factor == FACTORS.index(table)) & (before.table_row == k))[row]
    assert moved_by[mine] == pytest.approx(-1e-3 / sigma[table][row], rel=1e-6)
    assert np.delete(moved_by, mine) == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("coordinate", range(3))
def test_a_longer_measured_step_lowers_the_odometrys_residual(
    coordinate: int, make_survey: Survey
) -> None:
    p = make_survey()
    before = evaluate(p, NAIVE)
    p.odometry.measured = p.odometry.measured.copy()
    p.odometry.measured[2, coordinate] += 1e-3
    change = evaluate(p, NAIVE).residual - before.residual
    mine = np.flatnonzero((before.factor == FACTORS.index("odometry")) & (before.table_row == 2))
    expected = np.zeros(6)
    expected[coordinate] = -1e-3 * 100
    np.testing.assert_allclose(change[mine], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("navigation", "table", "sign"),
    [
        (0, "odometry", -1),
        (1, "odometry", -1),
        (2, "attitude", 1),
        (3, "attitude", 1),
        (4, "attitude", 1),
        (5, "tray", 0),
    ],
)
def test_systematic_errors_enter_their_tables_with_their_signs(
    navigation: int, table: str, sign: int, make_survey: Survey
) -> None:
    p = make_survey()
    p.constant = tuple(name for name in p.constant if name != "navigation")
    e = evaluate(p, NAIVE)
    column = jacobian(e)[:, e.columns["navigation"][0] + navigation]
    mine = e.factor == FACTORS.index(table)
    prior = e.factor == FACTORS.index("prior")
    assert (column[~mine & ~prior] == 0).all()
    if sign:
        derivative = p.odometry.by_navigation[:, :, navigation] if table == "odometry" else None
        whitened = (
            np.einsum("kij,kj->ki", p.odometry.sqrt_information, derivative).ravel()
            if derivative is not None
            else np.tile(np.eye(3)[{4: 0, 2: 1, 3: 2}[navigation]], len(p.unknowns.pose))
            / p.attitude.sigma.ravel()
        )
        np.testing.assert_allclose(column[mine], sign * whitened, rtol=1e-12)
    else:
        np.testing.assert_allclose(column[mine], p.tray.direction / p.tray.sigma, rtol=1e-12)


@pytest.mark.parametrize("case", [c for c in CASES if "held" in c or "free" in c])
def test_a_held_block_has_no_column_and_a_free_one_its_width(
    case: str, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    e = evaluate(p)
    widths = {
        "T_g_M": 6,
        "T_s_ct": 6,
        "T_ct_cb": 6,
        "T_s_d": 6,
        "navigation": 6,
        "intrinsics_top": 9,
        "intrinsics_bottom": 9,
    }
    for name, width in widths.items():
        assert e.columns.get(name, (0, 0))[1] == (0 if name in p.constant else width), name
    assert e.columns["pose 2"][1] == (6 if "tray" in p.constant else 7)
    starts, counts = zip(*e.columns.values(), strict=True)
    np.testing.assert_array_equal(np.cumsum((0, *counts[:-1])), starts)
    assert e.width == sum(counts)


@pytest.mark.parametrize("case", ["everything free, mono", "links, tray held"])
def test_without_the_jacobian_all_else_is_the_same(
    case: str, make_survey: Survey, shaken: Survey
) -> None:
    p = built(problem(case, make_survey, shaken))
    whole, bare = native.evaluate(p, NAIVE), native.evaluate(p, NAIVE, jacobian=False)
    for name in ("residual", "weight", "factor", "table_row"):
        np.testing.assert_array_equal(getattr(bare, name), getattr(whole, name))
    assert bare.cost_by_factor == whole.cost_by_factor
    assert bare.width == whole.width
    assert len(bare.jacobian_start) == len(bare.residual) + 1
    assert not bare.jacobian_start.any()
    assert (len(bare.jacobian_column), len(bare.jacobian_value), bare.columns) == (0, 0, {})
