# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""links and adjust on a dive without a camera: the path stands on the patches of hull that were
passed again.
"""

import json
import shutil
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from navigation.planar_dive import aligned, simulate

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.artifacts.runner import run_stage
from hullrecon.dive.config import schema
from hullrecon.errors import ContradictionError
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import PositionTies
from hullrecon.steps.artifacts import AdjustArtifact, LinksArtifact
from hullrecon.steps.chain import stage
from hullrecon.studies.scenes.ellipsoid_dive import TRAY_ORIGIN_M
from hullrecon.vision.options import LinkOptions, MatchOptions

ADJUST = stage("adjust")
LINKS = stage("links")


def sections(**links):
    return {
        "tray": schema.Tray(origin=tuple(TRAY_ORIGIN_M.tolist()), sigma_deg=0.01),
        "imu": schema.Imu(heading_drift_deg_per_hour=100.0),
        "pressure": schema.Pressure(),
        "dvl": schema.Dvl(mount=(0.0,) * 6, mount_sigma=(0.001, 0.001, 0.001, 0.2, 0.2, 0.2)),
        "camera": schema.Cameras(),
        "hull": None,
        "matches": MatchOptions(),
        "links": LinkOptions(**links),
        "adjust": AdjustOptions(),
    }


@pytest.fixture(scope="module")
def dive():
    return simulate(11, drift_deg_per_hour=100.0, legs=3, leg_m=8.0)


@pytest.fixture(scope="module")
def folder(dive, tmp_path_factory):
    """What ingest and navigate would have left."""
    root = tmp_path_factory.mktemp("dive")
    (root / "ingest").mkdir()
    (root / "navigate").mkdir()
    for name in ("trajectory", "odometry", "attitude", "returns"):
        with zipfile.ZipFile(root / "navigate" / f"{name}.npz", "w") as file:
            for member, value in to_arrays(getattr(dive, name)).items():
                with file.open(f"{member}.npy", "w") as stream:
                    np.save(stream, value)
    return root


def positions(dive, sigma_m=0.02, every=10):
    """Fixes at every tenth node, in a world that lies any way to g."""
    node = np.arange(0, len(dive.trajectory.t_ns), every)
    at, rng = dive.truth.translation[node, :2], np.random.default_rng(5)
    turn = np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])
    return PositionTies(
        t_ns=dive.trajectory.t_ns[node],
        node=node,
        antenna=np.zeros((len(node), 3)),
        north_east=at @ turn.T + [30.0, -8.0] + sigma_m * rng.standard_normal(at.shape),
        sigma=np.full(len(node), sigma_m),
    )


def run(folder, out, **links):
    """The artifacts of links and adjust."""
    inputs = {name: folder / name for name in ("ingest", "navigate")}
    run_stage(LINKS, sections(**links), inputs, out / "links")
    run_stage(ADJUST, sections(), inputs | {"links": out / "links"}, out / "adjust")
    return LinksArtifact(out / "links"), AdjustArtifact(out / "adjust")


@pytest.fixture(scope="module")
def tied(folder, tmp_path_factory):
    return run(folder, tmp_path_factory.mktemp("tied"))


def error_m(dive, at):
    return float(np.sqrt(np.mean(np.sum(aligned(at, dive.truth.translation) ** 2, axis=1))))


def test_the_step_applies_to_a_dive_without_a_camera():
    assert LINKS.applies is None
    assert "features" in LINKS.optional


def test_the_path_is_tied_by_planes_and_no_file_speaks_of_images(dive, tied):
    links, _ = tied
    assert error_m(dive, links.path.pose[:, :3]) < 0.4 * error_m(dive, dive.trajectory.translation)
    assert (links.path.part == -1).all()
    names = {path.name for path in links.folder.iterdir() if path.is_file()}
    assert {"path.npz", "planes.npz", "links.json"} <= names
    assert not names & {"pairs.npz", "features.npz", "links.npz", "stereo.npz"}
    facts = json.loads((links.folder / "links.json").read_text())["planes"]
    assert facts["ties"] == len(links.planes) > 20
    assert facts["refusal"] is None


def test_adjust_keeps_path_and_covariance_of_links(tied):
    links, adjust = tied
    found = adjust.solution.global_from_vehicle.translation
    np.testing.assert_allclose(found, links.path.pose[:, :3], atol=1e-3)
    track = adjust.solution.track()
    sigma = np.sqrt(np.einsum("nii->ni", links.path.covariance))[:, :3]
    assert np.median(np.abs(track.sigma[20:, :2] / sigma[20:, :2] - 1)) < 0.2


def test_without_planes_links_and_adjust_keep_navigation(dive, folder, tied, tmp_path):
    links, adjust = run(folder, tmp_path, planes=False)
    assert links.planes is None
    assert error_m(dive, adjust.solution.global_from_vehicle.translation) > 0.8 * error_m(
        dive, dive.trajectory.translation
    )
    across, tied_across = (
        found[1].solution.track().sigma[-1, 0] for found in ((links, adjust), tied)
    )
    assert tied_across < 0.5 * across  # x of g points into the hull


@pytest.fixture(scope="module")
def bounded(dive, folder, tmp_path_factory):
    """The same dive with positions from outside and without planes."""
    root = tmp_path_factory.mktemp("bounded")
    shutil.copytree(folder, root / "dive")
    np.savez(root / "dive" / "navigate" / "positions.npz", **to_arrays(positions(dive)))
    return run(root / "dive", root, planes=False)


def test_positions_bound_the_path_in_links_and_in_adjust_alike(dive, folder, bounded, tmp_path):
    links, adjust = bounded
    without, _ = run(folder, tmp_path, planes=False)
    assert error_m(dive, links.path.pose[:, :3]) < 0.3 * error_m(dive, without.path.pose[:, :3])
    np.testing.assert_allclose(
        adjust.solution.global_from_vehicle.translation, links.path.pose[:, :3], atol=2e-3
    )
    sigma, free = (np.sqrt(found.path.covariance[-1, 0, 0]) for found in (links, without))
    assert sigma < 0.3 * free


def test_both_documents_say_how_far_positions_lie_from_the_path(dive, bounded):
    links, adjust = bounded
    for found in (links.facts["positions"], adjust.summary["positions"]):
        assert found["count"] == len(positions(dive))
        assert 0.5 < found["rms_sigmas"] < 1.5
        assert found["outliers"] == 0
        assert found["heading_deg"] == pytest.approx(
            np.degrees(2.0), abs=3 * found["heading_sigma_deg"]
        )
    assert adjust.summary["residuals_after"]["position"]["count"] == 2 * len(positions(dive))


def test_without_positions_neither_document_speaks_of_them(tied):
    links, adjust = tied
    assert "positions" not in links.facts
    assert "positions" not in adjust.summary


def test_positions_in_another_unit_are_named_and_the_remedy_heals(dive, folder, tied, tmp_path):
    shutil.copytree(folder, tmp_path / "dive")
    right = positions(dive)
    in_feet = replace(right, north_east=right.north_east / 0.3048)
    np.savez(tmp_path / "dive" / "navigate" / "positions.npz", **to_arrays(in_feet))
    with pytest.raises(ContradictionError, match=r"leave topics\.position away"):
        run(tmp_path / "dive", tmp_path)
    _, without = tied  # the same dive, topics.position left away
    assert error_m(dive, without.solution.global_from_vehicle.translation) < 0.1
