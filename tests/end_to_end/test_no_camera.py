# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive with neither camera nor CAD model, from the command to the deliverables: planes of the
hull bound its drift.
"""

import json
import shutil

import pytest
from end_to_end import claims
from end_to_end.shell import Shell

from hullrecon.evaluation.score import score_run

pytestmark = pytest.mark.slow

DIVE = (
    "--cameras",
    "none",
    "--no-sonar",
    "--legs",
    2,
    "--leg-length-m",
    7,
    "--leg-spacing-m",
    0.5,
    "--structures",
    0,
    "--marks",
    0,
    "--barnacles",
    0,
    "--heading-drift-deg-per-hour",
    400,
    "--seed",
    3,
    "--form",
    "plain",
)


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    """The dive, run with planes into `with` and without them into `without`."""
    shell = Shell(tmp_path_factory.mktemp("no_camera"))
    shell("simulate", "dive", *DIVE)
    path = shell.folder / "dive" / "dive.toml"
    text = path.read_text()
    path.write_text(text[: text.index("[hull]")])
    shell("run", "dive", "--runs", "with")
    shutil.copytree(
        shell.folder / "with", shell.folder / "without"
    )  # up to navigate it is the same
    shell("run", "dive", "--runs", "without", "--set", "links.planes=false")
    return shell


def trajectory(shell, runs):
    return score_run(shell.folder / runs / "simulated", shell.folder / "dive")["trajectory"]


def test_the_delivered_path_and_surface_stand_on_the_planes(shell):
    run = shell.folder / "with" / "simulated"
    facts = json.loads((run / "links" / "links.json").read_text())["planes"]
    assert facts["ties"] > 5
    assert json.loads((run / "surface" / "surface.json").read_text())["poses"] == "adjusted"


def test_planes_improve_the_path_within_its_sigmas(shell):
    planes, without = trajectory(shell, "with"), trajectory(shell, "without")
    assert planes["rigid_rmse_m"] < 0.4 * without["rigid_rmse_m"]
    assert all(planes[f"error_over_sigma_{axis}"] < 2.5 for axis in "xyz")


def test_heading_drift_on_the_page_is_the_simulated_one(shell):
    run = shell.folder / "with" / "simulated"
    errors = claims.sensor_errors(run, shell.folder / "dive", drift_deg_per_hour=400)
    assert abs(errors["Drift of the heading"]) < 3
