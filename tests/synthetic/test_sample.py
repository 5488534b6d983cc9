# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.dive_toml import dive_toml
from hullrecon.synthetic.sample import SAMPLE
from hullrecon.synthetic.truth import write_truth

DEMO = Path(__file__).resolve().parents[2] / "sample_data" / "demo"


@pytest.fixture(scope="module")
def again() -> Dive:
    return simulate_dive(SAMPLE)


def test_sample_is_small_enough_for_repository() -> None:
    assert sum(p.stat().st_size for p in DEMO.rglob("*") if p.is_file()) < 12e6


def test_sample_is_what_its_description_makes(again: Dive, tmp_path: Path) -> None:
    kept, made = tomllib.loads((DEMO / "dive.toml").read_text()), tomllib.loads(dive_toml(again))
    np.testing.assert_allclose(kept["hull"].pop("pose"), made["hull"].pop("pose"), atol=1e-6)
    assert kept == made
    write_truth(tmp_path, again)
    for name in ("poses.csv", "servo.csv"):
        ours, theirs = (
            np.loadtxt(folder / name, delimiter=",", skiprows=1)
            for folder in (tmp_path, DEMO / "truth")
        )
        np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_sample_has_structures_to_find_and_paint_not_to() -> None:
    objects = json.loads((DEMO / "truth" / "objects.json").read_text())["objects"]
    assert (
        sum(not o["painted"] and abs(o["height"]) >= 0.08 and o["views"] >= 6 for o in objects) >= 3
    )
    assert any(o["painted"] for o in objects)


def test_sample_has_both_cameras_and_sonar() -> None:
    topics = tomllib.loads((DEMO / "dive.toml").read_text())["topics"]
    assert {"dvl", "imu", "pressure", "joints", "camera_top", "camera_bottom", "sonar"} == set(
        topics
    )
