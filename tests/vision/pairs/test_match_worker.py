# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import pickle

import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp
from hullrecon.vision.features.store import GrowingArray
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.match_worker import (
    MatchNode,
    MatchWorker,
    NodePair,
)
from hullrecon.vision.pairs.matching import PairMatcher
from hullrecon.vision.pairs.pair_match import Reason
from hullrecon.vision.stereo.matching import no_matches
from hullrecon.vision.stereo.node_view import DepthPrior

PRIOR = DepthPrior(mean=1.3, sigma=0.2, nearest=0.8, farthest=2.0)
KNOWN = np.diag([0.02**2] * 3 + [0.01**2] * 3)


@pytest.fixture
def nodes(look):
    return [look([0.25 * k, 0, 0, 0, 0, 0], seed=k) for k in range(3)]


@pytest.fixture
def worker(tmp_path, rig, nodes):
    """The features of three nodes on disk; the top camera's images score 0.8, 0.0 and 0.8, all of
    the bottom's 0.6.
    """
    index = {}
    for camera in ("top", "bottom"):
        found = [getattr(node, camera) for node in nodes]
        index[f"camera_{camera}_start"] = np.concatenate([[0], np.cumsum([len(f) for f in found])])
        index[f"camera_{camera}_saliency"] = np.array(
            [0.8, 0.0, 0.8] if camera == "top" else [0.6] * 3
        )
        for kind, width, dtype in (
            ("keypoints", 4, np.float32),
            ("descriptors", 128, np.uint8),
            ("color", 3, np.uint8),
        ):
            with GrowingArray(tmp_path / f"{kind}_camera_{camera}.npy", width, dtype) as file:
                for features in found:
                    file.append(getattr(features, kind))
    np.savez(tmp_path / "index.npz", **index)
    return MatchWorker(features=tmp_path, rig=rig, options=MatchOptions())


def filled(worker, k):
    bare = MatchNode(image=(k, k), depth=PRIOR, stereo=no_matches())
    return MatchNode(image=bare.image, depth=PRIOR, stereo=worker.match_stereo(bare)[1])


def test_work_on_node_survives_way_to_another_process(worker, nodes):
    count, stereo = pickle.loads(pickle.dumps(worker.match_stereo))(
        MatchNode(image=(1, 1), depth=PRIOR, stereo=no_matches())
    )
    assert count == len(nodes[1].top)
    np.testing.assert_array_equal(nodes[1].top_id[stereo.top], nodes[1].bottom_id[stereo.bottom])


def test_bottom_camera_leads_where_top_one_saw_nothing(tmp_path, rig):
    """Be it that it has no image or that its image shows nothing."""
    index = {}
    for camera, count in (("top", (5, 0, 0)), ("bottom", (4, 6, 0))):
        index[f"camera_{camera}_start"] = np.concatenate([[0], np.cumsum(count)])
        index[f"camera_{camera}_saliency"] = np.zeros(3)
        for kind, width, dtype in (
            ("keypoints", 4, np.float32),
            ("descriptors", 128, np.uint8),
            ("color", 3, np.uint8),
        ):
            with GrowingArray(tmp_path / f"{kind}_camera_{camera}.npy", width, dtype) as file:
                file.append(np.zeros((sum(count), width), dtype))
    np.savez(tmp_path / "index.npz", **index)
    images = [(0, 0), (1, 1), (2, 2), (-1, 0), (0, -1), (-1, 2), (-1, -1), (1, 2)]
    worker = MatchWorker(features=tmp_path, rig=rig, options=MatchOptions())
    nodes = [
        MatchNode(image=(top, bottom), depth=None, stereo=no_matches()) for top, bottom in images
    ]
    assert worker.bottom_leads(nodes).tolist() == [
        False,
        True,
        False,
        True,
        False,
        False,
        False,
        False,
    ]
    alone = MatchWorker(
        features=tmp_path, rig=camera_rig(rig.model(Camera.TOP)), options=MatchOptions()
    )
    assert not alone.bottom_leads(nodes).any()


def test_block_gives_each_pair_what_it_gets_alone(worker, rig, nodes):
    members = {k: filled(worker, k) for k in range(3)}
    pairs = [
        NodePair(
            first=a,
            second=b,
            expected=Motion(
                (nodes[b].pose.inverse() @ nodes[a].pose @ exp([[0.01, 0, 0, 0, 0, 0]])).matrix()[
                    0
                ],
                KNOWN,
            ),
            full_search=False,
        )
        for a, b in ((0, 1), (0, 2), (1, 2))
    ]
    together = pickle.loads(pickle.dumps(worker.match_pairs))((members, pairs))
    for pair, found in zip(pairs, together, strict=True):
        views = worker.view(members[pair.first]), worker.view(members[pair.second])
        alone = PairMatcher(rig, worker.options).match(
            *views, pair.expected, (worker.options.seed, pair.first, pair.second), False
        )
        assert found.reason is Reason.MATCHED
        np.testing.assert_array_equal(found.first, alone.first)
        np.testing.assert_array_equal(found.second, alone.second)


def test_node_is_as_salient_as_image_that_leads(worker):
    assert worker.saliency(MatchNode(image=(0, 0), depth=PRIOR, stereo=no_matches())) == 0.8
    assert worker.saliency(MatchNode(image=(-1, 0), depth=PRIOR, stereo=no_matches())) == 0.6
    assert worker.saliency(MatchNode(image=(-1, -1), depth=PRIOR, stereo=no_matches())) == 0.0


def test_node_without_image_has_nothing_to_match(worker):
    count, stereo = worker.match_stereo(MatchNode(image=(-1, -1), depth=None, stereo=no_matches()))
    assert (count, len(stereo)) == (0, 0)


def test_mono_worker_reads_no_bottom_images(worker, nodes):
    mono = MatchWorker(
        features=worker.features,
        rig=camera_rig(worker.rig.model(Camera.TOP)),
        options=worker.options,
    )
    bare = MatchNode(image=(0, 0), depth=PRIOR, stereo=no_matches())
    assert len(mono.read(bare).bottom) == 0
    assert len(mono.read(bare).top) == len(nodes[0].top)
    assert not mono.view(MatchNode(image=(0, 0), depth=PRIOR, stereo=no_matches())).stereo.any()
