# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
import os
import signal
from collections import Counter

import pytest

from benchmarks.fuzz import worker
from benchmarks.fuzz.__main__ import main
from benchmarks.fuzz.campaign import Campaign, read_campaign, run_campaign, signature
from benchmarks.fuzz.cases import Verdict
from benchmarks.fuzz.corpus import add_findings, read_corpus

TRACE = (
    'Traceback\n  File "/x/hullrecon/a.py", line 3, in f\n    f()\n  File "/y/numpy.py", '
    "line 9, in g\n{}: {}\n"
)


def test_similar_failures_are_one_finding():
    campaign = Campaign(7)
    for case in (5, 3):
        campaign.add("toml", case, Verdict("traceback", TRACE.format("ValueError", case)))
    campaign.add("toml", 9, Verdict("traceback", TRACE.format("KeyError", "x")))
    campaign.add("toml", 1, Verdict("refused", "no"))
    document = campaign.document()
    assert document["formats"] == {"toml": {"refused": 1, "traceback": 3}}
    assert [(f["count"], f["cases"]) for f in document["failures"]] == [(2, [3, 5]), (1, [9])]


def test_a_traceback_is_known_by_the_innermost_place_of_ours():
    assert (
        signature(Verdict("traceback", TRACE.format("ValueError", 1)))
        == 'File "/x/hullrecon/a.py", line 3, in f ValueError'
    )
    assert signature(Verdict("silence")) == ""


def test_findings_go_to_the_corpus_once(tmp_path):
    campaign = Campaign(1)
    campaign.add("toml", 4, Verdict("traceback", TRACE.format("ValueError", 1)))
    for _ in range(2):
        add_findings(tmp_path / "c.json", campaign)
    assert [(e.form, e.found) for e in read_corpus(tmp_path / "c.json")] == [
        ("toml", "traceback: ValueError: 1")
    ]


def test_the_command_prints_what_it_found(capsys):
    assert (
        main(
            ["--cases", "41", "--seed", "1", "--format", "toml", "--format", "image", "--jobs", "1"]
        )
        == 0
    )
    document = json.loads(capsys.readouterr().out)
    assert {form: sum(counts.values()) for form, counts in document["formats"].items()} == {
        "toml": 21,
        "image": 20,
    }
    assert document["failures"] == []


def test_verdicts_are_equal_over_any_number_of_processes(bench):
    alone = Counter(bench.run("yaml", 5, case).kind for case in range(120))
    assert run_campaign(Campaign(5), ["yaml"], 120, 2).verdicts == {"yaml": alone}


def test_a_campaign_that_was_ended_goes_on_where_it_was(bench, tmp_path, capsys):
    state = tmp_path / "state.json"
    words = ["--seed", "5", "--format", "yaml", "--format", "toml", "--state", str(state)]
    words += ["--jobs", "1"]
    assert main([*words, "--cases", "30"]) == 0
    assert main([*words, "--cases", "70"]) == 0
    capsys.readouterr()
    alone = {form: Counter(bench.run(form, 5, k).kind for k in range(35)) for form in words[3:6:2]}
    assert read_campaign(state).verdicts == alone
    assert set(json.loads(state.read_text())["worst"]) == {"yaml", "toml"}
    with pytest.raises(SystemExit):
        main([*words[2:], "--seed", "6"])


def test_a_campaign_is_written_and_read_back(tmp_path):
    campaign = Campaign(7, 3)
    campaign.add("toml", 5, Verdict("traceback", TRACE.format("ValueError", 1), 0.25, 3 << 20))
    (tmp_path / "state.json").write_text(json.dumps(campaign.document()))
    again = read_campaign(tmp_path / "state.json")
    again.add("toml", 6, Verdict("traceback", TRACE.format("ValueError", 2)))
    assert [(f["count"], f["cases"]) for f in again.document()["failures"]] == [(2, [5, 6])]
    assert again.document()["worst"] == {"toml": {"seconds": 0.25, "mib": 3.0}}


def test_a_process_that_dies_is_a_finding_and_another_goes_on(tmp_path):
    running = worker.Worker(tmp_path)
    try:
        assert running.run("no such format", 1, 0).kind == "crash"
        assert running.run("toml", 1, 0).kind in ("refused", "same", "unnoticed")
    finally:
        running.stop()


def test_process_that_hangs_is_a_finding_and_is_replaced(tmp_path, monkeypatch):
    running = worker.Worker(tmp_path)
    try:
        os.kill(running.pid, signal.SIGSTOP)
        monkeypatch.setattr(worker, "PATIENCE_S", 0.1)
        assert running.run("toml", 1, 0).kind == "hang"
        monkeypatch.undo()
        assert running.run("toml", 1, 0).kind in ("refused", "same", "unnoticed")
    finally:
        running.stop()
