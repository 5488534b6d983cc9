# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.synthetic import sonar
from hullrecon.synthetic.instruments import Dvl, Imu, Series
from hullrecon.synthetic.logs import write_plain
from hullrecon.synthetic.recorder import START_NS, InTurn, Streams


def made() -> Streams:
    """Two readings of each sensor; the second beam of the first ping is lost."""
    t = np.array([0.25, 0.450000001])
    ranges = np.array([[1.1, np.nan, 1.3, 1.4], [1.5, 1.6, 1.7, 1.8]])
    return Streams(
        dvl=Dvl(t_s=t, velocity=np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]), ranges=ranges),
        imu=Imu(
            t_s=t,
            quaternion=np.tile([0.0, 0, 0, 1], (2, 1)),
            rates=np.zeros((2, 3)),
            force=np.tile([0.0, 0, -9.81], (2, 1)),
        ),
        pressure=Series(t, np.array([120000.0, 120001.5])),
        joints=Series(t, np.array([[0.1, -0.6], [0.2, -0.5]])),
        cameras=("camera_top",),
        frame_s=t,
        frames=InTurn(iter([(b"first",), (b"second",)])),
        ping_s=t[:1],
        pings=InTurn(iter([np.full((96, 256), 7, np.uint8)])),
    )


@pytest.fixture
def streams() -> Streams:
    return made()


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_lost_beam_is_left_empty(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    first, second = rows(tmp_path / "dvl.csv")
    assert first["range_2"] == ""
    assert float(first["range_1"]) == 1.1
    assert float(second["range_2"]) == 1.6
    assert float(second["vz"]) == 0.6


def test_positions_are_written_where_there_are_some(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    assert not (tmp_path / "position.csv").exists()
    place = Series(np.array([0.5]), np.array([[12.34567, -8.0, -1.5]]))
    write_plain(tmp_path, replace(made(), positions=place))
    assert rows(tmp_path / "position.csv") == [
        {"t": "1777887000.500000000", "x": "12.3457", "y": "-8.0000", "z": "-1.5000"}
    ]


def test_times_keep_their_nanoseconds(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    assert [r["t"] for r in rows(tmp_path / "pressure.csv")] == [
        f"{START_NS // 10**9}.250000000",
        f"{START_NS // 10**9}.450000001",
    ]


def test_joints_have_row_each(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    found = [(r["name"], float(r["rad"])) for r in rows(tmp_path / "joints.csv")]
    assert found == [("tray", 0.1), ("sonar_tray", -0.6), ("tray", 0.2), ("sonar_tray", -0.5)]


def test_images_are_files_that_table_names(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    named = [r["file"] for r in rows(tmp_path / "camera_top.csv")]
    assert [(tmp_path / name).read_bytes() for name in named] == [b"first", b"second"]
    assert not (tmp_path / "camera_bottom.csv").exists()


def test_ping_is_npz_with_image_azimuth_and_range(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    (row,) = rows(tmp_path / "sonar.csv")
    with np.load(tmp_path / row["file"]) as ping:
        assert ping["image"].shape == (96, 256)
        assert (ping["image"] == 7).all()
        np.testing.assert_allclose(ping["azimuth"], sonar.AZIMUTH)
        np.testing.assert_allclose(ping["range"], sonar.RANGE)


def test_imu_has_columns_of_format(streams: Streams, tmp_path: Path) -> None:
    write_plain(tmp_path, streams)
    assert list(rows(tmp_path / "imu.csv")[0]) == [
        "t",
        "qx",
        "qy",
        "qz",
        "qw",
        "wx",
        "wy",
        "wz",
        "ax",
        "ay",
        "az",
    ]


def test_same_streams_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        write_plain(tmp_path / name, made())
    files = sorted(
        p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*") if p.is_file()
    )
    assert len(files) == 9
    assert all(
        (tmp_path / "one" / f).read_bytes() == (tmp_path / "two" / f).read_bytes() for f in files
    )
