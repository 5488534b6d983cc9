# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from benchmarks.pair_motion import (
    BASELINE_M,
    BOTTOM_FROM_TOP,
    MOTION,
    compared,
    difference,
    moved,
    plain_normal,
    scene,
)
from hullrecon import native
from hullrecon.errors import InputError
from hullrecon.geometry.poses import exp

STIFF_M = 1e9  # of a baseline: depths are known, residuals are not whitened
FIELD = 0.5


def stepped(step):
    """The motion moved by (translation, rotation vector on the right)."""
    out = MOTION.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = MOTION[:3, :3] @ exp(np.r_[0, 0, 0, step[3:]][None]).matrix()[0, :3, :3]
    return out


def central(of, size, step=1e-6):
    """The derivative (..., size) of a function by numeric differences at zero."""
    ahead, behind = ([of(sign * step * np.eye(size)[k]) for k in range(size)] for sign in (1, -1))
    return np.stack([(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)], axis=-1)


@pytest.fixture
def data():
    return scene(200)


@pytest.mark.parametrize("part", ["squared_errors", "normal", "rows"])
def test_compiled_and_plain_are_the_same(data, part):
    compiled, plain = compared(data)[part]
    assert difference(compiled(), plain()) < 1e-11


def test_reduced_features_are_those_of_plain_numpy(data):
    """A feature that one camera saw alone has an inverse of 1 / damping: it says nothing, to fewer
    digits.
    """
    compiled, plain = (way() for way in compared(data)["reduced"])
    sure = np.isfinite(data.seen).all(axis=1)
    assert sure.sum() > 100
    assert difference([v[sure] for v in compiled], [v[sure] for v in plain]) < 1e-11
    assert difference(compiled[:4], plain[:4]) < 1e-6


@pytest.mark.parametrize("backward", [False, True])
def test_the_normal_equations_are_of_numeric_derivatives(data, backward):
    points = moved(MOTION, data.points) if backward else data.points
    xy = data.seen[:, 2:4] if backward else data.seen[:, 6:8]
    counts = np.isfinite(xy[:, 0])

    def at(motion):
        return native.normal_of_reprojections(
            motion, points, xy, BOTTOM_FROM_TOP, backward, STIFF_M, counts
        )

    def residuals(step):
        way = np.linalg.inv(stepped(step)) if backward else stepped(step)
        seen = moved(BOTTOM_FROM_TOP @ way, points[counts])
        return (seen[:, :2] / seen[:, 2:] - xy[counts]).ravel()

    jacobian = central(residuals, 6)
    normal, gradient, cost = at(MOTION)
    np.testing.assert_allclose(normal, jacobian.T @ jacobian, rtol=1e-6, atol=1e-6 * normal.max())
    np.testing.assert_allclose(
        gradient, jacobian.T @ residuals(np.zeros(6)), atol=1e-6 * np.abs(gradient).max()
    )
    np.testing.assert_allclose(cost, (residuals(np.zeros(6)) ** 2).sum())


@pytest.mark.parametrize("backward", [False, True])
def test_points_behind_the_camera_are_counted_as_in_plain_numpy(data, backward):
    points = data.points * np.where(np.arange(200) % 5 == 0, -1.0, 1.0)[:, None]
    xy = data.seen[:, 4:6]
    given = MOTION, points, xy, np.eye(4), backward, BASELINE_M, np.isfinite(xy[:, 0])
    compiled, plain = native.normal_of_reprojections(*given), plain_normal(*given)
    for found, wanted in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_the_rows_are_of_numeric_derivatives(data):
    def residual(step=None, shift=None):
        motion = MOTION if step is None else stepped(step)
        points = data.points if shift is None else data.points + shift
        return native.linearise_stereo(motion, BOTTOM_FROM_TOP, FIELD, points, data.seen).residual

    rows = native.linearise_stereo(MOTION, BOTTOM_FROM_TOP, FIELD, data.points, data.seen)
    np.testing.assert_allclose(rows.by_motion, central(lambda s: residual(step=s), 6), atol=1e-7)
    np.testing.assert_allclose(rows.by_point, central(lambda s: residual(shift=s), 3), atol=1e-7)


def test_step_of_motion_and_points_is_that_of_the_whole_system(data):
    """Points eliminated or not, the normal equations have one solution."""
    seen = data.seen[np.isfinite(data.seen).all(axis=1)][:20]
    points = data.points[np.isfinite(data.seen).all(axis=1)][:20]
    rows = native.linearise_stereo(MOTION, BOTTOM_FROM_TOP, FIELD, points, seen)
    reduced = native.reduce_stereo(MOTION, BOTTOM_FROM_TOP, points, seen)
    whole = np.zeros((160, 6 + 60))
    whole[:, :6] = rows.by_motion.reshape(160, 6)
    for k in range(20):
        whole[8 * k : 8 * k + 8, 6 + 3 * k : 9 + 3 * k] = rows.by_point[k]
    solution = np.linalg.lstsq(whole, -rows.residual.ravel(), rcond=None)[0]
    step = -np.linalg.solve(reduced.information.sum(axis=0), reduced.gradient.sum(axis=0))
    np.testing.assert_allclose(step, solution[:6], rtol=1e-5, atol=1e-9)
    wanted = reduced.point_gradient + np.einsum("mji,j->mi", reduced.point_by_motion, step)
    moves = -np.einsum("mij,mj->mi", reduced.point_inverse, wanted)
    np.testing.assert_allclose(moves.ravel(), solution[6:], rtol=1e-4, atol=1e-8)


def test_what_no_camera_saw_says_nothing(data):
    seen = np.full((1, 8), np.nan)
    rows = native.linearise_stereo(MOTION, BOTTOM_FROM_TOP, FIELD, data.points[:1], seen)
    assert not any(values.any() for values in vars(rows).values())
    reduced = native.reduce_stereo(MOTION, BOTTOM_FROM_TOP, data.points[:1], seen)
    assert reduced.freedom[0] == -3
    assert not reduced.information.any()


@pytest.mark.parametrize("name", ["points", "seen", "bottom_from_top"])
def test_arrays_that_do_not_fit_are_refused_by_name(data, name):
    given = {
        "motion": MOTION,
        "bottom_from_top": BOTTOM_FROM_TOP,
        "points": data.points,
        "seen": data.seen,
    }
    given[name] = given[name][:, :2]
    with pytest.raises(InputError, match=name):
        native.reduce_stereo(**given)


def test_views_that_do_not_fit_are_refused_by_name(data):
    xy = data.seen[:, :2]
    with pytest.raises(InputError, match="xy"):
        native.squared_reprojections(MOTION[None], data.points, xy[1:])
    with pytest.raises(InputError, match="counts"):
        native.normal_of_reprojections(
            MOTION, data.points, xy, MOTION, False, 0.1, np.ones(3, bool)
        )
