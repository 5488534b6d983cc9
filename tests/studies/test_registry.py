# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The list of studies, and the commands that run them."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from hullrecon_cli.commands.study import study
from hullrecon_cli.main import main

from hullrecon.errors import UsageError
from hullrecon.studies.registry import FIGURES, STUDIES, find_study
from hullrecon.studies.study import StudyFunction


def test_ids_of_studies_are_unique() -> None:
    ids = [entry.id for entry in STUDIES]
    assert len(set(ids)) == len(ids)


def test_commands_of_their_own_are_of_studies_there_are() -> None:
    tables = set(study.commands) - {"list", "run", "figures"}
    assert tables | set(FIGURES) <= {entry.id for entry in STUDIES}


def test_every_function_named_by_its_path_is_there() -> None:
    named = [entry.run for entry in STUDIES if isinstance(entry.run, StudyFunction)]
    assert named
    assert all(callable(function.load()) for function in named)


def test_an_unknown_study_is_refused() -> None:
    with pytest.raises(UsageError, match="no study is called 'sonar'"):
        find_study("sonar")


def test_list_names_every_study_with_its_source(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "list", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document == {
        s.id: {"source": s.source, "shows": s.shows, "needs_dive": s.needs_dive} for s in STUDIES
    }


def test_study_alone_prints_its_help() -> None:
    answer = CliRunner().invoke(study, [])
    assert answer.exit_code == 0
    assert "methods" in answer.output
