# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`adjust` where the measurements are spoilt or too few."""

from dataclasses import replace

import numpy as np
import pytest
from adjustment.simulated_dive import simulate
from adjustment.solved_dives import solved

from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.errors import StageError
from hullrecon.records.serialisation import from_arrays, to_arrays


def quietly(measured, **options):
    return adjust(measured, AdjustOptions(**options), lambda _: None)


def rows(record, kept):
    """Those rows of a record all whose fields have one a row, but `color`."""
    return from_arrays(
        type(record), {k: v if k == "color" else v[kept] for k, v in to_arrays(record).items()}
    )


def shifted(tracks, landmark, by_px):
    """The tracks with the bottom pixels of one landmark moved."""
    bottom = tracks.bottom.copy()
    bottom[tracks.landmark == landmark] += by_px
    return replace(tracks, bottom=bottom)


def well_seen(tracks):
    both = np.isfinite(tracks.top[:, 0]) & np.isfinite(tracks.bottom[:, 0])
    return int(np.argmax(np.bincount(tracks.landmark[both])))


def seen_once_by_both(tracks, landmark):
    """The tracks with a single stereo observation of that landmark."""
    own = np.flatnonzero(
        (tracks.landmark == landmark)
        & np.isfinite(tracks.top[:, 0])
        & np.isfinite(tracks.bottom[:, 0])
    )
    return rows(
        tracks,
        np.setdiff1d(
            np.arange(len(tracks.node)),
            np.setdiff1d(np.flatnonzero(tracks.landmark == landmark), own[:1]),
        ),
    )


def test_landmark_behind_cameras_is_dropped():
    measured = simulate(cad=False).measured
    landmark = well_seen(measured.tracks)
    lone = seen_once_by_both(measured.tracks, landmark)
    assert landmark in quietly(replace(measured, tracks=lone)).chosen.landmarks
    # the bottom camera lies 0.1 m down the image: more is behind
    behind = shifted(lone, landmark, [0.0, 130.0])
    left = quietly(replace(measured, tracks=behind))
    assert landmark not in left.chosen.landmarks
    assert np.isnan(left.state.landmark[landmark]).all()


def test_observation_far_from_its_landmark_is_dropped():
    measured = simulate(cad=False).measured
    tracks, landmark = measured.tracks, well_seen(measured.tracks)
    row = int(np.flatnonzero(tracks.landmark == landmark)[0])
    top = tracks.top.copy()
    top[row] += 15.0
    found = quietly(replace(measured, tracks=replace(tracks, top=top)))
    assert not found.chosen.top[row]
    assert landmark in found.chosen.landmarks


@pytest.mark.parametrize("cad", [True, False])
def test_too_few_landmarks_are_refused_and_the_remedy_heals(cad):
    measured = simulate(cad=cad).measured
    few = rows(measured.tracks, measured.tracks.landmark < 12)
    with pytest.raises(StageError, match=r"only \d+ landmarks agree") as error:
        quietly(replace(measured, tracks=few))
    assert "without [camera.top] and [camera.bottom]" in error.value.remedy
    assert quietly(replace(measured, tracks=None)).result.converged


def test_nothing_to_register_is_refused_and_the_remedy_heals():
    measured = simulate(camera=False).measured
    few = replace(measured, returns=measured.returns.take(slice(0, 20)))
    with pytest.raises(StageError, match="fewer than 30") as error:
        quietly(few)
    assert "without [hull]" in error.value.remedy
    assert quietly(replace(few, cad_model=None)).result.converged


def test_a_dive_that_measures_no_hull_is_told_to_end_with_its_path():
    measured = simulate().measured
    with pytest.raises(StageError, match="nothing measures the hull") as error:
        quietly(replace(measured, returns=None, tracks=None))
    assert "--to navigate" in error.value.remedy  # followed in steps/test_navigate.py


def test_flagged_returns_count_for_nothing():
    measured = simulate(camera=False).measured
    flagged = replace(measured.returns, flagged=np.ones(len(measured.returns.node), bool))
    with pytest.raises(StageError, match="fewer than 30"):
        quietly(replace(measured, returns=flagged))


def test_flagged_returns_do_not_enter():
    measured = simulate().measured
    wrong = measured.returns.range_m.copy()
    wrong[::20] += 1.0
    flagged = np.zeros(len(wrong), bool)
    flagged[::20] = True
    returns = replace(measured.returns, range_m=wrong, flagged=flagged)
    found = quietly(replace(measured, returns=returns))
    np.testing.assert_array_equal(found.chosen.returns, ~flagged)
    assert len(found.problem.ranges.measured) == (~flagged).sum()
    without = quietly(replace(measured, returns=returns.take(~flagged)))
    np.testing.assert_array_equal(found.state.nodes.translation, without.state.nodes.translation)


def test_dive_without_returns_registers_stereo_landmarks():
    found = solved(ranges=False)
    assert found.adjusted.placement.registration.fitness > 0.8
    assert len(found.adjusted.problem.ranges.measured) == 0


def test_dive_without_pressure_keeps_reckoned_depth():
    measured = simulate().measured
    none = {k: v[:0] for k, v in to_arrays(measured.attitude).items() if not k.startswith("tray")}
    attitude = replace(measured.attitude, **none)
    found = quietly(replace(measured, attitude=attitude))
    assert found.result.converged
    np.testing.assert_allclose(
        found.state.nodes.translation[0], measured.trajectory.translation[0], atol=1e-3
    )


def test_without_a_cad_model_there_is_no_hull_state():
    assert solved(cad=False).adjusted.state.hull is None


def test_deviation_from_hull_is_cad_distance_less_field():
    found = solved()
    state, solution = found.adjusted.state, found.outcome.solution
    on = solution.landmarks.label == 1
    apart = state.hull.deviation(solution.landmarks.position[on])
    bare = replace(state.hull, grid=None).deviation(solution.landmarks.position[on])
    np.testing.assert_allclose(bare, solution.landmarks.deviation[on], atol=1e-6)
    assert np.std(apart) < np.std(bare)
