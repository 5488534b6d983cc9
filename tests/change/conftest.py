# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Comparisons that many tests look at, made once."""

from __future__ import annotations

from dataclasses import replace

import pytest
from change.simulated_surveys import BEFORE, drawn, survey

from hullrecon.change.compare_surveys import compare_surveys
from hullrecon.records.change import HullChange
from hullrecon.synthetic.items import Item

ADDED = (
    Item("recess", 32.2, 4.8, -0.04, (0.25, 0.25)),
    Item("cylinder", 31.2, 4.7, 0.09, (0.2, 0.2)),
    Item("dome", 32.4, 5.5, 0.1, (0.24, 0.24)),
)
GROWN = replace(BEFORE[0], height_m=0.14)


def address(point, sigma):
    return f"x {point[0]:.1f}"


@pytest.fixture(scope="session")
def changed() -> HullChange:
    """Three structures new, the lump gone, the cylinder 3 cm higher, between two dives with errors
    of their own.
    """
    after = (GROWN, *BEFORE[1:3], *ADDED)
    return compare_surveys(
        survey(BEFORE, drawn(2), name="may"), survey(after, drawn(102), name="june"), address
    )


@pytest.fixture(scope="session")
def unchanged() -> HullChange:
    """Nothing changed between two dives with errors of their own."""
    return compare_surveys(
        survey(BEFORE, drawn(3), name="may"), survey(BEFORE, drawn(103), name="june"), address
    )
