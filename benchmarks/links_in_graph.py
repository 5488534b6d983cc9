# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the pose graph of a run throws false links out that images took."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import RIG_SECTIONS
from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.pose_graph.graph import GraphSolution, PoseGraph
from hullrecon.records.links import CameraLinks, no_links
from hullrecon.rig import rig_with_priors
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact, NavigateArtifact
from hullrecon.typing import Ints, Mask
from hullrecon.vision.pairs.cycles import contradicted_links
from hullrecon.vision.pairs.pair_match import PairMatch

RIGHT, MOST_GRAPHS = 20, 10  # links of the run to a false one; graphs that are solved


def solved_graph(run: Path, config: LoadedConfig) -> GraphSolution:
    """Return the pose graph as the step `links` had it, without planes, solved with the links of
    the run.
    """
    ingest, navigate = IngestArtifact(run / "ingest"), NavigateArtifact(run / "navigate")
    rig = rig_with_priors({name: config.value(name) for name in RIG_SECTIONS}, ingest.camera_models)
    graph = PoseGraph(
        trajectory=navigate.trajectory,
        odometry=navigate.odometry,
        attitude=navigate.attitude,
        rig=rig,
    )
    return graph.solve(LinksArtifact(run / "links").links, graph.solve(no_links(), None))


def kept_by_graph(run: Path, solved: GraphSolution, false: CameraLinks) -> dict[str, int]:
    """Count the false links added to those of the run, one to RIGHT of these, and how
    many are left when cycles and the solved path have had their say.
    """
    right, pairs = solved.links, LinksArtifact(run / "links").pairs
    across = pairs.across[pairs.joined]
    most = max(1, len(right) // RIGHT)
    added = kept = 0
    for start in range(0, min(len(false), MOST_GRAPHS * most), most):
        some = select(false, np.arange(start, min(start + most, len(false))))
        both = joined(right, some)
        rejected = contradicted_links(both, np.r_[across, np.ones(len(some), bool)])
        again = solved.graph.solve(select(both, ~rejected), solved)
        rejected[~rejected] = again.rejected
        added, kept = added + len(some), kept + int((~rejected[len(right) :]).sum())
    return {"added": added, "kept": kept}


def links_of(first: Ints, second: Ints, matches: Sequence[PairMatch]) -> CameraLinks:
    """Return the pairs of nodes (m,) that matched as links of the top cameras."""
    rows = np.array([k for k, match in enumerate(matches) if match.motion is not None], np.int64)
    found = [motion for motion in (matches[k].motion for k in rows) if motion is not None]
    relative = from_matrix(np.array([m.second_from_first for m in found]).reshape(-1, 4, 4))
    return CameraLinks(
        first=first[rows],
        second=second[rows],
        translation=relative.translation,
        quaternion=relative.quaternion,
        covariance=np.array([m.covariance for m in found]).reshape(-1, 6, 6),
        scaled=np.array([matches[k].scaled for k in rows], bool),
        bottom=np.zeros((len(rows), 2), bool),
    )


def select(links: CameraLinks, rows: Ints | Mask) -> CameraLinks:
    """Select some of the links."""
    return CameraLinks(**{f.name: getattr(links, f.name)[rows] for f in fields(CameraLinks)})


def joined(first: CameraLinks, second: CameraLinks) -> CameraLinks:
    """Join two tables of links."""
    names = [f.name for f in fields(CameraLinks)]
    return CameraLinks(
        **{name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in names}
    )
