# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Link images by appearance where the path leaves their places open by many footprints.

Images that look alike are matched without a prior of their motion. They are linked where several
pairs confirm each other, no rival group of pairs contradicts them, and places known to be two do
not match (the control of `hypotheses`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.appearance.consistency import (
    agreement,
    extent_m,
    independent_links,
    largest_group,
)
from hullrecon.vision.appearance.hypotheses import (
    BEYOND,
    KNOWN,
    footprint_m,
    largest_sigma,
    likeliest_pairs,
    open_places,
    scene_offsets,
)
from hullrecon.vision.appearance.vocabulary import Descriptors, Vocabulary, invert, learn_vocabulary
from hullrecon.vision.compared_pairs import ComparedPairs, LinkedScene
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.footprints import footprint_overlap
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker
from hullrecon.vision.pairs.pair_match import PairMatch, agrees
from hullrecon.vision.pairs.selection import Proposal

SAMPLE = 100_000  # descriptors that a vocabulary is learnt from: 13 MB
STRONGEST = 1000  # features of an image that become words
GATE_CHI2 = 22.5  # of a link against the path: 99.9 % of chi-square with six degrees of freedom
LEAST_LINKS = 3  # links that confirm each other and share no image
# Footprints over which the scenes of these links must extend: a single thing that looks like
# another is not enough.
LEAST_EXTENT = 1.0
# Size of a rival group, which contradicts the largest one, as a share of it, from which it is
# undecided which of them is right
RIVAL_SHARE = 1 / 3
# The control must cover distances of this many sigmas of the uncertain offset. Otherwise it has no
# information on patterns that repeat at larger distances.
LEAST_REACH = 2.0
MAX_ALIKE = 2  # pairs of the control that may match: with more, different places look alike
# Pairs of the next round from which their matches count, and the share that must match.
LEAST_AFTER, LEAST_MATCHED = 5, 0.2

# Why no link is taken.
TOO_FEW = "too few images that look alike confirm each other"
AMBIGUOUS = "images that look alike confirm more than one path"
ALIKE = "places that the path knows to be two look alike"
TOO_SHORT = "no part of the path is long enough to show whether different places look alike"


@dataclass(frozen=True, kw_only=True)
class Recognition:
    """The result of one place recognition."""

    proposal: Proposal  # m pairs that were compared
    found: tuple[PairMatch, ...]  # (m,) their results
    accepted: Mask  # (m,) links to be taken
    counts: dict[str, int]  # figures for links.json, by their keys there
    refusal: str | None  # why no link is taken

    def refused(self, reason: str) -> Recognition:
        """Take no link, for this reason or an earlier one."""
        return replace(self, accepted=np.zeros_like(self.accepted), refusal=self.refusal or reason)

    def facts(self) -> dict[str, object]:
        """Collect the counts, the accepted links, and the refusal, for links.json."""
        return {**self.counts, "accepted": int(self.accepted.sum()), "refusal": self.refusal}


def is_confirmed(compared: ComparedPairs, number: int) -> bool:
    """Decide whether the links of a round are right: images that they bring together must match.

    compared: all pairs, with those of the round `number` and of the round after it, which compared
    these images. At least LEAST_LINKS links of the round must be kept, and of the pairs of the next
    round, if there are LEAST_AFTER, a share of LEAST_MATCHED.
    """
    kept = np.zeros(len(compared.found), bool)
    kept[compared.kept()] = True
    after = kept[compared.round == number + 1]
    return int(kept[compared.round == number].sum()) >= LEAST_LINKS and (
        len(after) < LEAST_AFTER or float(after.mean()) >= LEAST_MATCHED
    )


def recognise_places(
    scene: LinkedScene, track: CameraTrack, keyframes: Ints, compared: Ints
) -> Recognition | None:
    """Link keyframes that look alike, where the search by overlap cannot reach.

    Links are accepted all together or not at all. None is accepted where too few confirm each
    other, where another group contradicts them, or where the control shows, or cannot exclude, that
    different places of this hull look alike.

    Parameters
    ----------
    scene
        Nodes, depths and matching of the dive.
    track
        The leading cameras on the path known so far.
    keyframes
        Nodes (m,) to choose from.
    compared
        Pairs (first * n + second) that are not compared again.

    Returns
    -------
    recognition
        None where the search by overlap covers all that the path leaves open, or with one camera.
    """
    # Find images that look alike, of places that may be one, and, as a control, of places that are
    # known to be two.
    keyframes = keyframes[np.isfinite(scene.depth_m[keyframes])]
    likely = (
        _most_alike(scene, track, keyframes) if scene.worker.rig.stereo_mount is not None else None
    )
    if likely is None:
        return None
    proposal = _propose(scene, track, keyframes[likely.pairs])
    proposal = proposal.take(~np.isin(proposal.first * len(track) + proposal.second, compared))

    # Match them without a prior of the motion.
    found = scene.match(track, proposal, anywhere=True)
    alike = _match_control(scene, track, keyframes, likely)

    # Take those that confirm each other, unless the control shows that places look alike.
    within = _within_gate(track, proposal, found)
    group, refusal = _confirmed(scene, track, proposal, found, within)
    _, covariance = scene_offsets(
        track, proposal.first[group], proposal.second[group], scene.depth_m
    )
    # A control excludes look-alikes only as far apart as its own pairs. It has to reach as far as
    # the path is uncertain.
    if len(group) and likely.reach_m < LEAST_REACH * largest_sigma(covariance).max():
        group, refusal = group[:0], TOO_SHORT
    if alike > MAX_ALIKE:
        group, refusal = group[:0], ALIKE
    accepted = np.zeros(len(proposal), bool)
    accepted[group] = True
    counts = {
        "words": likely.words,
        "offered": len(proposal),
        "matched": sum(pair.motion is not None for pair in found),
        "control": len(likely.control),
        "control_matched": alike,
        "within_gate": len(within),
    }
    return Recognition(
        proposal=proposal, found=tuple(found), accepted=accepted, counts=counts, refusal=refusal
    )


def reject_look_alikes(
    scene: LinkedScene, track: CameraTrack, keyframes: Ints, compared: ComparedPairs
) -> ComparedPairs:
    """Reject matches across an outage where places known to be two look alike.

    An outage is where the path, `track` by dead reckoning, is uncertain by more than a footprint. A
    match across it may be with the wrong one of two places that look alike. Whether such places
    exist is seen from the control: all matches across outages are rejected, or none. Matches of
    nodes whose depth is unknown are kept. keyframes: nodes from which the control is taken.
    compared: the pairs so far.
    """
    known = np.isfinite(scene.depth_m)
    rows = compared.kept()
    first, second = compared.proposal.first[rows], compared.proposal.second[rows]
    doubtful = known[first] & known[second]
    if not doubtful.any():
        return compared
    _, covariance = scene_offsets(track, first[doubtful], second[doubtful], scene.depth_m)
    sigma = largest_sigma(covariance)
    doubtful[doubtful] = sigma > BEYOND * footprint_m(scene.depth_m, scene.camera)
    keyframes = keyframes[known[keyframes]]
    likely = _most_alike(scene, track, keyframes) if doubtful.any() else None
    if likely is None:
        return compared
    # A control that does not reach far enough must not have a single match.
    most = MAX_ALIKE if likely.reach_m >= LEAST_REACH * sigma.max() else 0
    if _match_control(scene, track, keyframes, likely) <= most:
        return compared
    return compared.rejecting(doubtful)


@dataclass(frozen=True, kw_only=True)
class _Likely:
    """Pairs of keyframes that look most alike, as rows of the keyframes."""

    pairs: Array  # (m, 2) may be one place
    control: Array  # (c, 2) known to be two places
    words: int  # in the vocabulary
    reach_m: float  # as in OpenPlaces


def _most_alike(scene: LinkedScene, track: CameraTrack, keyframes: Ints) -> _Likely | None:
    """Find the images that look most alike, by visual words learnt from the keyframes.

    None where the search by overlap reaches as far as the path is uncertain.
    """
    places = open_places(track, keyframes, scene.depth_m, scene.camera)
    if places is None:
        return None
    vocabulary, words = learn_words(scene.worker, [scene.nodes[k] for k in keyframes])
    images_by_word = invert(words, len(vocabulary))
    pairs, control = likeliest_pairs(
        track, keyframes, scene.depth_m, scene.camera, places, images_by_word
    )
    return _Likely(pairs=pairs, control=control, words=len(vocabulary), reach_m=places.reach_m)


def _match_control(scene: LinkedScene, track: CameraTrack, keyframes: Ints, likely: _Likely) -> int:
    """Match the pairs of the control, places known to be two, and count those that match.

    Each of them shows that two places of this hull look alike.
    """
    proposal = _propose(scene, track, keyframes[likely.control])
    return sum(pair.motion is not None for pair in scene.match(track, proposal, anywhere=True))


def learn_words(worker: MatchWorker, nodes: Sequence[MatchNode]) -> tuple[Vocabulary, list[Ints]]:
    """Learn visual words from the leading images of some nodes, and look up the words of each.

    Returns the vocabulary, and for each node the words of its strongest features.
    """
    each = min(max(1, SAMPLE // len(nodes)), STRONGEST)
    vocabulary = learn_vocabulary(
        np.concatenate([_strongest(worker, node, each) for node in nodes]), worker.options.seed
    )
    return vocabulary, [vocabulary.words(_strongest(worker, node, STRONGEST)) for node in nodes]


def _strongest(worker: MatchWorker, node: MatchNode, most: int) -> Descriptors:
    """Read the descriptors (k, 128) of the leading image's strongest features, k at most `most`.

    Features without a score are left out.
    """
    features = worker.read(node).leading
    rows = np.flatnonzero(features.scored)
    order = np.argsort(-features.keypoints[rows, 3], kind="stable")[:most]
    return features.descriptors[rows[np.sort(order)]]


def _propose(scene: LinkedScene, track: CameraTrack, nodes: Array) -> Proposal:
    """Propose pairs of nodes (m, 2) across legs, with the overlap that the path predicts."""
    first, second = nodes[:, 0].astype(np.int64), nodes[:, 1].astype(np.int64)
    overlap = footprint_overlap(track, first, second, scene.depth_m, scene.camera)
    return Proposal(first=first, second=second, across=np.ones(len(first), bool), overlap=overlap)


def _within_gate(track: CameraTrack, proposal: Proposal, found: Sequence[PairMatch]) -> Ints:
    """List the matched pairs whose motion the path, within its covariance, does not contradict.

    Pairs without a measured length are left out. Returns rows of `found`.
    """
    rows = [k for k, pair in enumerate(found) if pair.motion is not None and pair.scaled]
    prior = track.motions(proposal.first[rows], proposal.second[rows])
    within = [k for k, p in zip(rows, prior, strict=True) if agrees(found[k], p, GATE_CHI2)]
    return np.array(within, np.int64)


def _confirmed(
    scene: LinkedScene,
    track: CameraTrack,
    proposal: Proposal,
    found: Sequence[PairMatch],
    rows: Ints,
) -> tuple[Ints, str | None]:
    """Select the largest group of pairs that confirm each other, or none with the reason.

    None where the group is too small or too narrow, or another group contradicts it.

    Parameters
    ----------
    scene, track
        As in `recognise_places`, for depths and for the path between the pairs.
    proposal, found
        Pairs that were compared, and their results.
    rows
        Those of them that matched and agree with the path.

    Returns
    -------
    group
        Rows of the selected pairs.
    refusal
        Why there are none, None if there are some.
    """
    # The largest group has to be of several links, spread over the hull.
    size = footprint_m(scene.depth_m, scene.camera)
    first, second = proposal.first[rows], proposal.second[rows]
    links = agreement(track, first, second, [found[k] for k in rows], KNOWN * size)
    group = largest_group(links.agree, np.arange(len(rows)))
    middle = scene.depth_m[first[group], None] * [0.0, 0.0, 1.0]
    extent = extent_m(track.global_from_camera[first[group]].apply(middle))
    independent = independent_links(first[group], second[group])
    if independent < LEAST_LINKS or extent < LEAST_EXTENT * size:
        return rows[:0], TOO_FEW
    # Links that contradict most of it must not form a group that is nearly as large.
    against = np.flatnonzero(links.contradict[:, group].sum(axis=1) > len(group) / 2)
    rival = largest_group(links.agree, against)
    if len(rival) > 1 and len(rival) >= RIVAL_SHARE * len(group):
        return rows[:0], AMBIGUOUS
    return rows[group], None
