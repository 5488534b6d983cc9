# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two thousand damaged inputs and all that were ever found: a typed error in one line, a named
loss, or the same data.
"""

from pathlib import Path

import pytest

from benchmarks.fuzz.cases import BAD, Bench
from benchmarks.fuzz.corpus import Entry, read_corpus
from benchmarks.fuzz.formats import seeds

CORPUS = Path(__file__).parent / "corpus.json"
SEED = 20260504
CASES = {"image": 350, "hull-gz": 350, "hull": 125, "toml": 250, "yaml": 100}
OF_A_LOG = 66
BATCHES = [(form, part) for form in seeds() for part in range(2)]


@pytest.mark.parametrize(("form", "part"), BATCHES)
def test_damaged_input_is_refused_or_its_loss_named(bench: Bench, form: str, part: int) -> None:
    count = CASES.get(form, OF_A_LOG)
    verdicts = {case: bench.run(form, SEED, case) for case in range(part, count, 2)}
    assert {case: verdict for case, verdict in verdicts.items() if verdict.kind in BAD} == {}
    # the damage is neither always seen nor never
    assert len({verdict.kind for verdict in verdicts.values()}) > 1


@pytest.mark.parametrize(
    "entry", read_corpus(CORPUS), ids=lambda entry: f"{entry.form}-{entry.found[:40]}"
)
def test_what_was_ever_found_stays_repaired(bench: Bench, entry: Entry) -> None:
    verdict = bench.judge(entry.form, entry.number, entry.data())
    assert verdict.kind not in BAD, verdict.text
