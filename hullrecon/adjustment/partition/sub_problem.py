# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Cut a problem into parts that are problems of their own, given the part that owns each pose.

A row of a table depends on poses, landmarks, planes and field nodes. It goes to the first part that
owns one of its poses. A landmark goes with all its rows to the first part that sees it. Poses,
field nodes and planes on which rows of several parts depend are copied into each of these parts,
and are shared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from hullrecon import native
from hullrecon.memory import release_pages
from hullrecon.native.parts import Part
from hullrecon.typing import Array, Ints, Ints16, Ints32

AS_GOOD_AS_NONE = 1e150  # sigma of a prior that counts in another part
# Columns with numbers of poses, by table
NODES = {
    "attitude": ("node",),
    "tray": ("node",),
    "odometry": ("first", "second"),
    "velocities": ("first", "second", "third"),
    "positions": ("node",),
    "ranges": ("node",),
    "stereo": ("node",),
    "mono": ("node",),
    "plane_ranges": ("node",),
    "plane_pairs": (),
    "plane_sightings": ("node",),
}
# Columns with numbers of planes, by table
PLANES = {
    "plane_ranges": ("plane",),
    "plane_pairs": ("first", "second"),
    "plane_sightings": ("plane",),
}
OF_LANDMARKS = ("stereo", "mono", "surface")  # tables whose rows depend on a landmark
IN_FIELD = ("ranges", "surface")  # tables whose rows depend on the deviation field
TABLES = (*NODES, "surface")


class SubProblems:
    """The parts of a problem, and which rows of the whole problem each has.

    The problem has no links: those are of the pose graph, which is solved whole.
    """

    def __init__(self, problem: native.Problem, owner: Ints) -> None:
        """Assign each row, landmark and field node to a part.

        Parameters
        ----------
        problem
            The whole problem.
        owner
            (n,) part of each pose. Parts are numbered from 0 on, and each has a pose.
        """
        if len(problem.links.first):
            raise ValueError("links are not cut into parts")
        # Of all rows of images: numbers of parts take half of what others do
        self.problem, self.owner = problem, owner.astype(np.int16)
        self.count = int(owner.max(initial=0)) + 1  # of parts
        # Part of each landmark, of each row of each table, of each node of the deviation field and
        # of each row of its prior
        self.landmark_owner = self._owner_of_landmarks()
        self.row_owner = {name: self._owner_of_rows(name) for name in TABLES}
        self.node_owner, self.field_row_owner = self._owners_of_field()
        # For each part the poses, planes, field nodes and landmarks of the whole that it has
        parts = range(self.count)
        self.poses, self.planes = zip(*(self._poses_and_planes(k) for k in parts), strict=True)
        self.nodes = tuple(self._nodes(k) for k in parts)
        self.landmarks = tuple(np.flatnonzero(self.landmark_owner == k) for k in parts)
        self._release_pages()

    def parts(self) -> Iterator[Part]:
        """Build the parts, one at a time, and release the pages of the whole problem's tables."""
        for k in range(self.count):
            part = self.part(k)
            self._release_pages()
            yield part

    def _release_pages(self) -> None:
        """Return the memory into which the whole problem's largest tables were read."""
        whole = self.problem
        for table in (whole.stereo, whole.mono, whole.surface.field):
            release_pages(*vars(table).values())
        release_pages(whole.unknowns.landmark)

    def part(self, k: int) -> Part:
        """Build part k, with tables of its own."""
        whole = self.problem
        # Numbers within the part, by numbers within the whole
        number = {
            "pose": _numbers(self.poses[k], len(whole.unknowns.pose)),
            "landmark": _numbers(self.landmarks[k], len(whole.unknowns.landmark)),
            "node": _numbers(self.nodes[k], len(whole.unknowns.deviation)),
            "plane": _numbers(self.planes[k], len(whole.unknowns.plane)),
        }
        unknowns = replace(
            whole.unknowns,
            pose=whole.unknowns.pose[self.poses[k]],
            landmark=whole.unknowns.landmark[self.landmarks[k]],
            deviation=whole.unknowns.deviation[self.nodes[k]],
            plane=whole.unknowns.plane[self.planes[k]],
        )
        tables: dict[str, Any] = {name: self._table(name, k, number) for name in TABLES}
        problem = replace(
            whole,
            unknowns=unknowns,
            priors=self._priors(k, number),
            # all parts share the lenses, and their prior counts once
            lenses=whole.lenses if k == 0 else _without_prior(whole.lenses),
            planes=native.PlaneTable(anchor=number["pose"][whole.planes.anchor[self.planes[k]]]),
            **tables,
        )
        # Shared unknowns are numbered among all parts: first the poses, then the field's nodes,
        # then the planes.
        shared = [self.shared_poses, self.shared_nodes, self.shared_planes]
        first = np.cumsum([0, *(len(rows) for rows in shared)])
        rows = [
            _shared(kept, number[kind], int(begin))
            for kept, kind, begin in zip(shared, ("pose", "node", "plane"), first, strict=False)
        ]
        return Part(
            problem=problem, shared_poses=rows[0], shared_nodes=rows[1], shared_planes=rows[2]
        )

    @cached_property
    def shared_poses(self) -> Ints:
        """List the poses on which rows of several parts depend."""
        return _in_several(self.poses, len(self.owner))

    @cached_property
    def shared_nodes(self) -> Ints:
        """List the nodes of the deviation field on which rows of several parts depend."""
        return _in_several(self.nodes, len(self.problem.unknowns.deviation))

    @cached_property
    def shared_planes(self) -> Ints:
        """List the planes on which rows of several parts depend."""
        return _in_several(self.planes, len(self.problem.unknowns.plane))

    def _owner_of_landmarks(self) -> Ints16:
        """Find the owner of each landmark: the first part that sees it, part 0 if none does."""
        owner = np.full(len(self.problem.unknowns.landmark), self.count, np.int16)
        for table in (self.problem.stereo, self.problem.mono):
            np.minimum.at(owner, table.landmark, self.owner[table.node])
        owner[owner == self.count] = 0
        return owner

    def _owner_of_rows(self, name: str) -> Ints16:
        """Find the owner of each row of a table: its landmark's, else the first of its poses'."""
        table = getattr(self.problem, name)
        if name in OF_LANDMARKS:
            return np.asarray(self.landmark_owner[table.landmark])
        met = [getattr(table, column) for column in NODES[name]]
        met += [self.problem.planes.anchor[getattr(table, c)] for c in PLANES.get(name, ())]
        return np.asarray(self.owner[np.stack(met)].min(axis=0))

    def _owners_of_field(self) -> tuple[Ints16, Ints16]:
        """Find the owner of each node of the deviation field, and of each row of its prior.

        A node goes to the first part whose measurements depend on it. Nodes on which no measurement
        depends take the owner of the nodes next to them, in the rows of the prior, step by step. A
        row of the prior goes to the first part that owns one of its nodes.
        """
        prior, last = self.problem.priors.deviation, self.count
        owner = np.full(len(self.problem.unknowns.deviation), last, np.int16)
        for name in IN_FIELD:
            field = getattr(self.problem, name).field
            if len(field.index):
                np.minimum.at(owner, field.index, self.row_owner[name][:, None])
        if len(prior.start) < 2:
            return np.where(owner == last, np.int16(0), owner), np.zeros(0, np.int16)
        row_of = np.repeat(np.arange(len(prior.start) - 1), np.diff(prior.start))
        # A row takes the first owner among its nodes, then a node without one that of its rows
        while True:
            of_row = np.full(len(prior.start) - 1, last, np.int16)
            np.minimum.at(of_row, row_of, owner[prior.index])
            near = np.full_like(owner, last)
            np.minimum.at(near, prior.index, of_row[row_of])
            spread = np.where(owner == last, near, owner)
            if np.array_equal(spread, owner):
                break
            owner = spread
        none = np.int16(0)
        return np.where(owner == last, none, owner), np.where(of_row == last, none, of_row)

    def _poses_and_planes(self, k: int) -> tuple[Ints, Ints]:
        """List the poses and planes that part k owns or that its rows depend on."""
        anchor = self.problem.planes.anchor
        planes, poses = (
            [np.flatnonzero(self.owner[anchor] == k)],
            [np.flatnonzero(self.owner == k)],
        )
        for name in NODES:
            table, rows = getattr(self.problem, name), self.row_owner[name] == k
            planes += [getattr(table, column)[rows] for column in PLANES.get(name, ())]
            poses += [getattr(table, column)[rows] for column in NODES[name]]
        met_planes = np.unique(np.concatenate(planes))
        return np.unique(np.concatenate([*poses, anchor[met_planes]])), met_planes

    def _nodes(self, k: int) -> Ints:
        """List the nodes of the deviation field that part k owns or that its rows depend on."""
        prior, met = self.problem.priors.deviation, [np.flatnonzero(self.node_owner == k)]
        for name in IN_FIELD:
            field = getattr(self.problem, name).field
            if len(field.index):
                met.append(field.index[self.row_owner[name] == k].ravel())
        of_entry = np.repeat(self.field_row_owner, np.diff(prior.start))
        return np.unique(np.concatenate([*met, prior.index[of_entry == k]]))

    def _table(self, name: str, k: int, number: dict[str, Ints32]) -> object:
        """Take the rows of a table that part k owns, with poses etc. in the part's numbers.

        number: numbers within the part, by kind and number within the whole.
        """
        table = getattr(self.problem, name).take(np.flatnonzero(self.row_owner[name] == k))
        columns = {c: number["pose"][getattr(table, c)] for c in NODES.get(name, ())}
        columns |= {c: number["plane"][getattr(table, c)] for c in PLANES.get(name, ())}
        if name in OF_LANDMARKS:
            columns["landmark"] = number["landmark"][table.landmark]
        if name in IN_FIELD and len(table.field.index):
            columns["field"] = replace(table.field, index=number["node"][table.field.index])
        return replace(table, **columns)

    def _priors(self, k: int, number: dict[str, Ints32]) -> native.Priors:
        """Take the priors of part k. The priors of globals are in the first part alone."""
        whole = self.problem.priors
        kept = np.flatnonzero(self.owner[whole.pose.node] == k)
        poses = native.PosePriors(
            node=number["pose"][whole.pose.node[kept]],
            value=whole.pose.value[kept],
            sqrt_information=whole.pose.sqrt_information[kept],
        )
        priors = replace(whole, pose=poses, deviation=self._field_prior(k, number["node"]))
        if k == 0:
            return priors
        return replace(
            priors,
            T_g_M=None,
            T_s_ct=None,
            T_ct_cb=None,
            T_s_d=None,
            navigation_sigma=_no_prior(whole.navigation_sigma),
            intrinsics_sigma=_no_prior(whole.intrinsics_sigma),
            world_sigma=_no_prior(whole.world_sigma),
        )

    def _field_prior(self, k: int, number: Ints32) -> native.SparseRows:
        """Take the rows of the deviation field's prior that part k owns, in the part's numbers."""
        prior = self.problem.priors.deviation
        if len(prior.start) < 2:
            return prior
        entries_of_row = np.diff(prior.start)
        entries = np.repeat(self.field_row_owner == k, entries_of_row)
        start = np.cumsum(np.r_[0, entries_of_row[self.field_row_owner == k]])
        return native.SparseRows(
            start=start.astype(np.int32),
            index=number[prior.index[entries]],
            value=prior.value[entries],
        )


def _numbers(kept: Ints, count: int) -> Ints32:
    """Give the kept ones of `count` items numbers from 0 on, and the others -1, (count,)."""
    number = np.full(count, -1, np.int32)
    number[kept] = np.arange(len(kept), dtype=np.int32)
    return number


def _in_several(of_parts: tuple[Ints, ...], count: int) -> Ints:
    return np.flatnonzero(np.bincount(np.concatenate(of_parts), minlength=count) > 1)


def _shared(rows: Ints, number: Ints32, first: int) -> Ints32:
    """List the shared items that a part has: number within the part, number among all shared.

    Parameters
    ----------
    rows
        Shared items of one kind, by number within the whole.
    number
        Numbers within the part, -1 for items that it does not have.
    first
        Number of the first of them among all shared items.

    Returns
    -------
    Ints32
        (k, 2).
    """
    here = number[rows]
    pairs = np.stack([here, np.arange(first, first + len(rows))], axis=1)
    return np.asarray(pairs[here >= 0], np.int32)


def _no_prior(sigma: Array) -> Array:
    return np.full_like(sigma, AS_GOOD_AS_NONE)


def _without_prior(lenses: native.LensTable) -> native.LensTable:
    return replace(lenses, sigma_px=_no_prior(lenses.sigma_px))
