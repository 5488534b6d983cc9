# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How the features of a solved path move if the rows of images were exposed one after another.

Each leg then shears its images its own way, by what the vehicle moves within an exposure, and legs
that lie beside each other contradict each other. No calibration explains that, one time from the
first row to the last does (docs/methods.md 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, exp
from hullrecon.records.clock import seconds
from hullrecon.typing import Array, Ints32

STEP_S = 1e-3  # for derivatives
LONGEST_S = 5.0  # between two nodes from which a node's motion is known


@dataclass(frozen=True, kw_only=True)
class RowMotion:
    """By how much features move for each second from an image's first row to its last, px/s."""

    stereo: Array  # (m, 4) of a problem's table
    mono: Array  # (m, 2)

    def moved(
        self, problem: native.Problem, readout_s: float, cameras: Sequence[Camera] = tuple(Camera)
    ) -> native.Problem:
        """Move features of some cameras to where they were at their node's time."""
        stereo, mono = problem.stereo, problem.mono
        of = [camera.column for camera in cameras]
        in_stereo = np.isin(np.arange(4) // 2, of)
        in_mono = np.isin(mono.camera, of)[:, None]
        return replace(
            problem,
            stereo=replace(stereo, pixel=stereo.pixel + readout_s * in_stereo * self.stereo),
            mono=replace(mono, pixel=mono.pixel + readout_s * in_mono * self.mono),
        )


def motion_by_row(problem: native.Problem, measured: Measurements, state: State) -> RowMotion:
    """Compute how a readout time moves the features of a problem at its solution.

    Parameters
    ----------
    problem
        Without the CAD model.
    measured, state
        What it is of, and its solution.
    """
    rig = state.mounted(measured.rig)
    t_ns = measured.trajectory.t_ns
    tray = rig.poses_along(state.path, "tray")
    twist = _twists(seconds(t_ns, int(t_ns[0])), tray)

    def moved(camera: Camera, node: Ints32, landmark: Ints32, pixel: Array) -> Array:
        """Compute the motion of features, px for each second from the first row to the last.

        A feature in the last row moves as much as the tray does in that second, one in the first
        not at all.
        """
        mount, model = rig.tray_from(camera), rig.model(camera)
        seen = (tray @ mount).inverse().apply_rows(node, problem.unknowns.landmark[landmark])
        at_node = (mount.inverse() @ exp(STEP_S * twist) @ mount).apply_rows(node, seen)
        flow = (model.project(at_node) - model.project(seen)) / STEP_S
        return np.asarray(np.nan_to_num(flow * (pixel[:, 1:] / (model.height - 1))))

    stereo, mono = problem.stereo, problem.mono
    sides = [
        moved(camera, stereo.node, stereo.landmark, stereo.pixel[:, place])
        for camera, place in zip(Camera, (slice(0, 2), slice(2, 4)), strict=True)
        if len(stereo.node)
    ]
    of_one = np.zeros((len(mono.node), 2))
    for camera in Camera:
        rows = mono.camera == camera.column
        if rows.any():
            of_one[rows] = moved(camera, mono.node[rows], mono.landmark[rows], mono.pixel[rows])
    return RowMotion(stereo=np.hstack(sides) if sides else np.zeros((0, 4)), mono=of_one)


def _twists(t_s: Array, tray: Poses) -> Array:
    """Compute the tray's motion (n, 6) around each node in its own axes, m/s and rad/s.

    Zero where nodes beside it are far away.
    """
    first = np.maximum(np.arange(len(t_s)) - 1, 0)
    last = np.minimum(np.arange(len(t_s)) + 1, len(t_s) - 1)
    lasts_s = (t_s[last] - t_s[first])[:, None]
    moved = (tray[first].inverse() @ tray[last]).log()
    return np.where(lasts_s < LONGEST_S, moved / np.maximum(lasts_s, 1e-9), 0.0)
