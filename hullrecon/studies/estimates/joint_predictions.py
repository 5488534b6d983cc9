# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What predictions of a surface have in common [Ozog2016 E.3].

The sigma of a mean offset, of an area or of a volume needs the joint covariance of the vertices.
Marginal sigmas alone give too small a sigma if errors are taken as independent, and too large a one
if as common.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.surface.gaussian import Kernel, Regression, fit
from hullrecon.typing import Array

KERNEL = Kernel((3.0, 1.5), 0.02)  # lengths in m, sigma in m: of the demo's order
RETURNS, NOISE_M = 120, 0.012
SIZES_M = np.array([0.2, 0.5, 1.0, 2.0, 3.0, 4.0])  # sides of a patch whose mean is taken
DRAWS = 300  # of fields, that the sigma is held against
SIDE_M = 6.0  # of the surveyed square


@dataclass(frozen=True, kw_only=True)
class PatchSigmas:
    """The sigma of the mean offset of patches (k) of rising size, m."""

    joint: Array  # by the joint covariance
    independent: Array  # as if every vertex were on its own
    common: Array  # as if all were off by the same
    scatter: Array  # of the errors themselves, over drawn fields


def joint_covariance(regression: Regression, wanted: Array) -> Array:
    """Compute the joint covariance (m, m) m2 of predictions at places (m, 2) [Ozog2016 E.3]."""
    cross = regression.kernel.matrix(regression.at, wanted).toarray()
    prior = regression.kernel.matrix(wanted, wanted).toarray()
    return np.asarray(prior - cross.T @ regression.factor.solve(cross))


def study() -> StudyResult:
    """Hold the sigma of a patch's mean offset against drawn fields."""
    rng = np.random.default_rng(0)
    at = SIDE_M * rng.uniform(size=(RETURNS, 2))
    regression = fit(KERNEL, at, np.zeros(RETURNS), np.full(RETURNS, NOISE_M))
    patches = [_patch(size) for size in SIZES_M]
    sigmas = patch_sigmas(rng, at, regression, patches)
    return StudyResult(figures=(draw(regression, patches[-1], sigmas),))


def _patch(size_m: float) -> Array:
    """Spread 9 x 9 vertices over a square in the middle."""
    line = 0.5 * SIDE_M + size_m * np.linspace(-0.5, 0.5, 9)
    return np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)


def patch_sigmas(
    rng: np.random.Generator, at: Array, regression: Regression, patches: list[Array]
) -> PatchSigmas:
    """Compute the sigma of each patch's mean, and its errors' scatter over drawn fields.

    at: (RETURNS, 2) m, to which the regression was fitted. patches: vertices (v, 2) m of each.
    """
    # Draw fields at returns and patches, and regress each from its noisy values at the returns
    everywhere = np.vstack([at, *patches])
    lower = np.linalg.cholesky(
        KERNEL.covariance(everywhere).toarray() + 1e-12 * np.eye(len(everywhere))
    )
    fields = lower @ rng.standard_normal((len(everywhere), DRAWS))
    seen = fields[:RETURNS] + NOISE_M * rng.standard_normal((RETURNS, DRAWS))
    weights = regression.factor.solve(seen)
    found: dict[str, list[float]] = {name: [] for name in PatchSigmas.__dataclass_fields__}
    start = RETURNS
    for patch in patches:
        covariance = joint_covariance(regression, patch)
        own = np.diag(covariance)
        count = len(patch)
        error = regression.kernel.matrix(patch, at) @ weights - fields[start : start + count]
        start += count
        # sigma of the mean by the joint covariance, as if independent, as if fully correlated
        found["joint"].append(float(np.sqrt(covariance.mean())))
        found["independent"].append(float(np.sqrt(own.sum()) / count))
        found["common"].append(float(np.sqrt(own).mean()))
        found["scatter"].append(float(np.std(error.mean(axis=0))))
    return PatchSigmas(**{name: np.array(values) for name, values in found.items()})


def draw(regression: Regression, patch: Array, sigmas: PatchSigmas) -> PublishedFigure:
    """Draw the correlation with the middle of a patch, and the sigmas by size."""
    figure, axes = new_canvas(9.6, 3.8, 1, 2)
    covariance = joint_covariance(regression, patch)
    own = np.sqrt(np.diag(covariance))
    middle = len(patch) // 2
    correlation = covariance[middle] / own[middle] / own
    drawn = axes[0][0].tricontourf(
        *patch.T, correlation, levels=np.linspace(-0.4, 1, 15), cmap="RdBu_r", vmin=-1, vmax=1
    )
    axes[0][0].scatter(regression.at[:, 0], regression.at[:, 1], s=5, color=INK, linewidths=0)
    low, high = patch.min(axis=0), patch.max(axis=0)
    axes[0][0].set(
        xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="along (m)", ylabel="girth (m)",
        aspect="equal",
    )  # fmt: skip
    axes[0][0].set_title("correlation with the middle, returns as dots", fontsize=9)
    figure.colorbar(drawn, ax=axes[0][0])
    for values, ink, style, name in (
        (sigmas.common, COLOURS["geva"], "--", "as if common"),
        (sigmas.joint, COLOURS["maxmix"], "-", "joint covariance"),
        (sigmas.independent, RED, "--", "as if independent"),
    ):
        axes[0][1].plot(SIZES_M, 1e3 * values, style, color=ink, linewidth=1.6, label=name)
    axes[0][1].plot(
        SIZES_M, 1e3 * sigmas.scatter, "o", color=GREEN, label=f"scatter of {DRAWS} fields"
    )
    axes[0][1].set(
        xlabel="side of the patch (m)", ylabel="sigma of its mean offset (mm)", yscale="log"
    )
    axes[0][1].legend(fontsize=8, frameon=False)
    table = ["side_m,joint_m,independent_m,common_m,scatter_m"]
    columns = (SIZES_M, sigmas.joint, sigmas.independent, sigmas.common, sigmas.scatter)
    table += [",".join(f"{v:.6g}" for v in row) for row in zip(*columns, strict=True)]
    ratio = sigmas.scatter / sigmas.joint
    return finish_figure(
        "joint_predictions",
        figure,
        table,
        "The sigma of a patch's mean offset by the joint covariance of its vertices is that of "
        f"drawn fields to {100 * np.abs(ratio - 1).max():.0f} %. Taken as independent it is "
        f"{(sigmas.scatter / sigmas.independent).max():.1f} times too small, as common up to "
        f"{(sigmas.common / sigmas.scatter).max():.1f} times too large.",
        (
            ComparedValue(
                what="scatter of drawn fields over the sigma by the joint covariance, worst patch",
                ours=float(ratio[np.argmax(np.abs(ratio - 1))]),
                note="printed as a formula alone",
            ),
        ),
    )
