# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Place the targets that several passes of a side-scan sonar detect, with their covariance.

A detection gathers the pings that show a target, and gives the place of its near edge. Its error is
the reading's own, that of the pass's pose, and that of the sonar's mount, which all passes share.
Detections of different passes are paired by joint compatibility [NeiraTardos2001], the second check
of [Aulinas2011 4.2.2]: a detection of one pass alone is no target.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.studies.association.methods import joint_compatibility
from hullrecon.studies.association.point_sets import PointSets, chi_square
from hullrecon.studies.targets.side_scan import ACROSS_M, ALONG_M, ALTITUDE_M, FAR_M
from hullrecon.studies.targets.thresholds import Detection
from hullrecon.typing import Array, Ints, Mask

CONFIDENCE = 0.99
LEAST_PASSES = 2
MAX_P_VALUE = 0.05  # of coincidence anywhere in the survey

Cluster = dict[int, int]  # detections of one thing, by the pass: one each


@dataclass(frozen=True, kw_only=True)
class Sigmas:
    """One sigma of what places a detection."""

    place_m: float = 0.15  # of a pass, in x and in y
    heading_rad: float = np.radians(0.3)  # of a pass
    mount_rad: float = np.radians(0.5)  # of the sonar about the vertical, one for all passes


@dataclass(frozen=True, kw_only=True)
class Readings:
    """What a pass's detections measure, in the frame of the track."""

    along_m: Array  # (n,) way of the vehicle when the sonar saw the target's middle
    range_m: Array  # (n,) ground range of its near edge, to port
    height_m: Array  # (n,) by its shadow
    pings: Ints  # (n,) that show its spot

    def __len__(self) -> int:
        return len(self.along_m)


@dataclass(frozen=True, kw_only=True)
class ReadingErrors:
    """How readings of known targets erred."""

    bias: Array  # (3,) of along, range, height, m
    covariance: Array  # (3, 3) m^2


@dataclass(frozen=True, kw_only=True)
class Pass:
    """A straight pass along +x, sonar to port."""

    start: Array  # (2,) m, as navigated
    readings: Readings


def read_detections(seen: Detection) -> Readings:
    """Measure detections: middle of the pings, near edge, and height by the shadow's far end.

    The ray over the top of a target whose flank is as deep as it is high, from altitude H, meets
    the floor at the range r' where the shadow ends: h = H (r' - r) / (r' + H).
    """
    range_m = np.asarray(FAR_M - seen.column * ACROSS_M, dtype=float)
    ends, pings = [], []
    for row, column in zip(seen.row, seen.column, strict=True):
        behind = np.flatnonzero(~seen.shadows[row, column::-1])  # lit, from the near edge outwards
        dark = np.flatnonzero(seen.shadows[row, column::-1])
        first = dark[0] if len(dark) else 0
        lit_again = behind[behind > first]
        ends.append(column - (lit_again[0] if len(lit_again) else column))
        pings.append(_run_through(seen.spots[:, max(0, column - 4)], int(row)))
    end_m = FAR_M - np.array(ends) * ACROSS_M
    return Readings(
        along_m=np.asarray(seen.row * ALONG_M),
        range_m=range_m,
        height_m=ALTITUDE_M * (end_m - range_m) / (end_m + ALTITUDE_M),
        pings=np.array(pings, dtype=np.int64),
    )


def _run_through(marked: Mask, row: int) -> int:
    """Count the marked rows without a gap around a row."""
    gaps = np.flatnonzero(~marked)
    before, after = gaps[gaps <= row], gaps[gaps > row]
    first = before[-1] + 1 if len(before) else 0
    end = after[0] if len(after) else len(marked)
    return max(1, int(end - first))


def sonar_sees(point: Array, start: Array, heading: float, mount: float) -> tuple[float, float]:
    """Compute where a straight pass of a side-scan sonar sees a point (2,) m of the map.

    Parameters
    ----------
    point
        The point.
    start, heading
        Where the pass starts (2,) m, and its heading, rad.
    mount
        Turn of the sonar about the vertical, rad, from looking to port.

    Returns
    -------
    float
        Way of the vehicle from the start, m, when it sees the point.
    float
        Range, m.
    """
    ahead = np.array([np.cos(heading), np.sin(heading)])
    port = np.array([-np.sin(heading + mount), np.cos(heading + mount)])
    along, across = np.linalg.solve(np.column_stack([ahead, port]), point - start)
    return float(along), float(across)


@dataclass(frozen=True, kw_only=True)
class Placed:
    """Targets with all that their places depend on, as one Gaussian.

    The state is the targets' places, then the mount's turn.
    """

    mean: Array  # (2t + 1,)
    covariance: Array  # (2t + 1, 2t + 1)

    @property
    def points(self) -> Array:
        """Places (t, 2) of the targets, m."""
        return self.mean[:-1].reshape(-1, 2)


@dataclass(frozen=True, kw_only=True)
class SonarTarget:
    """A target that several passes show, as a row of objects.json would say."""

    center: Array  # (3,) m, its top
    covariance: Array  # (2, 2) m^2, of the place
    height_sigma_m: float
    pings: int
    passes: int
    p_value: float  # that unrelated detections coincide so, anywhere in the survey

    def row(self, number: int) -> dict[str, object]:
        """Make the target's row, with the fields of objects.json that a sonar measures."""
        z_sigma = self.height_sigma_m
        covariance = np.zeros((3, 3))
        covariance[:2, :2], covariance[2, 2] = self.covariance, z_sigma**2
        return {
            "id": number,
            "by": "sonar",
            "center": self.center.tolist(),
            "height": float(self.center[2]),
            "height_sigma": z_sigma,
            "position_covariance": covariance.tolist(),
            "position_sigma": np.sqrt(np.diag(covariance)).tolist(),
            "views": self.pings,
            "passes": self.passes,
            "p_value": self.p_value,
        }


def place_targets(
    passes: Sequence[Pass], sigmas: Sigmas, errors: ReadingErrors, area_m2: float
) -> tuple[list[SonarTarget], list[SonarTarget]]:
    """Pair the detections of passes, place the targets, and select the confirmed ones.

    Each pass in turn is paired with the map that the passes before it give.

    Parameters
    ----------
    passes
        The passes with their detections.
    sigmas
        Of the passes' poses and of the mount.
    errors
        Of a detection's reading.
    area_m2
        Of the survey, over which unrelated detections may lie.

    Returns
    -------
    list[SonarTarget]
        Confirmed: shown by LEAST_PASSES, and not by coincidence.
    list[SonarTarget]
        The rest.
    """
    clusters: list[Cluster] = []
    for number, new in enumerate(passes):
        pairs: dict[int, int] = {}
        if clusters and len(new.readings):
            sets = _against_map(
                _fuse(passes[:number], clusters, sigmas, errors), new, sigmas, errors
            )
            pairs = {second: first for first, second in joint_compatibility(sets, CONFIDENCE).pairs}
        for detection in range(len(new.readings)):
            if detection in pairs:
                clusters[pairs[detection]][number] = detection
            else:
                clusters.append({number: detection})
    if not clusters:
        return [], []
    placed = _fuse(passes, clusters, sigmas, errors)
    found = [_describe(k, clusters, placed, passes, errors, area_m2) for k in range(len(clusters))]
    sure = [t.passes >= LEAST_PASSES and t.p_value < MAX_P_VALUE for t in found]
    return (
        [t for t, kept in zip(found, sure, strict=True) if kept],
        [t for t, kept in zip(found, sure, strict=True) if not kept],
    )


def _places(seen: Pass, errors: ReadingErrors) -> tuple[Array, Array]:
    """Place a pass's detections (n, 2) m in the map, with their Jacobian (n, 2, 4).

    It is by the pass's x, y and heading, and by the turn of the mount.
    """
    along = seen.readings.along_m - errors.bias[0]
    across = seen.readings.range_m - errors.bias[1]
    jacobian = np.zeros((len(along), 2, 4))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 0, 2] = jacobian[:, 0, 3] = -across
    jacobian[:, 1, 2] = along
    return seen.start + np.column_stack([along, across]), jacobian


def _fuse(
    passes: Sequence[Pass], clusters: Sequence[Cluster], sigmas: Sigmas, errors: ReadingErrors
) -> Placed:
    """Solve for all targets, the passes' poses and the mount together, by least squares."""
    targets, size = 2 * len(clusters), 2 * len(clusters) + 3 * len(passes) + 1
    information, right = np.zeros((size, size)), np.zeros(size)
    prior = [sigmas.place_m, sigmas.place_m, sigmas.heading_rad] * len(passes)
    at = np.arange(targets, size)
    information[at, at] = np.array([*prior, sigmas.mount_rad]) ** -2.0
    weight = np.linalg.inv(errors.covariance[:2, :2])
    for number, of in enumerate(passes):
        points, jacobian = _places(of, errors)
        pose = targets + 3 * number
        for k, cluster in enumerate(clusters):
            if number not in cluster:
                continue
            row = cluster[number]
            # navigated place = target - errors by pose and mount
            by = np.zeros((2, size))
            by[:, 2 * k : 2 * k + 2] = np.eye(2)
            by[:, pose : pose + 3], by[:, -1] = -jacobian[row, :, :3], -jacobian[row, :, 3]
            information += by.T @ weight @ by
            right += by.T @ weight @ points[row]
    covariance = np.linalg.inv(information)
    kept = np.r_[:targets, size - 1]
    return Placed(mean=(covariance @ right)[kept], covariance=covariance[np.ix_(kept, kept)])


def _against_map(placed: Placed, new: Pass, sigmas: Sigmas, errors: ReadingErrors) -> PointSets:
    """Set a pass's detections beside the targets known, with the mount's error in both."""
    points, jacobian = _places(new, errors)
    pose = np.diag([sigmas.place_m, sigmas.place_m, sigmas.heading_rad]) ** 2
    by_pose, by_mount = jacobian[:, :, :3].reshape(-1, 3), jacobian[:, :, 3].reshape(-1)
    own = np.kron(np.eye(len(points)), errors.covariance[:2, :2])
    return PointSets(
        first=placed.points,
        second=points + (by_mount * placed.mean[-1]).reshape(-1, 2),
        first_covariance=placed.covariance[:-1, :-1],
        second_covariance=by_pose @ pose @ by_pose.T
        + placed.covariance[-1, -1] * np.outer(by_mount, by_mount)
        + own,
        cross_covariance=np.outer(placed.covariance[:-1, -1], by_mount),
    )


def _describe(
    number: int,
    clusters: Sequence[Cluster],
    placed: Placed,
    passes: Sequence[Pass],
    errors: ReadingErrors,
    area_m2: float,
) -> SonarTarget:
    """Make the target of a cluster, with the probability that its detections coincide by chance.

    area_m2: of the floor that was searched.
    """
    members = clusters[number]
    heights = [passes[p].readings.height_m[row] - errors.bias[2] for p, row in members.items()]
    block = slice(2 * number, 2 * number + 2)
    # Detections of one thing agree but for their readings, once the pose is known by the others.
    gate_m2 = (
        np.pi * chi_square(CONFIDENCE, 2) * np.sqrt(np.linalg.det(2 * errors.covariance[:2, :2]))
    )
    others = [len(passes[p].readings) for p in list(members)[1:]]
    chances = [1 - np.exp(-count * gate_m2 / area_m2) for count in others]
    tried = sum(len(of.readings) for of in passes)
    return SonarTarget(
        center=np.array([*placed.points[number], np.mean(heights)]),
        covariance=placed.covariance[block, block],
        height_sigma_m=float(np.sqrt(errors.covariance[2, 2] / len(members))),
        pings=int(sum(passes[p].readings.pings[row] for p, row in members.items())),
        passes=len(members),
        p_value=float(min(1.0, tried * np.prod(chances))),
    )
