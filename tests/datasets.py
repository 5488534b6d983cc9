# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The evaluation data: public logs, hulls and problems that the repository does not hold."""

import os
from pathlib import Path

import pytest

FOLDER = Path(
    os.environ.get("HULLRECON_DATA", Path(__file__).resolve().parents[2] / "shared" / "data")
)


def dataset(part: str = "") -> Path:
    """All of it or a part by its path; the test is skipped where that is not there."""
    if not (FOLDER / part).exists():
        pytest.skip(f"no evaluation data at {FOLDER / part} (set HULLRECON_DATA)")
    return FOLDER / part
