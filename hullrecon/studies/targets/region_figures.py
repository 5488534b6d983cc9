# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of regions of interest [Aulinas2011 Figs 4.20 to 4.22]."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.targets.regions import even_out, find_regions, match_regions
from hullrecon.studies.targets.sea_floor import WIDTH, View

LINES = 60  # of the inliers that are drawn


def evened_images(views: Mapping[str, View]) -> PublishedFigure:
    """Draw images and what evening makes of them [Aulinas2011 Fig. 4.20]."""
    canvas, axes = new_canvas(9.0, 4.9, 2, len(views))
    table = ["image,contrast_before,contrast_after"]
    for column, (name, view) in enumerate(views.items()):
        even = even_out(view.image)
        _show(axes[0][column], view.image, name)
        _show(axes[1][column], even, "evened")
        table.append(f"{name},{view.image.mean(axis=2).std():.2f},{even.std():.2f}")
    return finish_figure(
        "regions-evened",
        canvas,
        table,
        "Images with haze, uneven light and noise. Below: grey, the light's pattern taken off, "
        "contrast normalised.",
    )


def region_stages(view: View) -> PublishedFigure:
    """Draw the stages from an image to a region and its features [Aulinas2011 Fig. 4.21]."""
    import cv2

    found = find_regions(view.image)
    canvas, axes = new_canvas(9.0, 7.4, 3, 3)
    panels = [axis for row in axes for axis in row]
    stages: list[tuple[str, Any, str]] = [
        ("a  image", view.image, "gray"),
        ("b  edges", found.edges, "gray"),
        ("c  joined, specks dropped", found.joined, "gray"),
        ("d  regions by edges", found.by_edges, "gray"),
        ("e  hue", np.degrees(found.hue), "twilight"),
        ("f  away from the mean hue", found.away, "gray"),
        ("g  regions by hue", found.by_hue, "gray"),
        ("h  both", view.image, "gray"),
        ("i  its features", found.even, "gray"),
    ]
    for axis, (name, picture, colours) in zip(panels, stages, strict=True):
        _show(axis, picture, name, colours)
    panels[7].contour(found.region, [0.5], colors=[RED], linewidths=1.5)
    sift = cv2.SIFT.create(contrastThreshold=0.02)
    keys = sift.detect(found.even, found.region.astype(np.uint8))
    places = np.array([key.pt for key in keys]).reshape(-1, 2)
    panels[8].plot(*places.T, ".", color=COLOURS["maxmix"], ms=2.5)
    recall = found.region[view.rocks].mean()
    false = found.region[~view.rocks].mean()
    table = ["of_rock_in_region,of_background_in_region,features"]
    table.append(f"{recall:.4f},{false:.4f},{len(places)}")
    return finish_figure(
        "regions-stages",
        canvas,
        table,
        f"From an image to its region of interest, where edges and hue agree: {100 * recall:.0f} % "
        f"of the rock, {100 * false:.1f} % of the rest.",
    )


def matched_regions(first: View, second: View) -> PublishedFigure:
    """Draw the matches of a rock over a quarter turn [Aulinas2011 Fig. 4.22]."""
    a, b = find_regions(first.image), find_regions(second.image)
    matches = match_regions(a.even, b.even, a.region, b.region)
    canvas, axes = new_canvas(9.0, 3.6)
    axis = axes[0][0]
    _show(axis, np.hstack([first.image, second.image]), "")
    shift = np.array([WIDTH, 0])
    inliers = int(matches.inlier.sum())
    drawn = np.flatnonzero(matches.inlier)[:: max(1, inliers // LINES)]
    for k in [*drawn, *np.flatnonzero(~matches.inlier)]:
        tint = "white" if matches.inlier[k] else RED
        ends = np.array([matches.first[k], matches.second[k] + shift])
        axis.plot(*ends.T, "o-", color=tint, lw=0.5, ms=1.5, alpha=0.9)
    table = ["u_first,v_first,u_second,v_second,inlier"] + [
        f"{u:.1f},{v:.1f},{s:.1f},{t:.1f},{int(right)}"
        for (u, v), (s, t), right in zip(matches.first, matches.second, matches.inlier, strict=True)
    ]
    return finish_figure(
        "regions-matched",
        canvas,
        table,
        f"A rock seen twice, turned by 90 degrees: {inliers} of {len(matches.inlier)} matches of "
        "features in its regions are explained by one turn, scale and shift (white, some drawn), "
        "the rest are red.",
    )


def _show(axis: Axes, picture: Any, name: str, colours: str = "gray") -> None:
    """Show a picture without ticks."""
    axis.imshow(picture, cmap=colours, interpolation="nearest")
    axis.set_title(name, fontsize=9, loc="left")
    axis.grid(visible=False)
    axis.set(xticks=[], yticks=[])
