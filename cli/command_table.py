# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The commands of `hullrecon --help`, listed so that the help imports none of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """A command: its module below commands/, its name there, and one line about it."""

    module: str
    name: str
    summary: str


ON_A_DIVE = {
    "init": Entry("package", "init", "write a dive.toml by looking into a log"),
    "check": Entry(
        "package",
        "check",
        "say what a dive package or a run's folder holds and what is wrong with it",
    ),
    "run": Entry("run", "run", "run the chain: every step that is not up to date"),
    "fleet": Entry("fleet", "fleet", "run every dive of a folder that is new or out of date"),
    "status": Entry("run", "status", "say which steps are up to date"),
    "explain": Entry("run", "explain", "say why a step would run again"),
    "clean": Entry("clean", "clean", "remove artifacts, after asking"),
}
_STEPS = {
    "ingest": "read the logs, the calibration and the CAD model",
    "navigate": "compute the dead-reckoned trajectory",
    "features": "find features in every image",
    "links": "link images in rounds, tie passes by the hull, and straighten the path with them",
    "matches": "join matches of linked images to feature tracks",
    "adjust": "adjust images, DVL ranges and the CAD model together",
    "surface": "fit a surface to the DVL's returns",
    "detect": "find structures and remesh the hull as found",
    "mosaic-optical": "blend the images on the hull's surface",
    "mosaic-sonar": "blend the sonar's pings on the hull's surface",
    "change": "say what changed since an earlier dive of the hull",
    "report": "write the deliverables and the report",
}
STEPS = {name: Entry("steps", name, summary) for name, summary in _STEPS.items()}
AROUND = {
    "simulate": Entry("simulate", "simulate", "simulate a dive package, with its truth"),
    "evaluate": Entry("results", "evaluate", "score a run against the truth of a simulated dive"),
    "diff": Entry("results", "diff", "say what changed on a hull between two runs"),
    "export": Entry(
        "results", "export", "write results for other programs: undistorted images for COLMAP"
    ),
    "study": Entry("study", "study", "reproduce the published methods, tables and figures"),
    "completion": Entry("completion", "completion", "print the shell's completion script"),
}
SECTIONS = {"A dive": ON_A_DIVE, "Steps of the chain": STEPS, "Around it": AROUND}
RENAMED = {"compare-methods": "study methods", "figures": "study figures"}  # since 0.2.0
COMMANDS = {**ON_A_DIVE, **STEPS, **AROUND}
