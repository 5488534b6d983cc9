# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lenses that their calibrations do not know: what is found, and that sigmas count the rest."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hullrecon import native
from hullrecon.adjustment.problem.lens import (
    apply_lenses,
    displacement,
    estimate_lens_sigma,
    free_lenses,
    lens_warnings,
    mode_shares,
    summarise_lenses,
)
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import read_blocks
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_rpy, identity
from hullrecon.records.tracks import Tracks
from hullrecon.rig import Rig, RigPriors
from hullrecon.typing import Array

IMAGE = CameraModel(400, 320, 330.0, 330.0, 199.5, 159.5)
NOISE_PX, STEP_M, DISTANCE_M, BASELINE_M = 0.15, 0.15, 1.0, 0.1
SIGMA_PX = np.array([0.1, 0.1])
OPTIONS = native.Options(method="naive", initial_radius=1e8)
GRID = np.stack(np.meshgrid(np.arange(0, 400, 8.0), np.arange(0, 320, 8.0)), -1).reshape(-1, 2)


def lens_modes(pixels: Array) -> Array:
    """The modes (n, LENS_MODES) at pixels (n, 2), as native/factors/lens.h has them."""
    at, degree = (2 * pixels + 1) / [400, 320] - 1, native.LENS_DEGREE
    unit_rms = np.sqrt(2 * np.arange(degree + 1) + 1)
    u, v = (np.polynomial.legendre.legvander(at[:, k], degree) * unit_rms for k in range(2))
    orders = [(n, total - n) for total in range(2, degree + 1) for n in range(total + 1)]
    return np.stack([u[:, along_u] * v[:, along_v] for along_u, along_v in orders], axis=1)


def test_modes_are_orthogonal_and_free_of_what_a_calibration_finds() -> None:
    u, v = np.meshgrid(np.arange(400.0), np.arange(320.0))
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    modes = lens_modes(pixels)
    np.testing.assert_allclose(modes.T @ modes / len(modes), np.eye(native.LENS_MODES), atol=2e-3)
    linear = np.column_stack([np.ones(len(pixels)), pixels / 400 - 0.5])
    assert np.abs(linear.T @ modes / len(modes)).max() < 1e-3


def test_shares_make_the_rms_of_a_displacement_that_of_the_calibration() -> None:
    rng = np.random.default_rng(0)
    drawn = 0.1 * mode_shares() * rng.normal(size=(300, 2 * native.LENS_MODES))
    squares = [(displacement(GRID, IMAGE, lens) ** 2).sum(axis=1).mean() for lens in drawn]
    assert np.sqrt(np.mean(squares)) == pytest.approx(0.1, rel=0.05)


def waves(rms_px: float, rng: np.random.Generator) -> Array:
    """A displacement (n, 2) at GRID of another kind than the modes are, as numbers of modes.

    Waves of at most one period over the image. Their fit to the modes leaves less than a tenth.
    """
    at = (2 * GRID + 1) / [400, 320] - 1
    waves_px = np.stack(
        [
            sum(np.cos(at @ rng.uniform(-np.pi, np.pi, 2) + rng.uniform(0, 6)) for _ in range(6))
            for _ in range(2)
        ],
        axis=1,
    )
    known = np.column_stack([np.ones(len(at)), at])
    waves_px -= known @ np.linalg.lstsq(known, waves_px, rcond=None)[0]
    waves_px *= rms_px / np.sqrt((waves_px**2).sum(axis=1).mean())
    return np.linalg.lstsq(lens_modes(GRID), waves_px, rcond=None)[0].T.ravel()


def strip(lenses: Array, rng: np.random.Generator) -> tuple[Measurements, native.Problem]:
    """Two legs of 4.5 m there and back over a plate with relief, seen by both cameras.

    Cameras look along the vehicle's z. The problem starts at the truth; its lenses are held.
    """
    x = np.arange(30) * STEP_M
    path = np.vstack([np.c_[x, 0 * x], np.c_[x[::-1], 0 * x + 0.45]])
    nodes = from_rpy(np.c_[path, 0.03 * np.sin(path[:, 0])], 0.02 * rng.normal(size=(60, 3)))
    spots = rng.uniform([-0.6, -0.5], [x[-1] + 0.6, 0.95], (500, 2))
    landmark = np.c_[spots, DISTANCE_M + 0.05 * rng.normal(size=500)]
    node, seen = [], []
    pixel: list[Array] = []
    for k in range(len(nodes)):
        at = nodes[k].inverse().apply(landmark)
        both = [IMAGE.project(at), IMAGE.project(at - [0, BASELINE_M, 0])]
        both = [_seen_through(p, lens) for p, lens in zip(both, lenses, strict=True)]
        inside = np.all([(p > 8) & (p < [392, 312]) for p in both], axis=(0, 2))
        node.append(np.full(inside.sum(), k))
        seen.append(np.flatnonzero(inside))
        pixel.append(np.hstack(both)[inside])
    kept, number = np.unique(np.concatenate(seen), return_inverse=True)
    landmark = landmark[kept]
    measured = np.vstack(pixel) + NOISE_PX * rng.normal(size=(len(np.concatenate(node)), 4))
    stereo = native.StereoTable(
        node=np.concatenate(node).astype(np.int32),
        landmark=number.astype(np.int32),
        pixel=measured,
    )
    return _measurements(stereo, len(landmark)), _problem(nodes, landmark, stereo, rng)


def _seen_through(pixel: Array, lens: Array) -> Array:
    """The pixels (n, 2) that a lens shows where its calibration has `pixel`."""
    inside = np.clip(pixel, 0, [399, 319])
    return pixel - displacement(inside, IMAGE, lens)


def _measurements(stereo: native.StereoTable, landmarks: int) -> Measurements:
    order = np.lexsort((stereo.node, stereo.landmark))
    tracks = Tracks(
        landmark=stereo.landmark[order],
        node=stereo.node[order],
        top=stereo.pixel[order, :2],
        bottom=stereo.pixel[order, 2:],
        response=np.full(len(order), np.nan),
        color=np.zeros((landmarks, 3), np.uint8),
    )
    rig = Rig(
        tray_origin=np.zeros(3),
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(),
        camera_models=dict.fromkeys(Camera, IMAGE),
        priors=RigPriors(calibration_sigma_px=(0.1, 0.1)),
    )
    nothing: Any = None
    return Measurements(
        trajectory=nothing,
        odometry=nothing,
        returns=None,
        attitude=nothing,
        tracks=tracks,
        rig=rig,
        cad_model=None,
    )


def _problem(
    nodes: Poses, landmark: Array, stereo: native.StereoTable, rng: np.random.Generator
) -> native.Problem:
    n, attitude_sigma = len(nodes), np.array([0.02, 0.002, 0.002])
    steps = (nodes[:-1].inverse() @ nodes[1:]).vectors()
    steps[:, :3] += 0.01 * rng.normal(size=(n - 1, 3))
    level = np.c_[nodes.translation[:, 2], nodes.rotation.as_euler("xyz")[:, :2]]
    return native.Problem(
        unknowns=native.Unknowns(
            pose=np.hstack([nodes.vectors(), np.zeros((n, 1))]),
            landmark=landmark,
            T_ct_cb=np.array([0, BASELINE_M, 0, 0, 0, 0, 1.0]),
            intrinsics_top=IMAGE.parameters(),
            intrinsics_bottom=IMAGE.parameters(),
        ),
        constant=(
            "T_g_M",
            "T_ct_cb",
            "T_s_ct",
            "T_s_d",
            "deviation",
            "intrinsics_bottom",
            "intrinsics_top",
            "navigation",
            "tray",
        ),
        priors=native.Priors(
            pose=native.PosePriors(
                node=np.zeros(1, np.int32),
                value=nodes.vectors()[:1],
                sqrt_information=1e4 * np.eye(6)[None],
            )
        ),
        attitude=native.AttitudeTable(
            node=np.arange(n, dtype=np.int32),
            measured=level + attitude_sigma * rng.normal(size=(n, 3)),
            sigma=np.tile(attitude_sigma, (n, 1)),
        ),
        odometry=native.OdometryTable(
            first=np.arange(n - 1, dtype=np.int32),
            second=np.arange(1, n, dtype=np.int32),
            measured=steps,
            sqrt_information=np.tile(np.diag([100.0] * 3 + [50.0] * 3), (n - 1, 1, 1)),
            by_navigation=np.zeros((n - 1, 6, 2)),
            by_mount=np.zeros((n - 1, 6, 3)),
            by_tray=np.zeros((n - 1, 6)),
            tray=np.zeros(n - 1),
        ),
        stereo=stereo,
        sigma_px=NOISE_PX,
    )


def _off(problem: native.Problem, true: native.Problem) -> tuple[Array, Array]:
    """Errors (n, 3) m of the solved places of the vehicle, and their sigmas."""
    solved = problem.started_from(native.solve(problem, OPTIONS).unknowns)
    variance = np.einsum("nii->ni", native.covariance(solved, OPTIONS).pose[1:, :3, :3])
    return (solved.unknowns.pose - true.unknowns.pose)[1:, :3], np.sqrt(variance)


def test_sigmas_count_lenses_of_a_tenth_of_a_pixel_and_the_bend_is_smaller() -> None:
    """Of eight dives, each with lenses and noise of its own."""
    held, free = [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        m, true = strip(np.stack([waves(0.1, rng), waves(0.1, rng)]), rng)
        held.append(_off(true, true))
        free.append(_off(free_lenses(true, m, SIGMA_PX), true))

    def ratio(found: list[tuple[Array, Array]]) -> float:
        return float(np.sqrt(np.mean([(error / sigma) ** 2 for error, sigma in found])))

    def rms_m(found: list[tuple[Array, Array]]) -> float:
        return float(np.sqrt(np.mean([error**2 for error, _ in found])))

    assert ratio(held) > 2
    assert 0.5 < ratio(free) < 1.6
    assert rms_m(free) < 0.5 * rms_m(held)


def test_pixels_are_moved_by_what_was_found_and_the_prior_with_them() -> None:
    rng = np.random.default_rng(3)
    truth = np.stack([waves(0.2, rng), waves(0.2, rng)])
    m, problem = strip(truth, rng)
    first = free_lenses(problem, m, SIGMA_PX)
    once = native.solve(first, OPTIONS)
    moved = apply_lenses(m, first, once)
    assert m.tracks is not None
    np.testing.assert_allclose(moved.lenses[0], once.unknowns.lens_top)
    (tracks,) = (block.tracks for block in read_blocks(moved))
    np.testing.assert_allclose(
        tracks.top - m.tracks.top, displacement(m.tracks.top, IMAGE, moved.lenses[0]), atol=1e-12
    )
    np.testing.assert_allclose(
        displacement(GRID, IMAGE, moved.lenses[0]),
        lens_modes(GRID) @ moved.lenses[0].reshape(2, -1).T,
        atol=1e-14,
    )
    # solved again on the moved pixels, nothing is left to find
    pixel = np.hstack([tracks.top, tracks.bottom])
    again = replace(problem, stereo=replace(problem.stereo, pixel=pixel, **_rows(tracks)))
    second = native.solve(free_lenses(again, moved, SIGMA_PX), OPTIONS)
    assert np.abs(second.unknowns.lens_top).max() < 1e-3
    marginals = native.covariance(first.started_from(once.unknowns), OPTIONS)
    told = summarise_lenses(m.rig, moved.lenses, marginals)
    assert set(told) == {"top", "bottom"}
    assert told["top"]["displacement_px"] == pytest.approx(np.linalg.norm(moved.lenses[0]))
    assert told["top"]["sigma_px"] < told["top"]["calibration_sigma_px"]


@pytest.mark.parametrize("rms_px", [0.0, 0.02, 0.1, 0.25])
def test_the_modes_that_were_found_tell_how_good_a_lens_is(rms_px: float) -> None:
    rng = np.random.default_rng(1)
    found = np.stack([waves(rms_px, rng) if rms_px else np.zeros(36) for _ in range(2)])
    np.testing.assert_allclose(
        estimate_lens_sigma(found, SIGMA_PX), rms_px or 0.005, rtol=0.35 if rms_px else 0
    )
    np.testing.assert_allclose(estimate_lens_sigma(100 * found + 5, SIGMA_PX), 0.3)
    assert not estimate_lens_sigma(found, np.zeros(2)).any()


def _rows(tracks: Tracks) -> dict[str, Any]:
    return {"node": tracks.node.astype(np.int32), "landmark": tracks.landmark.astype(np.int32)}


def test_a_lens_that_is_said_to_be_exact_is_held() -> None:
    m, problem = strip(np.zeros((2, 2 * native.LENS_MODES)), np.random.default_rng(0))
    assert free_lenses(problem, m, np.zeros(2)) is problem
    one = free_lenses(problem, m, np.array([0.1, 0.0]))
    assert "lens_bottom" in one.constant
    assert "lens_top" not in one.constant


def test_a_lens_is_warned_of_beyond_its_calibrations_sigma_and_its_own() -> None:
    def warnings(displacement_px: float, sigma_px: float) -> list[str]:
        found = {"displacement_px": displacement_px, "sigma_px": sigma_px}
        return lens_warnings({"top": {**found, "calibration_sigma_px": 0.1}})

    (line,) = warnings(0.36, 0.07)
    assert "the top camera's lens 0.36 ± 0.07 px (rms) off its calibration, 4 times" in line
    assert warnings(0.2, 0.01) == []  # two sigmas of the calibration
    assert warnings(0.36, 0.2) == []  # not known well enough to say
