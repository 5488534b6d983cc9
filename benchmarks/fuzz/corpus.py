# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What was ever found, kept as edits of the sound inputs, so that it is read again by the tests."""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.fuzz.campaign import Campaign
from benchmarks.fuzz.cases import damaged_input
from benchmarks.fuzz.formats import seeds

GAP = 16  # bytes that agree between two edits


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A damaged input. number: of the sound input of its format; edits: (offset, count of bytes
    taken out, bytes put in), from the end to the start, the last as zlib in base 85.
    """

    form: str
    number: int
    found: str
    edits: tuple[tuple[int, int, str], ...]

    def data(self) -> bytes:
        """Return the damaged bytes. Where the sound input has changed since, they are another
        damage of it.
        """
        sound = seeds()[self.form][self.number]
        out = bytearray(sound.files[sound.target])
        for at, taken, put in self.edits:
            out[at : at + taken] = zlib.decompress(base64.b85decode(put))
        return bytes(out)


def describe(form: str, number: int, data: bytes, found: str) -> Entry:
    """Return the entry for damaged bytes: what differs, run by run where the length is the same,
    else all between the ends.
    """
    sound = seeds()[form][number]
    whole = sound.files[sound.target]
    runs = _runs(whole, data) if len(whole) == len(data) else [_middle(whole, data)]
    edits = tuple((at, taken, _packed(data[at : at + put])) for at, taken, put in reversed(runs))
    return Entry(form=form, number=number, found=found, edits=edits)


def read_corpus(path: Path) -> list[Entry]:
    """Return the entries of a corpus file; none where there is no file."""
    if not path.is_file():
        return []
    return [
        Entry(**{**row, "edits": tuple(map(tuple, row["edits"]))})
        for row in json.loads(path.read_text())
    ]


def write_corpus(path: Path, entries: list[Entry]) -> None:
    """Write a corpus file, an entry a line."""
    path.write_text("[\n" + ",\n".join(json.dumps(asdict(entry)) for entry in entries) + "\n]\n")


def add_findings(path: Path, campaign: Campaign) -> None:
    """Add the first case of each finding of a campaign to a corpus file."""
    entries = read_corpus(path)
    for finding in campaign.findings.values():
        number, data = damaged_input(finding.form, campaign.seed, finding.cases[0])
        last = (finding.text.strip().splitlines() or [""])[-1]
        entries.append(describe(finding.form, number, data, f"{finding.kind}: {last[:80]}"))
    write_corpus(path, list(dict.fromkeys(entries)))


def _runs(whole: bytes, data: bytes) -> list[tuple[int, int, int]]:
    """Return (offset, length, length) of the parts where two strings of one length differ."""
    out: list[tuple[int, int, int]] = []
    for at in (k for k, (a, b) in enumerate(zip(whole, data, strict=True)) if a != b):
        if out and at - sum(out[-1][:2]) < GAP:
            start = out[-1][0]
            out[-1] = (start, at + 1 - start, at + 1 - start)
        else:
            out.append((at, 1, 1))
    return out


def _middle(whole: bytes, data: bytes) -> tuple[int, int, int]:
    """Return (offset, length in the first, length in the second) of what lies between the equal
    ends of two strings.
    """
    shorter = min(len(whole), len(data))
    start = next((k for k in range(shorter) if whole[k] != data[k]), shorter)
    end = next(
        (k for k in range(shorter - start) if whole[-1 - k] != data[-1 - k]), shorter - start
    )
    return start, len(whole) - end - start, len(data) - end - start


def _packed(data: bytes) -> str:
    return base64.b85encode(zlib.compress(data, 9)).decode()
