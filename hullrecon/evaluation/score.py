# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Score the deliverables of a run against the truth of its dive."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import msgspec

from hullrecon.errors import InputError
from hullrecon.evaluation.deliverables import (
    PointCloud,
    TimedPoses,
    deliver_folder,
    read_cloud,
    read_trajectory,
)
from hullrecon.evaluation.objects import move_object, score_objects
from hullrecon.evaluation.surfaces import score_landmarks, score_surface
from hullrecon.evaluation.trajectory import (
    Figures,
    hull_from_start,
    score_cameras,
    score_trajectory,
)
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.poses import Poses, identity
from hullrecon.records.deliverables import ReportedObject

MISSING = "missing"
# Figures by deliverable, or MISSING for one that was not delivered
Score = dict[str, Figures | str]


class _ObjectsFile(msgspec.Struct, frozen=True):
    objects: tuple[ReportedObject, ...]


class _SummaryFile(msgspec.Struct, frozen=True):
    frame: str = "M"


def score_run(run: Path, package: Path) -> Score:
    """Score a run against its truth, by deliverable and name.

    Raises InputError when there is nothing to score or no truth to score it by. `run`: RUNS/<dive>
    or its deliver/.
    """
    deliver, truth = deliver_folder(run), read_truth(package)
    reader = _DeliveryReader(deliver, truth)
    figures: Score = {"trajectory": MISSING}
    motion = identity()
    if (deliver / "trajectory.csv").exists():
        figures["trajectory"], motion = score_trajectory(
            reader.trajectory(deliver / "trajectory.csv"), truth
        )
    scores: dict[str, tuple[str, Callable[[Path], Figures]]] = {
        "surface": ("surface.ply", lambda p: score_surface(reader.cloud(p), truth, motion, 1)),
        "as_found": ("as_found.ply", lambda p: score_surface(reader.cloud(p), truth, motion, 2)),
        "landmarks": ("landmarks.ply", lambda p: score_landmarks(reader.cloud(p), truth, motion)),
        "objects": ("objects.json", lambda p: score_objects(reader.objects(p), truth, motion)),
        "cameras": ("colmap", lambda p: score_cameras(p, truth)),
    }
    for name, (file, score) in scores.items():
        figures[name] = score(deliver / file) if (deliver / file).exists() else MISSING
    return figures


class _DeliveryReader:
    """Read deliverables in M.

    Those of a dive without a CAD model are in g. They are moved so that the path begins at the true
    pose.
    """

    def __init__(self, deliver: Path, truth: Truth) -> None:
        """Read in which frame the deliverables are, and find the motion from g to M if it is g.

        Without a delivered path that motion is the true hull pose.
        """
        summary = deliver / "summary.json"
        frame = (
            msgspec.json.decode(summary.read_bytes(), type=_SummaryFile).frame
            if summary.exists()
            else "M"
        )
        self._hull_from_delivered: Poses | None = None
        if frame == "g":
            path = deliver / "trajectory.csv"
            start = (
                hull_from_start(read_trajectory(path), truth)
                if path.exists()
                else truth.global_from_hull.inverse()
            )
            self._hull_from_delivered = start

    def trajectory(self, path: Path) -> TimedPoses:
        """Read trajectory.csv in M."""
        track = read_trajectory(path)
        moved = self._hull_from_delivered
        return (
            track
            if moved is None
            else replace(track, poses=moved @ track.poses, hull_from_delivered=moved)
        )

    def cloud(self, path: Path) -> PointCloud:
        """Read a PLY in M."""
        cloud = read_cloud(path)
        moved = self._hull_from_delivered
        return cloud if moved is None else replace(cloud, points=moved.apply(cloud.points))

    def objects(self, path: Path) -> list[ReportedObject]:
        """Read objects.json in M."""
        try:
            found = list(msgspec.json.decode(path.read_bytes(), type=_ObjectsFile).objects)
        except msgspec.MsgspecError as error:
            raise InputError(f"objects.json cannot be read: {error}", where=str(path)) from error
        moved = self._hull_from_delivered
        return found if moved is None else [move_object(o, moved) for o in found]


def unit_of(name: str) -> str:
    """Read the unit from a figure's name. Shares, ratios and counts have none."""
    endings = {"_m": "m", "_deg": "deg", "_percent": "%"}
    return next((unit for ending, unit in endings.items() if name.endswith(ending)), "")


def table_rows(figures: Score) -> list[tuple[str, str, str]]:
    """List rows (figure, value with four digits, unit) of a table of the score."""
    rows = list[tuple[str, str, str]]()
    for part, values in figures.items():
        if isinstance(values, str):
            rows.append((part, values, ""))
            continue
        for name, value in values.items():
            text = f"{value:.4g}" if isinstance(value, float) else str(value)
            rows.append((f"{part}.{name}", text, unit_of(name)))
    return rows


def without_nan(figures: Mapping[str, object]) -> dict[str, object]:
    """Replace NaN, which JSON does not have, by None, also in nested mappings."""
    return {name: _without_nan(value) for name, value in figures.items()}


def _without_nan(value: object) -> object:
    if isinstance(value, Mapping):
        return without_nan(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
