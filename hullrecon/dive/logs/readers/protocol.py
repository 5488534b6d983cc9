# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The interface of all log readers: messages in file order, and afterwards what was lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.samples import Sample
from hullrecon.findings.finding import Finding


@dataclass(frozen=True)
class Channel:
    """One topic of a log."""

    topic: str
    type: str
    # "cdr", "ros1", or "sample" where messages hold samples already, as those of every log with
    # `gives_samples` do; any other is listed but not decoded
    encoding: str
    definition: str = ""  # the type's text as the log carries it, "" where it does not
    definition_format: str = "ros2msg"

    def __post_init__(self) -> None:
        """Escape control characters: names come from the log and are printed."""
        for name in ("topic", "type", "encoding"):
            object.__setattr__(self, name, printable(getattr(self, name)))


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a log."""

    channel: Channel
    t_ns: int  # when it was logged
    data: bytes | Sample  # serialised, or the sample where the channel's encoding is "sample"


@dataclass(frozen=True)
class Loss:
    """A part of a log that could not be read."""

    why: str
    topic: str = ""  # "": every topic may be touched
    start_ns: int | None = None  # in log time; None where unknown: the start of the log
    end_ns: int | None = None  # None where unknown: its end
    messages: int | None = None  # how many are gone; None where unknown


class Log(Protocol):
    """An open log. Reading it twice gives the same messages."""

    path: Path
    kind: str  # its name, "MCAP"
    gives_samples: bool  # its messages are samples of known sensors: no topics apply
    notes: list[Finding]  # what was assumed or is missing; filled while reading

    def messages(self) -> Iterator[Message]:
        """Yield every whole message, in the order of the file. Raises HullreconError only."""

    def losses(self) -> list[Loss]:
        """List what the last pass of `messages` could not read."""
