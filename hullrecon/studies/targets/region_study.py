# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regions of interest in images of the sea floor, and their features over a quarter turn.

[Aulinas2011 4.4, Figs 4.20 to 4.22].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.targets.region_figures import evened_images, matched_regions, region_stages
from hullrecon.studies.targets.regions import Matches, find_regions, match_regions
from hullrecon.studies.targets.sea_floor import Floor, View, draw_floor, look
from hullrecon.typing import Array

FLOORS = 10
ROCKS = np.array([[200.0, 250.0], [600.0, 300.0], [400.0, 700.0]])
STAINS = np.array([[700.0, 700.0]])
BARE = np.array([[450.0, 480.0], [700.0, 700.0]])  # no rock in view, at the second a stain


@dataclass(frozen=True, kw_only=True)
class RegionTrial:
    """Regions found in many images."""

    recall: Array  # (n,) share of the rocks' pixels, of images with a rock
    false: Array  # (m,) share of the background's pixels taken for a region, of all images
    bare: int  # images without a rock that got a region
    bare_images: int  # images without a rock
    inliers: Array  # (n,) matches that one similarity explains, after a quarter turn
    right: Array  # (n,) share of these that are where the floor's true place is


def find_rocks() -> StudyResult:
    """Find rocks on simulated floors, and match each over a quarter turn."""
    trial = try_regions(FLOORS)
    floor = draw_floor(0, ROCKS, STAINS)
    figures = (
        evened_images(_artefacts(floor)),
        region_stages(look(floor, 1, (400.0, 700.0))),
        matched_regions(*_two_looks(floor, ROCKS[2], 3)),
    )
    return StudyResult(
        figures=figures,
        values={
            "recall": float(trial.recall.mean()),
            "false": float(trial.false.mean()),
            "inliers": int(trial.inliers.min()),
        },
        compared=_compare(trial),
    )


def try_regions(floors: int) -> RegionTrial:
    """Find regions around each rock of new floors and match them over a quarter turn."""
    recall, false, inliers, right = [], [], [], []  # as of `RegionTrial`
    with_region = 0
    for seed in range(floors):
        floor = draw_floor(seed, ROCKS, STAINS)
        for k, middle in enumerate(ROCKS):
            first, second = _two_looks(floor, middle, 100 * seed + 2 * k)
            found = find_regions(first.image)
            recall.append(found.region[first.rocks].mean())
            false.append(found.region[~first.rocks].mean())
            other = find_regions(second.image)
            matches = match_regions(found.even, other.even, found.region, other.region)
            inliers.append(matches.inlier.sum())
            right.append(_share_in_place(matches, first, second))
        for middle in BARE:
            seen = find_regions(look(floor, 100 * seed + 50, tuple(middle)).image)
            false.append(seen.region.mean())
            with_region += bool(seen.region.any())
    return RegionTrial(
        recall=np.array(recall),
        false=np.array(false),
        bare=with_region,
        bare_images=floors * len(BARE),
        inliers=np.array(inliers),
        right=np.array(right),
    )


def _two_looks(floor: Floor, middle: Array, seed: int) -> tuple[View, View]:
    """Look at a place (2,) of the floor twice: then turned by 90 degrees, nearer, in more haze."""
    first = look(floor, seed, (middle[0], middle[1]))
    second = look(
        floor,
        seed + 1,
        (middle[0] + 12.0, middle[1] - 8.0),
        turn_rad=np.pi / 2,
        scale=1.1,
        haze=0.3,
        noise=4.0,
    )
    return first, second


def _share_in_place(matches: Matches, first: View, second: View) -> float:
    """Compute which share of the inliers lies within 3 px of its true place in the second view."""
    if not matches.inlier.any():
        return 0.0
    a, b = first.image_from_floor, second.image_from_floor
    on_floor = np.linalg.solve(a[:, :2], (matches.first[matches.inlier] - a[:, 2]).T).T
    there = on_floor @ b[:, :2].T + b[:, 2]
    return float(np.mean(np.linalg.norm(there - matches.second[matches.inlier], axis=1) < 3.0))


def _artefacts(floor: Floor) -> dict[str, View]:
    """Simulate images with the artefacts of images under water [Aulinas2011 Fig. 2.10]."""
    middle = (600.0, 300.0)
    return {
        "haze": look(floor, 4, middle, haze=0.65, uneven=0.2),
        "uneven light": look(floor, 5, middle, uneven=0.9),
        "noise": look(floor, 6, middle, noise=14.0),
    }


def _compare(trial: RegionTrial) -> tuple[ComparedValue, ...]:
    """Collect how well regions cover rocks, and how well they are matched."""
    words = "the source shows one example and no rates"
    return (
        ComparedValue(
            what="pixels of rocks inside a region, mean",
            unit="%",
            ours=100 * float(trial.recall.mean()),
            note=words,
        ),
        ComparedValue(
            what="pixels of background inside a region, mean",
            unit="%",
            ours=100 * float(trial.false.mean()),
            note=words,
        ),
        ComparedValue(
            what="images with ripples, pebbles or a soft stain alone that got a region",
            unit=f"of {trial.bare_images}",
            ours=float(trial.bare),
            note="each of the two lines alone takes some of these for a region",
        ),
        ComparedValue(
            what="matches over a turn of 90 degrees that one similarity explains, fewest",
            ours=float(trial.inliers.min()),
            note=f"{100 * float(trial.right.mean()):.1f} % of them lie at the true place. The "
            "source draws its matches and does not count them. SIFT in place of SURF",
        ),
    )
