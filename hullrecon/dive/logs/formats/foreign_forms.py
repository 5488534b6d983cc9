# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Name files that are no log of a dive, and say how to provide a log instead."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from hullrecon.dive.files import LFS_POINTER, LFS_WORDS
from hullrecon.dive.images.encoded import IMAGE_SUFFIXES
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.readers.water_linked import holds_reports

VIDEOS = (".mp4", ".mov", ".mkv", ".avi", ".ts", ".mpg")
TABLES = (
    "tables dvl.csv, imu.csv, pressure.csv, camera_top.csv, ... with the columns of "
    "docs/dive_package.md"
)
TO_PHOTOS = (
    "camera_top.csv with columns t (s since 1970) and file, and camera_bottom.csv for a second "
    "camera"
)
TO_VIDEOS = f"{TO_PHOTOS} (a row names the video and, in a column frame, its frame from 0)"
TO_TABLES = f"write {TABLES}"
TO_MCAP = f"convert it to MCAP, or {TO_TABLES}"
PACKED = "packed by gzip"
PAGES = (b"<!doctype", b"<html", b"<?xml")  # begin what a server sends in a file's place
MESHES = (".stl", ".ply", ".obj", ".off", ".glb")
BY_MAGIC: tuple[tuple[bytes, str, str], ...] = (
    (LFS_POINTER, *LFS_WORDS),
    (
        b"SO",
        "pings of an Oculus sonar without the time of day",
        "name file and ping in sonar.csv, with columns t, file, ping",
    ),
    (
        b"RIP",
        "a recording of a 3-D sonar (Water Linked Sonar 3D-15)",
        "3-D sonars are not read; give DVL and IMU, or cameras",
    ),
    (
        b"DDF",
        "a recording of a DIDSON, which states neither ranges in metres nor where its beams point",
        "name file and frame in sonar.csv, with columns t, file, ping, range_from, range_to, and "
        "give sonar.beam_azimuth_deg",
    ),
    (b"\xa3\x95", "a data-flash log of ArduPilot", TO_MCAP),
    (
        b"\xa5\x0a",
        "a file of another instrument of Nortek",
        f"have its DVL write PD0, log it as nortek_dvl/Dvl or {TO_TABLES}",
    ),
    (b"\x1f\x8b", PACKED, "where it is the log, unpack it first (gunzip)"),
    (b"7z\xbc\xaf", "a packed archive", "unpack it first"),
    (b"ULog", "a log of PX4", TO_MCAP),
    (b"PAR1", "a table of Parquet", f"write its sensors as {TABLES}"),
    (b":SA", "the text that a DVL of Teledyne sends (PD6)", f"have it write PD0, or {TO_TABLES}"),
    *(
        (
            command,
            "the serial protocol of a Water Linked DVL",
            f"log the JSON that it sends over TCP, or {TO_TABLES}",
        )
        for command in (b"wrz,", b"wrx,", b"wru,")
    ),
    *((talker, "NMEA sentences", TO_TABLES) for talker in (b"$P", b"$D", b"$G", b"$S", b"$V")),
    (b"\x89HDF", "an HDF5 or NetCDF file", f"write its sensors as {TABLES}"),
)
BY_SUFFIX = {
    ".tlog": ("a telemetry log of ArduPilot", TO_MCAP),
    ".svlog": ("a log of SonarView", TO_MCAP),
    ".npz": ("an archive of NumPy arrays", f"write its sensors as {TABLES}"),
    ".mat": ("a file of MATLAB", f"write {TABLES}"),
    **dict.fromkeys((".zip", ".tar", ".tgz"), ("a packed archive", "unpack it first")),
    ".csv": ("one table", f"give its folder, with {TABLES}"),
    ".xtf": ("a side-scan recording", "side scans are not read"),
    ".jsf": ("a side-scan recording", "side scans are not read"),
}


def describe_file(path: Path, start: bytes) -> tuple[str, str]:
    """Name what a file is and what to do with it, for the error that refuses it as a log.

    Both follow from its first bytes, else from its name. Two empty texts where that is not known.
    start: those first bytes.
    """
    suffix = path.suffix.lower()
    if suffix in IMAGE_SUFFIXES:
        return "a photo", f"give the folder that holds it, with {TO_PHOTOS}"
    if suffix in VIDEOS:
        return "a video", f"give the folder that holds it, with {TO_VIDEOS}"
    if holds_reports(start):
        is_list = start.lstrip().startswith(b"[")
        what = "'.[]'" if is_list else "."
        return (
            "reports of a Water Linked DVL, but not one a line as it sends them",
            f"`jq -c {what} OLD > NEW.json` puts them so",
        )
    if is_page(start):
        return "a page of the web or XML", "fetch the file itself"
    if path.name.lower().endswith((".tar.gz", ".tgz")):
        return BY_SUFFIX[".tar"]
    known = [(what, remedy) for magic, what, remedy in BY_MAGIC if start.startswith(magic)]
    return (known or [BY_SUFFIX.get(suffix, ("", ""))])[0]


def is_page(start: bytes) -> bool:
    """Tell whether a file begins as a page of the web, which was saved in the place of a log."""
    return start.lstrip().lower().startswith(PAGES)


def describe_pictures(names: Iterable[str]) -> tuple[str, str]:
    """Name photos or videos that no table names, and say what to do with them.

    Both follow from the names of files. Two empty texts where there are none.
    """
    suffixes = Counter(Path(name.lower()).suffix for name in names)
    photos = sum(suffixes[suffix] for suffix in IMAGE_SUFFIXES)
    if any(suffixes[suffix] for suffix in VIDEOS):
        return "videos without times", f"put beside them {TO_VIDEOS}"
    return (
        (f"{photos} photos without times", f"put beside them {TO_PHOTOS}")
        if photos > 1
        else ("", "")
    )


def describe_folder(names: Iterable[str]) -> tuple[str, str]:
    """Name what a folder without a log holds and what to do with it, for the error that refuses it.

    Both follow from the names of its files. Two empty texts where that is not known.
    """
    names = sorted(names)
    pictures = describe_pictures(names)
    if pictures[0]:
        return pictures
    suffixes = Counter(Path(name.lower().removesuffix(".gz")).suffix for name in names)
    tables = [name for name in names if name.lower().endswith((".csv", ".csv.gz"))]
    if tables:
        shown = printable(", ".join(tables[:3])) + (", ..." if len(tables) > 3 else "")
        return f"tables of other names ({shown})", f"rename or rewrite them (unpacked) as {TABLES}"
    found = [BY_SUFFIX[suffix] for suffix in suffixes if suffix in BY_SUFFIX]
    meshes = [name for name in names if Path(name.lower().removesuffix(".gz")).suffix in MESHES]
    if meshes and not found:
        shown = printable(", ".join(meshes[:3])) + (", ..." if len(meshes) > 3 else "")
        return (
            f"CAD models alone ({shown})",
            "give the folder of a dive: its log, and the CAD model beside it",
        )
    return found[0] if found else ("", "")
