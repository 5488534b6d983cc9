# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a CAD model has the surveyed hull's form: right ones do, whatever grows on them; others
do not, where one can see.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.scenes import TRUTH, cad_model, side
from scipy.stats import chi2

from hullrecon.adjustment.cad_acceptance import accept_shape
from hullrecon.adjustment.hull_pose import estimate
from hullrecon.adjustment.hull_pose.cad_error import matern32
from hullrecon.adjustment.hull_pose.registration import thin_points
from hullrecon.adjustment.hull_pose.shape_comparison import (
    CHANCE,
    WIDENING,
    ShapeComparison,
    compare_shape,
)
from hullrecon.geometry.meshes.mesh import Mesh

CURVED = side(0.9)
PLACE = np.array([7.0, 3.8, 2.5])  # of the survey, in M
AGREES = ShapeComparison(patterns=12, deviation=1.0, plane=40.0)


@lru_cache
def surveyed(deviation_m=0.0, growth_m=0.0, seed=1, flat=False):
    """Points (n, 3) in M on a side as it is, 9 by 3.4 m: off the model by a smooth field of that
    sigma, with growth that stands out over two square metres, and noise.
    """
    random = np.random.default_rng(seed)
    at = np.c_[random.uniform(2, 11, 700), np.full(700, 3.8), random.uniform(0.8, 4.2, 700)]
    if not flat:
        found = CURVED.index.closest(at)
        at = at - found.distance[:, None] * found.gradient
    field = np.linalg.cholesky(
        matern32(at[:, [0, 2]], 1.0, (3.0, 1.5)) + 1e-9 * np.eye(700)
    ) @ random.standard_normal(700)
    grown = (abs(at[:, 0] - 5) < 1.0) & (abs(at[:, 2] - 2.5) < 0.5)
    at[:, 1] += deviation_m * field + growth_m * grown + 0.004 * random.standard_normal(700)
    return at


def compared(mesh, points):
    """The form, with that model fitted to those points."""
    model = cad_model(mesh, TRUTH, np.zeros(6))
    kept = thin_points(TRUTH.apply(points), 0.2, 450)
    evidence, best = estimate.fit_hull_pose(
        estimate.HullPoints(xyz=kept, by_range=np.zeros_like(kept)),
        model.guess,
        model,
        TRUTH.inverse().apply(kept).mean(0),
    )
    return compare_shape(evidence, best)


def stretched(factors):
    return Mesh((CURVED.vertices - PLACE) * factors + PLACE, CURVED.faces)


def refused(form, sigmas_off=1.0):
    return accept_shape(form, sigmas_off).reason


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_model_as_good_as_its_package_says_is_believed(seed):
    form = compared(CURVED, surveyed(deviation_m=0.02, seed=seed))
    assert form.patterns > 5
    assert not form.needs_wider_sigma
    assert form.fits_better_than_plane
    assert refused(form, sigmas_off=6.0) is None  # and found far from a guess, too


def test_hull_off_by_more_than_stated_is_no_other_ship():
    form = compared(CURVED, surveyed(deviation_m=0.045))
    assert form.needs_wider_sigma
    assert refused(form) is None


def test_growth_of_fifteen_centimetres_is_no_other_form():
    form = compared(CURVED, surveyed(deviation_m=0.015, growth_m=0.15))
    assert not form.needs_wider_sigma
    assert refused(form) is None


def test_a_plain_side_confirms_nothing_and_is_not_refused_for_it():
    plate = side(0.0)
    plate = Mesh(
        np.c_[plate.vertices[:, 0], np.full(len(plate.vertices), 3.8), plate.vertices[:, 2]],
        plate.faces,
    )
    form = compared(plate, surveyed(deviation_m=0.01, flat=True))
    assert not form.needs_wider_sigma
    assert not form.fits_better_than_plane
    assert min(form.scale_sigma) > 0.4  # the patch says nothing of the model's ratios
    assert refused(form) is None


def test_a_plain_side_far_from_the_guess_is_refused():
    assert "too plain to tell that it is this one" in refused(
        replace(AGREES, plane=1.0), sigmas_off=4.0
    )


def test_package_is_not_mistaken_in_place_and_error():
    worse = replace(AGREES, deviation=5.0)
    assert worse.exceeds_stated_error
    assert refused(worse, sigmas_off=3.0) is None
    assert refused(AGREES, sigmas_off=6.0) is None
    why = refused(worse, sigmas_off=6.0)
    assert "6.0 times farther from hull.pose" in why
    assert "2.2 times hull.deviation_sigma" in why


def test_another_ship_s_side_is_refused():
    x, y, z = CURVED.vertices.T
    other = Mesh(np.c_[x, y - 0.02 * (x - 7) ** 2 + 0.12 * (z - 2.5) ** 2, z], CURVED.faces)
    form = compared(other, surveyed(deviation_m=0.01))
    assert form.needs_wider_sigma or form.fits_better_scaled
    assert refused(form) is not None


def test_a_model_with_other_proportions_is_refused():
    form = compared(stretched([1.5, 1.0, 1.0]), surveyed(deviation_m=0.01))
    assert refused(form) is not None


def test_what_the_points_tell_of_the_ratios_is_their_sigma():
    """A model a tenth too long is within what the points tell of its length."""
    form = compared(stretched([1.05, 1.0, 1.0]), surveyed(deviation_m=0.01))
    assert len(form.scale_sigma) == 3
    assert refused(form) is None


def test_each_reason_names_what_speaks():
    assert refused(AGREES) is None
    assert "4.0 times hull.deviation_sigma" in refused(replace(AGREES, deviation=16.0))
    assert "its proportions, its scale, hull.pose, the path, the tray's" in refused(
        replace(AGREES, scale_chi2=20.0)
    )
    # contradicted, but a package may be mistaken by a factor of two
    assert refused(replace(AGREES, deviation=5.0)) is None
    # unless a plane leaves hardly more
    assert refused(replace(AGREES, deviation=5.0, plane=12.0)) is not None


def test_right_model_is_refused_by_tail_of_chi_square():
    random = np.random.default_rng(5)
    draws = (random.standard_normal((20000, 12)) ** 2).mean(axis=1)
    # confirmed by nothing
    plain = [ShapeComparison(patterns=12, deviation=float(d), plane=1.0) for d in draws]
    assert np.mean([form.needs_wider_sigma for form in plain]) == pytest.approx(
        WIDENING, abs=2.5e-3
    )
    assert np.mean([form.is_of_another_hull for form in plain]) == pytest.approx(CHANCE, abs=8e-4)


def test_a_model_is_doubted_before_it_is_refused():
    """Even where a plane explains as much."""

    def with_chance(chance):
        return replace(AGREES, deviation=float(chi2.isf(chance, AGREES.patterns)) / AGREES.patterns)

    doubted, refusable = with_chance(5e-3), with_chance(5e-4)
    assert doubted.needs_wider_sigma
    assert refused(replace(doubted, plane=1.0)) is None
    assert refused(replace(refusable, plane=1.0)) is not None
    assert not with_chance(0.02).needs_wider_sigma


def test_without_a_resolved_pattern_nothing_is_said():
    nothing = ShapeComparison(patterns=0)
    assert (
        nothing.needs_wider_sigma,
        nothing.fits_better_scaled,
        nothing.fits_better_than_plane,
        nothing.log_odds,
    ) == (
        False,
        False,
        False,
        0.0,
    )


def test_two_points_that_are_left_tell_no_form():
    form = compared(CURVED, surveyed()[[0, 350]])
    assert form.plane == pytest.approx(0.0, abs=1e-6)
    assert not form.fits_better_than_plane
