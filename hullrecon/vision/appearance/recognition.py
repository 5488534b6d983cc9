# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links by appearance: where the path leaves open by many footprints what lies where, images that
look alike are compared in full, and taken where several confirm each other, none contradicts them,
and places known to be two do not look alike.
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
from hullrecon.vision.appearance.inverted_file import invert
from hullrecon.vision.appearance.vocabulary import Descriptors, Vocabulary, learn_vocabulary
from hullrecon.vision.compared_pairs import ComparedPairs, LinkedScene, Map
from hullrecon.vision.pair_match import PairMatch, agrees
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker
from hullrecon.vision.pairs.selection import Proposal, footprint_overlap

SAMPLE = 100_000  # descriptors that a vocabulary is learnt from: 13 MB
STRONGEST = 1000  # features of an image that become words
LEAST_LINKS = 3  # that share no image and confirm each other
# footprints over which their scenes must lie: one thing that looks like another is not enough
LEAST_EXTENT = 1.0
RIVAL_SHARE = 1 / 3  # of them: as many that confirm each other elsewhere leave open which is right
LEAST_REACH = (
    # sigmas of the path between them, that is known within one part: of paint that comes again
    # later none can tell
    2.0
)
# of the control's pairs that match: more, and this hull looks alike in different places
MAX_ALIKE = 2
# pairs of the next round that say something, and the share of them that must match
LEAST_AFTER, BORNE_OUT = 5, 0.2
GATE_CHI2 = 22.5  # of the six numbers of a link against the path, 99.9 %

# Why no link is taken.
TOO_FEW = "too few images that look alike confirm each other"
AMBIGUOUS = "images that look alike confirm more than one path"
ALIKE = "places that the path knows to be two look alike"
TOO_SHORT = "no part of the path is long enough to show whether different places look alike"


@dataclass(frozen=True, kw_only=True)
class Recognition:
    """What appearance was asked and gave. proposal: the pairs, found: what came of each; accepted
    (m,): links to be taken. counts: of what was asked; refusal: why none is taken.
    """

    proposal: Proposal
    found: tuple[PairMatch, ...]
    accepted: Mask
    counts: dict[str, int]
    refusal: str | None

    def refused(self, reason: str) -> Recognition:
        """Return the same with no link taken; of two reasons the first holds."""
        return replace(self, accepted=np.zeros_like(self.accepted), refusal=self.refusal or reason)

    def facts(self) -> dict[str, object]:
        """Return the counts, how many links were taken, and why none was."""
        return {**self.counts, "accepted": int(self.accepted.sum()), "refusal": self.refusal}


def reject_others(compared: ComparedPairs, accepted: Mask) -> ComparedPairs:
    """Return the pairs without those of the last len(accepted) that matched and are not accepted."""
    rows = compared.kept() - (len(compared.found) - len(accepted))
    return compared.rejecting((rows >= 0) & ~np.append(accepted, True)[np.maximum(rows, -1)])


def bears_out(compared: ComparedPairs, number: int) -> bool:
    """Return whether links taken in that round still stand, and the images that they put beside
    each other match, as the round after it found.
    """
    kept = np.zeros(len(compared.found), bool)
    kept[compared.kept()] = True
    after = kept[compared.round == number + 1]
    return int(kept[compared.round == number].sum()) >= LEAST_LINKS and (
        len(after) < LEAST_AFTER or float(after.mean()) >= BORNE_OUT
    )


def recognise_places(
    scene: LinkedScene, track: CameraTrack, keyframes: Ints, compared: Ints, map_items: Map
) -> Recognition | None:
    """Return links by appearance between keyframes (m,), worth asking for; None where the search
    covers all that the path leaves open. compared: pairs (first * n + second) that are not asked
    for again.
    """
    keyframes = keyframes[np.isfinite(scene.depth_m[keyframes])]
    likely = (
        _likeliest(scene, track, keyframes) if scene.worker.rig.stereo_mount is not None else None
    )
    if likely is None:
        return None
    proposal = _propose(scene, track, keyframes[likely.pairs])
    proposal = _select(proposal, ~np.isin(proposal.first * len(track) + proposal.second, compared))
    found = scene.match(track, proposal, map_items, anywhere=True)
    alike = _match_control(scene, track, keyframes, likely, map_items)
    counts = {
        "words": likely.words,
        "offered": len(proposal),
        "matched": sum(pair.motion is not None for pair in found),
        "control": len(likely.control),
        "control_matched": alike,
    }
    within = _within_gate(track, proposal, found)
    group, refusal = _confirmed(scene, track, proposal, found, within)
    _, covariance = scene_offsets(
        track, proposal.first[group], proposal.second[group], scene.depth_m
    )
    if len(group) and likely.reach_m < LEAST_REACH * largest_sigma(covariance).max():
        group, refusal = group[:0], TOO_SHORT
    if counts["control_matched"] > MAX_ALIKE:
        group, refusal = group[:0], ALIKE
    accepted = np.zeros(len(proposal), bool)
    accepted[group] = True
    counts["within_gate"] = len(within)
    return Recognition(
        proposal=proposal, found=tuple(found), accepted=accepted, counts=counts, refusal=refusal
    )


def reject_look_alikes(
    scene: LinkedScene, track: CameraTrack, keyframes: Ints, compared: ComparedPairs, map_items: Map
) -> ComparedPairs:
    """Return the pairs of neighbours without those across an outage in which the path is lost by
    more than a footprint, where places known to be two look alike: one of these may be what
    matched. track: of dead reckoning.
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
    likely = _likeliest(scene, track, keyframes) if doubtful.any() else None
    if likely is None:
        return compared
    most = MAX_ALIKE if likely.reach_m >= LEAST_REACH * sigma.max() else 0
    if _match_control(scene, track, keyframes, likely, map_items) <= most:
        return compared
    return compared.rejecting(doubtful)


@dataclass(frozen=True, kw_only=True)
class _Likely:
    """Pairs of ranks among the keyframes that look most alike: may be one place, and a control of
    places known to be two; words: in the vocabulary; reach_m: the largest distance that the path
    knows.
    """

    pairs: Array
    control: Array
    words: int
    reach_m: float


def _likeliest(scene: LinkedScene, track: CameraTrack, keyframes: Ints) -> _Likely | None:
    """Return what looks most alike; None where the search covers all that the path leaves open."""
    places = open_places(track, keyframes, scene.depth_m, scene.camera)
    if places is None:
        return None
    vocabulary, words = learn_words(scene.worker, [scene.nodes[k] for k in keyframes])
    images = invert(words, len(vocabulary))
    pairs, control = likeliest_pairs(track, keyframes, scene.depth_m, scene.camera, places, images)
    return _Likely(pairs=pairs, control=control, words=len(vocabulary), reach_m=places.reach_m)


def _match_control(
    scene: LinkedScene, track: CameraTrack, keyframes: Ints, likely: _Likely, map_items: Map
) -> int:
    """Return how many pairs of places known to be two match."""
    alike = scene.match(
        track, _propose(scene, track, keyframes[likely.control]), map_items, anywhere=True
    )
    return sum(pair.motion is not None for pair in alike)


def learn_words(worker: MatchWorker, nodes: Sequence[MatchNode]) -> tuple[Vocabulary, list[Ints]]:
    """Return words learnt from the leading images of some nodes, and those that each shows."""
    each = min(max(1, SAMPLE // len(nodes)), STRONGEST)
    vocabulary = learn_vocabulary(
        np.concatenate([_strongest(worker, node, each) for node in nodes]), worker.options.seed
    )
    return vocabulary, [vocabulary.words(_strongest(worker, node, STRONGEST)) for node in nodes]


def _strongest(worker: MatchWorker, node: MatchNode, most: int) -> Descriptors:
    """Return the descriptors (at most `most`, 128) of the leading image's strongest features."""
    features = worker.read(node.image, node.stereo).leading.without_corners()
    return features.descriptors[
        np.sort(np.argsort(-features.keypoints[:, 3], kind="stable")[:most])
    ]


def _propose(scene: LinkedScene, track: CameraTrack, nodes: Array) -> Proposal:
    first, second = nodes[:, 0].astype(np.int64), nodes[:, 1].astype(np.int64)
    overlap = footprint_overlap(track, first, second, scene.depth_m, scene.camera)
    return Proposal(first=first, second=second, across=np.ones(len(first), bool), overlap=overlap)


def _select(proposal: Proposal, rows: Mask) -> Proposal:
    return Proposal(
        first=proposal.first[rows],
        second=proposal.second[rows],
        across=proposal.across[rows],
        overlap=proposal.overlap[rows],
    )


def _within_gate(track: CameraTrack, proposal: Proposal, found: Sequence[PairMatch]) -> Ints:
    """Return the pairs that matched, with a length, where the path may have them."""
    rows = np.array(
        [k for k, pair in enumerate(found) if pair.motion is not None and pair.scaled], np.int64
    )
    prior = track.motions(proposal.first[rows], proposal.second[rows])
    return np.array(
        [
            k
            for k, motion in zip(rows.tolist(), prior, strict=True)
            if agrees(found[k], motion, GATE_CHI2)
        ],
        np.int64,
    )


def _confirmed(
    scene: LinkedScene,
    track: CameraTrack,
    proposal: Proposal,
    found: Sequence[PairMatch],
    rows: Ints,
) -> tuple[Ints, str | None]:
    """Return the pairs that confirm each other, none and the reason where these are too few, or
    others do as well.
    """
    none = rows[:0]
    size = footprint_m(scene.depth_m, scene.camera)
    first, second = proposal.first[rows], proposal.second[rows]
    links = agreement(track, first, second, [found[k] for k in rows], KNOWN * size)
    group = largest_group(links.agree, np.arange(len(rows)))
    seen = track.global_from_camera[first[group]].apply(
        scene.depth_m[first[group], None] * [0.0, 0.0, 1.0]
    )
    if (
        independent_links(first[group], second[group]) < LEAST_LINKS
        or extent_m(seen) < LEAST_EXTENT * size
    ):
        return none, TOO_FEW
    against = np.flatnonzero(links.contradict[:, group].sum(axis=1) > len(group) / 2)
    rival = largest_group(links.agree, against)
    if len(rival) > 1 and len(rival) >= RIVAL_SHARE * len(group):
        return none, AMBIGUOUS
    return rows[group], None
