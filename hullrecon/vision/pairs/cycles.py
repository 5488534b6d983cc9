# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check cycles of three links, around which the relative rotations must close.

A link that most of its cycles contradict is wrong.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.records.links import CameraLinks
from hullrecon.typing import Array, Ints, Mask

MAX_CHI2 = 16.3  # of a cycle's three angles: 99.9 % of chi-square with three degrees of freedom
LEAST_SIGMA_RAD = np.radians(0.1)  # added to each link, for errors that its covariance leaves out


def contradicted_links(links: CameraLinks, across: Mask) -> Mask:
    """Reject links (m,) that more cycles of three links contradict than confirm.

    A wrong link makes the cycles of its neighbours fail too. So the worst link is removed first,
    its cycles no longer count, and this is repeated until no link has more failing cycles than
    closing ones.

    Parameters
    ----------
    links
        Relative poses of pairs of nodes.
    across
        Links (m,) between two legs. Only these are rejected.
    """
    out = np.zeros(len(links), bool)
    cycle = _cycles(links)
    if len(cycle) == 0:
        return out
    closed = _chi2(links, cycle) < MAX_CHI2
    # Excess (m,): failing minus closing cycles of each link.
    vote = np.where(closed, -1, 1)
    excess = np.bincount(cycle.ravel(), np.repeat(vote, 3), minlength=len(links)).astype(np.int64)
    # The cycles of each link: `by_link` from its `start` to that of the next link, over three.
    by_link = np.argsort(cycle.ravel(), kind="stable")
    start = np.searchsorted(cycle.ravel()[by_link], np.arange(len(links) + 1))
    alive = np.ones(len(cycle), bool)
    while True:
        worst = int(np.argmax(np.where(across & ~out, excess, 0)))
        if not across[worst] or out[worst] or excess[worst] <= 0:
            return out
        out[worst] = True
        own = by_link[start[worst] : start[worst + 1]] // 3
        own = own[alive[own]]
        alive[own] = False
        np.subtract.at(excess, cycle[own], vote[own, None])


def _cycles(links: CameraLinks) -> Ints:
    """List the rows (c, 3) of the links a-b, b-c, a-c of every cycle of nodes a < b < c.

    A link's first node is the lower one, and no pair of nodes has two links.
    """
    n = int(max(links.first.max(initial=-1), links.second.max(initial=-1))) + 1
    order = np.argsort(links.first * n + links.second, kind="stable")
    first, second = links.first[order], links.second[order]
    keys = first * n + second
    # each link a-b with each link that begins at b, where a link a-c closes the cycle
    start = np.searchsorted(first, second)
    count = np.searchsorted(first, second, side="right") - start
    ab = np.repeat(np.arange(len(keys)), count)
    bc = np.arange(count.sum()) + np.repeat(start - (np.cumsum(count) - count), count)
    wanted = first[ab] * n + second[bc]
    at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    found = keys[at] == wanted if len(keys) else np.zeros(0, bool)
    return np.asarray(order[np.column_stack([ab[found], bc[found], at[found]])])


def _chi2(links: CameraLinks, cycle: Ints) -> Array:
    """Compute chi-square (c,), three degrees of freedom, of the rotation left around each cycle.

    Lengths do not enter, so links without a measured length count as well.
    """
    ab, bc, ac = (Rotation.from_quat(links.quaternion[cycle[:, k]]) for k in range(3))
    gap = (ac.inv() * bc * ab).as_rotvec()
    # Each link's rotation is perturbed on its right. The angles are small, so that their
    # covariances add, turned into common axes.
    turn_ab = ab.inv().as_matrix()
    covariance = [links.covariance[cycle[:, k], 3:, 3:] for k in range(3)]
    total = covariance[0] + turn_ab @ covariance[1] @ turn_ab.swapaxes(1, 2) + covariance[2]
    total = total + 3 * LEAST_SIGMA_RAD**2 * np.eye(3)
    return np.asarray(np.einsum("ci,cij,cj->c", gap, np.linalg.inv(total), gap))
