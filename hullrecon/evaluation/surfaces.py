# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Score surfaces and landmarks against the true hull."""

from __future__ import annotations

import numpy as np

from hullrecon.evaluation.deliverables import PointCloud
from hullrecon.evaluation.trajectory import Figures, rms
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import LABEL_BOUNDARY_M
from hullrecon.typing import Array, Mask

_UNCLEAR_M = 0.02  # a landmark nearer to the label boundary may have either label


def score_surface(cloud: PointCloud, truth: Truth, motion: Poses, min_support: int) -> Figures:
    """Score the vertices of a surface that have enough support, where the true surface is known.

    Parameters
    ----------
    cloud
        Vertices in M, with support and sigma.
    truth
        Of the dive.
    motion
        The rigid motion that aligns the delivered trajectory with the true one. Figures named
        aligned_ are after it.
    min_support
        Least number of views or returns of a vertex.
    """
    keep = truth.near(cloud.points, 0.25)
    for points in (cloud.points, motion.apply(cloud.points)):
        keep &= ~truth.on_rim(truth.built.closest(points).foot)
    if "support" in cloud.fields:
        keep &= np.asarray(cloud.fields["support"], np.int64) >= min_support
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
        figures["cad_model_alone_rmse_m"] = rms(truth.cad_model.closest(foot).distance)
    if "sigma" in cloud.fields:
        figures |= _sigma_coverage(
            distance, aligned, np.asarray(cloud.fields["sigma"], float)[keep]
        )
    return figures


def score_landmarks(cloud: PointCloud, truth: Truth, motion: Poses) -> Figures:
    """Score the landmarks' distances to the true hull, and their labels.

    Label 0 is right where the true hull is off the CAD model by more than the label boundary.
    `motion` aligns the delivered trajectory with the true one.
    """
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
        foot = truth.built.closest(motion.apply(cloud.points[keep])).foot
        figures |= _score_labels(
            foot, np.asarray(cloud.fields["label"])[keep] == 0, truth.cad_model
        )
    if "sigma" in cloud.fields:
        sigma = np.asarray(cloud.fields["sigma"], float)[keep]
        known = np.isfinite(sigma) & (sigma > 0)
        figures["share_within_1_sigma"] = _share(distance[known] <= sigma[known])
    return figures


def _score_labels(foot: Array, off: Mask, cad_model: Scene) -> Figures:
    """Compute recall and precision of label 0.

    Parameters
    ----------
    foot
        Nearest points on the true hull (n, 3).
    off
        (n,) whether the landmark has label 0.
    cad_model
        In M.
    """
    away = np.abs(cad_model.closest(foot).distance)
    clear = np.abs(away - LABEL_BOUNDARY_M) > _UNCLEAR_M
    real = (away > LABEL_BOUNDARY_M) & clear
    hits = int((off & real).sum())
    return {
        "off_cad_model": int(real.sum()),
        "off_recall": hits / max(1, int(real.sum())),
        "off_precision": hits / max(1, int((off & clear).sum())),
    }


def _distances(points: Array, truth: Truth, motion: Poses) -> tuple[Array, Array, Array]:
    """Compute the distances of points to the true hull.

    Returns
    -------
    distance
        (n,) m, as delivered.
    foot
        (n, 3) m, nearest points on the true hull, as delivered.
    aligned
        (n,) m, distances after the alignment of the trajectory.
    """
    here, there = truth.built.closest(points), truth.built.closest(motion.apply(points))
    return np.abs(here.distance), here.foot, np.abs(there.distance)


def _sigma_coverage(distance: Array, aligned: Array, sigma: Array) -> Figures:
    """Compute the shares of errors that are within their sigmas.

    distance, aligned: (n,) m from the true hull, as delivered and after rigid alignment. sigma:
    (n,) m.
    """
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
