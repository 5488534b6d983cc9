# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How far surfaces and landmarks are from the steel as it is."""

from __future__ import annotations

import numpy as np

from hullrecon.evaluation.scoring.alignment import Motion, rms
from hullrecon.evaluation.scoring.deliverables import Cloud
from hullrecon.evaluation.scoring.trajectory import Figures
from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.typing import Array, Mask

OFF_M, DOUBT_M = (
    0.056,
    0.02,
)  # a landmark is off the CAD model beyond the mixture's boundary; nearer it than this it is not clear


def judge_surface(cloud: Cloud, truth: Truth, motion: Motion, least_support: int) -> Figures:
    """Of the vertices that enough views or returns stand behind, where the true surface is known."""
    keep = truth.near(cloud.points, 0.25)
    if "support" in cloud.fields:
        keep &= np.asarray(cloud.fields["support"], np.int64) >= least_support
    if not keep.any():
        return {"vertices": 0}
    distance, foot, aligned = _distances(cloud.points[keep], truth, motion)
    figures: Figures = {
        "vertices": int(keep.sum()),
        "rmse_m": rms(distance),
        "p95_m": float(np.percentile(distance, 95)),
        "aligned_rmse_m": rms(aligned),
        "aligned_median_m": float(np.median(aligned)),
    }
    if truth.cad_model is not None:
        figures["drawing_alone_rmse_m"] = rms(truth.cad_model.closest(foot).distance)
    if "sigma" in cloud.fields:
        figures |= _held(distance, aligned, np.asarray(cloud.fields["sigma"], float)[keep])
    return figures


def judge_landmarks(cloud: Cloud, truth: Truth, motion: Motion) -> Figures:
    """Their distance to the steel, and whether label 0 stands where the steel leaves the CAD model."""
    keep = truth.near(cloud.points, 0.5)
    distance, _, aligned = _distances(cloud.points[keep], truth, motion)
    figures: Figures = {
        "landmarks": len(cloud.points),
        "far_from_hull": int((~keep).sum()),
        "rmse_m": rms(distance),
        "median_m": _quantile(distance, 50),
        "p95_m": _quantile(distance, 95),
        "aligned_rmse_m": rms(aligned),
        "aligned_median_m": _quantile(aligned, 50),
    }
    if "label" in cloud.fields and truth.cad_model is not None:
        figures |= _labels(cloud.points[keep], np.asarray(cloud.fields["label"])[keep] == 0, truth, motion)
    if "sigma" in cloud.fields:
        sigma = np.asarray(cloud.fields["sigma"], float)[keep]
        known = np.isfinite(sigma) & (sigma > 0)
        figures["share_within_1_sigma"] = _share(distance[known] <= sigma[known])
    return figures


def _labels(points: Array, off: Mask, truth: Truth, motion: Motion) -> Figures:
    assert truth.cad_model is not None
    foot = truth.built.closest(motion.apply(points)).foot
    away = np.abs(truth.cad_model.closest(foot).distance)
    clear = np.abs(away - OFF_M) > DOUBT_M
    real = (away > OFF_M) & clear
    hits = int((off & real).sum())
    return {
        "off_drawing": int(real.sum()),
        "off_recall": hits / max(1, int(real.sum())),
        "off_precision": hits / max(1, int((off & clear).sum())),
    }


def _distances(points: Array, truth: Truth, motion: Motion) -> tuple[Array, Array, Array]:
    """Distance (n,) as delivered, foot (n, 3) on the steel, distance after the trajectory's alignment."""
    here, there = truth.built.closest(points), truth.built.closest(motion.apply(points))
    return np.abs(here.distance), here.foot, np.abs(there.distance)


def _held(distance: Array, aligned: Array, sigma: Array) -> Figures:
    known = np.isfinite(sigma) & (sigma > 0)
    return {
        "share_within_1.96_sigma": _share(distance[known] < 1.96 * sigma[known]),
        "share_within_1_sigma": _share(distance[known] < sigma[known]),
        "aligned_share_within_1_sigma": _share(aligned[known] < sigma[known]),
    }


def _share(hits: Mask) -> float:
    return float(np.mean(hits)) if len(hits) else float("nan")


def _quantile(values: Array, percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) else float("nan")
