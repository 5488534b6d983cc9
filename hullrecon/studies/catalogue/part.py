# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A part of a source: the code that implements it, and the studies and tests that reproduce it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum


class Absence(StrEnum):
    """Why nothing reproduces a part."""

    PICTURE = "illustration or photograph"
    LITERATURE = "survey of the literature"
    DATA = "data not public"
    NOT_BUILT = "not built"


class Status(StrEnum):
    """What reproduces a part, the first that holds."""

    STUDY = "study"
    RUN = "delivered by a run"
    BENCHMARK = "benchmark"
    TEST = "held by tests"
    PRODUCT = "in the product"  # code without a number of its own
    ABSENT = "absent"


@dataclass(frozen=True)
class Part:
    """A figure, table, equation or section of a source."""

    number: str  # as the source numbers it
    what: str  # in our words
    printed: str = field(default="", kw_only=True)  # value that the source prints
    studies: tuple[str, ...] = field(default=(), kw_only=True)  # id, or id/figure
    delivered: tuple[str, ...] = field(default=(), kw_only=True)  # files of deliver/
    benchmarks: tuple[str, ...] = field(default=(), kw_only=True)  # modules of benchmarks/
    tests: tuple[str, ...] = field(default=(), kw_only=True)  # file, or file::function
    code: tuple[str, ...] = field(default=(), kw_only=True)  # file, or file:name in it
    differs: str = field(default="", kw_only=True)  # from the source, and why
    absent: Absence | None = field(default=None, kw_only=True)

    @property
    def study_ids(self) -> frozenset[str]:
        """Ids of the studies that reproduce it."""
        return frozenset(name.partition("/")[0] for name in self.studies)

    @property
    def status(self) -> Status:
        """What reproduces this part."""
        for status, shown in (
            (Status.STUDY, self.studies),
            (Status.RUN, self.delivered),
            (Status.BENCHMARK, self.benchmarks),
            (Status.TEST, self.tests),
            (Status.PRODUCT, self.code),
        ):
            if shown and self.absent is None:
                return status
        return Status.ABSENT


@dataclass(frozen=True, kw_only=True)
class Misprint:
    """A slip in a source: how it is printed, and how it is right."""

    where: str
    printed: str
    right: str
    tests: tuple[str, ...] = ()  # in which the print fails and the correction holds
    checked: str = ""  # what a test can hold where the print cannot be made to fail


@dataclass(frozen=True, kw_only=True)
class Survey:
    """A survey table of a source, with hullrecon as one more row."""

    number: str
    about: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    ours: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Chapter:
    """Parts of a source that belong together."""

    title: str
    parts: tuple[Part, ...]


@dataclass(frozen=True, kw_only=True)
class Source:
    """A source with its parts, misprints and surveys."""

    key: str  # of docs/references.md
    title: str
    chapters: tuple[Chapter, ...]
    misprints: tuple[Misprint, ...]
    surveys: tuple[Survey, ...] = ()

    @property
    def parts(self) -> tuple[Part, ...]:
        """All parts, chapter by chapter."""
        return tuple(part for chapter in self.chapters for part in chapter.parts)
