# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How the features of a solved path move if the rows of images were exposed one after another.

The vehicle moves between the first row and the last, so the shear of images differs from leg to
leg, and adjacent legs contradict each other. No calibration explains that. One readout time, from
the first row to the last, does (docs/methods.md 6).
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

STEP_S = 1e-3  # of the numeric derivatives
LONGEST_S = 5.0  # longest time between the neighbours of a node that give its motion


@dataclass(frozen=True, kw_only=True)
class RowMotion:
    """Shift of features to their node's time for each second of readout time, px/s."""

    stereo: Array  # (m, 4) of the rows of a problem's stereo table
    mono: Array  # (m, 2) of the rows of its mono table

    def moved(
        self, problem: native.Problem, readout_s: float, cameras: Sequence[Camera] = tuple(Camera)
    ) -> native.Problem:
        """Move features to where they were at their node's time, given a readout time.

        Parameters
        ----------
        problem
            Its stereo and mono tables have the features, in the order of the motion's rows.
        readout_s
            Time from the first row to the last.
        cameras
            The features of these are moved, and the others stay.
        """
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
    """Compute how a readout time shifts the features of a problem at its solution.

    Parameters
    ----------
    problem
        The features and landmarks. It has no CAD model, and is at its solution.
    measured, state
        The measurements of which the problem was made, and its solution as a state.
    """
    rig = state.mounted(measured.rig)
    t_ns = measured.trajectory.t_ns
    tray = rig.poses_along(state.path, "tray")
    twist = _twists(seconds(t_ns, int(t_ns[0])), tray)

    def shifts(camera: Camera, node: Ints32, landmark: Ints32, pixel: Array) -> Array:
        """Compute the shift (n, 2) of features to their node's time, px/s of readout time.

        The node's time is that of the first row. A feature in the last row was exposed the whole
        readout time later, one in the first row at that time.

        camera: which sees them. node, landmark, pixel: of each feature (n,), its pixel (n, 2).
        """
        mount, model = rig.tray_from(camera), rig.model(camera)
        seen = (tray @ mount).inverse().apply_rows(node, problem.unknowns.landmark[landmark])
        # Where a point that is seen like this STEP_S later is seen at the node's time
        at_node = (mount.inverse() @ exp(STEP_S * twist) @ mount).apply_rows(node, seen)
        flow = (model.project(at_node) - model.project(seen)) / STEP_S
        return np.asarray(np.nan_to_num(flow * (pixel[:, 1:] / (model.height - 1))))

    stereo, mono = problem.stereo, problem.mono
    sides = [
        shifts(camera, stereo.node, stereo.landmark, stereo.pixel[:, columns])
        for camera, columns in zip(Camera, (slice(0, 2), slice(2, 4)), strict=True)
        if len(stereo.node)
    ]
    of_one = np.zeros((len(mono.node), 2))
    for camera in Camera:
        rows = mono.camera == camera.column
        if rows.any():
            of_one[rows] = shifts(camera, mono.node[rows], mono.landmark[rows], mono.pixel[rows])
    return RowMotion(stereo=np.hstack(sides) if sides else np.zeros((0, 4)), mono=of_one)


def _twists(t_s: Array, tray: Poses) -> Array:
    """Compute the tray's velocity (n, 6) at each node in its own axes, m/s and rad/s.

    It is the motion between the two neighbouring nodes over its duration. Zero where these are more
    than LONGEST_S apart.
    """
    first = np.maximum(np.arange(len(t_s)) - 1, 0)
    last = np.minimum(np.arange(len(t_s)) + 1, len(t_s) - 1)
    lasts_s = (t_s[last] - t_s[first])[:, None]
    moved = (tray[first].inverse() @ tray[last]).log()
    return np.where(lasts_s < LONGEST_S, moved / np.maximum(lasts_s, 1e-9), 0.0)
