# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Propose pairs of keyframes that may show the same part of the hull, by how alike they look.

They are needed where the path is too uncertain for the search by overlap: the offset of two scenes
is uncertain by more than a footprint, as after an outage. Two kinds of pairs are proposed: those
that may be the same place by the path, and, as a control, those that the path knows to be two
different places. If controls match, appearance cannot be trusted on this hull.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.appearance.vocabulary import InvertedFile
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.expected_overlap import scene_in_target

# Sigma of the offset of two scenes, in footprints, above which the search by overlap finds no pair
# probable enough to compare
BEYOND = 1.0
KNOWN = 0.25  # sigma of an offset, in footprints, up to which two scenes may be a control
APART = 2.0  # least distance of the scenes of a control, in footprints
GATE_CHI2 = 16.3  # of the offset of two scenes: 99.9 % of chi-square with three degrees of freedom
STATIONS = 100  # keyframes at which the path is evaluated, evenly along it
QUERIES = 300  # keyframes for which others that look alike are searched, evenly along the path
PART_STATIONS, PART_QUERIES = 3, 10  # the same, at least in each part of the path, however short
MOST_STATIONS, MOST_QUERIES = 600, 1000  # the same, at most in all, where there are many parts
CANDIDATES = 20  # keyframes most like a query for which the offset is computed
PLACES = 5  # of these, keyframes at separate places that are compared with the query
MOST_PAIRS = 200  # pairs compared in all
CONTROLS = 60  # control pairs compared


@dataclass(frozen=True, kw_only=True)
class OpenPlaces:
    """Which pairs of m keyframes may show the same place by the path, evaluated at s stations.

    Stations are some of the keyframes, evenly along the path.
    """

    edges: Ints  # (p + 1,) first keyframe of each of p parts of the path, and m
    station: Ints  # (m,) number of the station that stands for each keyframe
    open: Mask  # (s, s) pairs of stations that may be one place, beyond the search by overlap
    apart: Mask  # (s, s) pairs of stations known to be two places
    reach_m: float  # largest distance between stations whose offset is known (sigma below KNOWN)

    def of_keyframes(self, queries: Ints, mask: Mask) -> Mask:
        """Expand a mask (s, s) of stations to pairs (q, m) of queried with all keyframes."""
        return np.asarray(mask[self.station[queries]][:, self.station])


def footprint_m(depth_m: Array, camera: CameraModel) -> float:
    """Compute the smaller side of an image's footprint on the scene at the median depth, m."""
    return float(np.nanmedian(depth_m)) * min(camera.width / camera.fx, camera.height / camera.fy)


def scene_offsets(
    track: CameraTrack, first: Ints, second: Ints, depth_m: Array
) -> tuple[Array, Array]:
    """Compute the offset between the centres of the scenes of m pairs of nodes.

    By its size and covariance two nodes may show one place, or are known to show two. The centre of
    a scene is the point on the optical axis at its median depth.

    Parameters
    ----------
    track
        Poses of the leading cameras.
    first, second
        Nodes (m,).
    depth_m
        Median depth (n,) of the scene by node.

    Returns
    -------
    offset
        (m, 3) from the centre of the second scene to that of the first, in the second camera, m.
    covariance
        (m, 3, 3) of the offset, m^2.
    """
    relative, covariance = scene_in_target(track, first, second, depth_m[first])
    middle = depth_m[first, None] * [0.0, 0.0, 1.0]
    # Centre of the first scene in the second camera
    centre = np.einsum("mij,mj->mi", relative[:, :3, :3], middle) + relative[:, :3, 3]
    return centre - depth_m[second, None] * [0.0, 0.0, 1.0], covariance


def may_be_one(offset: Array, covariance: Array, slack_m: float) -> Mask:
    """Select pairs (m,) of scenes that may be the same place, by a chi-square gate on their offset.

    offset, covariance: (m, 3) and (m, 3, 3), as by `scene_offsets`. slack_m: sigma of the distance
    between the centres of scenes that overlap, which is added to the covariance.
    """
    chi2 = np.einsum(
        "mi,mij,mj->m", offset, np.linalg.inv(covariance + slack_m**2 * np.eye(3)), offset
    )
    return np.asarray(chi2 <= GATE_CHI2)


def largest_sigma(covariance: Array) -> Array:
    """Compute the sigma (m,) along the longest axis of covariances."""
    return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[:, -1], 0)))


def open_places(
    track: CameraTrack, keyframes: Ints, depth_m: Array, camera: CameraModel
) -> OpenPlaces | None:
    """Find the pairs of keyframes that may be one place although the search by overlap skips them.

    Only some keyframes, the stations, are tested, as the pairs of all keyframes are too many. The
    result is None where the path is known well enough for the search by overlap.

    Parameters
    ----------
    track
        Poses of the leading cameras, with the uncertainty of relative poses.
    keyframes
        Nodes (m,) of known depth.
    depth_m
        Depth (n,) of the scene by node.
    camera
        Model that footprints are computed with.
    """
    if len(keyframes) < 2:
        return None
    size = footprint_m(depth_m[keyframes], camera)
    # The relative sigma of two nodes is at most the sum of their sigmas relative to a third one,
    # and along its longest axis at most sqrt(3) times the mean over the axes.
    middle = np.full(len(keyframes), keyframes[len(keyframes) // 2])
    if 2 * np.sqrt(3) * track.relative_sigma(keyframes, middle).max() < BEYOND * size:
        return None
    # Stations are rows of `keyframes`, and `station` is the number of the one that stands for each
    # keyframe.
    edges = _edges_of_parts(track, keyframes, depth_m, size)
    stations = _spread(edges, STATIONS, PART_STATIONS, MOST_STATIONS)
    station = _nearest_of_part(edges, stations)
    at = track.global_from_camera.translation[keyframes]
    # Typical distance of a keyframe from its station.
    slack = float(np.median(np.linalg.norm(at - at[stations[station]], axis=1)))
    a, b = np.triu_indices(len(stations), 1)
    offset, covariance = scene_offsets(
        track, keyframes[stations[a]], keyframes[stations[b]], depth_m
    )
    # Scenes that overlap are within about half a footprint, and a keyframe within `slack` of its
    # station.
    pairs_open = _is_open(offset, covariance, size, size / 2 + slack)
    if not pairs_open.any():
        return None
    known = largest_sigma(covariance) < KNOWN * size
    return OpenPlaces(
        edges=edges,
        station=station,
        open=_symmetric(pairs_open, a, b, len(stations)),
        apart=_symmetric(_is_apart(offset, covariance, size, slack), a, b, len(stations)),
        reach_m=float(np.linalg.norm(offset[known], axis=1).max(initial=0.0)),
    )


def _edges_of_parts(track: CameraTrack, keyframes: Ints, depth_m: Array, size_m: float) -> Ints:
    """Cut the path where a step between keyframes is uncertain by a footprint, as at an outage.

    depth_m: (n,) of the scene by node. size_m: side of a footprint. Returns the first keyframe of
    each part, and the number of keyframes.
    """
    _, covariance = scene_offsets(track, keyframes[:-1], keyframes[1:], depth_m)
    return np.concatenate(
        [[0], np.flatnonzero(largest_sigma(covariance) > BEYOND * size_m) + 1, [len(keyframes)]]
    )


def _spread(edges: Ints, total: int, each: int, most: int) -> Ints:
    """Choose keyframes evenly along each part of the path, and return their rows, ascending.

    Each part gets some, however short: an outage may separate it from the others.

    Parameters
    ----------
    edges
        First keyframe of each part, and the number of keyframes.
    total
        Number of keyframes to choose, shared among the parts by their lengths.
    each
        Least number in a part, unless these would be more than `most` in all.
    most
        Largest number in all. If there are more parts than that, the whole path is taken as one
        part.
    """
    length, parts = np.diff(edges), len(edges) - 1
    if parts > most:
        edges, length, parts = edges[[0, -1]], edges[[-1]], 1
    count = np.rint(total * length / length.sum()).astype(np.int64)
    if parts > 1:
        count = np.maximum(count, min(each, most // parts))
    rows = [
        np.linspace(a, b - 1, n).round()
        for a, b, n in zip(edges[:-1], edges[1:], count, strict=True)
    ]
    return np.unique(np.concatenate(rows).astype(np.int64))


def _nearest_of_part(edges: Ints, stations: Ints) -> Ints:
    """Assign each of m keyframes the nearest station, preferably one of its own part of the path.

    Beyond an outage a station would say little of where the keyframe is.

    edges: first keyframe of each part, and m. stations: (s,) keyframes that are stations,
    ascending. Returns (m,) rows of `stations`.
    """
    number = np.arange(edges[-1])
    after = np.searchsorted(stations, number)
    beside = np.clip([after - 1, after], 0, len(stations) - 1)
    part, of_station = (
        np.searchsorted(edges, values, side="right") for values in (number, stations[beside])
    )
    # Keyframes to the stations before and after. A station of another part is farther than any.
    away = np.abs(number - stations[beside]) + edges[-1] * (part != of_station)
    return np.asarray(np.where(away[0] <= away[1], *beside))


def _symmetric(values: Mask, a: Ints, b: Ints, count: int) -> Mask:
    """Fill a symmetric mask (count, count) from its values (k,) at the pairs a, b (k,)."""
    out = np.zeros((count, count), bool)
    out[a, b] = out[b, a] = values
    return out


def likeliest_pairs(
    track: CameraTrack,
    keyframes: Ints,
    depth_m: Array,
    camera: CameraModel,
    places: OpenPlaces,
    images: InvertedFile,
) -> tuple[Array, Array]:
    """Find the pairs of keyframes that look most alike, to be matched.

    Parameters are those of `open_places`, with its result and the visual words of the keyframes.
    Either result may be empty.

    Returns
    -------
    pairs
        (m, 2) rows of keyframes that may be one place, first < second, sorted.
    control
        (c, 2) rows of keyframes known to be two places.
    """
    queries = _spread(places.edges, QUERIES, PART_QUERIES, MOST_QUERIES)
    scores, size = images.scores(queries), footprint_m(depth_m[keyframes], camera)

    def pairs_where(
        mask: Mask, wanted: Callable[[Array, Array], Mask], most_each: int, most: int
    ) -> Array:
        """Find the pairs that look most alike among those whose offset `wanted` selects.

        mask: (s, s) pairs of stations to search. wanted: selects by offset and covariance of the
        scenes. most_each: pairs of a query at most. most: pairs in all at most.
        """
        # Rows of `queries` and of `keyframes`. The mask only preselects: an outage may lie between
        # a keyframe and its station.
        queried, candidate = _best(
            np.where(places.of_keyframes(queries, mask), scores, 0.0), CANDIDATES
        )
        keep = wanted(
            *scene_offsets(track, keyframes[queries[queried]], keyframes[candidate], depth_m)
        )
        queried, candidate = queried[keep], candidate[keep]
        order = _order_for_comparison(queried, candidate, scores[queried, candidate], most_each)
        return _distinct(np.column_stack([queries[queried], candidate])[order], most)

    return (
        pairs_where(
            places.open,
            lambda offset, covariance: _is_open(offset, covariance, size, size / 2),
            PLACES,
            MOST_PAIRS,
        ),
        pairs_where(
            places.apart,
            lambda offset, covariance: _is_apart(offset, covariance, size, 0.0),
            1,
            CONTROLS,
        ),
    )


def _is_open(offset: Array, covariance: Array, size_m: float, slack_m: float) -> Mask:
    """Select pairs (m,) that may be one place and that the search by overlap skips.

    offset, covariance: as by `scene_offsets`. size_m: side of a footprint. slack_m: as in
    `may_be_one`.
    """
    return np.asarray(
        (largest_sigma(covariance) > BEYOND * size_m) & may_be_one(offset, covariance, slack_m)
    )


def _is_apart(offset: Array, covariance: Array, size_m: float, slack_m: float) -> Mask:
    """Select pairs (m,) of scenes known to be two places: the offset is large and well known.

    offset, covariance, size_m: as of `_is_open`. slack_m: typical distance of a keyframe from the
    station that stands for it, 0 where both scenes are keyframes' own.
    """
    distance = np.linalg.norm(offset, axis=1)
    return np.asarray(
        (largest_sigma(covariance) < KNOWN * size_m) & (distance > APART * size_m + 2 * slack_m)
    )


def _best(scores: Array, most: int) -> tuple[Ints, Ints]:
    """List rows and columns of the `most` highest scores of each row (q, m), without zeros."""
    most = min(most, scores.shape[1])
    column = np.argsort(-scores, axis=1, kind="stable")[:, :most]
    row = np.repeat(np.arange(len(scores)), most)
    some = scores[row, column.ravel()] > 0
    return row[some], column.ravel()[some]


def _order_for_comparison(queried: Ints, candidate: Ints, score: Array, most: int) -> Ints:
    """Order candidates for comparison: the best of each query, then the next best elsewhere, etc.

    In this order a limited number of comparisons spreads over queries and places. Candidates of a
    query within two keyframes of one already taken are left out: they show about the same place.

    Parameters
    ----------
    queried, candidate
        Query and keyframe (k,) of each candidate, by query, the best first.
    score
        (k,) how alike they look.
    most
        Candidates of a query at most.

    Returns
    -------
    rows
        Rows of `queried` and `candidate` that are taken, in the order of comparison.
    """
    rank, taken = np.full(len(queried), -1), dict[int, list[int]]()
    for k, (query, place) in enumerate(zip(queried.tolist(), candidate.tolist(), strict=True)):
        before = taken.setdefault(query, [])
        if len(before) < most and all(abs(place - other) > 2 for other in before):
            rank[k] = len(before)
            before.append(place)
    order = np.lexsort((-score, rank))
    return np.asarray(order[rank[order] >= 0])


def _distinct(pairs: Array, most: int) -> Array:
    """Take the first `most` distinct pairs (m, 2), and sort them, the lower keyframe first."""
    ordered = np.sort(pairs, axis=1)
    first = np.sort(np.unique(ordered, axis=0, return_index=True)[1])[:most]
    return np.unique(ordered[first], axis=0)
