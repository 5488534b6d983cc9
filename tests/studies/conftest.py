# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The wall of the evaluation's tests, here as the dive that studies are made of."""

import pickle

import numpy as np
import pytest
from detection.conftest import scenery, views_at
from evaluation.conftest import block_points, deliver, package, returns, rig, solution, wall_points

from hullrecon.studies.scenes.scene_figures import draw_scene_figures

__all__ = [
    "block_points",
    "deliver",
    "package",
    "returns",
    "rig",
    "scenery",
    "solution",
    "views_at",
    "wall_points",
]


@pytest.fixture
def pictures() -> None:
    """Is asked for by tests that look at pictures."""


@pytest.fixture(autouse=True)
def _no_other_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures of figures away, which cost far more than their tables and captions."""
    if "pictures" not in request.fixturenames:
        monkeypatch.setattr("hullrecon.studies.figure_style.png_bytes", lambda _: b"")


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


@pytest.fixture(scope="session")
def scene_figures(once) -> list:
    """The figures of scenes that need no dive, drawn once."""
    folder = once(
        "scene_figures",
        lambda shell: (shell.folder / "figures").write_bytes(pickle.dumps(draw_scene_figures())),
    )
    return pickle.loads((folder / "figures").read_bytes())
