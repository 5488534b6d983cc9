# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Both detectors of side-scan targets, tried on simulated tiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.targets.cascade import Layer, Rates, rates, train_cascade
from hullrecon.studies.targets.haar import (
    PROPORTIONS,
    Rectangles,
    describe,
    integral_images,
    separation,
)
from hullrecon.studies.targets.patches import Patches, augment, cut_patches
from hullrecon.studies.targets.side_scan import (
    Kind,
    Thing,
    column_of,
    draw_tile,
    row_of,
    rows_of_lanes,
    scatter_things,
)
from hullrecon.studies.targets.thresholds import Detection, detect_by_thresholds
from hullrecon.typing import Array, Mask

TILE_KINDS = (*[Kind.TARGET] * 4, Kind.BRIGHT, Kind.DARK, Kind.HOLLOW)
NEAR_ROWS, NEAR_COLUMNS = 8, 14  # a detection this near a thing is of it
POSITIVES, NEGATIVES = 2000, 5000  # [Aulinas2011 4.3.4]
# [Aulinas2011 Table 4.2]: detection and false positives up to a layer, features of the layer
REACHED = ((0.995, 0.53, 1), (0.993, 0.06, 2), (0.992, 0.01, 4))


@dataclass(frozen=True, kw_only=True)
class ThresholdTrial:
    """Detector 1 on many tiles."""

    found: dict[Kind, float]  # share of the things of a kind that were taken for targets
    false_per_tile: float  # detections where nothing is
    tile: Array  # the last one
    things: Sequence[Thing]  # in it
    detection: Detection  # on it


@dataclass(frozen=True, kw_only=True)
class CascadeTrial:
    """Detector 2 trained on patches, tried on patches of other tiles."""

    names: list[str]  # of the features
    training: Array  # (n, f) features
    training_target: Mask  # (n,)
    by_table: Rates  # trained by Table 4.1
    by_count: Rates  # trained with REACHED's features in its layers
    layers: list[Layer]  # of by_count
    passed: dict[Kind, float]  # share that passes all layers of by_table
    examples: Patches  # some that it was tried on

    def separation(self) -> Array:
        """Measure how far each feature (f,) sets targets apart from the rest, in sigmas."""
        return separation(self.training[self.training_target], self.training[~self.training_target])


def try_thresholds(seed: int, tiles: int) -> ThresholdTrial:
    """Detect targets in new tiles by thresholds and count what was taken for one."""
    rng = np.random.default_rng(seed)
    taken: dict[Kind, list[bool]] = {kind: [] for kind in set(TILE_KINDS)}
    false = 0
    for _ in range(tiles):
        things = scatter_things(rng, TILE_KINDS)
        tile = draw_tile(rng, rows_of_lanes(len(TILE_KINDS)), things)
        detection = detect_by_thresholds(tile)
        explained = np.zeros(len(detection.row), bool)
        for thing in things:
            near = _near(detection, thing)
            taken[thing.kind].append(bool(near.any()))
            explained |= near
        false += int(np.sum(~explained))
    return ThresholdTrial(
        found={kind: float(np.mean(hits)) for kind, hits in taken.items()},
        false_per_tile=false / tiles,
        tile=tile,
        things=things,
        detection=detection,
    )


def _near(detection: Detection, thing: Thing) -> Mask:
    """Mark the detections (n,) at a thing."""
    return np.asarray(
        (np.abs(detection.row - row_of(thing.along_m)) < NEAR_ROWS)
        & (detection.column > column_of(thing.range_m + thing.length_m) - NEAR_COLUMNS)
        & (detection.column < column_of(thing.range_m) + NEAR_COLUMNS)
    )


def try_cascade(
    seed: int, tiles: int, positives: int = POSITIVES, negatives: int = NEGATIVES
) -> CascadeTrial:
    """Train cascades on patches made more by augmentation, and try them on patches as cut.

    Thresholds are set on patches as cut too: an augmented target may be dimmer than any that a
    sonar shows, and a threshold that keeps it lets a tenth of the bright spots pass.
    """
    training = augment(cut_patches(seed, tiles), seed, positives, negatives)
    validation, tested = (cut_patches(seed + k, 2 * tiles) for k in (1, 2))
    values, names = describe(training.picture)
    check, _ = describe(validation.picture)
    new, _ = describe(tested.picture)
    known = (values, training.is_target, check, validation.is_target)
    by_table = train_cascade(*known)
    # No false positive is few enough: each layer takes all the features it may, and may lose a
    # third of the targets that the source loses in all.
    lost = (1 - REACHED[-1][0]) / len(REACHED)
    counted = tuple((1 - lost * (k + 1), 0.0, count) for k, (_, _, count) in enumerate(REACHED))
    layers = train_cascade(*known, counted)
    passes = np.all([layer.passes(new) for layer in by_table], axis=0)
    return CascadeTrial(
        names=names,
        training=values,
        training_target=training.is_target,
        by_table=rates(by_table, new, tested.is_target),
        by_count=rates(layers, new, tested.is_target),
        layers=layers,
        passed={
            kind: float(np.mean([p for p, k in zip(passes, tested.kind, strict=True) if k is kind]))
            for kind in Kind
        },
        examples=tested,
    )


def best_proportion(patches: Patches, by_sums: bool = False) -> int:
    """Find the proportion k:1 that sets targets furthest apart, by means or by sums."""
    integral = integral_images(patches.picture)
    shapes = [Rectangles(first=k, second=1, along="range") for k in PROPORTIONS]
    values = np.column_stack([shape.value(integral, by_sums) for shape in shapes])
    apart = separation(values[patches.is_target], values[~patches.is_target])
    return PROPORTIONS[int(np.argmax(apart))]
