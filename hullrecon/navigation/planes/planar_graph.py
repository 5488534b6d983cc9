# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve the pose graph without planes, then with patches of hull that the DVL saw on two passes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon import native
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.navigation.planes.comparison import PatchPairs, compare_patches
from hullrecon.navigation.planes.curvature import BROAD, curvature_of_mesh, curvature_of_patches
from hullrecon.navigation.planes.patches import Patches, find_patches
from hullrecon.navigation.planes.ties import (
    is_alike,
    is_informative,
    is_position_known,
    propose_ties,
    roughness,
    tie_planes,
)
from hullrecon.navigation.pose_graph.graph import OPTIONS, GraphSolution, PoseGraph
from hullrecon.records.links import CameraLinks
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array

# Prior sigma of a patch's curvature over the characteristic curvature. With 1 patches come out too
# flat, by a fifth where their noise is half of it, and the planes of a full circle around a hull
# pull the path along it.
PRIOR_WIDER = 2.0
MOST_ROUNDS = 5  # of solving and offering ties anew
LEAST_TIES = 5
# share of the offered ties that agree: on a ship's side 0.9 and more, on rocks far less
LEAST_AGREEING = 0.6
MAX_ROUGHNESS = (
    5.0  # factor on the noise, beyond which patches have little and uncertain information
)
SAME_ROUGHNESS = 0.05  # relative change of the factors, below which they have converged
# chi-square of the estimated navigation errors: 99.9 % at their six degrees of freedom
MAX_NAVIGATION_CHI2 = 22.5


@dataclass(frozen=True, kw_only=True)
class PlanarSolution(GraphSolution):
    """A solved pose graph, with planes or without."""

    patches: int  # number of patches that the returns show on its path
    offered: int  # number of pairs of them that would add information
    refusal: str | None  # why offered planes were left out; None where they are used

    @property
    def planes(self) -> TiedPlanes | None:
        """The planes that tie the path. None where there are none."""
        return self.graph.planes


@dataclass(frozen=True, kw_only=True)
class Offer:
    """Ties between patches that would add information to the path."""

    patches: int  # number of patches on the path
    roughness: Array  # (3,) factors on the noise of height and slopes, 1 for a smooth hull
    offered: int  # number of pairs that would add information
    agreeing: frozenset[tuple[int, int]]  # those whose patches agree
    planes: TiedPlanes | None  # of the agreeing pairs; None with too few

    @property
    def trusted(self) -> bool:
        """Whether enough of the offered pairs agree for them to be believed."""
        return len(self.agreeing) >= LEAST_AGREEING * self.offered


@dataclass(frozen=True, kw_only=True)
class PlanarGraph:
    """A pose graph, the DVL's returns that show the hull, and its characteristic curvature."""

    graph: PoseGraph
    returns: Returns
    curvature: Array | None  # (3,) 1/m, None where it is estimated from the dive

    def solve(self, links: CameraLinks, before: GraphSolution | None = None) -> PlanarSolution:
        """Solve for the path with links, and with planes where these add information.

        Ties are proposed on the solved path, the graph is solved with them, and so on until the
        same ties agree. Planes that contradict each other or navigation are all left out: a wrong
        plane is worse than none.

        Parameters
        ----------
        links
            Relative poses that images measured.
        before
            A solution with fewer links, to start from.
        """
        alone = self.graph.solve(links, before)
        # The characteristic curvature: the CAD model's, else that of patches fitted with little
        # prior knowledge.
        known = (
            curvature_of_patches(self._patches(alone, BROAD))
            if self.curvature is None
            else self.curvature
        )
        curvature = PRIOR_WIDER * known
        # Ties change with the path on which patches are compared, so both are found in turns.
        solved, offer = alone, self._offer_ties(alone, alone, curvature, np.ones(3))
        for _ in range(MOST_ROUNDS):
            if offer.planes is None or _why_refused(offer, alone) is not None:
                break
            solved = replace(self.graph, planes=offer.planes).solve(links, solved)
            last, offer = offer, self._offer_ties(alone, solved, curvature, offer.roughness)
            if last.agreeing == offer.agreeing and np.allclose(
                last.roughness, offer.roughness, rtol=SAME_ROUGHNESS
            ):
                break
        refusal = _why_refused(offer, solved)
        return _with_offer(alone if refusal else solved, offer, refusal)

    def _offer_ties(
        self, alone: GraphSolution, solved: GraphSolution, curvature: Array, rough: Array
    ) -> Offer:
        """Propose the ties between planes on a solved path.

        Pairs of patches are offered that would add information, and those of them that agree become
        ties. With fewer than LEAST_TIES of them there are no planes.

        Parameters
        ----------
        alone
            The solution without planes, whose covariance decides what a tie would add.
        solved
            The solution on whose path patches are compared.
        curvature, rough
            Estimates (3,) for the hull so far: prior sigma of the curvature, and the factors of
            roughness.
        """
        path, rig = solved.path, self.graph.rig
        patches = self._patches(solved, curvature)
        first, second = propose_ties(patches, path)

        # The noise of all pairs is inflated by how much their gaps exceed it.
        smooth = compare_patches(patches, first, second, path)
        joint = _joint_covariance(solved, patches, smooth)
        rough = np.maximum(rough, roughness(patches, smooth, path, rig, joint))
        pairs = smooth.roughened(rough)

        # A tie is offered where it has more information than the path without planes.
        joint_alone = joint if solved is alone else _joint_covariance(alone, patches, pairs)
        is_offered = is_informative(patches, pairs, path, rig, joint_alone)
        is_offered &= is_position_known(patches, pairs, path, rig, joint_alone)
        pairs, joint = pairs.rows(is_offered), joint[is_offered]
        agreeing = pairs.rows(is_alike(patches, pairs, path, rig, joint))
        return Offer(
            patches=len(patches),
            roughness=rough,
            offered=len(pairs),
            agreeing=frozenset(zip(agreeing.first.tolist(), agreeing.second.tolist(), strict=True)),
            planes=tie_planes(patches, agreeing, self.returns)
            if len(agreeing) >= LEAST_TIES
            else None,
        )

    def _patches(self, solved: GraphSolution, curvature: Array) -> Patches:
        return find_patches(
            self.returns, solved.path, self.graph.trajectory.t_ns, self.graph.rig, curvature
        )


def planar_graph(graph: PoseGraph, returns: Returns, cad_model: Mesh | None) -> PlanarGraph:
    """Make a planar graph. The curvature is the CAD model's, else estimated from the dive."""
    return PlanarGraph(
        graph=graph,
        returns=returns,
        curvature=None if cad_model is None else curvature_of_mesh(cad_model),
    )


def _joint_covariance(solved: GraphSolution, patches: Patches, pairs: PatchPairs) -> Array:
    """Compute the covariance (m, 14, 14) of the poses and trays of both anchors of each pair.

    It tells how well the path predicts the gap between the pair's patches. An anchor is the node in
    whose vehicle frame a patch was fitted. Of each there are translation in g, rotation on the
    right, and the tray's angle.
    """
    if not len(pairs):
        return np.zeros((0, 14, 14))
    nodes = np.column_stack([patches.anchor[pairs.first], patches.anchor[pairs.second]]).astype(
        np.int32
    )
    return native.pair_covariance(solved.problem, nodes, OPTIONS).pose


def _why_refused(offer: Offer, solved: GraphSolution) -> str | None:
    """Explain why planes are left out.

    Returns None where planes are used, and where there was none to use.

    They are left out where few of them agree, where the hull is too rough, and where the solution
    with them asks for implausible errors of navigation.
    """
    if offer.offered >= LEAST_TIES and not offer.trusted:
        share = 100 * len(offer.agreeing) / offer.offered
        return (
            f"only {share:.0f} % of {offer.offered} patches of the hull that were passed again "
            "agree with what was measured before"
        )
    if offer.roughness.max() > MAX_ROUGHNESS:
        return (
            f"what is passed again differs {offer.roughness.max():.0f} times as "
            "much as a smooth hull would"
        )
    if solved.graph.planes is None:
        return None
    found = solved.problem.unknowns.navigation / solved.problem.priors.navigation_sigma
    if found @ found > MAX_NAVIGATION_CHI2:
        return (
            f"they ask for navigation errors {np.sqrt(found @ found / len(found)):.1f} "
            "times as large as their sigmas"
        )
    return None


def _with_offer(solved: GraphSolution, offer: Offer, refusal: str | None) -> PlanarSolution:
    """Add to a solution what was offered, and why planes were refused.

    offer: the last one. solved: the solution that is kept, without planes where they were refused.
    """
    return PlanarSolution(
        graph=solved.graph,
        links=solved.links,
        problem=solved.problem,
        rejected=solved.rejected,
        converged=solved.converged,
        patches=offer.patches,
        offered=offer.offered,
        refusal=refusal,
    )
