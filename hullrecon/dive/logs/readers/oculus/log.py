# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An .oculus file as an imaging sonar: simple pings in the frame `sonar` of an upright sonar."""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

from hullrecon.dive.logs.formats.oculus_ping import is_ping, parse_ping
from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.readers.file_log import FileLog
from hullrecon.dive.logs.readers.oculus.log_items import (
    FILE_HEADER_BYTES,
    ItemHeader,
    items,
    parse_file_header,
    unpacked,
)
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.readers.unpack import DamagedError, UnpackBudget, printable
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding

CHANNEL = Channel("sonar", "Blueprint Oculus", "sample")
OCULUS = 10  # kind of the items that hold what the sonar sent


class OculusLog(FileLog):
    """Reads pings of items whose headers ViewPoint may have written. Other bytes are losses."""

    kind = "Oculus ViewPoint"
    gives_samples = True

    def _read(self) -> Iterator[Message]:
        """Yield the pings. Items of other kinds are counted, damaged ones become losses."""
        pings, others, budget = 0, 0, UnpackBudget(self.path.stat().st_size)
        with self.path.open("rb") as stream:
            for start, end, found in items(stream, self._first_item(stream), budget):
                if isinstance(found, str):
                    self._tracker.open_gap(
                        f"{end - start} bytes from byte {start} on hold no whole item: {found}"
                    )
                    continue
                try:
                    sample = to_sample(*found, budget)
                except DamagedError as error:
                    self._tracker.open_gap(f"the item at byte {start}: {error}")
                    continue
                if sample is None:
                    others += 1
                    continue
                pings += 1
                yield self._tracker.record(Message(CHANNEL, sample.t_ns, sample))
        self._tracker.finish()
        if others:
            self.notes.append(Finding("oculus-others", {"count": others}))
        self.notes.append(Finding("oculus-read" if pings else "oculus-empty"))

    def _first_item(self, stream: BinaryIO) -> int:
        """Find the byte at which the first item begins. Raises InputError where they are encrypted.

        With a damaged header it is taken to be of the usual length, and the damage is a loss.
        """
        try:
            size, is_encrypted = parse_file_header(stream.read(FILE_HEADER_BYTES))
        except DamagedError as error:
            self._tracker.open_gap(f"the header of the file: {error}")
            return FILE_HEADER_BYTES
        if is_encrypted:
            raise InputError(
                f"{printable(self.path.name)} is encrypted",
                where=printable(str(self.path.parent)),
                remedy="record without encryption, or export the log without it",
            )
        return size


def to_sample(header: ItemHeader, payload: bytes, budget: UnpackBudget) -> SonarSample | None:
    """Read the ping of an item. None for another item. Raises DamagedError for a damaged one."""
    if header.kind != OCULUS:
        return None
    data = unpacked(header, payload, budget)
    if not is_ping(data):
        return None
    ping = parse_ping(data)
    return SonarSample(header.t_ns, ping.image, in_fan(ping.azimuth_rad), ping.range_m)
