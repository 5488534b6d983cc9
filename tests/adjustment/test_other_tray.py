# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tray angles that are read wrongly are named where the CAD model fits them read otherwise."""

from dataclasses import replace

import pytest
from adjustment.test_cad_acceptance import true_path

from hullrecon.adjustment.hull_pose.other_tray import (
    READINGS,
    find_fitting_tray,
    turned_odometry,
    with_tray,
)

SOLVED = true_path(camera=False)
RIG = SOLVED.state.mounted(SOLVED.measured.rig)


def found(factor):
    """What is found where the logged angles are those of the tray times a factor."""
    m, path = SOLVED.measured, SOLVED.state.path
    turn = (factor - 1) * 0.5 * (path.tray[m.odometry.first] + path.tray[m.odometry.second])
    return find_fitting_tray(
        RIG,
        with_tray(path, m.odometry, factor * path.tray),
        turned_odometry(m.odometry, turn),
        replace(m.returns, tray_offset=factor * m.returns.tray_offset),
        m.cad_model,
    )


@pytest.mark.parametrize("reading", ["sign", "rad"])
def test_reading_with_which_the_cad_model_fits_is_named(reading):
    named, before_m, after_m = found(1 / READINGS[reading])
    assert named == reading
    assert after_m < 0.5 * before_m


def test_angles_as_they_are_are_not_doubted():
    assert found(1.0) is None
