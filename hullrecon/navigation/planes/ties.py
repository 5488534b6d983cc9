# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find pairs of patches that are one piece of the hull seen twice, and tie them.

Both have to be near each other on the hull and agree within their covariance. A wrong tie is worse
than none, so each has to pass the gate from either patch. A tie that adds no information, as
between nodes that images link, is left out.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.native import PlanePairTable, PlaneRangeTable, PlaneTable
from hullrecon.navigation.planes.comparison import (
    PatchPairs,
    compare_patches,
    difference_of_planes,
    gap_by_poses,
    position_and_gap_by_poses,
)
from hullrecon.navigation.planes.patches import Patches
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# between the centres of two patches along the hull; farther, a patch cannot be extrapolated
REACH_M = 2.2
# of path between two patches of one pass, over which odometry is better than any tie
SAME_PASS_M = 3.0
MOST_TIES = 4  # of a patch to earlier ones, the nearest on the hull
SEARCH_M = 4.0  # between two centres in space: a drift may have moved them apart
MOST_UNSURE_M = 0.25 * REACH_M  # sigma of the second's position along the hull from the first
LEAST_ALIGNMENT = 0.7  # cosine between the normals of two patches of one piece of hull
GATE_CHI2 = 11.34  # 99 % at three degrees of freedom
# variance of the gap by the path over that by the patches, in the direction where it is largest
LEAST_GAIN = 1.0


def propose_ties(patches: Patches, path: VehiclePath) -> tuple[Ints, Ints]:
    """Propose pairs (m,) of patches of different passes that are near each other on the hull.

    Of each patch at most MOST_TIES to earlier ones are proposed. Whether they agree is not looked
    at yet. Returns rows of the earlier and of the later patches, empty where no part of the hull
    was passed again.
    """
    if len(patches) < 2:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    at = path.poses[patches.anchor]
    center = at.apply(patches.center)
    normal = at.rotation.apply(patches.axes[:, :, 2])
    pairs = cKDTree(center).query_pairs(SEARCH_M, output_type="ndarray").astype(np.int64)
    first, second = np.sort(pairs, axis=1).T
    # of another pass, facing the same way, and near each other along the hull
    apart = patches.travelled[second] - patches.travelled[first] > SAME_PASS_M
    alike = np.sum(normal[first] * normal[second], axis=1) > LEAST_ALIGNMENT
    # the part along the normal does not count: a drift of the path may have caused it
    step = center[second] - center[first]
    across = np.sum(step * normal[first], axis=1, keepdims=True) * normal[first]
    distance = np.linalg.norm(step - across, axis=1)
    keep = apart & alike & (distance < REACH_M)
    first, second, distance = first[keep], second[keep], distance[keep]
    # at most MOST_TIES of each patch to earlier ones, the nearest
    order = np.lexsort((first, distance, second))
    first, second = first[order], second[order]
    rank = np.arange(len(second)) - np.searchsorted(second, second)
    return first[rank < MOST_TIES], second[rank < MOST_TIES]


def is_informative(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, rig: Rig, joint: Array
) -> Mask:
    """Tell which pairs (m,) measure their gap better than the path predicts it, in some direction.

    A tie of another pair would add nothing, but might be wrong. It is the largest generalised
    eigenvalue of the two covariances of the gap that decides.

    joint (m, 14, 14): the covariance of both anchors' poses and trays on the path.
    """
    predicted = _predicted_covariance(patches, pairs, path, rig, joint)
    root = np.linalg.inv(np.linalg.cholesky(pairs.noise + pairs.fit))
    return np.asarray(
        np.linalg.eigvalsh(root @ predicted @ root.swapaxes(1, 2)).max(axis=1, initial=0.0)
        > LEAST_GAIN
    )


def is_position_known(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, rig: Rig, joint: Array
) -> Mask:
    """Tell for which pairs (m,) the path gives the position along the hull well enough to compare.

    Where it does not, as after minutes without a DVL, the second patch may be of another part of
    the hull with another shape. Gaps are linearised in the position. Such ties would pull the path
    along the hull to where the shapes fit best, with a covariance that is far too small.

    joint (m, 14, 14): the covariance of both anchors' poses and trays on the path.
    """
    by_poses = position_and_gap_by_poses(patches, pairs, path, rig.tray_origin)[:, :2]
    variance = np.linalg.eigvalsh(by_poses @ joint @ by_poses.swapaxes(1, 2)).max(
        axis=1, initial=0.0
    )
    return np.asarray(variance < MOST_UNSURE_M**2)


def is_alike(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, rig: Rig, joint: Array
) -> Mask:
    """Tell which pairs (m,) agree within their covariance, extrapolated from either patch.

    Those that do not may be of different structures, or of a wrong path, and are not tied.

    joint (m, 14, 14): the covariance of both anchors' poses and trays on the path.
    """
    back = compare_patches(patches, pairs.second, pairs.first, path)
    swapped = np.r_[7:14, 0:7]
    agrees = np.ones(len(pairs), bool)
    for way, covariance in ((pairs, joint), (back, joint[:, swapped][:, :, swapped])):
        predicted = _predicted_covariance(patches, way, path, rig, covariance)
        whole = predicted + way.noise + way.fit
        agrees &= (
            np.sum(way.gap * np.linalg.solve(whole, way.gap[:, :, None])[:, :, 0], axis=1)
            < GATE_CHI2
        )
    return agrees


def roughness(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, rig: Rig, joint: Array
) -> Array:
    """Estimate by what factor (3,) the gaps of pairs exceed their sigma, in height and two slopes.

    It is one robust factor for the whole dive, at least 1. On an uneven hull the noise of the ties
    is inflated by it.

    joint (m, 14, 14): the covariance of both anchors' poses and trays on the path.
    """
    predicted = _predicted_covariance(patches, pairs, path, rig, joint)
    whole = predicted + pairs.noise + pairs.fit
    ratio = np.abs(pairs.gap) / np.sqrt(np.einsum("mii->mi", whole))
    return np.maximum(NORMAL_MAD * np.median(ratio, axis=0), 1.0) if len(pairs) else np.ones(3)


def tie_planes(patches: Patches, pairs: PatchPairs, returns: Returns) -> TiedPlanes:
    """Make the tables of the native graph: planes of patches, ranges to them, and their pairs.

    A patch brings its own error into each of its pairs. So the noise of a pair is inflated by the
    mean number of pairs of its two patches.
    """
    used = np.unique(np.concatenate([pairs.first, pairs.second]))
    # number of each patch's plane, and of its pairs
    number = np.full(len(patches), -1, np.int64)
    number[used] = np.arange(len(used))
    degree = np.bincount(np.concatenate([pairs.first, pairs.second]), minlength=len(patches))
    shared = np.maximum(0.5 * (degree[pairs.first] + degree[pairs.second]), 1.0)
    found = difference_of_planes(patches, pairs, pairs.noise * shared[:, None, None])
    return TiedPlanes(
        plane=patches.plane[used],
        table=PlaneTable(anchor=patches.anchor[used].astype(np.int32)),
        ranges=_range_table(patches, used, returns),
        pairs=PlanePairTable(
            first=number[pairs.first].astype(np.int32),
            second=number[pairs.second].astype(np.int32),
            measured=found.difference,
            sqrt_information=found.information,
            point=patches.center[pairs.second],
            place=pairs.place,
            by_place=found.by_place,
        ),
    )


def _predicted_covariance(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, rig: Rig, joint: Array
) -> Array:
    """Predict the covariance (m, 3, 3) of gaps that errors of the path alone cause.

    joint (m, 14, 14): the covariance of both anchors' poses and trays.
    """
    by_poses = gap_by_poses(patches, pairs, path, rig.tray_origin)
    return np.asarray(by_poses @ joint @ by_poses.swapaxes(1, 2))


def _range_table(patches: Patches, used: Ints, returns: Returns) -> PlaneRangeTable:
    """Build the table of ranges to planes, from the returns that the patches were fitted to.

    used: rows of the patches that become planes. A range to the plane is the measured one plus the
    way from the curved patch to its tangent plane.
    """
    size = np.array([len(patches.rows[k]) for k in used], np.int64)
    rows = np.concatenate([np.zeros(0, np.int64), *(patches.rows[k] for k in used)])
    to_plane = np.concatenate([np.zeros(0), *(patches.to_plane[k] for k in used)])
    kept = returns.take(rows)
    return PlaneRangeTable(
        node=kept.node.astype(np.int32),
        plane=np.repeat(np.arange(len(used), dtype=np.int32), size),
        offset=Poses(kept.quaternion, kept.translation).vectors(),
        tray_offset=kept.tray_offset,
        beam=kept.beam,
        measured=kept.range_m + to_plane,
        sigma=np.repeat(patches.sigma_m[used], size),
    )
