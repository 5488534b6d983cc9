# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve the pose graph of odometry, depth, attitude and links [KimEustice2009], [Ozog2016 2].

Navigation's systematic errors and the cameras' mount are unknowns. The native module solves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from hullrecon import native
from hullrecon.estimation.navigation_tables import (
    attitude_table,
    gauge_prior,
    mount_prior_table,
    odometry_table,
    tray_table,
    velocity_table,
)
from hullrecon.estimation.plane_tables import with_planes
from hullrecon.estimation.position_tables import PositionFit, fit_of_positions, with_positions
from hullrecon.geometry.poses import Poses, pose_from_vector, pose_vector
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.navigation.pose_graph.link_table import link_table, shared_noise
from hullrecon.navigation.pose_graph.start import path_along_links
from hullrecon.records.iterations import reached_cost
from hullrecon.records.links import CameraLinks, LinkedPath
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.trajectory import Attitude, Odometry, PositionTies, Trajectory, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# chi-square of a link over its rows; beyond, dynamic covariance scaling has all but dropped it
REJECTED_CHI2 = 5.0
MAX_REJECTED_SHARE = 0.03  # of the links; if more are rejected, the path itself may be wrong
MOUNTS = ("T_s_d", "T_s_ct", "T_ct_cb")
KERNELS = {
    "scaling": native.LinkKernel.SCALING,
    "switch": native.LinkKernel.SWITCH,
    "none": native.LinkKernel.NONE,
}
# Damping slows the bends of a long path, which the measurements hardly determine, far more than its
# single steps. With a smaller trust region they take ten iterations more, and stop short of the
# minimum. Two threads, as no images are compared meanwhile. They give the same bytes as one.
OPTIONS = native.Options(
    method="naive", max_iterations=60, function_tolerance=1e-7, initial_radius=1e8, threads=2
)


@dataclass(frozen=True, kw_only=True)
class PoseGraph:
    """Navigation's measurements, the rig with its priors, and the robust kernel for links."""

    trajectory: Trajectory
    odometry: Odometry
    attitude: Attitude
    rig: Rig
    kernel: str = "scaling"  # robust kernel against wrong links: "scaling", "switch" or "none"
    planes: TiedPlanes | None = None  # patches of hull that were seen on two passes and tie them
    positions: PositionTies | None = None  # position fixes (USBL, GNSS)

    def solve(self, links: CameraLinks, before: GraphSolution | None = None) -> GraphSolution:
        """Find the path of least cost.

        Without an earlier solution the start is `path_along_links`. Seen from there correct links
        look as wrong as wrong ones, so a first solve takes all links as right, and a second one
        guards against wrong links. The first solve is also tried where more than
        MAX_REJECTED_SHARE of the links are rejected from the earlier solution: they may share an
        error, as of the cameras' mount, that the earlier solution could not know. The cheaper
        result counts. Raises StageError where nothing determines the path.

        Parameters
        ----------
        links
            Relative poses that images measured.
        before
            A solution with fewer links, to start from.
        """
        if before is None:
            begin = path_along_links(self.trajectory, self.odometry, links, self.rig)
            pose = np.hstack([begin.vectors(), self.trajectory.tray[:, None]])
            return self._solve_guarded(links, self._solve_unguarded(links, pose))[0]
        known = before.problem.unknowns
        solved, cost = self._solve_guarded(links, known)
        if solved.rejected.sum() <= MAX_REJECTED_SHARE * len(links):
            return solved
        other, other_cost = self._solve_guarded(
            links, self._solve_unguarded(links, known.pose, known)
        )
        return other if other_cost < cost else solved

    def _solve_unguarded(
        self, links: CameraLinks, pose: Array, known: native.Unknowns | None = None
    ) -> native.Unknowns:
        """Solve with all links taken to be right.

        pose (n, 8): start of global_from_vehicle and the tray. known: start of the other unknowns.
        """
        problem = self._build_problem(links, native.LinkKernel.NONE, _vehicle(pose))
        start = problem.unknowns if known is None else self._carry_over(problem, known)
        return native.solve(problem.started_from(replace(start, pose=pose)), OPTIONS).unknowns

    def _solve_guarded(
        self, links: CameraLinks, known: native.Unknowns
    ) -> tuple[GraphSolution, float]:
        """Solve from known unknowns with the kernel that guards against wrong links.

        Returns the solution and its cost.
        """
        problem = self._build_problem(links, KERNELS[self.kernel], _vehicle(known.pose))
        result = native.solve(problem.started_from(self._carry_over(problem, known)), OPTIONS)
        solved = problem.started_from(result.unknowns)
        found = GraphSolution(
            graph=self,
            links=links,
            problem=solved,
            rejected=_find_rejected(solved, len(links)),
            converged=result.converged,
        )
        return found, float(reached_cost(result.iterations.cost, result.iterations.accepted)[-1])

    @staticmethod
    def _carry_over(problem: native.Problem, known: native.Unknowns) -> native.Unknowns:
        """Carry over the unknowns of another problem of the same dive.

        Switches of links and planes stay those of `problem`, as their number may differ.
        """
        return replace(
            known, link_switch=problem.unknowns.link_switch, plane=problem.unknowns.plane
        )

    def _build_problem(
        self, links: CameraLinks, kernel: native.LinkKernel, path: Poses
    ) -> native.Problem:
        """Build the native problem, started from dead reckoning.

        Parameters
        ----------
        links, kernel
            Relative poses, and how wrong ones are guarded against.
        path
            global_from_vehicle (n) as known so far, about which odometry is linearised.
        """
        rig, t, start = self.rig, self.trajectory, self.trajectory.track().path
        switches = len(links) if kernel == native.LinkKernel.SWITCH else 0
        mounts = {
            "T_s_d": rig.tray_from_dvl,
            "T_s_ct": rig.tray_from_top,
            "T_ct_cb": rig.top_from_bottom,
        }
        known = {
            "T_s_d": rig.priors.tray_from_dvl,
            "T_s_ct": rig.priors.tray_from_top if len(links) else None,
            "T_ct_cb": rig.priors.top_from_bottom if links.bottom.any() else None,
        }
        priors = {
            name: mount_prior_table(mount, known[name], mount) for name, mount in mounts.items()
        }
        # mounts that nothing measures, or that are known exactly
        held = {name for name, prior in priors.items() if prior is None}
        problem = native.Problem(
            unknowns=_start_unknowns(start, mounts, switches),
            constant=tuple(
                sorted(held | {"T_g_M", "deviation", "intrinsics_top", "intrinsics_bottom"})
            ),
            lever_arms=native.LeverArms(tray=rig.tray_origin, pressure=rig.pressure_origin),
            priors=native.Priors(
                T_s_d=priors["T_s_d"],
                T_s_ct=priors["T_s_ct"],
                T_ct_cb=priors["T_ct_cb"],
                pose=gauge_prior(start.poses, self.attitude),
                navigation_sigma=rig.priors.navigation_sigma,
            ),
            attitude=attitude_table(self.attitude),
            tray=tray_table(
                t.tray,
                self.attitude.tray_direction,
                rig.priors.tray_sigma_rad,
                self.attitude.tray_sigma,
            ),
            velocities=velocity_table(self.odometry, t.t_ns),
            odometry=odometry_table(
                _unlinked_motions(self.odometry, links), t.tray, rig.tray_from_dvl, path
            ),
            links=link_table(links, len(t.t_ns), kernel),
        )
        return with_positions(with_planes(problem, self.planes), self.positions)


@dataclass(frozen=True, kw_only=True)
class GraphSolution:
    """A solved pose graph."""

    graph: PoseGraph
    links: CameraLinks
    problem: native.Problem  # at its solution
    rejected: Mask  # (m,) links that all other measurements contradict
    converged: bool

    @property
    def path(self) -> VehiclePath:
        """The vehicle's poses and tray angles."""
        pose = self.problem.unknowns.pose
        return VehiclePath(
            poses=Poses(pose[:, 3:7].copy(), pose[:, :3].copy()), tray=pose[:, 7].copy()
        )

    def relative_errors(self, bottom: Mask) -> GraphErrors:
        """Prepare the covariances of the nodes' leading cameras relative to each other.

        With them it is predicted where images overlap. A node's leading camera is the one whose
        image is compared with other nodes.

        bottom (n,): nodes where the bottom camera leads.
        """
        return GraphErrors(problem=self.problem, bottom=bottom)

    def information_gain(
        self, bottom: Mask, first: Ints, second: Ints, information: Array
    ) -> Array:
        """Compute the information (m,), nats, that one more link adds [docs/methods.md (59a)].

        With it the pairs of images that are worth comparing next are chosen. The mounts are held.
        Links measure the motion of cameras, so an unknown error of the mount would make each of
        them look informative, however many there are already.

        Parameters
        ----------
        bottom
            Nodes (n,) where the bottom camera leads.
        first, second
            Nodes (m,) of the link.
        information
            Inverse covariance (m, 6, 6) of each link's second_from_first, in the order of
            `CameraLinks.covariance`. It is singular where the link measures no length.
        """
        kept = ~self.rejected
        ends = np.concatenate([self.links.first[kept], self.links.second[kept]])
        degree = 1 + np.bincount(ends, minlength=len(bottom))  # with the new link
        own = information / shared_noise(degree, first, second)[:, None, None]
        held = GraphErrors(problem=self.problem.hold(*MOUNTS), bottom=bottom)
        known = held.relative_covariance(first, second)
        return np.asarray(0.5 * np.linalg.slogdet(np.eye(6) + own @ known)[1])

    def record(self) -> LinkedPath:
        """Record the path with its covariance, and the parts that links tie together.

        Links that were rejected tie nothing.
        """
        marginals = native.covariance(self.problem, OPTIONS)
        pose = self.problem.unknowns.pose
        kept = ~self.rejected
        part = linked_parts(len(pose), self.links.first[kept], self.links.second[kept])
        return LinkedPath(
            pose=pose[:, :7].copy(),
            tray=pose[:, 7].copy(),
            covariance=marginals.pose[:, :6, :6],
            part=part,
            part_sigma=self._sigma_of_parts(part),
        )

    def fit_of_positions(self) -> PositionFit | None:
        """Compare position fixes (USBL, GNSS) with the path. None where there are none.

        The result tells how many of their sigmas are left between them and the solved path.
        """
        if self.graph.positions is None:
            return None
        return fit_of_positions(
            self.problem,
            self.graph.positions,
            native.covariance(self.problem, OPTIONS).world,
            OPTIONS,
        )

    def _sigma_of_parts(self, part: Ints) -> Array:
        """Compute the sigma (parts,) m of each part's middle relative to the largest part's.

        It tells how well navigation alone ties parts of the dive that no image joins. It is 0 for
        the largest part itself.

        part (n,): number of each node's part (`linked_parts`).
        """
        rows = [np.flatnonzero(part == k) for k in range(part.max(initial=-1) + 1)]
        if not rows:
            return np.zeros(0)
        middle = np.array([nodes[len(nodes) // 2] for nodes in rows], np.int64)
        errors = self.relative_errors(np.zeros(len(part), bool))
        covariance = errors.relative_covariance(np.full(len(middle), middle[0]), middle)[:, :3, :3]
        sigma = np.sqrt(np.maximum(np.trace(covariance, axis1=1, axis2=2), 0))
        sigma[0] = 0.0  # of the largest part to itself, where rounding would leave a remainder
        return np.asarray(sigma)


@dataclass(frozen=True, kw_only=True)
class GraphErrors:
    """Relative covariances of the leading cameras, from joint marginals of a solved graph."""

    problem: native.Problem
    bottom: Mask  # (n,) nodes where the bottom camera leads

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Compute the covariance (m, 6, 6) of second_from_first, of the leading cameras.

        It is of (translation in the second camera's axes, rotation perturbed on its right). The
        camera's mount is taken as known, as its error is common to both nodes. The joint marginals
        of both vehicle poses and tray angles are propagated by the Jacobian.

        first, second: (m,) nodes of each pair.
        """
        if len(first) == 0:
            return np.zeros((0, 6, 6))
        pairs = np.column_stack([first, second]).astype(np.int32)
        joint = native.pair_covariance(self.problem, pairs, OPTIONS).pose
        by_first, by_second = self._jacobian_by_vehicle(first), self._jacobian_by_vehicle(second)
        rotation, position = self._cameras
        back = rotation[second].swapaxes(1, 2)  # second camera from g
        # rotation and translation of second_from_first
        relative = back @ rotation[first]
        shift = np.einsum("mij,mj->mi", back, position[first] - position[second])
        # columns: of each node position (3), rotation (3) and the tray's angle
        jacobian = np.zeros((len(first), 6, 14))
        jacobian[:, :3, :7] = back @ by_first[:, :3]
        jacobian[:, :3, 7:] = -back @ by_second[:, :3] + cross_matrix(shift) @ by_second[:, 3:]
        jacobian[:, 3:, :7] = by_first[:, 3:]
        jacobian[:, 3:, 7:] = -relative.swapaxes(1, 2) @ by_second[:, 3:]
        return np.asarray(jacobian @ joint @ jacobian.swapaxes(1, 2))

    @cached_property
    def _cameras(self) -> tuple[Array, Array]:
        """Rotation (n, 3, 3) and position (n, 3) m of the leading camera in g."""
        vehicle, tray, mount = self._chain
        lever = self.problem.lever_arms.tray + np.einsum("nij,nj->ni", tray, mount[:, :3, 3])
        position = self.problem.unknowns.pose[:, :3] + np.einsum("nij,nj->ni", vehicle, lever)
        return np.asarray(vehicle @ tray @ mount[:, :3, :3]), np.asarray(position)

    @cached_property
    def _chain(self) -> tuple[Array, Array, Array]:
        """Compute the chain of motions from the global frame to the leading camera, at every node.

        Returns R_g_v (n, 3, 3) of the vehicle, R_v_s (n, 3, 3) of the tray in it, and T_s_c
        (n, 4, 4) of the camera on the tray.
        """
        pose = self.problem.unknowns.pose
        vehicle = _vehicle(pose).rotation.as_matrix()
        cos, sin, zero, one = (
            np.cos(pose[:, 7]),
            np.sin(pose[:, 7]),
            np.zeros(len(pose)),
            np.ones(len(pose)),
        )
        tray = np.stack([cos, zero, sin, zero, one, zero, -sin, zero, cos], axis=1).reshape(
            -1, 3, 3
        )
        top = pose_from_vector(self.problem.unknowns.T_s_ct)
        mount = np.tile(top.matrix(), (len(pose), 1, 1))
        if self.bottom.any():
            mount[self.bottom] = (top @ pose_from_vector(self.problem.unknowns.T_ct_cb)).matrix()
        return vehicle, tray, mount

    def _jacobian_by_vehicle(self, nodes: Ints) -> Array:
        """Compute the Jacobian (m, 6, 7) of the camera's pose by the vehicle's pose and tray angle.

        nodes: (m,). Poses are perturbed as (position in g, rotation on the right).
        """
        vehicle, tray, mount = (x[nodes] for x in self._chain)
        axis = np.array([0.0, 1.0, 0.0])
        # from the tray's origin to the camera, in the vehicle's axes
        arm = np.einsum("nij,nj->ni", tray, mount[:, :3, 3])
        out = np.zeros((len(nodes), 6, 7))
        out[:, :3, :3] = np.eye(3)
        out[:, :3, 3:6] = -vehicle @ cross_matrix(self.problem.lever_arms.tray + arm)
        out[:, :3, 6] = np.einsum("nij,nj->ni", vehicle, np.cross(axis, arm))
        out[:, 3:, 3:6] = (tray @ mount[:, :3, :3]).swapaxes(1, 2)
        out[:, 3:, 6] = mount[:, :3, :3].swapaxes(1, 2) @ axis
        return out


def _unlinked_motions(odometry: Odometry, links: CameraLinks) -> Odometry:
    """Drop odometry by images between nodes that a link joins, so that no image counts twice."""
    nodes = 1 + max(int(odometry.second.max(initial=0)), int(links.second.max(initial=0)))
    linked = np.isin(odometry.first * nodes + odometry.second, links.first * nodes + links.second)
    return odometry.take(~(odometry.from_images & linked))


def _vehicle(pose: Array) -> Poses:
    """Take T_g_v (n) from poses with their trays (n, 8)."""
    return Poses(pose[:, 3:7], pose[:, :3])


def _find_rejected(problem: native.Problem, count: int) -> Mask:
    """Find links whose chi-square is beyond REJECTED_CHI2 per degree of freedom.

    Residuals are evaluated without the robust kernel: a switch would reduce those of a wrong link
    to nothing.

    problem: with the unknowns at its solution. count: number of links.
    """
    bare = replace(problem.links, kernel=np.full(count, int(native.LinkKernel.NONE), np.int32))
    bare_unknowns = replace(problem.unknowns, link_switch=np.ones(0))
    found = native.evaluate(
        replace(problem, links=bare, unknowns=bare_unknowns), OPTIONS, jacobian=False
    )
    rows = found.factor == native.FACTORS.index("link")
    chi2 = np.bincount(found.table_row[rows], found.residual[rows] ** 2, minlength=count)
    degrees_of_freedom = np.bincount(found.table_row[rows], minlength=count)
    return np.asarray(chi2 > REJECTED_CHI2 * np.maximum(degrees_of_freedom, 1))


def _start_unknowns(
    start: VehiclePath, nominal: Mapping[str, Poses | None], switches: int
) -> native.Unknowns:
    """Make the unknowns to start from: poses and trays of the path, nominal mounts, switches at 1.

    nominal: by name of the unknown, None for a sensor that the dive lacks. switches: their number;
    1 is a link that counts fully.
    """
    unknowns = native.Unknowns(
        pose=np.hstack([start.poses.vectors(), start.tray[:, None]]), link_switch=np.ones(switches)
    )
    return replace(
        unknowns, **{name: pose_vector(pose) for name, pose in nominal.items() if pose is not None}
    )


def linked_parts(nodes: int, first: Ints, second: Ints) -> Ints:
    """Label each node (n,) with its part: nodes that a chain of links joins to each other.

    0 is the part with most nodes, 1 the next. -1 is a node without links.

    nodes: number of nodes. first, second (m,): nodes of the links.
    """
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(nodes, nodes))
    label = connected_components(graph, directed=False)[1]
    touched = np.zeros(nodes, bool)
    touched[first] = touched[second] = True
    labels, size = np.unique(label[touched], return_counts=True)
    rank = np.full(label.max(initial=-1) + 1, -1, np.int64)
    rank[labels[np.lexsort((labels, -size))]] = np.arange(len(labels))
    return np.asarray(np.where(touched, rank[label], -1))
