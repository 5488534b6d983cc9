# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two views by one model alone, whatever the geometric information criterion says."""

from __future__ import annotations

from hullrecon.typing import Array
from hullrecon.vision.pairs.matching import MatchStrategy
from hullrecon.vision.pairs.two_view import TwoView, fit_both


def fit_essential(first: Array, second: Array, tolerance: float) -> TwoView | None:
    """Fit an essential matrix to matches (n, 2) as `two_view.fit` fits the likelier model."""
    both = fit_both(first, second, tolerance)
    return None if both is None else both.essential.within(tolerance)


def fit_homography(first: Array, second: Array, tolerance: float) -> TwoView | None:
    """Fit a homography to matches (n, 2) as `two_view.fit` fits the likelier model."""
    both = fit_both(first, second, tolerance)
    return None if both is None else both.homography.within(tolerance)


TWO_VIEW_MODELS = {
    "automatic": MatchStrategy(),
    "essential": MatchStrategy(fit_two_views=fit_essential),
    "homography": MatchStrategy(fit_two_views=fit_homography),
}
