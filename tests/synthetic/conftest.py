# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One small dive, simulated once, for the tests of this folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.output.package import write_package
from hullrecon.synthetic.spec import DiveSpec

SMALL = spec_from(
    name="small",
    seed=3,
    legs=2,
    leg_length_m=1.6,
    image_width=240,
    image_height=192,
    views=3.0,
    structures=2,
    marks=1,
    barnacles=0,
)


@pytest.fixture(scope="session")
def spec() -> DiveSpec:
    return SMALL


@pytest.fixture(scope="session")
def dive() -> Dive:
    return simulate_dive(SMALL)


@pytest.fixture(scope="session")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("packages") / "small"
    write_package(folder, SMALL)
    return folder
