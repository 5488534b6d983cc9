"""Which nodes of a merged graph are kept [Ozog2016 2.4.3.4, Algorithm 2]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hullrecon.studies.sessions.factors import State
from hullrecon.studies.sessions.graph import Graph
from hullrecon.studies.sessions.removal import remove_node
from hullrecon.typing import Array, Ints, Mask

REDUNDANT_M, VIEWS = 1.5, 3  # as printed
APART_S = 60.0  # two views of a place that are nearer in time are one; not printed


@dataclass(frozen=True, kw_only=True)
class View:
    """A key frame that is kept."""

    node: int
    at_s: float


@dataclass(frozen=True, kw_only=True)
class Neighbourhood:
    """A place of the hull with the views kept of it, the oldest first."""

    center: Array  # (3,) m
    views: list[View] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Candidates:
    """The nodes of the session that has just been merged."""

    nodes: Ints  # (n,)
    places: Array  # (n, 3) m
    times_s: Array  # (n,)
    salient: Mask  # (n,)


def choose_nodes(kept: list[Neighbourhood], new: Candidates) -> list[int]:
    """Choose the nodes to remove by Algorithm 2. The neighbourhoods `kept` are updated.

    A new node goes if it is near another one, if its place was seen just before, or if it shows
    little. Of a place with too many views the oldest goes.
    """
    redundant = spatially_redundant(new.places)
    gone = [int(node) for node in new.nodes[redundant]]
    for k in np.flatnonzero(~redundant):
        node, at_s = int(new.nodes[k]), float(new.times_s[k])
        views = nearest_or_new(kept, new.places[k]).views
        if any(abs(v.at_s - at_s) < APART_S for v in views) or not new.salient[k]:
            gone.append(node)
            continue
        views.append(View(node=node, at_s=at_s))
        if len(views) > VIEWS:
            gone.append(views.pop(0).node)
    return gone


def spatially_redundant(places: Array) -> Mask:
    """Find places (n, 3) m that are near an earlier one that is not redundant itself."""
    redundant = np.zeros(len(places), bool)
    for k in range(1, len(places)):
        before = places[:k][~redundant[:k]]
        redundant[k] = np.linalg.norm(before - places[k], axis=1).min() < REDUNDANT_M
    return redundant


def nearest_or_new(kept: list[Neighbourhood], place: Array) -> Neighbourhood:
    """Find the neighbourhood of a place, or begin one."""
    near = [n for n in kept if np.linalg.norm(n.center - place) < REDUNDANT_M]
    if near:
        return min(near, key=lambda n: float(np.linalg.norm(n.center - place)))
    kept.append(Neighbourhood(center=place))
    return kept[-1]


def remove_nodes(
    graph: Graph,
    state: State,
    poses: Sequence[int],
    planes: Sequence[int],
    *,
    tree: bool = True,
    at_root: bool = True,
) -> Graph:
    """Remove planes, then poses, one after the other. Parameters are as of `remove_node`."""
    for plane in planes:
        graph = remove_node(graph, state, plane=plane, tree=tree, at_root=at_root)
    for pose in poses:
        graph = remove_node(graph, state, pose=pose, tree=tree, at_root=at_root)
    return graph
