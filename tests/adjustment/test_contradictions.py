# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors that are wrong beyond any correction: the dive is refused, and who is wrong is named."""

import re
from dataclasses import replace

import numpy as np
import pytest
from adjustment.simulated_dive import motion, records_poses, simulate
from adjustment.solved_dives import solved

from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.results.summary import explained_as_well
from hullrecon.adjustment.suspects import Trial, best_explanations
from hullrecon.errors import ContradictionError
from hullrecon.findings.adjustment import REMEDIES, SUSPECTS

OPTIONS = AdjustOptions(rounds=2)
CAMERA_ONLY = {"stereo": False, "cad": False, "landmarks": 250}


def with_depth(measured, depth):
    """The dive with other depths, by those that were measured."""
    attitude = measured.attitude
    return replace(measured, attitude=replace(attitude, depth=depth(attitude.depth)))


def with_lens(measured, **intrinsics):
    """The dive with a calibration of other intrinsics, each by that of the true one."""
    models = {
        camera: replace(
            model, **{name: by(getattr(model, name)) for name, by in intrinsics.items()}
        )
        for camera, model in measured.rig.camera_models.items()
    }
    return replace(measured, rig=replace(measured.rig, camera_models=models))


def with_turned(measured, mount, deg):
    rig = measured.rig
    turned = getattr(rig, mount) @ records_poses(motion(0, 0, 0, 0, 0, deg))
    return replace(measured, rig=replace(rig, **{mount: turned}))


def refused(measured):
    with pytest.raises(ContradictionError) as found:
        adjust(measured, OPTIONS, lambda _: None)
    assert found.value.exit_code == 3
    return found.value.what


@pytest.mark.parametrize(
    "depth",
    [lambda d: 0 * d + d.mean(), lambda d: 3.28 * d, lambda d: -d],
    ids=["constant", "in feet", "upward"],
)
@pytest.mark.parametrize("scene", [{"camera": False}, CAMERA_ONLY], ids=["no camera", "mono"])
def test_depths_of_no_water_are_named(scene, depth):
    said = refused(with_depth(simulate(**scene).measured, depth))
    assert SUSPECTS["pressure"](None) in said


def test_depths_left_away_as_advised_heal():
    assert "leave topics.pressure away" in REMEDIES["pressure"]
    measured = simulate(camera=False).measured
    wrong = with_depth(measured, lambda d: 0 * d + d.mean())
    attitude = wrong.attitude
    unread = replace(
        attitude,
        depth=measured.trajectory.translation[attitude.node, 2],
        sigma=attitude.sigma * np.array([1e3, 1.0, 1.0]),
        nodes_per_reading=np.zeros(len(attitude.node)),
    )
    adjusted = adjust(replace(wrong, attitude=unread), OPTIONS, lambda _: None)
    assert adjusted.verdict.accepted


@pytest.mark.parametrize(("factor", "cause"), [(1 / 1.333, "calibrated in air"), (1.333, "again")])
def test_a_calibration_of_another_medium_is_named_by_its_factor(factor, cause):
    lens = dict.fromkeys(("fx", "fy"), lambda f: factor * f)
    said = refused(with_lens(simulate(**CAMERA_ONLY).measured, **lens))
    (found,) = re.findall(r"focal lengths (\d\.\d+) times the calibration's", said)
    assert float(found) == pytest.approx(1 / factor, abs=0.05)
    assert cause in said


def test_a_principal_point_that_is_none_is_named():
    lens = dict.fromkeys(("cx", "cy"), lambda _: 0.0)
    said = refused(with_lens(simulate(**CAMERA_ONLY).measured, **lens))
    assert "principal point" in said


def test_a_mount_that_is_turned_by_15_degrees_is_named():
    said = refused(with_turned(simulate(**CAMERA_ONLY).measured, "tray_from_top", 15.0))
    assert "camera.top.mount turned by 1" in said
    assert "dvl.mount" not in said


def test_a_package_that_allows_a_large_error_is_believed():
    measured = with_turned(simulate(**CAMERA_ONLY).measured, "tray_from_top", 6.0)
    rough = np.diag(1 / np.r_[np.full(3, 0.01), np.radians(np.full(3, 3.0))])
    measured = replace(measured, rig=measured.rig.with_priors(tray_from_top=rough))
    assert not adjust(measured, OPTIONS, lambda _: None).verdict.suspects


def trial(suspect, gain, rows, found=None):
    return Trial(suspect=suspect, gain=gain, rows=rows, found=found)


SOUND, MOUNT = trial("dvl-scale", 500.0, 1, -0.08), trial("dvl-mount", 480.0, 3, 0.03)
DEPTHS, VELOCITIES = trial("pressure", 490.0, 100), trial("dvl-velocities", 510.0, 120)


def test_a_sensor_is_not_named_beside_its_own_error():
    assert best_explanations([VELOCITIES, SOUND]) == (SOUND,)
    assert best_explanations([VELOCITIES]) == (VELOCITIES,)


def test_what_noise_explains_names_nobody():
    assert best_explanations([trial("pressure", 30.0, 100), trial("dvl-scale", 3.0, 1)]) == ()


def test_all_that_explain_as_much_are_named():
    assert best_explanations([SOUND, DEPTHS, MOUNT]) == (SOUND, DEPTHS, MOUNT)
    assert best_explanations([SOUND, trial("pressure", 300.0, 100)]) == (SOUND,)


def test_a_scale_that_no_unit_has_explains_nothing():
    assert best_explanations([trial("dvl-scale", 500.0, 1, -2.2), DEPTHS]) == (DEPTHS,)


def test_a_correction_that_another_explains_as_well_is_doubted():
    (said,) = explained_as_well([SOUND, DEPTHS])
    assert "which of them is wrong is not known" in said
    assert SUSPECTS["pressure"](None) in said
    assert explained_as_well([SOUND]) == []
    assert explained_as_well([]) == []


@pytest.mark.parametrize("cad", [True, False], ids=["CAD", "no CAD"])
def test_a_faultless_dive_has_no_suspects(cad):
    assert solved(cad=cad).adjusted.verdict.suspects == ()
