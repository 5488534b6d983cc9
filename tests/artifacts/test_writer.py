# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.writer: what a stage writes, the same bytes for the same content."""

from __future__ import annotations

import errno
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from hullrecon.artifacts.stage import load_arrays
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import StorageError


@pytest.fixture
def out(tmp_path: Path) -> ArtifactWriter:
    return ArtifactWriter(tmp_path)


def test_arrays_come_back_with_name_type_and_shape(out: ArtifactWriter, tmp_path: Path) -> None:
    given = {
        "t_ns": np.array([1, 2**62]),
        "scalar": np.array(3.5),
        "none": np.zeros((0, 3)),
        "text": np.array(["a", "ü"]),
    }
    out.arrays("a.npz", given)
    read = load_arrays(tmp_path / "a.npz")
    assert read.keys() == given.keys()
    for name, array in given.items():
        np.testing.assert_array_equal(read[name], array)
        assert (read[name].dtype, read[name].shape) == (array.dtype, array.shape)


@settings(
    max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None
)
@given(
    array=arrays_of.arrays(
        st.sampled_from(["f8", "f4", "i8", "u1", "?"]),
        arrays_of.array_shapes(min_dims=0, max_side=4),
    )
)
def test_any_array_comes_back_bit_for_bit(
    out: ArtifactWriter, tmp_path: Path, array: np.ndarray
) -> None:
    out.arrays("a.npz", {"x": array})
    read = load_arrays(tmp_path / "a.npz")["x"]
    assert (read.dtype, read.shape, read.tobytes()) == (array.dtype, array.shape, array.tobytes())


def test_the_same_arrays_give_the_same_bytes_in_another_order(
    out: ArtifactWriter, tmp_path: Path
) -> None:
    x, y = np.arange(6.0).reshape(2, 3), np.eye(2)
    out.arrays("a.npz", {"x": x, "y": y})
    out.arrays("b.npz", {"y": y, "x": np.asfortranarray(x)})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_no_clock_shows_in_an_archive(out: ArtifactWriter, tmp_path: Path) -> None:
    out.arrays("a.npz", {"x": np.eye(2)})
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        assert {member.date_time for member in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_an_array_of_objects_is_refused_and_leaves_nothing(
    out: ArtifactWriter, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="Object arrays"):
        out.arrays("a.npz", {"x": np.array([{}, None])})
    assert not list(tmp_path.iterdir())


def test_json_names_the_file_and_the_place_of_a_nan(out: ArtifactWriter, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^objects.json: not a finite number at sigma$"):
        out.json("objects.json", {"sigma": float("nan")})
    assert not list(tmp_path.iterdir())


def test_text_bytes_and_paths_land_in_subfolders(out: ArtifactWriter, tmp_path: Path) -> None:
    out.text("deliver/a.csv", "t,x\n")
    out.bytes("deliver/b.bin", b"\x00")
    out.json("deliver/c.json", {"a": 1})
    with out.path("deliver/plots/d.png") as path:
        path.write_bytes(b"png")
    assert sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.*")) == [
        "deliver/a.csv", "deliver/b.bin", "deliver/c.json", "deliver/plots/d.png",
    ]  # fmt: skip
    assert json.loads((tmp_path / "deliver/c.json").read_text()) == {"a": 1}


@pytest.mark.parametrize("name", ["../outside", "/etc/passwd", "a/../../b", "", "manifest.json"])
def test_a_name_outside_the_artifact_is_refused(name: str, out: ArtifactWriter) -> None:
    with pytest.raises(ValueError, match="no name for a file"):
        out.text(name, "x")


def test_a_scratch_file_is_written_read_and_leaves_nothing(
    out: ArtifactWriter, tmp_path: Path
) -> None:
    with out.scratch() as file:
        file.write(b"abc")
        file.seek(0)
        assert file.read() == b"abc"
    assert list(tmp_path.iterdir()) == []


def test_a_scratch_file_on_a_full_disk_is_said_so(out: ArtifactWriter) -> None:
    with pytest.raises(StorageError, match="cannot write"), out.scratch():
        raise OSError(errno.ENOSPC, "No space left on device")
