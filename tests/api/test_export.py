# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""export colmap over a small run made by hand: what is written, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hullrecon_cli.main import main

from hullrecon.adjustment.results.colmap_export import SparseModel, write_model
from hullrecon.api.export import export_colmap
from hullrecon.artifacts.documents import seal
from hullrecon.artifacts.manifest import Manifest, Recipe, write_manifest
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import InputError, StorageError
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.tracks import Tracks

CAMERA = CameraModel(160, 128, 150.0, 151.0, 82.0, 60.0, 0.2, 0.05, 0.001, -0.001)
STAMPS = np.array(
    [[1_700_000_000_000_000_000, 1_700_000_000_000_000_000], [1_700_000_000_500_000_000, -1]]
)
COLOURS = {"camera_top": (200, 40, 40), "camera_bottom": (40, 40, 200)}


def write_images(ingest: Path, camera: str, stamps: np.ndarray) -> None:
    """Images of one colour; the first of the log is unusable and has the stamp of the second."""
    _, jpeg = cv2.imencode(".jpg", np.full((128, 160, 3), COLOURS[camera][::-1], np.uint8))
    (ingest / f"images_{camera}.bin").write_bytes(jpeg.tobytes())
    t_ns = np.r_[stamps[0], stamps]
    index = ImageIndex(
        t_ns=t_ns,
        file=np.full(len(t_ns), "", "U1"),
        offset=np.zeros(len(t_ns), np.int64),
        size=np.full(len(t_ns), len(jpeg)),
        usable=np.r_[False, np.ones(len(stamps), bool)],
    )
    ArtifactWriter(ingest).arrays(f"images_{camera}.npz", to_arrays(index))


def write_colmap(folder: Path) -> None:
    """Two nodes above a plane, the second without a bottom image, and 60 landmarks that all three
    images see.
    """
    rng = np.random.default_rng(1)
    points = np.c_[rng.uniform(-0.4, 0.5, 60), rng.uniform(-0.3, 0.3, 60), np.ones(60)]
    top = poses.from_rpy(np.array([[0, 0, 0], [0.1, 0, 0]]), np.zeros((2, 3)))
    beside = poses.from_mount([0.0, 0.05, 0, 0, 0, 0])
    node, landmark = np.repeat([0, 1], 60), np.tile(np.arange(60), 2)
    seen = CAMERA.project(top.inverse()[node].apply(points[landmark]))
    below = CAMERA.project((top @ beside).inverse()[node].apply(points[landmark]))
    folder.mkdir(parents=True)
    tracks = Tracks(
        landmark=landmark,
        node=node,
        top=seen,
        bottom=below,
        response=np.ones(120),
        color=np.full((60, 3), 90, np.uint8),
    )
    model = SparseModel(
        tracks=tracks, top=np.ones(120, bool), bottom=node == 0, hull_from_top=top,
        top_from_bottom=beside,
        cameras=(CAMERA, CAMERA), stamps=STAMPS, position=points,
    )  # fmt: skip
    write_model(model, folder)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = tmp_path / "runs" / "may"
    (folder / ".hullrecon").mkdir(parents=True)
    (folder / ".hullrecon" / "workspace.json").write_bytes(
        seal({"package": str(tmp_path / "package")})
    )
    write_colmap(folder / "adjust" / "colmap")
    (folder / "ingest").mkdir()
    write_images(folder / "ingest", "camera_top", STAMPS[:, 0])
    write_images(folder / "ingest", "camera_bottom", STAMPS[:1, 1])
    for name in ("ingest", "adjust"):
        recipe = Recipe(stage=name, version=1, settings={}, inputs={})
        write_manifest(folder / name, Manifest(recipe=recipe, key="k", outputs={}))
    return folder


def test_images_and_model_are_of_one_size_and_name(run: Path, tmp_path: Path) -> None:
    import pycolmap

    made = export_colmap(run, tmp_path / "out")
    for sparse in ("sparse", "sparse/0"):
        model = pycolmap.Reconstruction(str(tmp_path / "out" / sparse))
        assert (model.num_images(), model.num_points3D()) == (made.images, made.points)
        for image in model.images.values():
            pixels = cv2.imread(str(tmp_path / "out" / "images" / image.name))
            camera = model.cameras[image.camera_id]
            assert pixels.shape == (camera.height, camera.width, 3)
            assert (camera.principal_point_x, camera.principal_point_y) == (
                camera.width / 2,
                camera.height / 2,
            )
    assert made.images == 3
    assert made.lost_observations + made.observations == 180
    assert made.lost_observations > 0


def test_each_image_is_that_of_its_camera_and_no_unusable_one(run: Path, tmp_path: Path) -> None:
    export_colmap(run, tmp_path / "out")
    for path in (tmp_path / "out" / "images").iterdir():
        mean = cv2.imread(str(path)).reshape(-1, 3).mean(axis=0)[::-1]
        assert path.name.endswith(".jpg")
        np.testing.assert_allclose(mean, COLOURS[path.name.rsplit("_", 1)[0]], atol=3)


def test_colmaps_stereo_finds_its_lists_and_folders(run: Path, tmp_path: Path) -> None:
    export_colmap(run, tmp_path / "out")
    names = sorted(p.name for p in (tmp_path / "out" / "images").iterdir())
    stereo = tmp_path / "out" / "stereo"
    assert (stereo / "fusion.cfg").read_text().splitlines() == names
    assert (stereo / "patch-match.cfg").read_text().splitlines()[::2] == names
    assert all(
        (stereo / name).is_dir() for name in ("depth_maps", "normal_maps", "consistency_graphs")
    )


def test_worker_processes_write_the_same_bytes(run: Path, tmp_path: Path) -> None:
    export_colmap(run, tmp_path / "one")
    export_colmap(run, tmp_path / "two", jobs=2)
    files = {p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*") if p.is_file()}
    assert files == {
        p.relative_to(tmp_path / "two") for p in (tmp_path / "two").rglob("*") if p.is_file()
    }
    assert all(
        (tmp_path / "one" / f).read_bytes() == (tmp_path / "two" / f).read_bytes() for f in files
    )


def test_a_run_without_a_camera_has_nothing_to_export(run: Path, tmp_path: Path) -> None:
    for file in (run / "adjust" / "colmap").iterdir():
        file.unlink()
    (run / "adjust" / "colmap").rmdir()
    with pytest.raises(InputError, match="no camera was carried"):
        export_colmap(run, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_with_something_in_it_is_left_alone(run: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"):
        export_colmap(run, tmp_path / "out")
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["mine.txt"]


def test_an_image_that_is_gone_leaves_no_folder(run: Path, tmp_path: Path) -> None:
    images = run / "ingest" / "images_camera_bottom.bin"
    whole = images.read_bytes()
    images.write_bytes(b"no image")
    with pytest.raises(InputError, match="camera_bottom does not decode"):
        export_colmap(run, tmp_path / "out")
    assert not any(p.name.startswith((".out", "out")) for p in tmp_path.iterdir())
    images.write_bytes(whole)  # as the run leaves it again
    export_colmap(run, tmp_path / "out")


@pytest.mark.parametrize(
    ("target", "code", "words"), [("nothing", 3, "this is no run"), ("runs/may", 0, "")]
)
def test_the_command_ends_in_one_line(
    run: Path,
    tmp_path: Path,
    target: str,
    code: int,
    words: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["export", "colmap", str(tmp_path / target), str(tmp_path / "out")]) == code
    seen = capsys.readouterr()
    assert len((seen.err if code else seen.out).strip().splitlines()) == 1
    assert words in seen.err


def test_the_command_prints_one_document_with_json(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", "colmap", str(run), str(tmp_path / "out"), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["images"] == 3
    assert document["folder"] == str(tmp_path / "out")


def test_an_unknown_form_is_a_usage_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "e57", "run", "out"]) == 2
    assert "No such command 'e57'" in capsys.readouterr().err
