# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What every log reader gives: messages in file order, and afterwards what was lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.samples import Sample


@dataclass(frozen=True)
class Channel:
    """One topic of a log. encoding: "cdr", "ros1", or "sample" where messages hold samples already,
    as those of every log with `gives_samples` do; any other is listed but not decoded. definition:
    the type's text as the log carries it, "" where it does not.
    """

    topic: str
    type: str
    encoding: str
    definition: str = ""
    definition_format: str = "ros2msg"

    def __post_init__(self) -> None:
        """Escape what a terminal would obey: names come from the log and are printed."""
        for name in ("topic", "type", "encoding"):
            object.__setattr__(self, name, printable(getattr(self, name)))


@dataclass(frozen=True, slots=True)
class Message:
    """t_ns: when it was logged. data: the serialised bytes, or the sample itself where the
    channel's encoding says so.
    """

    channel: Channel
    t_ns: int
    data: bytes | Sample


@dataclass(frozen=True)
class Loss:
    """A part of a log that could not be read. topic "": every topic may be touched. start_ns,
    end_ns: its span in log time, None where unknown (the start of the log, its end). messages: how
    many are gone, None where nobody can tell.
    """

    why: str
    topic: str = ""
    start_ns: int | None = None
    end_ns: int | None = None
    messages: int | None = None


class Log(Protocol):
    """A log that was opened. Reading it twice gives the same."""

    path: Path
    kind: str  # its name, "MCAP"
    gives_samples: bool  # its messages are samples of known sensors: no topics apply
    remarks: list[str]  # what a reader should know; filled while reading

    def messages(self) -> Iterator[Message]:
        """Yield every whole message, in the order of the file. Raises HullreconError only."""

    def losses(self) -> list[Loss]:
        """Return what the last pass of `messages` could not read."""
