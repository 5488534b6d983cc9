# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A footprint that ends because the survey does is told from one that ends on bare hull."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.objects.footprint import OpenEdge, find_open_edge
from hullrecon.detection.objects.regions import find_regions
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around

Unseen = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _edge_of_disc(found: HullAsFound, unseen: Unseen) -> tuple[OpenEdge, HullAsFound]:
    """The disc 0.10 m high and 0.24 m wide at (1.2, 1), where vertices (x, z) about its middle were
    not measured.
    """
    hidden = unseen(found.base.vertices[:, 0] - 1.2, found.base.vertices[:, 2] - 1.0)
    cut = replace(
        found, measured=found.measured & ~hidden, height=np.where(hidden, 0.0, found.height)
    )
    disc = next(region for region in find_regions(cut, DetectOptions()) if region.side > 0)
    return find_open_edge(cut, disc, vertex_areas(cut.base), Around(cut.base.vertices)), cut


def test_a_structure_with_hull_all_around_has_no_open_edge(found: HullAsFound) -> None:
    edge, _ = _edge_of_disc(found, lambda x, z: np.hypot(x, z) > 0.25)
    assert (edge.share, len(edge.beyond), edge.height) == (0.0, 0, 0.0)


def test_a_structure_cut_in_half_is_open_along_the_cut(found: HullAsFound) -> None:
    edge, cut = _edge_of_disc(found, lambda x, z: x > 0)
    # the diameter's share of the outline of a half disc
    assert edge.share == pytest.approx(2 / (2 + np.pi), abs=0.07)
    assert edge.height == pytest.approx(0.10, abs=0.01)
    x, z = (cut.base.vertices[edge.beyond][:, [0, 2]] - (1.2, 1.0)).T
    assert not cut.measured[edge.beyond].any()
    assert x.max() == pytest.approx(0.14, abs=0.03)  # as far as half a disc reaches from its middle
    assert np.abs(z).max() < 0.12 + 0.16


def test_a_gap_behind_measured_hull_opens_nothing(found: HullAsFound) -> None:
    edge, _ = _edge_of_disc(found, lambda x, z: x > 0.18)
    assert edge.share == 0.0


def test_a_small_gap_beside_a_structure_hides_no_more_than_itself(found: HullAsFound) -> None:
    edge, cut = _edge_of_disc(found, lambda x, z: np.hypot(x - 0.12, z) < 0.05)
    assert 0.05 < edge.share < 0.3
    assert np.hypot(*(cut.base.vertices[edge.beyond][:, [0, 2]] - (1.32, 1.0)).T).max() < 0.05
