# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A cascade of boosted classifiers, trained layer by layer [Aulinas2011 4.3.2, Table 4.1].

Patches of an image are judged by their features: `values` (n, f) has a patch a row and a feature a
column, and `is_target` (n,) tells which patches show a target. The rest are "others". AdaBoost
[FreundSchapire1997] chooses a feature and its threshold at a time. A layer refuses most of what is
left of the others, and keeps nearly every target.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array, Ints, Mask

# [Aulinas2011 Table 4.1]: detection and false positives, of all up to the layer, and features
TARGETS = (
    (0.999, 0.50, 1),
    (0.997, 0.20, 2),
    (0.996, 0.10, 6),
    (0.995, 0.05, 11),
    (0.995, 0.01, 20),
    (0.993, 0.005, 30),
    (0.990, 0.0005, 30),
)


@dataclass(frozen=True, kw_only=True)
class Weak:
    """A feature with a threshold."""

    feature: int  # which
    threshold: float
    sign: float  # 1 where targets lie above, -1 below
    spread: float  # of the feature over all patches
    vote: float  # its weight in the layer

    def is_target(self, values: Array) -> Mask:
        """Judge patches by their features (n, f)."""
        return np.asarray(self.sign * (values[:, self.feature] - self.threshold) > 0)

    def score(self, values: Array) -> Array:
        """Score patches (n,) by their features (n, f), between -vote and vote.

        A step of one spread, not a jump: a sum of n jumps has 2^n values, among which a layer's
        threshold could not be lowered by little.
        """
        away = self.sign * (values[:, self.feature] - self.threshold) / self.spread
        return self.vote * np.clip(away, -1, 1)


@dataclass(frozen=True, kw_only=True)
class Layer:
    """A strong classifier: passes what scores at least its threshold."""

    weak: tuple[Weak, ...]
    threshold: float

    def passes(self, values: Array) -> Mask:
        """Judge patches by their features (n, f)."""
        return np.asarray(sum_scores(self.weak, values) >= self.threshold)


@dataclass(frozen=True, kw_only=True)
class Rates:
    """What is left after each layer of a cascade."""

    detection: Array  # (layers,) share of the targets
    false: Array  # (layers,) share of the others
    features: Ints  # (layers,) of each layer


def sum_scores(weak: tuple[Weak, ...], values: Array) -> Array:
    """Add up the scores (n,) of a layer's weak classifiers."""
    return np.asarray(np.sum([w.score(values) for w in weak], axis=0))


def train_cascade(
    values: Array,
    is_target: Mask,
    validation: Array,
    validation_target: Mask,
    targets: tuple[tuple[float, float, int], ...] = TARGETS,
) -> list[Layer]:
    """Train layer by layer until the rates of each are met on the validation set.

    Where a layer's false positives are met already, it is to halve them. Training ends where the
    false positives of the last layer are met, where few of the others are left to learn from, or
    where a layer refuses none of them.

    Parameters
    ----------
    values, is_target
        Features (n, f) to learn from, and which are targets.
    validation, validation_target
        The same (m, f) of patches that set thresholds and count features.
    targets
        Of each layer: detection and false positives up to it, most features.
    """
    layers: list[Layer] = []
    left, check = np.ones(len(values), bool), np.ones(len(validation), bool)
    for detection, false, most in targets:
        met = check[~validation_target].mean() <= targets[-1][1]
        if met or np.sum(left & ~is_target) < 10:
            break
        layer = _train_layer(
            values[left],
            is_target[left],
            validation,
            check,
            validation_target,
            (detection, min(false, 0.5 * float(check[~validation_target].mean())), most),
        )
        passed = check & layer.passes(validation)
        if np.sum(passed & ~validation_target) >= np.sum(check & ~validation_target):
            break
        layers.append(layer)
        # The next layer learns from the false positives of those so far.
        left &= layer.passes(values) | is_target
        check = passed
    return layers


def _train_layer(
    values: Array,
    is_target: Mask,
    validation: Array,
    check: Mask,
    validation_target: Mask,
    wanted: tuple[float, float, int],
) -> Layer:
    """Add features to a layer until it meets the rates wanted on what passed the layers before.

    Parameters
    ----------
    values, is_target
        Features of the patches to learn from, and which are targets.
    validation, validation_target
        The same of the patches on which thresholds are set and rates are measured.
    check
        (m,) which of these passed the layers before.
    wanted
        Share of all targets to pass, share of all others that may pass, most features.
    """
    detection, false, most = wanted
    boosted = Boost(values, is_target)
    for _ in range(most):
        weak = boosted.add()
        score = sum_scores(weak, validation)
        # The lowest threshold with which enough targets of all pass.
        kept = np.sort(score[check & validation_target])[::-1]
        need = min(len(kept), int(np.ceil(detection * np.sum(validation_target))))
        threshold = float(kept[need - 1])
        passed = check & (score >= threshold) & ~validation_target
        if passed.sum() <= false * np.sum(~validation_target):
            break
    return Layer(weak=weak, threshold=threshold)


class Boost:
    """AdaBoost over features with one threshold each."""

    def __init__(self, values: Array, is_target: Mask) -> None:
        """Start with equal weights of both classes. values: features (n, f) to learn from."""
        self._values, self._is_target = values, is_target
        self._order = np.argsort(values, axis=0)
        count = np.where(is_target, is_target.sum(), (~is_target).sum())
        self._weight = 0.5 / count
        self._weak: list[Weak] = []

    def add(self) -> tuple[Weak, ...]:
        """Choose the next feature with its threshold. Returns all chosen so far."""
        weight = self._weight / self._weight.sum()
        feature, threshold, sign, error = self._best(weight)
        error = min(max(error, 1e-6), 0.5)
        beta = error / (1 - error)
        found = Weak(
            feature=feature,
            threshold=threshold,
            sign=sign,
            spread=float(self._values[:, feature].std()),
            vote=float(np.log(1 / beta)),
        )
        right = found.is_target(self._values) == self._is_target
        self._weight = weight * np.where(right, beta, 1.0)
        self._weak.append(found)
        return tuple(self._weak)

    def _best(self, weight: Array) -> tuple[int, float, float, float]:
        """Find the feature, threshold and sign of least weighted error, and that error.

        weight: (n,) of the patches, which sum to one. All thresholds between two patches in the
        order of a feature are tried at once.
        """
        signed = np.where(self._is_target, weight, -weight)[self._order]
        all_targets = weight[self._is_target].sum()
        below = np.cumsum(signed, axis=0)  # targets less others up to each place
        # Targets above a threshold: those below it, and the others above it, are wrong.
        above_wrong = below + (1 - all_targets)
        wrong = np.stack([above_wrong, 1 - above_wrong])
        side, place, feature = np.unravel_index(np.argmin(wrong), wrong.shape)
        column = self._values[self._order[:, feature], feature]
        after = column[min(place + 1, len(column) - 1)]
        return (
            int(feature),
            float(0.5 * (column[place] + after)),
            1.0 if side == 0 else -1.0,
            float(wrong[side, place, feature]),
        )


def rates(layers: list[Layer], values: Array, is_target: Mask) -> Rates:
    """Measure the shares of targets and of others that are left after each layer.

    values: features (n, f) of samples. is_target: (n,) which of them are targets.
    """
    left = np.ones(len(values), bool)
    detection, false = [], []
    for layer in layers:
        left &= layer.passes(values)
        detection.append(left[is_target].mean())
        false.append(left[~is_target].mean())
    return Rates(
        detection=np.array(detection),
        false=np.array(false),
        features=np.array([len(layer.weak) for layer in layers]),
    )
