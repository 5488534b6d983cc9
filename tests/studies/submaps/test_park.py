# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A park with trees: simulated, and as its public files hold it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from hullrecon.errors import InputError
from hullrecon.studies.association.trunks import scan_trees
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import Limits
from hullrecon.studies.submaps.missions import build_submaps
from hullrecon.studies.submaps.models import Car
from hullrecon.studies.submaps.park import FILES, Park, follow, read_victoria_park, simulate_park
from hullrecon.studies.submaps.park_study import within


@pytest.fixture(scope="module")
def park() -> Park:
    return simulate_park(1, laps=0.4)


def test_trees_are_mapped_from_scans_of_beams(park: Park) -> None:
    submaps = build_submaps(park.world.log, Limits(), Effort())
    assert sum(built.wrong_pairs for built in submaps) == 0
    first = submaps[0]  # its frame is the park's
    off = np.linalg.norm(first.landmarks - park.world.landmarks[first.truth], axis=1)
    rows = first.rows(np.arange(len(off)))
    sigma = np.sqrt(np.diag(first.covariance)[rows].reshape(-1, 2).sum(axis=1))
    assert (off / sigma).max() < 3.0
    assert off.max() < 1.0
    assert within([point for built in submaps for point in built.path]) > 0.9


def test_a_car_follows_its_way() -> None:
    angle = np.linspace(0, 1.5 * np.pi, 200)
    way = 40.0 * np.column_stack([np.sin(angle), 1 - np.cos(angle)])
    pose, car, off = np.zeros(3), Car(), []
    for speed, steering in follow(way):
        pose = car.move(pose, speed, steering, 0.1)
        off.append(np.linalg.norm(way - pose[:2], axis=1).min())
    assert max(off) < 2.5


def write_park(folder: Path, tree: np.ndarray) -> None:
    """Write a drive of three seconds straight ahead, with a scan a second."""
    rng = np.random.default_rng(0)
    time = np.arange(0, 3001, 50.0)
    savemat(
        folder / FILES[0],
        {"time": time, "speed": np.full(61, 2.0), "steering": np.zeros(61)},
    )
    scans = [
        scan_trees(np.array([2.0 * second, 0.0, 0.0]), tree, 0.0, rng) for second in (1.0, 2.0)
    ]
    cm = np.round(100 * np.array(scans)).astype(np.uint16)
    savemat(folder / FILES[1], {"TLsr": np.array([1001.0, 2001.0]), "LASER": cm})
    east, north = np.array([0.0, 2.0]), np.zeros(2)
    savemat(folder / FILES[2], {"timeGps": np.array([0.0, 1000.0]), "Lo_m": east, "La_m": north})


def test_public_files_are_read_in_metres_and_radians(tmp_path: Path) -> None:
    write_park(tmp_path, np.array([[12.0, 3.0, 0.4]]))
    recorded = read_victoria_park(tmp_path)
    assert recorded.log.step_s == pytest.approx(np.full(60, 0.05))
    assert recorded.log.odometry[0] == pytest.approx([2.0, 0.0])
    assert sorted(recorded.log.scans) == [20, 40]
    scan = recorded.log.scans[20]
    assert scan.readings[0, 0] == pytest.approx(np.hypot(10.0, 3.0), abs=0.06)
    assert scan.readings[0, 1] == pytest.approx(np.arctan2(3.0, 10.0) + np.pi / 2, abs=0.01)
    assert recorded.gps_step.tolist() == [0, 19]


def test_a_folder_without_the_files_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"aa3_dr\.mat"):
        read_victoria_park(tmp_path)
