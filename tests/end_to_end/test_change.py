# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two simulated dives of one hull, run and compared: three objects added, one removed, one grown by 3 cm."""

import pytest

from benchmarks.change import SMALLEST, compare

pytestmark = pytest.mark.slow


def test_all_five_changes_are_found_and_nothing_else(tmp_path):
    figures = compare(tmp_path, 1, SMALLEST)
    assert figures["found"] == 5
    assert figures["missed"] == figures["false"] == []
    grown, sigma = figures["grown_m"][0]
    assert grown == pytest.approx(0.03, abs=3 * sigma)
