# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where documents and messages list the logs that are read, every reader's form is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.fuzz.formats import seeds
from hullrecon.dive.logs.readers import open as opening
from hullrecon.dive.logs.readers.file_log import FileLog

ROOT = Path(__file__).resolve().parents[2]
READERS = [c for c in vars(opening).values() if isinstance(c, type) and issubclass(c, FileLog)]
# a .db3 belongs to a ROS 2 folder
FORMS = sorted({reader.kind.split()[-1] for reader in READERS} - {"database"})
OF_INSTRUMENTS = sorted({reader.kind.split()[-1] for reader in READERS if reader.gives_samples})
LISTS = {  # a file, and words by which the paragraph is known that lists the forms
    "README.md": "It reads ",
    "ARCHITECTURE.md": "yield samples themselves",
    "docs/dive_package.md": "| form | note |",
    "docs/tutorial.md": "MCAP files, ",
    "docs/security.md": "| form | damage that is noticed |",
    "docs/configuration.md": "`logs.files`",
}


def test_the_forms_are_those_of_the_readers() -> None:
    assert FORMS == ["AD2CP", "ARIS", "JSON", "MCAP", "PD0", "ViewPoint", "bag"]
    assert OF_INSTRUMENTS == ["AD2CP", "ARIS", "JSON", "PD0", "ViewPoint"]


def test_the_message_that_lists_what_is_read_names_every_form() -> None:
    assert [form for form in FORMS if form not in opening.FORMS] == []


@pytest.mark.parametrize("page", LISTS)
def test_a_list_of_the_logs_that_are_read_names_every_form(page: str) -> None:
    (paragraph,) = [part for part in (ROOT / page).read_text().split("\n\n") if LISTS[page] in part]
    wanted = OF_INSTRUMENTS if page == "ARCHITECTURE.md" else FORMS
    assert [form for form in wanted if form not in paragraph] == []


@pytest.mark.parametrize("read", ["log", "init"])
def test_logs_of_every_form_are_damaged_for_a_run_and_for_init(read: str) -> None:
    damaged = {
        Path(seed.target).suffix for each in seeds().values() for seed in each if seed.read == read
    }
    assert {*opening.BY_SUFFIX, ".json"} - damaged == set()
