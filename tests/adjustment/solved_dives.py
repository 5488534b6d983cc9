# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated dives adjusted once a session, and how far they end from truth."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from adjustment.simulated_dive import GLOBAL_FROM_HULL, SimulatedDive, aligning, moved, simulate
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.bundle_adjustment import Adjusted, adjust
from hullrecon.adjustment.results.summary import Outcome, summarise_adjustment
from hullrecon.studies.methods.adjust_variant import VariantOptions, strategy_of

SCENE = ("stereo", "cad", "ranges", "camera", "per_leg", "landmarks", "seed")


@dataclass(frozen=True, kw_only=True)
class SolvedDive:
    dive: SimulatedDive
    options: VariantOptions
    adjusted: Adjusted
    outcome: Outcome

    @property
    def landmark_truth(self):
        """Of the landmarks that entered, in the solution's order."""
        return self.dive.landmark[self.adjusted.chosen.landmarks]

    @property
    def on_hull_truth(self):
        return self.dive.on_hull[self.adjusted.chosen.landmarks]

    def position_errors_m(self):
        """Of the vehicle (n, 3) in the true g, after the best rigid alignment."""
        truth, found = (
            self.dive.global_from_vehicle[:, :3, 3],
            self.outcome.solution.global_from_vehicle.translation,
        )
        return moved(aligning(found, truth), found) - truth

    def turn_errors_rad(self):
        """Angles (n,) after alignment, less what is common to all: camera and vehicle may turn
        together on the tray.
        """
        truth, found = (
            self.dive.global_from_vehicle,
            self.outcome.solution.global_from_vehicle.matrix(),
        )
        laid = aligning(found[:, :3, 3], truth[:, :3, 3]) @ found
        apart = Rotation.from_matrix(np.swapaxes(truth[:, :3, :3], 1, 2) @ laid[:, :3, :3])
        return (apart.mean().inv() * apart).magnitude()

    def landmark_errors_m(self):
        """Distances (L,) after the best rigid alignment."""
        found = self.outcome.solution.landmarks.position
        return np.linalg.norm(
            moved(aligning(found, self.landmark_truth), found) - self.landmark_truth, axis=1
        )

    def hull_error(self):
        """(6,): T_g_M less its truth, (m in g, rad in M) about the survey's centre; g laid on the
        true one by the landmarks.
        """
        solution = self.outcome.solution
        center = solution.hull_pose.survey_center
        laid = aligning(solution.landmarks.position, self.landmark_truth)
        found = laid @ self.adjusted.state.hull.global_from_hull.matrix()[0]
        shift = laid[:3, :3].T @ (moved(found, center) - moved(GLOBAL_FROM_HULL, center))
        turn = Rotation.from_matrix(GLOBAL_FROM_HULL[:3, :3].T @ found[:3, :3]).as_rotvec()
        return np.r_[shift, turn]

    def pose_errors_in_hull(self):
        """(n, 6): T_M_v less its truth, m in M, rad in v."""
        truth = np.linalg.inv(GLOBAL_FROM_HULL) @ self.dive.global_from_vehicle
        found = (
            self.adjusted.state.hull.global_from_hull.inverse()
            @ self.outcome.solution.global_from_vehicle
        ).matrix()
        turn = Rotation.from_matrix(
            np.swapaxes(truth[:, :3, :3], 1, 2) @ found[:, :3, :3]
        ).as_rotvec()
        return np.c_[found[:, :3, 3] - truth[:, :3, 3], turn]


@lru_cache
def solved(**chosen):
    """The simulated dive of these arguments, adjusted with the options and variant among them."""
    dive = simulate(**{k: v for k, v in chosen.items() if k in SCENE})
    options = VariantOptions(**{k: v for k, v in chosen.items() if k not in SCENE})
    adjusted = adjust(dive.measured, options, lambda _: None, strategy_of(options))
    return SolvedDive(
        dive=dive,
        options=options,
        adjusted=adjusted,
        outcome=summarise_adjustment(dive.measured, adjusted, options),
    )
