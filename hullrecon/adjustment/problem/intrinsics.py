# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The cameras' intrinsics as unknowns with priors (docs/methods.md 6), where they are refined.

Every round starts from the calibration and not from the previous round's result, because the
solver takes the start values as the mean of the prior.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from hullrecon import native
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array

NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
_FAR_SIGMAS = 3.0  # of its prior, beyond which a parameter is warned of


def prior_sigma(camera: CameraModel, options: AdjustOptions) -> Array:
    """Compute the prior sigmas (9,) in the order of NAMES: four in px, then five coefficients.

    The sigma of tangential coefficients is a tenth of that of radial ones.
    """
    radial, center = options.distortion_sigma, options.center_sigma_px
    focal = options.focal_sigma * np.array([camera.fx, camera.fy])
    return np.asarray(
        np.r_[focal, center, center, radial, radial, 0.1 * radial, 0.1 * radial, radial]
    )


def free_intrinsics(
    problem: native.Problem, calibrated: Rig, options: AdjustOptions
) -> native.Problem:
    """Make the intrinsics of cameras that have observations unknowns, started at the calibration.

    Returns the problem unchanged without `refine_intrinsics`.
    """
    if not options.refine_intrinsics or calibrated.top is None:
        return problem
    seen = {"top": _saw(problem, 0), "bottom": calibrated.bottom is not None and _saw(problem, 1)}
    unknowns = replace(problem.unknowns, intrinsics_top=calibrated.top.parameters())
    if calibrated.bottom is not None:
        unknowns = replace(unknowns, intrinsics_bottom=calibrated.bottom.parameters())
    priors = replace(problem.priors, intrinsics_sigma=prior_sigma(calibrated.top, options))
    return replace(problem, unknowns=unknowns, priors=priors).free(
        *(f"intrinsics_{name}" for name, saw in seen.items() if saw)
    )


def apply_intrinsics(
    m: Measurements, problem: native.Problem, result: native.Result
) -> Measurements:
    """Replace the intrinsics that were unknowns in a problem by those of its solution."""
    rig = m.rig
    if "intrinsics_top" not in problem.constant and rig.top is not None:
        rig = _with_camera(rig, Camera.TOP, result.unknowns.intrinsics_top)
    if "intrinsics_bottom" not in problem.constant and rig.bottom is not None:
        rig = _with_camera(rig, Camera.BOTTOM, result.unknowns.intrinsics_bottom)
    return m if rig is m.rig else replace(m, rig=rig)


def summarise_intrinsics(
    calibrated: Rig, found: Rig, marginals: native.Covariance, options: AdjustOptions
) -> dict[str, Any]:
    """Tabulate the intrinsics that were estimated, for adjust.json.

    Parameters
    ----------
    calibrated, found
        Rigs before and after the adjustment.
    marginals
        Covariances. Those of intrinsics that were held are zero, and these are left out.
    options
        The prior sigmas, by which differences are divided.

    Returns
    -------
    dict
        By camera and parameter: the calibrated value, the estimate, its sigma, and the difference
        in sigmas of the prior.
    """
    out: dict[str, Any] = {}
    for name, covariance in (
        ("top", marginals.intrinsics_top),
        ("bottom", marginals.intrinsics_bottom),
    ):
        before, after, sigma = (
            getattr(calibrated, name),
            getattr(found, name),
            np.sqrt(np.maximum(np.diag(covariance), 0)),
        )
        if before is None or not sigma.any():
            continue
        start, end, prior = (
            before.parameters(),
            after.parameters(),
            prior_sigma(calibrated.top or before, options),
        )
        out[name] = {
            key: {
                "calibrated": float(a),
                "found": float(b),
                "sigma": float(s),
                "moved_in_prior_sigma": float((b - a) / p),
            }
            for key, a, b, s, p in zip(NAMES, start, end, sigma, prior, strict=True)
        }
    return out


def intrinsics_warnings(figures: dict[str, Any]) -> list[str]:
    """Warn of each camera with a parameter that moved beyond _FAR_SIGMAS of its prior.

    figures: as of `summarise_intrinsics`.
    """
    warnings = []
    for name, values in figures.items():
        far = {key: v for key, v in values.items() if abs(v["moved_in_prior_sigma"]) > _FAR_SIGMAS}
        if far:
            moved = ", ".join(
                f"{key} from {v['calibrated']:.5g} to {v['found']:.5g}" for key, v in far.items()
            )
            warnings.append(
                f"The calibration of camera.{name} does not fit the dive: {moved}, as estimated."
            )
    return warnings


def camera_fields(camera: CameraModel) -> dict[str, float]:
    """Collect the camera's parameters by name, as written to cameras.json."""
    return {name: getattr(camera, name) for name in camera.__dataclass_fields__}


def _saw(problem: native.Problem, camera: int) -> bool:
    return bool(len(problem.stereo.node) or (problem.mono.camera == camera).any())


def _with_camera(rig: Rig, camera: Camera, parameters: Array) -> Rig:
    before = rig.camera_models[camera]
    found = CameraModel(before.width, before.height, *(float(value) for value in parameters))
    return replace(rig, camera_models={**rig.camera_models, camera: found})
