# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare two runs byte by byte, without what differs between equal runs, and flip bits as a
failing disk does.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
from pathlib import Path

_NOT_RESULTS = {".hullrecon", "quarantine", "logs"}
_HOLD_TIMES = ("deliver/summary.json", "deliver/report/index.html")


def different_files(first: Path, second: Path) -> list[str]:
    """Return the names of files that are not in both folders of runs, or not the same."""
    one, two = lasting_hashes(first), lasting_hashes(second)
    return sorted(name for name in {*one, *two} if one.get(name) != two.get(name))


def lasting_hashes(folder: Path) -> dict[str, str]:
    """Return the hash of each file of a run that stays the same when the run is repeated."""
    found = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = path.relative_to(folder)
        if name.parts[0] not in _NOT_RESULTS:
            found[name.as_posix()] = hashlib.sha256(_lasting(path)).hexdigest()
    return found


def _lasting(path: Path) -> bytes:
    if path.name in ("manifest.json", "summary.json"):
        document = json.loads(path.read_text())
        for changing in ("run", "seal"):
            document.pop(changing, None)
        for name in _HOLD_TIMES:
            document.get("outputs", {}).pop(name, None)
        document.get("deliverables", {}).pop("report/index.html", None)
        return json.dumps(document, sort_keys=True).encode()
    if path.suffix == ".html":
        return "".join(
            line for line in path.read_text().splitlines() if "data-volatile" not in line
        ).encode()
    return path.read_bytes()


def flip_bit(path: Path, chance: random.Random, bit: int | None = None) -> int:
    """Flip a bit of a file, a random one for None, and return which; size, time and inode stay."""
    status = path.stat()
    bit = chance.randrange(8 * status.st_size) if bit is None else bit
    with path.open("r+b") as file:
        file.seek(bit // 8)
        byte = file.read(1)[0] ^ 1 << bit % 8
        file.seek(bit // 8)
        file.write(bytes([byte]))
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    return bit
