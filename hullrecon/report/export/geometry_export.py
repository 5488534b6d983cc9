# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks and surfaces as PLY, and the alignment as JSON, for other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.dive.config.schema import Hull
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.solution import HullPose, Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.export.ply import columns, ply_bytes
from hullrecon.report.survey import Survey


def landmarks_in_hull(solution: Solution) -> NDArray[np.float64]:
    """Transform the landmarks (L, 3) to M. They stay in g without a CAD model."""
    return solution.result_from_global().apply(solution.landmarks.position)


def header_comments(survey: Survey) -> list[str]:
    """Write the comments of each PLY's header: frame and units."""
    return [
        f"frame {survey.track.frame}: {survey.frame_in_words}",
        "unit metre; sigma is one standard deviation",
    ]


def landmarks_ply(survey: Survey, solution: Solution) -> bytes:
    """Encode landmarks.ply (docs/deliverables.md).

    sigma is that of one axis: the square root of a third of the covariance's trace.
    """
    sigma = np.sqrt(np.einsum("nii->n", solution.landmarks.covariance) / 3)
    color = {
        name: solution.landmarks.color[:, k].astype(np.uint8)
        for k, name in enumerate(("red", "green", "blue"))
    }
    values = {
        "label": solution.landmarks.label.astype(np.uint8),
        "deviation": solution.landmarks.deviation.astype(np.float32),
        "sigma": sigma.astype(np.float32),
        "track": solution.landmarks.views.astype(np.int32),
    }
    return ply_bytes(
        {**columns(landmarks_in_hull(solution)), **color, **values},
        comments=header_comments(survey),
    )


def surface_ply(survey: Survey, surface: Surface, split: DeviationSplit | None = None) -> bytes:
    """Encode surface.ply or as_found.ply (docs/deliverables.md).

    as_found.ply also holds the form of the deviation, NaN without a CAD model.
    """
    values = {
        "deviation": surface.deviation.astype(np.float32),
        "sigma": surface.sigma.astype(np.float32),
        "support": surface.support.astype(np.int32),
    }
    if surface is survey.surfaces.as_found:
        lost = np.full(len(surface.vertices), np.nan, np.float32)
        values["form"] = lost if split is None else split.form.astype(np.float32)
        values["form_sigma"] = lost if split is None else split.form_sigma.astype(np.float32)
    return ply_bytes(
        {**columns(surface.vertices), **values}, surface.faces, header_comments(survey)
    )


def motion_document(motion: Poses) -> dict[str, list[float]]:
    """Write a rigid motion (a batch of one) as translation (m) and quaternion (x y z w)."""
    return {
        "translation": motion.translation[0].tolist(),
        "quaternion": motion.quaternion[0].tolist(),
    }


def alignment_document(
    hull_pose: HullPose, hull: Hull, weak_directions: Sequence[Mapping[str, object]]
) -> dict[str, object]:
    """Build alignment.json (docs/deliverables.md): T_g_M, its first guess, weak directions.

    The covariance is that of the hull's pose in g, the CAD model's error included
    (HullPose.covariance).
    """
    return {
        "T_g_M": motion_document(hull_pose.global_from_hull),
        "covariance": hull_pose.covariance.tolist(),
        "covariance_order": "translation x y z in g (m), "
        "rotation x y z perturbed on the right (rad), about survey_center",
        "survey_center": hull_pose.survey_center.tolist(),
        "prior": {
            **motion_document(from_mount(hull.pose)),
            "sigma_m_deg": guess_sigma(hull.pose, hull.pose_sigma).tolist(),
        },
        "weak_directions": list(weak_directions),
    }
