# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the figures of a path say of a dive with one camera is what its run and its truth say."""

import csv
import shutil

import numpy as np
import pytest

from hullrecon.api.dive_run import open_dive
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.progress import Progress
from hullrecon.artifacts.runner import RunContext
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.steps.artifacts import LinksArtifact
from hullrecon.studies import run_studies
from hullrecon.studies.matching.comparison import VARIANTS
from hullrecon.studies.methods.variants import read_dead_reckoning
from hullrecon.studies.paths.path_figures import draw_path_figures
from hullrecon.studies.surfaces.comparison import AS_FOUND, SURFACES

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def drawn(mono_dive, tmp_path_factory):
    """The dive, and its figures by name."""
    folder = shutil.copytree(mono_dive, tmp_path_factory.mktemp("path_figures") / "mono")
    dive = open_dive(folder / "package", folder / "out", ())
    with choose_executor(1) as executor:
        figures = draw_path_figures(
            dive,
            read_dead_reckoning(dive),
            read_truth(dive.chain.package),
            RunContext(dive.workspace.hashes(), executor, Progress()),
        )
    return dive, {figure.name: figure for figure in figures}


def rows(figure):
    return list(csv.DictReader(figure.csv.splitlines()))


def test_all_that_such_a_dive_can_show_is_drawn(drawn):
    assert set(drawn[1]) >= {
        "sigma_along_path",
        "links_on_hull",
        "two_view_models",
        "sonar_variance",
    }


def test_links_make_the_path_better_known_than_dead_reckoning(drawn):
    last = rows(drawn[1]["sigma_along_path"])[-1]
    assert 0 < float(last["with_links_m"]) < 0.5 * float(last["dead_reckoned_m"])


def test_every_pair_that_the_run_joined_is_a_link_of_the_figure(drawn):
    dive, figures = drawn
    joined = [
        (int(r["first"]), int(r["second"]))
        for r in rows(figures["links_on_hull"])
        if r["joined"] == "1"
    ]
    pairs = LinksArtifact(dive.workspace.artifact("links")).pairs
    assert joined == list(
        zip(pairs.first[pairs.joined].tolist(), pairs.second[pairs.joined].tolist(), strict=True)
    )
    assert joined


def test_path_of_chosen_models_is_the_runs_with_its_true_error(drawn):
    dive, figures = drawn
    by_model = {r["model"]: r for r in rows(figures["two_view_models"])}
    assert list(by_model) == [
        "essential matrix alone",
        "homography alone",
        "chosen by the criterion",
    ]
    start, truth = read_dead_reckoning(dive).trajectory, read_truth(dive.chain.package)
    at = LinksArtifact(dive.workspace.artifact("links")).path.pose[:, :3]
    true = truth.vehicle_at(start.t_ns / 1e9).translation
    error = fit_rigid(at, true).apply(at) - true
    chosen = float(by_model["chosen by the criterion"]["rigid_rms_m"])
    assert chosen == pytest.approx(np.sqrt(np.mean(np.sum(error**2, axis=1))), abs=2e-5)
    assert chosen < 0.01
    assert not (dive.workspace.root / "compare" / "links-automatic").exists()
    assert (dive.workspace.root / "compare" / "links-essential" / "links" / "path.npz").exists()


def test_sonar_mosaic_variance_is_compared_for_all_pose_sources(drawn):
    table = rows(drawn[1]["sonar_variance"])
    names = [name for name in table[0] if name.startswith("share_")]
    assert names[0] == "share_dead_reckoned"
    assert names[-2:] == ["share_with_links", "share_adjusted"]
    assert all(float(table[0][name]) == 1.0 for name in names)


def test_links_of_the_product_are_compared_with_the_sources(drawn):
    dive = drawn[0]
    (found,) = run_studies(dive, ["links"])
    assert [row[0] for row in found.rows] == ["product", *VARIANTS]
    pairs = LinksArtifact(dive.workspace.artifact("links")).pairs
    assert found.values["product"]["joined"] == int(pairs.joined.sum())
    assert all(0 < row["rms_m"] < 0.05 for row in found.values.values())
    assert found.values["with corners"]["joined"] > 0


def test_surfaces_of_the_product_are_compared_with_the_sources(drawn):
    (found,) = run_studies(drawn[0], ["surfaces"])
    names = [f"surface, {name}" for name in ("product", *SURFACES)]
    names += [f"as found, {name}" for name in ("product", *AS_FOUND)]
    assert list(found.values) == names
    scored = [row for row in found.values.values() if "error" not in row]
    assert len(scored) >= 6
    assert all(0 < row["rmse_m"] < 0.2 for row in scored)
