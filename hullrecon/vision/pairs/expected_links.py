# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Foresee the link that a comparison would give, from the comparisons made so far.

How many features two images have in common follows from their overlap and from how many of either
were found again elsewhere. How probably they match, and what the link would tell, follow from that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from hullrecon.records.links import CameraLinks
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.mono_motion import DIRECTION_SIGMA_RAD, tangent_basis

# Logit of a match: half where as many features as a link needs are expected, and the odds grow as
# the features do. A sigma of one leaves the slope and the middle to some ten comparisons.
PRIOR_LOGIT, PRIOR_SIGMA = np.array([0.0, 1.0]), 1.0
NEWTON_STEPS, LEAST_STEP = 50, 1e-6


@dataclass(frozen=True, kw_only=True)
class Compared:
    """The comparisons made so far."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,)
    overlap: Array  # (m,) of the footprints as predicted, NaN where no depth is known
    common: Ints  # (m,) features in common, 0 of pairs that did not match


@dataclass(frozen=True, kw_only=True)
class ExpectedLinks:
    """What a dive's comparisons say of links to come."""

    found_again: Array  # (n,) features of a node's image that a look at all of it finds again
    logit: Array  # (2,) of a match: constant, and slope by the logarithm of expected features
    information: Array  # (6, 6) of a link, over the square of the features in common
    scaled: Mask  # (n,) nodes whose links have a length
    min_common: int  # features of a link at least

    def common(self, first: Ints, second: Ints, overlap: Array) -> Array:
        """Expect the number (m,) of features in common."""
        return np.asarray(overlap * np.minimum(self.found_again[first], self.found_again[second]))

    def probability(self, common: Array) -> Array:
        """Compute the probability (m,) that pairs match, given the features expected."""
        return np.asarray(expit(_regressors(common, self.min_common) @ self.logit))

    def link_information(
        self, first: Ints, second: Ints, common: Array, translation: Array
    ) -> Array:
        """Expect the information (m, 6, 6) of links, if the pairs match.

        translation (m, 3): of second_from_first, along which a link without a length tells nothing.
        """
        size = np.maximum(common, self.min_common)
        out = self.information * np.square(size)[:, None, None]
        bearing = ~(self.scaled[first] & self.scaled[second])
        across = _across(translation[bearing])
        out[bearing] = across @ out[bearing] @ across
        return np.asarray(out)


def learn_links(
    nodes: int, compared: Compared, links: CameraLinks, common: Ints, min_common: int
) -> ExpectedLinks:
    """Learn from comparisons what to expect of others.

    Parameters
    ----------
    nodes
        Their number, n.
    compared
        The comparisons.
    links
        Of those that matched.
    common
        Features in common (k,) of these.
    min_common
        Features of a link at least.
    """
    known = np.flatnonzero(np.isfinite(compared.overlap))
    first, second, overlap = (x[known] for x in (compared.first, compared.second, compared.overlap))
    found = compared.common[known]
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
        information=_information(links).sum(axis=0) / max(float(np.square(common).sum()), 1.0),
        scaled=scaled,
        min_common=min_common,
    )


def _regressors(common: Array, min_common: int) -> Array:
    return np.stack([np.ones(len(common)), np.log((common + 1) / min_common)], axis=1)


def _fit_logit(regressors: Array, matched: Mask) -> Array:
    """Fit the logistic regression of matches (m,) on regressors (m, 2) by Newton's method."""
    sign = np.where(matched, 1.0, -1.0)

    def cost(logit: Array) -> float:
        off = (logit - PRIOR_LOGIT) / PRIOR_SIGMA
        return float(np.logaddexp(0, -sign * (regressors @ logit)).sum() + 0.5 * off @ off)

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
    """Compute the information (k, 6, 6) of links, none along motions without a length."""
    out = np.zeros((len(links), 6, 6))
    full = np.flatnonzero(links.scaled)
    out[full] = np.linalg.inv(links.covariance[full])
    for k in np.flatnonzero(~links.scaled):
        length = float(np.linalg.norm(links.translation[k]))
        to_five = np.zeros((5, 6))
        to_five[:2, :3] = tangent_basis(links.translation[k] / length).T / length
        to_five[2:, 3:] = np.eye(3)
        own = np.linalg.inv(to_five @ links.covariance[k] @ to_five.T)
        # A direction of which the matches say nothing has a prior, which is no information.
        own[:2, :2] -= np.eye(2) / DIRECTION_SIGMA_RAD**2
        out[k] = to_five.T @ own @ to_five
    return out


def _across(translation: Array) -> Array:
    """Build the projections (m, 6, 6) of motions onto what is across their translations (m, 3)."""
    length = np.linalg.norm(translation, axis=1, keepdims=True)
    along = translation / np.maximum(length, np.finfo(float).tiny)
    out = np.tile(np.eye(6), (len(along), 1, 1))
    out[:, :3, :3] -= along[:, :, None] * along[:, None, :]
    return out
