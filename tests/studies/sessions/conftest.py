# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A short session, solved once."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.sessions.factors import State
from hullrecon.studies.sessions.graph import Graph, solve, whole
from hullrecon.studies.sessions.survey import Session, legs, survey

Solved = tuple[Session, Graph, State]


@pytest.fixture(scope="session")
def solved() -> Solved:
    session = survey(legs(-4.0, 3.0, (1.5, 2.5)), np.random.default_rng(2))
    graph = whole(session.factors, session.start)
    return session, graph, solve(graph, session.start).state
