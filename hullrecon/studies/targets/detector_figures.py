# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of the detectors of side-scan targets [Aulinas2011 Figs 4.9, 4.13 to 4.15]."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.targets.detector_trials import CascadeTrial, ThresholdTrial
from hullrecon.studies.targets.haar import PROPORTIONS
from hullrecon.studies.targets.side_scan import Kind, column_of, row_of
from hullrecon.typing import Array, Floats32, Mask

UNSUITED = ("8:1 track", "1:8 track", "1:8 range")
SUITED = ("4:1 range", "6:1 range", "8:1 range")
SHOWN = 400  # samples of each class in a panel
KIND_COLOURS = {Kind.TARGET: GREEN, Kind.BRIGHT: RED, Kind.DARK: RED, Kind.HOLLOW: RED}


def thresholds_by_stage(trial: ThresholdTrial) -> PublishedFigure:
    """Draw the stages of detector 1 on a tile [Aulinas2011 Fig. 4.9]."""
    seen = trial.detection
    stages: list[tuple[str, Array | Floats32 | Mask, float]] = [
        ("a  tile", trial.tile, 200.0),
        ("b  level, median", seen.smooth, 2.5),
        ("c  below the low threshold", seen.dark, 1.0),
        ("d  above the high threshold", seen.bright, 1.0),
        ("e  shadows, grown, long enough", seen.shadows, 1.0),
        ("f  bright spots, grown", seen.spots, 1.0),
        ("g  both, shadow behind the spot", seen.found, 1.0),
    ]
    canvas, axes = new_canvas(10.0, 7.6, 4, 2)
    panels = [axis for row in axes for axis in row]
    for axis, (name, picture, top) in zip(panels, stages, strict=False):
        axis.imshow(picture, cmap="gray", vmin=0, vmax=top, aspect="auto", interpolation="nearest")
        axis.set_title(name, fontsize=9, loc="left")
        axis.grid(visible=False)
        axis.set(xticks=[], yticks=[])
    _what_lies_there(panels[-1], trial)
    table = ["row,column"] + [f"{r},{c}" for r, c in zip(seen.row, seen.column, strict=True)]
    return finish_figure(
        "side-scan-thresholds",
        canvas,
        table,
        "Detector 1 in its stages. The sonar is beyond the right edge. Last: what lies there, "
        "targets green, the rest red, and crosses where a target was detected.",
    )


def _what_lies_there(axis: Axes, trial: ThresholdTrial) -> None:
    """Draw the things in a tile and the detections."""
    axis.imshow(trial.tile, cmap="gray", vmin=0, vmax=400, aspect="auto")
    for thing in trial.things:
        near, far = column_of(thing.range_m), column_of(thing.range_m + thing.length_m)
        row, tint = row_of(thing.along_m), KIND_COLOURS[thing.kind]
        axis.plot([far, near, near, far, far], np.array([-9, -9, 9, 9, -9]) + row, color=tint, lw=1)
        axis.text(near + 8, row, thing.kind.value, color=tint, fontsize=7, va="center")
    axis.plot(trial.detection.column, trial.detection.row, "x", color="white", ms=6)
    axis.set_title("what lies there, and detections", fontsize=9, loc="left")
    axis.grid(visible=False)
    axis.set(xticks=[], yticks=[])


def values_by_feature(trial: CascadeTrial) -> PublishedFigure:
    """Draw the value of each sample by feature, suited or not [Aulinas2011 Figs 4.14, 4.15]."""
    canvas, axes = new_canvas(10.0, 5.2, 2, 3)
    table = ["feature,separation"]
    apart = dict(zip(trial.names, trial.separation(), strict=True))
    for row, names in zip(axes, (UNSUITED, SUITED), strict=True):
        for axis, name in zip(row, names, strict=True):
            _samples(axis, trial, name)
            axis.set_title(f"{name}: {apart[name]:.1f} sigma apart", fontsize=9, loc="left")
    table += [f"{name},{value:.4f}" for name, value in apart.items()]
    return finish_figure(
        "side-scan-feature-values",
        canvas,
        table,
        "Value of two-rectangle features on training samples, targets red, others blue. Above: "
        "cut along the track, or bright on the wrong side. Below: dark far part, bright near part.",
    )


def _samples(axis: Axes, trial: CascadeTrial, name: str) -> None:
    """Draw the values of one feature."""
    values = trial.training[:, trial.names.index(name)]
    for mask, tint, label in (
        (~trial.training_target, COLOURS["maxmix"], "others"),
        (trial.training_target, RED, "targets"),
    ):
        chosen = values[mask][:SHOWN]
        axis.plot(np.linspace(0, 1, len(chosen)), chosen, ".", ms=2.5, color=tint, label=label)
    axis.set(xlabel="sample", ylabel="difference of means", xticks=[])
    axis.legend(fontsize=7, loc="upper right", framealpha=0.9)


def targets_and_proportions(trial: CascadeTrial) -> PublishedFigure:
    """Draw patches of each kind, and the separation by proportion [Aulinas2011 Fig. 4.13]."""
    canvas, axes = new_canvas(10.0, 4.4, 1, 2)
    gallery, bars = axes[0]
    rows = [
        np.hstack(
            [
                np.pad(trial.examples.picture[i], 2, constant_values=2.5)
                for i in [k for k, kind in enumerate(trial.examples.kind) if kind is wanted][:5]
            ]
        )
        for wanted in Kind
    ]
    gallery.imshow(np.vstack(rows), cmap="gray", vmin=0, vmax=2.5, aspect="auto")
    height = rows[0].shape[0]
    gallery.set_yticks([height * (k + 0.5) for k in range(len(Kind))], [k.value for k in Kind])
    gallery.set_xticks([])
    gallery.grid(visible=False)
    apart = dict(zip(trial.names, trial.separation(), strict=True))
    for along, tint in (("range", RED), ("track", COLOURS["maxmix"])):
        values = [apart[f"{k}:1 {along}"] for k in PROPORTIONS]
        bars.plot(PROPORTIONS, values, "o-", color=tint, label=f"cut along {along}", ms=4)
    bars.axvline(8, color=COLOURS["naive"], lw=1, ls="--", label="8:1, as published")
    bars.set(
        xlabel="proportion of the far part to the near part, k:1",
        ylabel="separation of targets from the rest, sigma",
        ylim=(0, None),
    )
    bars.legend(fontsize=8, frameon=False)
    table = ["proportion,range,track"] + [
        f"{k}:1,{apart[f'{k}:1 range']:.4f},{apart[f'{k}:1 track']:.4f}" for k in PROPORTIONS
    ]
    return finish_figure(
        "side-scan-proportions",
        canvas,
        table,
        "Left: windows as a scan meets them, near side right. Right: which proportion of dark to "
        "bright tells targets from the rest.",
    )
