# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors that are wrong beyond any correction: the dive is refused, and who is wrong is named."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from adjustment.simulated_dive import (
    CAMERA,
    STEP_S,
    TOP_FROM_BOTTOM,
    TRAY_FROM_TOP,
    _tray_poses,
    motion,
    moved,
    path,
    pixels_of,
    records_poses,
    simulate,
)
from adjustment.solved_dives import solved
from scipy.spatial.transform import Rotation

from hullrecon.adjustment import contradictions
from hullrecon.adjustment.bundle_adjustment import adjust, solve_path
from hullrecon.adjustment.contradictions import believe_place, explain_refusal
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.adjustment.results.adjustment_warnings import explained_as_well
from hullrecon.adjustment.rounds import ACCEPTED, Phase, RoundSolver, Verdict
from hullrecon.adjustment.suspects import Trial, best_explanations
from hullrecon.errors import ContradictionError
from hullrecon.findings.adjustment import REMEDIES, SUSPECTS
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import seconds

OPTIONS = AdjustOptions(rounds=2)
STEREO = {"landmarks": 250}
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


NO_CAMERA = {"camera": False}


@pytest.mark.parametrize("scene", [NO_CAMERA, CAMERA_ONLY], ids=["no camera", "mono"])
@pytest.mark.parametrize(
    ("depth", "words"),
    [(lambda d: 0 * d + d.mean(), "without the depths"), (lambda d: -d, "counted upwards")],
    ids=["constant", "upward"],
)
def test_depths_of_no_water_are_named(scene, depth, words):
    assert words in refused(with_depth(simulate(**scene).measured, depth))


@pytest.mark.parametrize(
    ("scene", "factor", "way"),
    [(NO_CAMERA, 3.28, "deep"), (CAMERA_ONLY, 3.28, "deep"), (NO_CAMERA, 0.6, "shallow")],
)
def test_depths_of_another_scale_are_named_with_it(scene, factor, way):
    said = refused(with_depth(simulate(**scene).measured, lambda d: factor * d))
    (found,) = re.findall(rf"depths of the pressure sensor (\d+) % too {way}", said)
    assert float(found) == pytest.approx(100 * abs(factor - 1), rel=0.07)


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


def test_a_heading_that_swings_names_the_imu_and_not_the_dvl():
    dive = simulate(**CAMERA_ONLY)
    odometry = dive.measured.odometry
    swing_deg = 6 * np.sin(np.arange(len(odometry.first) + 1) / 3)
    swung = Rotation.from_quat(odometry.quaternion) * Rotation.from_euler(
        "z", np.diff(swing_deg)[:, None], degrees=True
    )
    odometry = replace(odometry, quaternion=swung.as_quat())
    said = refused(replace(dive.measured, odometry=odometry))
    assert said.endswith("all else agrees without the IMU's turns")


def test_a_dvl_stamped_late_is_named_with_the_keys_that_heal():
    """Only where the velocity changes, so at the turn between the legs, does it show."""
    dive = simulate(**CAMERA_ONLY)
    measured = dive.measured
    t_s = seconds(measured.trajectory.t_ns, int(measured.trajectory.t_ns[0]))
    velocity = np.gradient(dive.global_from_vehicle[:, :3, 3], t_s, axis=0)
    odometry = measured.odometry
    change = np.einsum(
        "nji,nj->ni",
        dive.global_from_vehicle[odometry.first, :3, :3],
        velocity[odometry.second] - velocity[odometry.first],
    )
    late = replace(odometry, translation=odometry.translation - 0.2 * change)
    solver = solver_of(measured.rig)
    path = solve_path(replace(measured, odometry=late), solver)
    (said,) = explained_as_well(path.verdict.suspects)
    (late_s,) = re.findall(r"late beside the images' \(dvl\.time_offset = -(\S+),", said)
    assert float(late_s) == pytest.approx(0.2, abs=0.03)
    assert not solve_path(measured, solver).verdict.suspects


def test_a_dive_without_imu_and_depths_suspects_others():
    measured = with_turned(simulate(**CAMERA_ONLY).measured, "tray_from_top", 15.0)
    attitude = measured.attitude
    read = ("node", "depth", "roll", "pitch", "sigma", "nodes_per_reading")
    none = replace(attitude, **{name: getattr(attitude, name)[:0] for name in read})
    assert "depth" not in refused(replace(measured, attitude=none))


def test_a_package_that_allows_a_large_error_is_believed():
    measured = with_turned(simulate(**CAMERA_ONLY).measured, "tray_from_top", 6.0)
    rough = np.diag(1 / np.r_[np.full(3, 0.01), np.radians(np.full(3, 3.0))])
    measured = replace(measured, rig=measured.rig.with_priors(tray_from_top=rough))
    assert not adjust(measured, OPTIONS, lambda _: None).verdict.suspects


def with_pixels(measured, by_camera):
    """The dive with other pixels, by those that were seen, camera by camera."""
    tracks = measured.tracks
    seen = {name: by_camera(name, getattr(tracks, name)) for name in ("top", "bottom")}
    return replace(measured, tracks=replace(tracks, **seen))


def read_out(dive, readout_s, cameras=("top", "bottom")):
    """The measurements with rows of some cameras that were exposed one after another."""
    tracks, per_leg = dive.measured.tracks, len(dive.tray) // 2

    def by_camera(name, pixel):
        if name not in cameras:
            return pixel

        def at(time):
            poses, tray, _ = path(time, per_leg)
            top = poses @ _tray_poses(tray) @ TRAY_FROM_TOP
            camera = top if name == "top" else top @ TOP_FROM_BOTTOM
            return pixels_of(moved(np.linalg.inv(camera), dive.landmark[tracks.landmark]))

        late = readout_s * pixel[:, 1] / (CAMERA.height - 1) / STEP_S
        return pixel + np.nan_to_num(at(tracks.node + np.nan_to_num(late)) - at(tracks.node + 0.0))

    return with_pixels(dive.measured, by_camera)


def solver_of(rig):
    return RoundSolver(calibrated=rig, options=OPTIONS, strategy=PRODUCT, report=lambda _: None)


def path_rounds(measured):
    return solve_path(measured, solver_of(measured.rig))


@pytest.mark.parametrize("scene", [STEREO, CAMERA_ONLY], ids=["stereo", "mono"])
def test_readout_that_nobody_gave_is_named_and_its_remedy_heals(scene):
    dive = simulate(**scene)
    measured = read_out(dive, 0.02)
    said = refused(measured)
    assert "readout_s of camera.top" in said
    (found,) = re.findall(r"one after another, (\d+) ms", said)
    assert float(found) == pytest.approx(20, abs=2)
    healed = read_out(replace(dive, measured=measured), -1e-3 * float(found))
    assert path_rounds(healed).verdict.suspects == ()


def test_readout_of_one_camera_is_named():
    said = refused(read_out(simulate(**STEREO), 0.02, ("bottom",)))
    (found,) = re.findall(r"rows of an image of the bottom camera exposed .*?, (\d+) ms", said)
    assert float(found) == pytest.approx(20, abs=2)


@pytest.mark.parametrize("name", ["fy", "cx"])
def test_small_errors_of_a_lens_are_named_and_no_mount_is(name):
    lens = {"fy": {"fy": lambda f: 1.05 * f}, "cx": {"cx": lambda c: c + 22.0}}[name]
    said = refused(with_lens(simulate(**STEREO).measured, **lens))
    assert {"fy": "focal lengths 0.95", "cx": "principal point 2"}[name] in said
    assert "mount" not in said


def test_the_camera_whose_focal_length_is_wrong_is_named():
    measured = simulate(**STEREO).measured
    models = dict(measured.rig.camera_models)
    models[Camera.BOTTOM] = replace(CAMERA, fx=1.08 * CAMERA.fx, fy=1.08 * CAMERA.fy)
    said = refused(replace(measured, rig=replace(measured.rig, camera_models=models)))
    assert "all else agrees with the bottom camera's focal lengths 0.93" in said


def through_smooth_lens_errors(measured):
    random = np.random.default_rng(5)

    def by_camera(_, pixel):
        u, v = (2 * pixel / [CAMERA.width, CAMERA.height] - 1).T
        modes = np.stack([u * u - 1 / 3, u * v, v * v - 1 / 3, u**3 - 0.6 * u, u * v * v])
        return pixel + 0.3 * (random.normal(size=(2, 5)) @ modes).T

    return with_pixels(measured, by_camera)


@pytest.mark.parametrize("scene", [STEREO, CAMERA_ONLY], ids=["stereo", "mono"])
def test_smooth_errors_of_lenses_suspect_nobody(scene):
    measured = through_smooth_lens_errors(simulate(**scene).measured)
    assert path_rounds(measured).verdict.suspects == ()


def test_smooth_errors_that_the_calibration_states_explain_the_trials():
    """Else a long dive is refused for a distortion or a readout time that no camera has."""
    many = CAMERA_ONLY | {"landmarks": 2000}
    measured = through_smooth_lens_errors(simulate(**many).measured)
    measured = replace(measured, rig=measured.rig.with_priors(calibration_sigma_px=(0.3, 0.3)))
    solver = solver_of(measured.rig)
    trials = contradictions._try_all(solve_path(measured, solver), solver)
    assert {one.suspect for one in trials} >= {"distortion", "readout"}
    assert best_explanations(trials) == ()


def test_the_size_of_a_distortion_is_that_of_what_no_focal_length_moves():
    k1 = 0.1
    measured = with_lens(simulate(**CAMERA_ONLY).measured, k1=lambda k: k + k1)
    solver = solver_of(measured.rig)
    trials = contradictions._try_all(solve_path(measured, solver), solver)
    (found_px,) = [one.found for one in trials if one.suspect == "distortion"]
    u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    at = np.column_stack([u.ravel() - CAMERA.cx, v.ravel() - CAMERA.cy])
    moved = at * k1 * np.sum((at / CAMERA.fx) ** 2, axis=1, keepdims=True)
    left = moved - at * np.sum(moved * at) / np.sum(at**2)
    assert found_px == pytest.approx(np.sqrt(np.mean(np.sum(left**2, axis=1))), rel=0.3)


def test_a_distortion_that_calibrations_leave_is_corrected():
    measured = simulate(**CAMERA_ONLY).measured
    priors = replace(measured.rig.priors, calibration_sigma_px=(0.1, 0.1))
    solver = solver_of(replace(measured.rig, priors=priors))
    small, large = trial("distortion", 60.0, 2, 0.2), trial("distortion", 60.0, 2, 0.5)
    contradictions._refuse((small, trial("focal-length", 55.0, 2, 1.01)), [], solver)
    with pytest.raises(ContradictionError, match=re.escape("0.5 px (rms)")):
        contradictions._refuse((large,), [], solver)


def trial(suspect, gain, rows, found=None):
    return Trial(suspect=suspect, gain=gain, rows=rows, found=found)


SOUND, MOUNT = trial("dvl-scale", 500.0, 1, -0.08), trial("dvl-mount", 480.0, 3, 0.03)
DEPTHS, VELOCITIES = trial("pressure", 490.0, 100), trial("dvl-velocities", 510.0, 120)


@pytest.mark.parametrize(
    ("turned_deg", "scale", "words"),
    [
        (3.0, 0.05, None),
        (8.0, 0.0, "dvl.mount turned by 8.0 degrees"),
        (0.0, -0.2, "20 times dvl.scale_sigma"),
    ],
)
def test_what_a_cad_model_corrects_is_believed_as_far_as_a_sensor_may_be_wrong(
    turned_deg, scale, words
):
    rig = simulate(**CAMERA_ONLY).measured.rig
    mount = rig.tray_from_dvl @ records_poses(motion(0, 0, 0, 0, 0, turned_deg))
    state = SimpleNamespace(
        navigation=np.r_[scale, np.zeros(5)], mounts=replace(rig.mounts, tray_from_dvl=mount)
    )
    placed = SimpleNamespace(estimate=SimpleNamespace(state=state), verdict=ACCEPTED)
    path = SimpleNamespace(first=object(), verdict=Verdict(suspects=(MOUNT,)))
    if words is None:
        assert believe_place(path, placed, rig, solver_of(rig)) is None
        return
    with pytest.raises(ContradictionError, match=words):
        believe_place(path, placed, rig, solver_of(rig))


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
    (said,) = explained_as_well([trial("focal-length", 600.0, 4, 0.98), SOUND])
    assert "agree better with focal lengths 0.98" in said
    assert explained_as_well([]) == []


@pytest.mark.parametrize("cad", [True, False], ids=["CAD", "no CAD"])
def test_a_faultless_dive_has_no_suspects(cad):
    assert solved(cad=cad).adjusted.verdict.suspects == ()


@pytest.mark.parametrize(("squares", "blamed"), [(12.0, False), (60.0, True)])
def test_a_wrong_cad_model_is_no_matter_of_a_lens_unless_that_is_certain(
    squares, blamed, monkeypatch
):
    """A faultless lens explains some squares of any dive, and no reason why a model misses it."""
    lens = trial("distortion", squares, 2)
    monkeypatch.setattr(contradictions, "_try_all", lambda *_: (lens,))
    monkeypatch.setattr(contradictions, "_refuse_misread_ranges", lambda *_: None)
    solver = solver_of(simulate(**STEREO).measured.rig)
    path = SimpleNamespace(first=object(), verdict=ACCEPTED, estimate=None)
    placed = Phase(
        history=(),
        start=None,
        first=None,
        last=None,
        estimate=None,
        verdict=Verdict(accepted=False, reason="ft"),
    )
    if blamed:
        with pytest.raises(ContradictionError, match="another distortion"):
            explain_refusal(path, placed, solver)
    else:
        assert explain_refusal(path, placed, solver).verdict == placed.verdict
