# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The log as a folder of CSV files, for anyone without ROS."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.synthetic.sensors import sonar
from hullrecon.synthetic.sensors.recorder import Streams, stamp_ns
from hullrecon.typing import Array


def write_plain(folder: Path, streams: Streams) -> None:
    """Write dvl.csv, imu.csv, pressure.csv, joints.csv, camera_*.csv and sonar.csv, with images."""
    ranges = [f"range_{k + 1}" for k in range(4)]
    dvl = np.hstack([streams.dvl.velocity, streams.dvl.ranges])
    write_table(folder / "dvl.csv", ["vx", "vy", "vz", *ranges], streams.dvl.t_s, dvl)
    imu = np.hstack([streams.imu.quaternion, streams.imu.rates, streams.imu.force])
    write_table(
        folder / "imu.csv",
        ["qx", "qy", "qz", "qw", "wx", "wy", "wz", "ax", "ay", "az"],
        streams.imu.t_s,
        imu,
    )
    write_table(
        folder / "pressure.csv",
        ["pascal"],
        streams.pressure.t_s,
        streams.pressure.value[:, None],
        "%.2f",
    )
    if len(streams.positions.t_s):
        write_table(
            folder / "position.csv",
            ["x", "y", "z"],
            streams.positions.t_s,
            streams.positions.value,
            "%.4f",
        )
    _joints(folder / "joints.csv", streams)
    _images(folder, streams)
    _pings(folder, streams)


def seconds(t_s: Array) -> list[str]:
    """Format seconds since 1970 with all nine digits, which a float64 would not hold."""
    return [f"{ns // 10**9}.{ns % 10**9:09d}" for ns in stamp_ns(t_s).tolist()]


def write_table(
    path: Path, names: list[str], t_s: Array, values: Array, form: str = "%.9f"
) -> None:
    """Write a CSV with a column t; NaN is left empty."""
    lines = [",".join(["t", *names])]
    for stamp, row in zip(seconds(t_s), values.tolist(), strict=True):
        lines.append(",".join([stamp, *("" if v != v else form % v for v in row)]))
    path.write_text("\n".join(lines) + "\n")


def _joints(path: Path, streams: Streams) -> None:
    lines = ["t,name,rad"]
    for stamp, row in zip(seconds(streams.joints.t_s), streams.joints.value.tolist(), strict=True):
        lines += [
            f"{stamp},{name},{angle:.9f}"
            for name, angle in zip(("tray", "sonar_tray"), row, strict=True)
        ]
    path.write_text("\n".join(lines) + "\n")


def _images(folder: Path, streams: Streams) -> None:
    """Write the images of all cameras frame by frame, then a table for each camera."""
    for camera in streams.cameras:
        (folder / camera).mkdir(exist_ok=True)
    stamps = seconds(streams.frame_s) if streams.cameras else []
    for k in range(len(stamps)):
        for camera, jpeg in zip(streams.cameras, streams.frames[k], strict=True):
            (folder / camera / f"{k:06d}.jpg").write_bytes(jpeg)
    for camera in streams.cameras:
        rows = [f"{stamp},{camera}/{k:06d}.jpg" for k, stamp in enumerate(stamps)]
        (folder / f"{camera}.csv").write_text("\n".join(["t,file", *rows]) + "\n")


def _pings(folder: Path, streams: Streams) -> None:
    if not len(streams.ping_s):
        return
    (folder / "sonar").mkdir(exist_ok=True)
    lines = ["t,file"]
    for k, stamp in enumerate(seconds(streams.ping_s)):
        _write_npz(
            folder / "sonar" / f"{k:06d}.npz",
            {"image": streams.pings[k], "azimuth": sonar.AZIMUTH, "range": sonar.RANGE},
        )
        lines.append(f"{stamp},sonar/{k:06d}.npz")
    (folder / "sonar.csv").write_text("\n".join(lines) + "\n")


def _write_npz(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write as numpy.savez_compressed, with fixed dates: the same dive gives the same bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(
                zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)),
                buffer.getvalue(),
                zipfile.ZIP_DEFLATED,
            )
