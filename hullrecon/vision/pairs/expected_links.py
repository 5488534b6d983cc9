# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Predict the link that a comparison would give, from the comparisons made so far.

How many features two images have in common is predicted from their overlap and from how many
features of each were found in other images. From that number follow the probability of a match and
the information of the link.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from hullrecon.records.links import CameraLinks
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.mono_motion import DIRECTION_SIGMA_RAD, tangent_basis

# Prior of the logistic regression of a match on the expected features: probability one half where
# as many features are expected as a link needs, odds proportional to the features. With a sigma of
# one, some ten comparisons outweigh it.
PRIOR_LOGIT, PRIOR_SIGMA = np.array([0.0, 1.0]), 1.0
NEWTON_STEPS, LEAST_STEP = 50, 1e-6  # at most, and the step in the logit that ends them


@dataclass(frozen=True, kw_only=True)
class Compared:
    """The comparisons made so far."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,)
    overlap: Array  # (m,) of the footprints as predicted, NaN where no depth is known
    common: Ints  # (m,) features in common, 0 of pairs that did not match


@dataclass(frozen=True, kw_only=True)
class ExpectedLinks:
    """Predictions of links not compared yet, learnt from the comparisons of the dive.

    They tell which comparisons are worth making.
    """

    # (n,) features of a node's image that would be found in an image that overlaps it fully
    found_again: Array
    # (2,) log odds of a match: constant, and slope by the logarithm of the expected features
    logit: Array
    information: Array  # (6, 6) mean information of a link over the square of its common features
    scaled: Mask  # (n,) nodes whose links measure the length of the motion
    min_common: int  # least number of common features of a link

    def common(self, first: Ints, second: Ints, overlap: Array) -> Array:
        """Predict the number (m,) of common features of pairs (nodes (m,)) with that overlap (m,).

        The image with fewer features that are found again limits it.
        """
        return np.asarray(overlap * np.minimum(self.found_again[first], self.found_again[second]))

    def probability(self, common: Array) -> Array:
        """Compute the probability (m,) that pairs match from the predicted common features (m,)."""
        return np.asarray(expit(_regressors(common, self.min_common) @ self.logit))

    def link_information(
        self, first: Ints, second: Ints, common: Array, translation: Array
    ) -> Array:
        """Predict the information (m, 6, 6) of the links, if the pairs match.

        It grows with the square of the common features: a larger overlap has more of them, and
        farther apart. A link that does not measure its length has no information along it.

        first, second: (m,) nodes. common: (m,) predicted common features. translation: (m, 3) of
        second_from_first.
        """
        # `information` is that of a link with one common feature.
        size = np.maximum(common, self.min_common)
        out = self.information * np.square(size)[:, None, None]
        without_length = ~(self.scaled[first] & self.scaled[second])
        across = _across(translation[without_length])
        out[without_length] = across @ out[without_length] @ across
        return np.asarray(out)


def learn_links(
    nodes: int, compared: Compared, links: CameraLinks, common: Ints, min_common: int
) -> ExpectedLinks:
    """Learn to predict links from the comparisons made so far.

    Comparisons of unknown overlap are left out. How many features of a node are found again in
    other images, for an overlap of 1, is its sum over the node's comparisons. A node that was not
    compared yet gets the mean of the dive.

    Parameters
    ----------
    nodes
        Number of nodes, n.
    compared
        The comparisons.
    links
        Links of the k comparisons that matched.
    common
        Common features (k,) of these links.
    min_common
        Least number of common features of a link.
    """
    known = np.flatnonzero(np.isfinite(compared.overlap))
    first, second, overlap = (x[known] for x in (compared.first, compared.second, compared.overlap))
    found = compared.common[known]
    # Over all comparisons of a node: the sum of overlaps, and of common features.
    ends = np.concatenate([first, second])
    looked = np.bincount(ends, np.tile(overlap, 2), minlength=nodes)
    seen = np.bincount(ends, np.tile(found, 2), minlength=nodes)
    typical = found.sum() / max(float(overlap.sum()), 1e-9)
    found_again = np.where(looked > 0, seen / np.maximum(looked, 1e-9), typical)
    expected = np.asarray(overlap * np.minimum(found_again[first], found_again[second]), float)
    scaled = np.zeros(nodes, bool)
    scaled[links.first[links.scaled]] = scaled[links.second[links.scaled]] = True
    return ExpectedLinks(
        found_again=found_again,
        logit=_fit_logit(_regressors(expected, min_common), found > 0),
        # of all links, over the squares of their common features: as of a link with one
        information=_information(links).sum(axis=0) / max(float(np.square(common).sum()), 1.0),
        scaled=scaled,
        min_common=min_common,
    )


def _regressors(common: Array, min_common: int) -> Array:
    """Build the regressors (m, 2) of the log odds of a match: 1, log of the expected features."""
    return np.stack([np.ones(len(common)), np.log((common + 1) / min_common)], axis=1)


def _fit_logit(regressors: Array, matched: Mask) -> Array:
    """Fit the logistic regression of matches (m,) on regressors (m, 2) by Newton's method.

    The prior PRIOR_LOGIT defines it before the first comparison. Returns the coefficients (2,) of
    the log odds.
    """
    sign = np.where(matched, 1.0, -1.0)

    def cost(logit: Array) -> float:
        """Compute minus the log posterior of the coefficients (2,)."""
        gap = (logit - PRIOR_LOGIT) / PRIOR_SIGMA
        return float(np.logaddexp(0, -sign * (regressors @ logit)).sum() + 0.5 * gap @ gap)

    logit = PRIOR_LOGIT
    for _ in range(NEWTON_STEPS):
        chance = expit(regressors @ logit)
        gradient = regressors.T @ (chance - matched) + (logit - PRIOR_LOGIT) / PRIOR_SIGMA**2
        weight = chance * (1 - chance)
        curvature = (regressors * weight[:, None]).T @ regressors + np.eye(2) / PRIOR_SIGMA**2
        step = -np.linalg.solve(curvature, gradient)
        while cost(logit + step) > cost(logit) and np.abs(step).max() > LEAST_STEP:
            step = step / 2
        if np.abs(step).max() <= LEAST_STEP:
            break
        logit = logit + step
    return np.asarray(logit)


def _information(links: CameraLinks) -> Array:
    """Compute the information (k, 6, 6) of links.

    A link without a measured length has none along its translation. Its covariance is reduced to
    rotation and direction, and the prior of the direction is taken out.
    """
    out = np.zeros((len(links), 6, 6))
    full = np.flatnonzero(links.scaled)
    out[full] = np.linalg.inv(links.covariance[full])
    for k in np.flatnonzero(~links.scaled):
        length = float(np.linalg.norm(links.translation[k]))
        # From (translation, rotation) to (direction across the translation, rotation), in rad.
        to_five = np.zeros((5, 6))
        to_five[:2, :3] = tangent_basis(links.translation[k] / length).T / length
        to_five[2:, 3:] = np.eye(3)
        own = np.linalg.inv(to_five @ links.covariance[k] @ to_five.T)
        # The covariance holds a prior of the direction, which is no information of the matches.
        own[:2, :2] -= np.eye(2) / DIRECTION_SIGMA_RAD**2
        out[k] = to_five.T @ own @ to_five
    return out


def _across(translation: Array) -> Array:
    """Build projections (m, 6, 6) that remove the component along each translation (m, 3)."""
    length = np.linalg.norm(translation, axis=1, keepdims=True)
    along = translation / np.maximum(length, np.finfo(float).tiny)
    out = np.tile(np.eye(6), (len(along), 1, 1))
    out[:, :3, :3] -= along[:, :, None] * along[:, None, :]
    return out
