# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The formats that are damaged, each with some sound inputs, all made here."""

from __future__ import annotations

import gzip
import io
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

from benchmarks.fuzz import seed_ad2cp, seed_aris, seed_files, seed_messages, seed_view_point
from benchmarks.fuzz.readings import CALIBRATION


@dataclass(frozen=True, kw_only=True)
class Seed:
    """A sound input. read: its reader, by name; files: by path in the folder that is read; target:
    the one that is damaged; given: what the reader is given, when that is not the target;
    checksummed: whether every change of its data must be noticed, unless the checksum is blind to
    it; finish: what is done to the damaged bytes before they are read.
    """

    read: str
    files: dict[str, bytes]
    target: str
    given: str = ""
    checksummed: bool = False
    text: bool = False
    blind: Callable[[bytes], bool] = field(default=lambda data: False)
    finish: Callable[[bytes], bytes] = field(default=bytes)

    @property
    def name(self) -> str:
        return self.given or self.target


@cache
def seeds() -> dict[str, tuple[Seed, ...]]:
    """Return sound inputs by format."""
    return {
        "mcap": _mcap(),
        "bag": _bag(),
        "rosbag2": _rosbag2(),
        "pd0": _pd0(),
        "ad2cp": _ad2cp(),
        "aris": _aris(),
        "view_point": _view_point(),
        "reports": _reports(),
        "plain": _plain(),
        "npz": _npz(),
        "oculus": _oculus(),
        "didson": _didson(),
        "toml": _toml(),
        "yaml": _yaml(),
        "hull": _hull(),
        "hull-gz": _hull_gz(),
        "image": _image(),
        "init": _init(),
    }


def _log(name: str, data: bytes, **more: object) -> Seed:
    files = {name: data, CALIBRATION: seed_files.SHORT_CALIBRATION.encode()}
    return Seed(read="log", files=files, target=name, **more)  # type: ignore[arg-type]


def _mcap() -> tuple[Seed, ...]:
    entries = seed_messages.tiny_dive(2, seed_files.images()["a.jpg"])
    packed = [seed_messages.as_mcap(entries, how) for how in ("zstd", "lz4", "none")]
    loose = seed_messages.as_mcap(entries, "none", use_chunking=False, enable_data_crcs=True)
    bare = seed_messages.as_mcap(entries, "none", enable_crcs=False)
    cut = packed[0][: int(0.7 * len(packed[0]))]
    return (
        *(_log("dive.mcap", data, checksummed=True) for data in (*packed, cut, loose)),
        _log("dive.mcap", bare),
    )


def _bag() -> tuple[Seed, ...]:
    entries = seed_messages.tiny_dive(1, seed_files.images()["a.jpg"])
    return tuple(
        _log("dive.bag", seed_messages.as_bag(entries, how))
        for how in ("none", "none", "lz4", "bz2")
    )


def _rosbag2() -> tuple[Seed, ...]:
    entries = seed_messages.tiny_dive(2, seed_files.images()["a.jpg"])
    out = []
    for storage, targets in (
        ("SQLITE3", ("dive.db3", "dive.db3", "metadata.yaml")),
        ("MCAP", ("metadata.yaml",)),
    ):
        files = {
            f"dive/{name}": data
            for name, data in seed_messages.as_ros2_folder(entries, storage).items()
        }
        files[CALIBRATION] = seed_files.SHORT_CALIBRATION.encode()
        for name in targets:
            text = name.endswith("yaml")
            out.append(
                Seed(read="log", files=files, target=f"dive/{name}", given="dive", text=text)
            )
    return tuple(out)


def _pd0() -> tuple[Seed, ...]:
    data = seed_files.pd0()
    return _log("dive.pd0", data, checksummed=True, blind=sums_are_right), _log(
        "dive.pd0", data, finish=with_right_sums
    )


def _ad2cp() -> tuple[Seed, ...]:
    files = [seed_ad2cp.dvl_file(), *(seed_ad2cp.signature_file(code) for code in range(3))]
    return (
        *(_log("dvl.ad2cp", data, checksummed=True, blind=word_sums_are_right) for data in files),
        *(_log("dvl.ad2cp", data, finish=with_right_word_sums) for data in files),
    )


def _aris() -> tuple[Seed, ...]:
    files = (seed_aris.aris_file(), seed_aris.aris_file(6, mode=9, samples=5, speed=1450.0))
    return tuple(_log("sonar.aris", data) for data in files)


def _view_point() -> tuple[Seed, ...]:
    files = (seed_view_point.oculus_file(), seed_view_point.oculus_file(6, compression=1))
    return tuple(_log("sonar.oculus", data) for data in files)


def word_sums_are_right(data: bytes) -> bool:
    """Verify the checksums of AD2CP blocks: two values that change places
    leave them as they are.
    """
    return with_right_word_sums(data) == data


def with_right_word_sums(data: bytes) -> bytes:
    """Return AD2CP blocks with the checksums that their bytes ask for, so that damage gets past
    them.
    """
    out, at = bytearray(data), 0
    while (at := out.find(0xA5, at)) >= 0:
        size = out[at + 1] if at + 12 <= len(out) else 0
        end = at + size + int.from_bytes(out[at + 4 : at + size - 4], "little")
        if size not in (10, 12) or out[at + 3] != 0x10 or end > len(out):
            at += 1
            continue
        out[at + size - 4 : at + size - 2] = seed_ad2cp.word_sum(
            bytes(out[at + size : end])
        ).to_bytes(2, "little")
        out[at + size - 2 : at + size] = seed_ad2cp.word_sum(
            bytes(out[at : at + size - 2])
        ).to_bytes(2, "little")
        at = end
    return bytes(out)


def _reports() -> tuple[Seed, ...]:
    return (_log("dvl.json", seed_files.reports().encode(), text=True),)


def sums_are_right(data: bytes) -> bool:
    """Verify the checksum of every ensemble: a plain sum, which bytes that change places
    leave as it is.
    """
    return with_right_sums(data) == data


def with_right_sums(data: bytes) -> bytes:
    """Return PD0 ensembles with the checksums that their bytes ask for, so that damage gets past
    them.
    """
    out, at = bytearray(data), 0
    while (at := out.find(b"\x7f\x7f", at)) >= 0:
        end = at + int.from_bytes(out[at + 2 : at + 4], "little")
        if end + 2 > len(out) or end < at + 4:
            at += 1
            continue
        out[end : end + 2] = (sum(out[at:end]) % 65536).to_bytes(2, "little")
        at = end + 2
    return bytes(out)


def _tables() -> dict[str, bytes]:
    pictures = seed_files.images()
    files = {f"logs/{name}.csv": text.encode() for name, text in seed_files.TABLES.items()}
    files |= {
        "logs/a.png": pictures["a.png"],
        "logs/b.png": pictures["a.bmp"],
        "logs/p.npz": seed_files.ping_npz(),
    }
    return files | {CALIBRATION: seed_files.SHORT_CALIBRATION.encode()}


def _plain() -> tuple[Seed, ...]:
    files = _tables()
    targets = [f"logs/{name}.csv" for name in seed_files.TABLES]
    return tuple(
        Seed(read="log", files=files, target=name, given="logs", text=True) for name in targets
    )


def _npz() -> tuple[Seed, ...]:
    files = {name: data for name, data in _tables().items() if not name.endswith("camera_top.csv")}

    def ping(data: bytes, **more: object) -> Seed:
        return Seed(
            read="log",
            files={**files, "logs/p.npz": data},
            target="logs/p.npz",
            given="logs",
            **more,
        )  # type: ignore[arg-type]

    whole = (ping(seed_files.ping_npz(seed), checksummed=True) for seed in (0, 1))
    return (*whole, ping(seed_files.ping_npy(), finish=zip_ping))


def zip_ping(image: bytes) -> bytes:
    """Return a sonar ping whose image is given as the bytes of an .npy, with the checksum that
    those bytes ask for.
    """
    file = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(seed_files.ping_npz())) as whole,
        zipfile.ZipFile(file, "w") as out,
    ):
        for name in whole.namelist():
            out.writestr(zipfile.ZipInfo(name), image if name == "image.npy" else whole.read(name))
    return file.getvalue()


def _oculus() -> tuple[Seed, ...]:
    files = {**_tables(), "logs/p.npz": 2 * seed_files.oculus_ping()}
    files["logs/sonar.csv"] = b"t,file,ping\n1700000000,p.npz,0\n1700000001,p.npz,1\n"
    return (Seed(read="log", files=files, target="logs/p.npz", given="logs"),)


def _didson() -> tuple[Seed, ...]:
    files = {name: data for name, data in _tables().items() if name != "logs/p.npz"}
    rows = "".join(f"{1_700_000_000 + n},p.ddf,{n},1,6\n" for n in range(2))
    files["logs/sonar.csv"] = f"t,file,ping,range_from,range_to\n{rows}".encode()
    whole = ({**files, "logs/p.ddf": seed_aris.didson_file(version)} for version in (3, 4))
    return tuple(Seed(read="log", files=each, target="logs/p.ddf", given="logs") for each in whole)


def _toml() -> tuple[Seed, ...]:
    texts = (seed_files.DIVE_TOML, seed_files.LONG_DIVE_TOML)
    return tuple(
        Seed(
            read="configuration", files={"dive.toml": text.encode()}, target="dive.toml", text=True
        )
        for text in texts
    )


def _init() -> tuple[Seed, ...]:
    """Return logs without a dive.toml, whose names and definitions `init` writes down."""
    ros2 = seed_messages.tiny_dive(2, seed_files.images()["a.jpg"])[:12]
    bag = seed_messages.as_bag(
        seed_messages.tiny_dive(1, seed_files.images()["a.jpg"])[:12], "none"
    )
    database = {
        f"log/{name}": data for name, data in seed_messages.as_ros2_folder(ros2, "SQLITE3").items()
    }
    mcap = seed_messages.as_mcap(ros2, "none", enable_crcs=False)
    return (
        Seed(read="init", files={"log/dive.mcap": mcap}, target="log/dive.mcap", given="log"),
        Seed(read="init", files={"log/dive.bag": bag}, target="log/dive.bag", given="log"),
        Seed(read="init", files=database, target="log/dive.db3", given="log"),
        Seed(read="init", files=_tables(), target="logs/joints.csv", given="logs", text=True),
        Seed(
            read="init",
            files={"log/dive.pd0": seed_files.pd0()},
            target="log/dive.pd0",
            given="log",
            finish=with_right_sums,
        ),
        Seed(
            read="init",
            files={"log/dvl.ad2cp": seed_ad2cp.signature_file(2)},
            target="log/dvl.ad2cp",
            given="log",
            finish=with_right_word_sums,
        ),
        Seed(
            read="init",
            files={"log/sonar.aris": seed_aris.aris_file()},
            target="log/sonar.aris",
            given="log",
        ),
        Seed(
            read="init",
            files={"log/sonar.oculus": seed_view_point.oculus_file()},
            target="log/sonar.oculus",
            given="log",
        ),
        Seed(
            read="init",
            files={"log/dvl.json": seed_files.reports().encode()},
            target="log/dvl.json",
            given="log",
            text=True,
        ),
    )


def _yaml() -> tuple[Seed, ...]:
    return (
        Seed(
            read="calibration",
            files={CALIBRATION: seed_files.CALIBRATION.encode()},
            target=CALIBRATION,
            text=True,
        ),
    )


def _hull() -> tuple[Seed, ...]:
    text = {"ascii.stl", "ascii.ply", "hull.obj", "hull.off"}
    return tuple(
        Seed(read="cad", files={name: data}, target=name, text=name in text)
        for name, data in seed_files.hulls().items()
    )


def _hull_gz() -> tuple[Seed, ...]:
    packed = {
        f"{name}.gz": gzip.compress(data, mtime=0)
        for name, data in seed_files.hulls().items()
        if name != "hull.glb"
    }
    whole = (
        Seed(read="cad", files={name: data}, target=name, checksummed=True)
        for name, data in packed.items()
    )
    past_sums = Seed(
        read="cad", files={"past.stl.gz": seed_files.hulls()["hull.stl"]}, target="past.stl.gz",
        finish=lambda data: gzip.compress(data, 1, mtime=0),
    )  # fmt: skip
    return (*whole, past_sums)


def _image() -> tuple[Seed, ...]:
    pictures = seed_files.images()
    past_sums = Seed(
        read="image",
        files={"sums.png": pictures["a.png"]},
        target="sums.png",
        finish=with_right_crcs,
    )
    return (
        *(
            Seed(read="image", files={n: data}, target=n, checksummed=n.endswith("png"))
            for n, data in pictures.items()
        ),
        past_sums,
    )


def with_right_crcs(data: bytes) -> bytes:
    """Return a PNG with the checksums that the bytes of its chunks ask for, so that damage gets
    past them.
    """
    out, at = bytearray(data), 8
    while at + 12 <= len(out):
        end = at + 8 + int.from_bytes(out[at : at + 4], "big")
        if end + 4 > len(out):
            break
        out[end : end + 4] = zlib.crc32(out[at + 4 : end]).to_bytes(4, "big")
        at = end + 4
    return bytes(out)
