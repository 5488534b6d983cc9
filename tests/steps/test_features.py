# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest

from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.manifest import HashCache
from hullrecon.artifacts.progress import choose_progress
from hullrecon.artifacts.runner import RunContext, build, make_job, run_stage
from hullrecon.artifacts.stage import StageSettings
from hullrecon.dive.config.schema import Cameras, CameraTop, Dive, Logs
from hullrecon.errors import InputError, StageError
from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import to_arrays
from hullrecon.steps.chain import stage
from hullrecon.vision.features.extraction import extract
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.options import FeatureOptions

STAGE = stage("features")

SECTIONS = {
    "dive": Dive(name="t"),
    "logs": Logs(files=("logs",)),
    "camera": Cameras(top=CameraTop(calibration="c.yaml")),
    "features": FeatureOptions(max_features=300, reduction=1.0),
}


def picture(seed):
    rng = np.random.default_rng(seed)
    return cv2.GaussianBlur(rng.integers(0, 255, (96, 128, 3)).astype(np.uint8), (0, 0), 1.5)


def ingest(folder, pictures, usable):
    """An ingest artifact whose images lie in its own file."""
    folder.mkdir()
    encoded = [cv2.imencode(".png", p[..., ::-1])[1].tobytes() for p in pictures]
    size = np.array([len(e) for e in encoded], np.int64)
    (folder / "images_camera_top.bin").write_bytes(b"".join(encoded))
    names = np.array([""] * len(encoded))
    index = ImageIndex(
        t_ns=np.arange(len(encoded)),
        file=names,
        offset=np.concatenate([[0], np.cumsum(size)[:-1]]),
        size=size,
        usable=np.array(usable),
    )
    # numpy.savez has no room for a member named file
    with zipfile.ZipFile(folder / "images_camera_top.npz", "w") as file:
        for name, values in to_arrays(index).items():
            with file.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, values, allow_pickle=False)
    return folder


@pytest.fixture
def made(tmp_path):
    """Three images, the middle one unusable."""
    (tmp_path / "package").mkdir()
    return ingest(tmp_path / "ingest", [picture(k) for k in range(3)], [True, False, True])


def run(ingested, out, jobs=1, sections=SECTIONS):
    return run_stage(
        STAGE, sections, {"ingest": ingested}, out, source=ingested.parent / "package", jobs=jobs
    )


def test_each_image_keeps_its_row_and_an_unusable_one_is_empty(made, tmp_path):
    store = FeatureStore(run(made, tmp_path / "out"), Camera.TOP)
    assert len(store) == 3
    want = extract(picture(2), SECTIONS["features"])
    np.testing.assert_array_equal(store.read(2).keypoints, want.keypoints)
    np.testing.assert_array_equal(store.read(2).descriptors, want.descriptors)
    np.testing.assert_array_equal(store.read(2).color, want.color)
    assert len(store.read(1)) == 0
    assert store.saliency(0) > 0.4
    assert store.saliency(1) == 0.0


def test_features_are_same_bytes_for_any_number_of_processes(made, tmp_path):
    one, two = run(made, tmp_path / "one"), run(made, tmp_path / "two", jobs=2)
    for name in (
        "keypoints_camera_top.npy",
        "descriptors_camera_top.npy",
        "color_camera_top.npy",
        "index.npz",
    ):
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_index_holds_rows_and_saliency_by_image(made, tmp_path):
    with np.load(run(made, tmp_path / "out") / "index.npz") as index:
        assert sorted(index.files) == ["camera_top_saliency", "camera_top_start"]


def test_a_camera_that_was_not_carried_leaves_no_files(made, tmp_path):
    assert not list(run(made, tmp_path / "out").glob("*camera_bottom*"))


def test_an_image_that_breaks_after_ingest_is_warned_of(made, tmp_path):
    bytes_ = bytearray((made / "images_camera_top.bin").read_bytes())
    bytes_[:200] = bytes(200)
    (made / "images_camera_top.bin").write_bytes(bytes_)
    out = run(made, tmp_path / "out")
    assert len(FeatureStore(out, Camera.TOP).read(0)) == 0
    assert "could not be read" in (out / "manifest.json").read_text()


def test_a_dive_without_a_single_feature_ends_with_advice(tmp_path):
    (tmp_path / "package").mkdir()
    black = ingest(tmp_path / "ingest", [np.zeros((64, 64, 3), np.uint8)], [True])
    with pytest.raises(StageError, match="no image has a feature"):
        run(black, tmp_path / "out")


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_leaves_the_bytes_of_one_process(made, tmp_path):
    distributed = pytest.importorskip("distributed")
    alone, out, hashes = run(made, tmp_path / "alone"), tmp_path / "out", HashCache()
    job = make_job(STAGE, SECTIONS, {"ingest": made}, made.parent / "package", hashes)
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as dask,
        choose_executor(scheduler=dask.scheduler_address) as executor,
    ):
        build(job, out, tmp_path / ".out", RunContext(hashes, executor, choose_progress()))
    names = sorted(path.name for path in alone.iterdir())
    assert [path.name for path in sorted(out.iterdir())] == names
    for name in set(names) - {"manifest.json"}:
        assert (out / name).read_bytes() == (alone / name).read_bytes()


def test_a_camera_that_logged_no_image_is_said_with_what_to_do(made, tmp_path):
    """Without the upper camera's images a lower one alone ended in a KeyError of the step links."""
    (made / "images_camera_top.npz").rename(made / "images_camera_bottom.npz")
    (made / "images_camera_top.bin").rename(made / "images_camera_bottom.bin")
    with pytest.raises(
        InputError, match=r"dive.toml has a camera.top, but no image of it was logged"
    ):
        run(made, tmp_path / "out")


def test_a_dive_without_camera_has_no_features():
    assert STAGE.applies({"camera.top.time_offset": None}, Path()) == "no camera was carried"
    assert STAGE.applies({"camera.top.time_offset": 0.0}, Path()) is None


def test_image_files_named_by_tables_are_external_inputs(tmp_path, monkeypatch):
    (tmp_path / "logs" / "left").mkdir(parents=True)
    for name in ("logs/left/b.JPG", "logs/left/a.png", "logs/left/other.png"):
        (tmp_path / name).write_text("")
    (tmp_path / "logs" / "camera_top.csv").write_text(
        "t,file\n1,left/b.JPG\n2,left/a.png\n3,left/gone.png\n"
    )
    settings = StageSettings("features", {"logs": Logs(files=("logs", "logs/dive.mcap"))})
    names = [Path("logs/left/a.png"), Path("logs/left/b.JPG")]
    assert STAGE.external(settings, tmp_path) == names
    monkeypatch.chdir(tmp_path.parent)
    # of a package given by a relative path, too
    assert STAGE.external(settings, Path(tmp_path.name)) == names
