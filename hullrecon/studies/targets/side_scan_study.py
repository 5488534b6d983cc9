# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Targets in side-scan sonar: both detectors of [Aulinas2011 4.3] beside their tables."""

from __future__ import annotations

from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.targets.cascade import TARGETS
from hullrecon.studies.targets.detector_figures import (
    targets_and_proportions,
    thresholds_by_stage,
    values_by_feature,
)
from hullrecon.studies.targets.detector_trials import (
    REACHED,
    CascadeTrial,
    ThresholdTrial,
    best_proportion,
    try_cascade,
    try_thresholds,
)
from hullrecon.studies.targets.side_scan import Kind

SEED, TILES = 1, 120
NEGATIVES_WORDS = (
    "three of ten negatives look like half a target or a reversed one; the source does not tell "
    "what its negatives are. Thresholds are set on patches as cut from tiles: set on augmented "
    "ones, dimmer than any target is, they let pass 2.3 % behind three layers of 1, 2, 4 features"
)


def detect_by_two_thresholds() -> StudyResult:
    """Run detector 1 on new tiles."""
    trial = try_thresholds(SEED, TILES)
    rows = tuple((kind.value, f"{100 * share:.1f}") for kind, share in trial.found.items())
    return StudyResult(
        figures=(thresholds_by_stage(trial),),
        values={kind.value: share for kind, share in trial.found.items()},
        heads=("thing", "taken for a target, %"),
        rows=rows,
        compared=_compare_thresholds(trial),
    )


def _compare_thresholds(trial: ThresholdTrial) -> tuple[ComparedValue, ...]:
    """Collect detection rates and false detections of the two thresholds."""
    words = "the source shows one picture and no rates"
    alone = max(trial.found[kind] for kind in (Kind.BRIGHT, Kind.DARK))
    return (
        ComparedValue(
            what="targets detected by two thresholds",
            unit="%",
            ours=100 * trial.found[Kind.TARGET],
            note=words,
        ),
        ComparedValue(
            what="bright spots or dark regions alone taken for targets",
            unit="%",
            printed=0.0,
            ours=100 * alone,
            note="only areas with both are accepted, says the source",
        ),
        ComparedValue(
            what="false detections on bare floor",
            unit="a tile",
            ours=trial.false_per_tile,
            note=words,
        ),
    )


def detect_by_cascade() -> StudyResult:
    """Train and try detector 2, with the rates and counts of Tables 4.1 and 4.2."""
    trial = try_cascade(SEED, TILES)
    reached = trial.by_table
    rows = tuple(
        (
            str(k + 1),
            f"{100 * TARGETS[k][0]:.1f} / {100 * TARGETS[k][1]:g} / {TARGETS[k][2]}",
            f"{100 * reached.detection[k]:.1f} / {100 * reached.false[k]:.2f} / "
            f"{reached.features[k]}",
        )
        for k in range(len(reached.features))
    )
    return StudyResult(
        figures=(values_by_feature(trial), targets_and_proportions(trial)),
        values={
            "layers": {
                "detection": reached.detection.tolist(),
                "false": reached.false.tolist(),
                "features": reached.features.tolist(),
            },
            "passed": {kind.value: share for kind, share in trial.passed.items()},
        },
        heads=(
            "layer",
            "asked by Table 4.1: detection % / false % / features",
            "reached on new tiles",
        ),
        rows=rows,
        compared=(*_compare_first_feature(trial), *_compare_layers(trial)),
    )


def _compare_first_feature(trial: CascadeTrial) -> tuple[ComparedValue, ...]:
    """Compare the proportion of the first feature that AdaBoost takes with the one printed."""
    first = trial.names[trial.layers[0].weak[0].feature]
    by_sums = best_proportion(trial.examples, by_sums=True)
    return (
        ComparedValue(
            what="proportion dark to bright of the first feature",
            printed=8.0,
            ours=float(first.split(":")[0]),
            note=f"AdaBoost takes {first} of 69 rectangles and 4 centroid features. Shadow to "
            "highlight is as range to altitude less height, 4 to 11 in these tiles, so the best "
            "proportion follows from the survey's geometry. With unweighted sums, as the source "
            f"writes them, it is {by_sums}:1",
        ),
    )


def _compare_layers(trial: CascadeTrial) -> tuple[ComparedValue, ...]:
    """Compare detection rate and false positives after each layer with those printed."""
    out = []
    got = trial.by_count
    for k, (detection, false, count) in enumerate(REACHED[: len(got.features)]):
        what = f"up to layer {k + 1} of {count} features"
        out += [
            ComparedValue(
                what=f"detection {what}",
                unit="%",
                printed=100 * detection,
                ours=100 * float(got.detection[k]),
            ),
            ComparedValue(
                what=f"false positives {what}",
                unit="%",
                printed=100 * false,
                ours=100 * float(got.false[k]),
                note=NEGATIVES_WORDS,
            ),
        ]
    enough = [k for k, false in enumerate(trial.by_table.false) if false <= REACHED[-1][1]]
    if enough:
        out.append(
            ComparedValue(
                what="features of the first layer behind which at most 1 % is false",
                printed=4.0,
                ours=float(trial.by_table.features[enough[0]]),
                note=f"layer {enough[0] + 1} of the cascade trained by Table 4.1, whose detection "
                f"is {100 * trial.by_table.detection[enough[0]]:.1f} % there",
            )
        )
    refused = 100 * (1 - max(trial.passed[kind] for kind in (Kind.BRIGHT, Kind.DARK)))
    return (
        *out,
        ComparedValue(
            what="things bright only or dark only refused, the worse of both",
            unit="%",
            ours=refused,
            note="by all layers; the source does not count them apart",
        ),
        ComparedValue(
            what="layers until as few are false as Table 4.1 asks of the last",
            ours=float(len(trial.by_table.features)),
            note="the source's false positives rise behind its third layer; layers that must all "
            "agree cannot raise them on the same patches",
        ),
    )
