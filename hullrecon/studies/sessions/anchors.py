# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in one graph by anchors, and that graph in a common frame [Ozog2016 2.4.2].

An anchor is the pose of a session's frame in the common one. All else of a session is in the
session's frame, so that a session is solved alone until something ties it to another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.poses import Poses, stacked
from hullrecon.studies.sessions.factors import Encounters, Factors, Priors, State, no_planes
from hullrecon.studies.sessions.graph import Graph, whole
from hullrecon.studies.sessions.motions import compose, errors, plane_in
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class Anchored:
    """The graph of several sessions: anchors first, then the sessions' poses in their order."""

    state: State  # anchors in the common frame; poses and planes in their sessions' frames
    anchor: Ints  # (n,) row in `state.poses` of each pose's anchor; of an anchor its own
    plane_anchor: Ints  # (p,) the same of each plane
    first_pose: Ints  # (sessions,) row of each session's first pose
    within: tuple[Factors, ...]  # of single sessions, their first poses' priors not among them
    # by session, the prior of its first pose, which holds the session in its own frame. Kept apart,
    # as a graph in one common frame has that of the first session alone (`merged`)
    held: tuple[Priors | None, ...]
    anchored: Priors  # of the anchors, which hold the sessions' frames in the common one
    across: tuple[Encounters, ...] = ()

    @property
    def sessions(self) -> int:
        """Number of sessions."""
        return len(self.first_pose)

    def graph(self) -> Graph:
        """Collect the factors of all sessions and those between them into one graph."""
        held = [table for table in self.held if table is not None]
        return whole((*self.within, *held, self.anchored, *self.across), self.state)


def join(
    states: Sequence[State],
    factors: Sequence[Sequence[Factors]],
    anchors: Poses,
    anchor_sigma: Array,
) -> Anchored:
    """Put sessions into one graph [Ozog2016 eq. 2.7].

    Parameters
    ----------
    states
        Poses and planes of each session, in its own frame.
    factors
        Tables of factors of each session, which count its own poses and planes. At most one of them
        is of priors: that of the session's first pose in its own frame. A map whose first pose was
        removed has none.
    anchors
        (sessions) common_from_session, where each session's frame is believed to lie.
    anchor_sigma
        (sessions, 6) sigmas of that, of translation, m, and rotation, rad.
    """
    count = len(states)
    sizes = np.array([len(s.poses) for s in states])
    planes = np.array([len(s.planes) for s in states])
    first_pose = count + np.cumsum([0, *sizes[:-1]])  # anchors stand first
    first_plane = np.cumsum([0, *planes[:-1]])
    within: list[Factors] = []
    held: list[Priors | None] = [None] * count  # prior of each session in its own frame
    for k, tables in enumerate(factors):
        rows = first_pose[k] + np.arange(sizes[k]), first_plane[k] + np.arange(planes[k])
        for table in tables:
            in_joint = table.renumbered(*rows)
            if isinstance(in_joint, Priors):
                held[k] = in_joint
            else:
                within.append(in_joint)
    return Anchored(
        state=State(
            poses=stacked([anchors, *(s.poses for s in states)]),
            planes=np.concatenate([s.planes for s in states]),
        ),
        anchor=np.concatenate([np.arange(count), np.repeat(np.arange(count), sizes)]),
        plane_anchor=np.repeat(np.arange(count), planes),
        first_pose=first_pose,
        within=tuple(within),
        held=tuple(held),
        anchored=Priors(
            poses=np.arange(count)[:, None],
            planes=no_planes(count),
            measured=anchors,
            sqrt_information=np.stack([np.diag(1 / sigma) for sigma in anchor_sigma]),
        ),
    )


def in_common_frame(joint: Anchored) -> State:
    """Compute all poses and planes in the common frame [Ozog2016 eq. 2.8], anchors left out."""
    poses, planes = joint.state.poses, joint.state.planes
    count = joint.sessions
    own = poses[joint.anchor[count:]]
    return State(
        poses=own @ poses[count:],
        planes=plane_in(poses[joint.plane_anchor].inverse(), planes)[0] if len(planes) else planes,
    )


def common_frame_derivative(joint: Anchored) -> Array:
    """Differentiate the poses in the common frame by anchors, poses and planes (dense).

    Rows are six of each pose, columns those of `Anchored.graph`: J_f of [Ozog2016 2.4.2].
    """
    count, poses = joint.sessions, joint.state.poses
    of = joint.anchor[count:]  # the anchor of each pose
    _, by_anchor, by_pose = compose(poses[of], poses[count:])
    rows = 6 * (len(poses) - count)
    out = np.zeros((rows, 6 * len(poses) + 3 * len(joint.state.planes)))
    for k in range(len(of)):
        row = slice(6 * k, 6 * k + 6)
        out[row, 6 * of[k] : 6 * of[k] + 6] = by_anchor[k]
        out[row, 6 * (count + k) : 6 * (count + k) + 6] = by_pose[k]
    return out


def merged(joint: Anchored) -> tuple[Graph, State]:
    """Leave the anchors out: one graph in the common frame [Ozog2016 eq. 2.9].

    The priors on all sessions' first poses but the first's are dropped, and those on anchors;
    measurements are not. Factors within a session must not change where its frame is moved as its
    anchor may move it: along the sea's surface and about the vertical, if they see depth and level.
    """
    count, state = joint.sessions, in_common_frame(joint)
    without = np.arange(len(joint.state.poses)) - count  # row of each pose without the anchors
    planes = np.arange(len(state.planes))
    held = []
    if (first := joint.held[0]) is not None:
        moved = replace(first, measured=joint.state.poses[0] @ first.measured)
        held.append(moved.renumbered(without, planes))
    tables = [table.renumbered(without, planes) for table in joint.within]
    links = [table.as_links().renumbered(without, planes) for table in joint.across]
    return whole([*held, *tables, *links], state), state


def laid_on(joint: Anchored) -> State:
    """Move the anchors so that each two linked sessions agree with their first link exactly."""
    poses = [joint.state.poses[k] for k in range(len(joint.state.poses))]
    for table in joint.across:
        anchor_a, a, anchor_b, b = table.poses[0]
        poses[anchor_b] = poses[anchor_a] @ poses[a] @ table.measured[0] @ poses[b].inverse()
    return State(poses=stacked(poses), planes=joint.state.planes)


def path_errors(poses: Poses, truth: Poses) -> Array:
    """Compute errors of poses (n, 6): translation m and rotation rad in the true pose's frame.

    poses, truth: (n) in one frame.
    """
    return errors(truth, poses)[0]
