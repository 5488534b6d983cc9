# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A problem split by the owners of its poses: each row goes to the first part of its poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.native import FieldNodes, Priors, Problem, SparseRows
from hullrecon.native.parts import Part

AS_GOOD_AS_NONE = 1e150  # sigma
POSES = {
    "attitude": ("node",),
    "tray": ("node",),
    "odometry": ("first", "second"),
    "velocities": ("first", "second", "third"),
    "ranges": ("node",),
    "stereo": ("node",),
    "mono": ("node",),
}


class Split:
    """The parts of a problem, and where their rows stood in it."""

    def __init__(self, problem: Problem, owner: np.ndarray) -> None:
        assert not len(problem.planes.anchor)
        assert not len(problem.links.first)
        self.problem, self.owner = problem, owner
        self.count = int(owner.max()) + 1
        landmark_owner = np.full(len(problem.unknowns.landmark), self.count)
        for table in (problem.stereo, problem.mono):
            np.minimum.at(landmark_owner, table.landmark, owner[table.node])
        self.landmark_owner = landmark_owner
        rows = {name: self._row_owner(name) for name in POSES}
        surface = landmark_owner[problem.surface.landmark]
        self.rows = [
            {name: np.flatnonzero(of == k) for name, of in {**rows, "surface": surface}.items()}
            for k in range(self.count)
        ]
        self.field_rows = self._field_row_owner()
        self.poses = [self._poses(k) for k in range(self.count)]
        self.nodes = [self._nodes(k) for k in range(self.count)]
        self.landmarks = [np.flatnonzero(landmark_owner == k) for k in range(self.count)]
        shared = [k for k, n in enumerate(self._times(self.poses, len(owner))) if n > 1]
        fields = self._times(self.nodes, len(problem.unknowns.deviation))
        self.shared = (np.array(shared, int), np.flatnonzero(fields > 1))

    def parts(self) -> list[Part]:
        return [self._part(k) for k in range(self.count)]

    def _row_owner(self, name: str) -> np.ndarray:
        table = getattr(self.problem, name)
        if name in ("stereo", "mono"):
            return self.landmark_owner[table.landmark]
        nodes = np.stack([getattr(table, column) for column in POSES[name]])
        return self.owner[nodes].min(axis=0)

    def _poses(self, k: int) -> np.ndarray:
        met = [np.flatnonzero(self.owner == k)]
        for name, columns in POSES.items():
            table = getattr(self.problem, name)
            met += [getattr(table, column)[self.rows[k][name]] for column in columns]
        return np.unique(np.concatenate(met))

    def _field_row_owner(self) -> np.ndarray:
        """A row of the field's prior goes to the first part that meets its first node."""
        prior = self.problem.priors.deviation
        first = np.full(len(self.problem.unknowns.deviation), self.count - 1)
        for k in range(self.count):
            for name in ("ranges", "surface"):
                field = getattr(self.problem, name).field
                if len(field.index):
                    np.minimum.at(first, field.index[self.rows[k][name]].ravel(), k)
        return first[prior.index[prior.start[:-1]]] if len(prior.start) else np.zeros(0, int)

    def _nodes(self, k: int) -> np.ndarray:
        prior, met = self.problem.priors.deviation, [np.zeros(0, int)]
        for name in ("ranges", "surface"):
            field = getattr(self.problem, name).field
            if len(field.index):
                met.append(field.index[self.rows[k][name]].ravel())
        for row in np.flatnonzero(self.field_rows == k):
            met.append(prior.index[prior.start[row] : prior.start[row + 1]])
        return np.unique(np.concatenate(met))

    @staticmethod
    def _times(of_parts: list[np.ndarray], count: int) -> np.ndarray:
        return np.bincount(np.concatenate(of_parts), minlength=count)

    def _part(self, k: int) -> Part:
        whole, rows = self.problem, self.rows[k]
        pose, node, landmark = (
            _numbers(kept, count)
            for kept, count in (
                (self.poses[k], len(whole.unknowns.pose)),
                (self.nodes[k], len(whole.unknowns.deviation)),
                (self.landmarks[k], len(whole.unknowns.landmark)),
            )
        )
        tables = {name: getattr(whole, name).take(rows[name]) for name in (*POSES, "surface")}
        for name, columns in POSES.items():
            local = {column: pose[getattr(tables[name], column)] for column in columns}
            tables[name] = replace(tables[name], **local)
        for name in ("stereo", "mono", "surface"):
            tables[name] = replace(tables[name], landmark=landmark[tables[name].landmark])
        for name in ("ranges", "surface"):
            field = tables[name].field
            if len(field.index):
                moved = FieldNodes(index=node[field.index], weight=field.weight)
                tables[name] = replace(tables[name], field=moved)
        unknowns = replace(
            whole.unknowns,
            pose=whole.unknowns.pose[self.poses[k]],
            landmark=whole.unknowns.landmark[self.landmarks[k]],
            deviation=whole.unknowns.deviation[self.nodes[k]],
        )
        problem = replace(whole, unknowns=unknowns, priors=self._priors(k, pose, node), **tables)
        return Part(
            problem=problem,
            shared_poses=self._shared(0, pose),
            shared_nodes=self._shared(1, node),
        )

    def _shared(self, kind: int, local: np.ndarray) -> np.ndarray:
        rows = local[self.shared[kind]]
        numbers = np.arange(len(rows)) + (len(self.shared[0]) if kind else 0)
        return np.stack([rows, numbers], axis=1)[rows >= 0].astype(np.int32)

    def _priors(self, k: int, pose: np.ndarray, node: np.ndarray) -> Priors:
        whole = self.problem.priors
        kept = np.flatnonzero(self.owner[whole.pose.node] == k)
        poses = replace(
            whole.pose,
            node=pose[whole.pose.node[kept]],
            value=whole.pose.value[kept],
            sqrt_information=whole.pose.sqrt_information[kept],
        )
        priors = replace(whole, pose=poses, deviation=self._field_prior(k, node))
        if k == 0:
            return priors
        none = dict.fromkeys(("T_g_M", "T_s_ct", "T_ct_cb", "T_s_d"))
        sigmas = {name: np.full_like(getattr(whole, name), AS_GOOD_AS_NONE) for name in SIGMAS}
        return replace(priors, **none, **sigmas)

    def _field_prior(self, k: int, node: np.ndarray) -> SparseRows:
        prior, rows = self.problem.priors.deviation, np.flatnonzero(self.field_rows == k)
        spans = [np.arange(prior.start[row], prior.start[row + 1]) for row in rows]
        at = np.concatenate([np.zeros(0, int), *spans])
        start = np.r_[0, np.cumsum([len(span) for span in spans])]
        if not len(prior.start):
            return prior
        return SparseRows(
            start=start.astype(np.int32), index=node[prior.index[at]], value=prior.value[at]
        )


SIGMAS = ("navigation_sigma", "intrinsics_sigma", "world_sigma")


def _numbers(kept: np.ndarray, count: int) -> np.ndarray:
    number = np.full(count, -1, np.int32)
    number[kept] = np.arange(len(kept))
    return number
