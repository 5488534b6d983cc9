# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One bench for all tests: its sound inputs are read once."""

import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.fuzz.cases import Bench


@pytest.fixture(scope="session")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return Bench(Path(tmp_path_factory.mktemp("fuzz")))


@pytest.fixture(autouse=True)
def _warnings_as_in_a_run() -> Iterator[None]:
    """Numbers out of range warn, as they do in a run, where nothing turns warnings into errors."""
    with warnings.catch_warnings(action="ignore"):
        yield
