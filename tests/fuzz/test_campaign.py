# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
import os
import signal
from collections import Counter

from benchmarks.fuzz import worker
from benchmarks.fuzz.__main__ import main
from benchmarks.fuzz.campaign import Campaign, run_campaign, signature
from benchmarks.fuzz.cases import Verdict
from benchmarks.fuzz.corpus import add_findings, read_corpus

TRACE = 'Traceback\n  File "/x/hullrecon/a.py", line 3, in f\n    f()\n  File "/y/numpy.py", line 9, in g\n{}: {}\n'


def test_failures_that_look_alike_are_one_finding_with_its_first_cases():
    campaign = Campaign(7)
    for case in (5, 3):
        campaign.add("toml", case, Verdict("traceback", TRACE.format("ValueError", case)))
    campaign.add("toml", 9, Verdict("traceback", TRACE.format("KeyError", "x")))
    campaign.add("toml", 1, Verdict("refused", "no"))
    document = campaign.document()
    assert document["formats"] == {"toml": {"refused": 1, "traceback": 3}}
    assert [(f["count"], f["cases"]) for f in document["failures"]] == [(2, [3, 5]), (1, [9])]


def test_a_traceback_is_known_by_the_innermost_place_of_ours():
    assert signature(Verdict("traceback", TRACE.format("ValueError", 1))) == 'File "/x/hullrecon/a.py", line 3, in f ValueError'
    assert signature(Verdict("silence")) == ""


def test_findings_go_to_the_corpus_once(tmp_path):
    campaign = Campaign(1)
    campaign.add("toml", 4, Verdict("traceback", TRACE.format("ValueError", 1)))
    for _ in range(2):
        add_findings(tmp_path / "c.json", campaign)
    assert [(e.form, e.found) for e in read_corpus(tmp_path / "c.json")] == [("toml", "traceback: ValueError: 1")]


def test_the_command_prints_what_it_found(capsys):
    assert main(["--cases", "41", "--seed", "1", "--format", "toml", "--format", "image", "--jobs", "1"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {form: sum(counts.values()) for form, counts in document["formats"].items()} == {"toml": 21, "image": 20}
    assert document["failures"] == []


def test_cases_have_the_same_verdicts_over_any_number_of_processes(bench):
    alone = Counter(bench.run("yaml", 5, case).kind for case in range(120))
    assert run_campaign(["yaml"], 120, 5, 2).verdicts == {"yaml": alone}


def test_a_process_that_dies_is_a_finding_and_another_goes_on(tmp_path):
    running = worker.Worker(tmp_path)
    try:
        assert running.run("no such format", 1, 0).kind == "crash"
        assert running.run("toml", 1, 0).kind in ("refused", "same", "unnoticed")
    finally:
        running.stop()


def test_a_process_that_does_not_answer_is_a_finding_and_another_goes_on(tmp_path, monkeypatch):
    running = worker.Worker(tmp_path)
    try:
        os.kill(running.pid, signal.SIGSTOP)
        monkeypatch.setattr(worker, "PATIENCE_S", 0.1)
        assert running.run("toml", 1, 0).kind == "hang"
        monkeypatch.undo()
        assert running.run("toml", 1, 0).kind in ("refused", "same", "unnoticed")
    finally:
        running.stop()
