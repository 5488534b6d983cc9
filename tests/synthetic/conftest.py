# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One small dive, simulated once, for the tests of this folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import DiveSpec, spec_from
from hullrecon.synthetic.package import write_package

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
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Dive]:
    folder = tmp_path_factory.mktemp("packages") / "small"
    return folder, write_package(folder, SMALL)


@pytest.fixture(scope="session")
def dive(written: tuple[Path, Dive]) -> Dive:
    return written[1]


@pytest.fixture(scope="session")
def package(written: tuple[Path, Dive]) -> Path:
    return written[0]
