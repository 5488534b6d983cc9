# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`evaluate` as a command."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hullrecon_cli.commands import results

from hullrecon.errors import InputError


def call(command: Any, *arguments: object) -> Any:
    return CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)


def test_evaluate_prints_a_figure_a_line_with_its_unit(deliver: Any, package: Path) -> None:
    deliver.track()
    lines = call(results.evaluate, deliver.folder, package).stdout.splitlines()
    rigid = next(line.split() for line in lines if line.startswith("trajectory.rigid_rmse_m"))
    assert float(rigid[1]) < 1e-6
    assert rigid[2] == "m"
    assert ["objects", "missing"] in [line.split() for line in lines]


def test_evaluate_of_a_package_without_truth_is_refused(deliver: Any, tmp_path: Path) -> None:
    deliver.track()
    with pytest.raises(InputError, match="no truth"):
        call(results.evaluate, deliver.folder, tmp_path)


def test_a_json_of_figures_has_no_nan(deliver: Any, package: Path) -> None:
    from hullrecon.evaluation.score import score_run, without_nan

    deliver.track()
    deliver.objects()
    document = json.dumps(without_nan(score_run(deliver.folder, package)), allow_nan=False)
    assert json.loads(document)["objects"]["height_error_median_m"] is None
