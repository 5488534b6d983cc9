# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from hullrecon.dive.config.schema import DiveConfig
from hullrecon.errors import StorageError
from hullrecon.synthetic import package as package_module
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import DiveSpec, spec_from, with_options
from hullrecon.synthetic.package import write_package


def test_package_holds_what_format_names(package: Path) -> None:
    found = {p.relative_to(package).as_posix() for p in package.rglob("*") if p.is_file()}
    truth = {
        "poses.csv",
        "alignment.json",
        "servo.csv",
        "sonar_servo.csv",
        "as_built.ply",
        "objects.json",
        "extrinsics.json",
    }
    assert found == {
        "dive.toml",
        "hull.stl",
        "logs/dive.mcap",
        "calibration/camera_top.yaml",
        "calibration/camera_bottom.yaml",
        *(f"truth/{name}" for name in truth),
    }


def test_plain_package_names_its_folder_and_its_beams(tmp_path: Path) -> None:
    spec = spec_from(
        legs=1, leg_length_m=0.8, structures=0, marks=0, barnacles=0, cameras="none", form="plain"
    )
    write_package(tmp_path / "plain", spec)
    config = msgspec.convert(
        tomllib.loads((tmp_path / "plain" / "dive.toml").read_text()), DiveConfig
    )
    assert config.logs.files == ("logs",)
    assert config.dvl.beams is not None
    np.testing.assert_allclose(np.linalg.norm(config.dvl.beams, axis=1), 1)
    names = {p.name for p in (tmp_path / "plain" / "logs").iterdir()}
    assert names == {"dvl.csv", "imu.csv", "pressure.csv", "joints.csv", "sonar.csv", "sonar"}


TINY = spec_from(
    legs=1,
    leg_length_m=0.7,
    structures=1,
    marks=0,
    barnacles=0,
    image_width=160,
    image_height=128,
    views=1.0,
)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A package written into an empty folder, and the progress that was shown."""
    shown: list[tuple[str, int, int]] = []

    def track(items: Iterator[bytes], label: str, total: int) -> Iterator[bytes]:
        for k, item in enumerate(items):
            shown.append((label, k + 1, total))
            yield item

    folder = tmp_path_factory.mktemp("tiny")
    return SimpleNamespace(folder=folder, dive=write_package(folder, TINY, track), shown=shown)


def test_same_seed_gives_same_bytes_another_seed_others(
    tiny: SimpleNamespace, tmp_path: Path
) -> None:
    write_package(tmp_path / "again", TINY)
    write_package(tmp_path / "other", with_options(TINY, seed=2))
    files = [p.relative_to(tiny.folder) for p in tiny.folder.rglob("*") if p.is_file()]
    kept = {f: (tiny.folder / f).read_bytes() for f in files}
    assert all((tmp_path / "again" / f).read_bytes() == kept[f] for f in files)
    differ = {f.as_posix() for f in files if (tmp_path / "other" / f).read_bytes() != kept[f]}
    assert {"logs/dive.mcap", "truth/poses.csv", "truth/as_built.ply", "dive.toml"} <= differ


def test_empty_folder_is_filled(tiny: SimpleNamespace) -> None:
    assert (tiny.folder / "dive.toml").exists()


def test_progress_counts_every_image_while_written(tiny: SimpleNamespace) -> None:
    images = 2 * len(tiny.dive.frame_s)
    assert tiny.shown == [("images written", k + 1, images) for k in range(images)]


def test_folder_with_something_in_it_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"):
        write_package(tmp_path, DiveSpec())
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_file_in_way_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(StorageError, match="taken"):
        write_package(tmp_path / "taken" / "dive", DiveSpec())


@pytest.mark.parametrize(
    "error",
    [KeyboardInterrupt, StorageError("the disk is full"), OSError(28, "No space left on device")],
)
def test_failed_or_interrupted_simulation_leaves_nothing(
    dive: Dive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(package_module, "simulate_dive", lambda _: dive)
    monkeypatch.setattr(package_module, "write_mcap", lambda path, _: path.touch())
    with monkeypatch.context() as broken:
        broken.setattr(package_module, "write_truth", fail)
        with pytest.raises((KeyboardInterrupt, StorageError)):
            write_package(tmp_path / "dive", dive.spec)
    assert list(tmp_path.iterdir()) == []
    write_package(tmp_path / "dive", dive.spec)
    assert [p.name for p in tmp_path.iterdir()] == ["dive"]
