# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The deliverables of a run against the truth of its dive: every figure that the project is held to, with its unit."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hullrecon.errors import InputError
from hullrecon.evaluation.scoring.alignment import STILL
from hullrecon.evaluation.scoring.cameras import judge_cameras
from hullrecon.evaluation.scoring.deliverables import Cloud, Track, deliver_folder, read_cloud, read_track
from hullrecon.evaluation.scoring.objects import judge_objects
from hullrecon.evaluation.scoring.surfaces import judge_landmarks, judge_surface
from hullrecon.evaluation.scoring.trajectory import judge_trajectory
from hullrecon.evaluation.scoring.truth import Truth, read_truth
from hullrecon.geometry.poses import Poses

MISSING = "missing"


def judge(run: Path, package: Path) -> dict[str, Any]:
    """Figures by deliverable and name; `"missing"` in place of what was not delivered.

    run: RUNS/<dive> or its deliver/. Raises InputError when there is nothing to judge or nothing to judge it by.
    """
    deliver, truth = deliver_folder(run), read_truth(package)
    into_hull = _into_hull(deliver, truth)
    figures: dict[str, Any] = {"trajectory": MISSING}
    motion = STILL
    if (deliver / "trajectory.csv").exists():
        figures["trajectory"], motion = judge_trajectory(into_hull.track(deliver / "trajectory.csv"), truth)
    jobs: dict[str, tuple[str, Callable[[Path], Any]]] = {
        "surface": ("surface.ply", lambda p: judge_surface(into_hull.cloud(p), truth, motion, 1)),
        "as_found": ("as_found.ply", lambda p: judge_surface(into_hull.cloud(p), truth, motion, 2)),
        "landmarks": ("landmarks.ply", lambda p: judge_landmarks(into_hull.cloud(p), truth, motion)),
        "objects": ("objects.json", lambda p: judge_objects(into_hull.objects(p), truth, motion)),
        "cameras": ("colmap", lambda p: judge_cameras(p, truth)),
    }
    for name, (file, work) in jobs.items():
        figures[name] = work(deliver / file) if (deliver / file).exists() else MISSING
    return figures


class IntoHull:
    """Reads deliverables; what stands in g (a dive without a CAD model) is moved to M by the true alignment."""

    def __init__(self, hull_from_delivered: Poses | None) -> None:
        self._motion = hull_from_delivered

    def track(self, path: Path) -> Track:
        track = read_track(path)
        return track if self._motion is None else Track(track.t_s, self._motion @ track.poses, track.sigma)

    def cloud(self, path: Path) -> Cloud:
        cloud = read_cloud(path)
        return cloud if self._motion is None else Cloud(self._motion.apply(cloud.points), cloud.fields)

    def objects(self, path: Path) -> list[dict[str, Any]]:
        try:
            found: list[dict[str, Any]] = json.loads(path.read_text())["objects"]
        except (ValueError, KeyError) as error:
            raise InputError(f"objects.json cannot be read: {error}", where=str(path)) from error
        if self._motion is None:
            return found
        return [{**o, "center": self._motion.apply([o["center"]])[0].tolist()} for o in found]


def _into_hull(deliver: Path, truth: Truth) -> IntoHull:
    summary = deliver / "summary.json"
    frame = json.loads(summary.read_text()).get("frame", "M") if summary.exists() else "M"
    return IntoHull(truth.T_g_M.inverse() if frame == "g" else None)


def unit_of(name: str) -> str:
    """The unit that a figure's name ends in; shares, ratios and counts have none."""
    endings = {"_m": "m", "_deg": "deg", "_percent": "%"}
    return next((unit for ending, unit in endings.items() if name.endswith(ending)), "")


def rows(figures: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(figure, value, unit) for a table, four digits as the independent judge prints them."""
    out = list[tuple[str, str, str]]()
    for part, values in figures.items():
        if isinstance(values, str):
            out.append((part, values, ""))
            continue
        for name, value in values.items():
            text = f"{value:.4g}" if isinstance(value, float) else str(value)
            out.append((f"{part}.{name}", text, unit_of(name)))
    return out


def plain(figures: Any) -> Any:
    """The same for JSON: NaN becomes null."""
    if isinstance(figures, dict):
        return {name: plain(value) for name, value in figures.items()}
    return None if isinstance(figures, float) and not math.isfinite(figures) else figures
