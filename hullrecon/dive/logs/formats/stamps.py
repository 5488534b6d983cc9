# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps of tables: seconds since 1970, dates and times, and times of day alone."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta, timezone

from hullrecon.records.clock import NS

UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
EARLIEST_S, LATEST_S = 3e8, 4.2e9  # 1979 and 2103: no log of a dive lies outside
DAY_S, DAY_NS = 86_400, 86_400 * NS
EPOCH = date(1970, 1, 1)
TIME = re.compile(r"(\d{1,2}):(\d\d):(\d\d)(?:[.,](\d+))?")
# The year first, or day.month.year. With slashes some write the day first and others the month
YEAR_FIRST = re.compile(r"(\d{4})([-/.])(\d{1,2})\2(\d{1,2})")
YEAR_LAST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})")
ZONES = {"UTC": "Z", "GMT": "Z"}
FORMS = "nor a date and time with its zone, as 2026-05-04T09:30:00.25+02:00"
ZONE_OPEN = 'give logs.time_zone, "UTC" or by how much the clock is ahead of it, as "+02:00"'
DAY_OPEN = "give dive.date, or the date in a column date"


@dataclass(frozen=True, kw_only=True)
class LoggerClock:
    """What tables leave out of their stamps: the zone, and the day of times of day."""

    zone: timezone | None = None
    day: date | None = None
    is_assumed: bool = False  # before there is a dive.toml that could say it


ASSUMED = LoggerClock(zone=UTC, day=EPOCH, is_assumed=True)


class LateStampError(ValueError):
    """Raised for a stamp that is too large to be seconds since 1970."""

    def __init__(self, seconds: float) -> None:
        super().__init__(f"the stamp {seconds:.17g} lies behind any log")
        self.seconds = seconds


class OpenStampError(ValueError):
    """Raised for a date or time of which the zone or the day is not known."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


class StampReader:
    """Reads the stamps of one table, row by row.

    Times of day that pass midnight go on on the next day.
    """

    def __init__(self, clock: LoggerClock) -> None:
        self._clock = clock
        self._last_ns: int | None = None  # of the last time of day without a date
        self.open: list[str] = []  # keys that say what stamps leave open

    def read_ns(self, row: Mapping[str, str]) -> int:
        """Read column t, with column date where t is a time of day, as ns since 1970.

        Raises ValueError for what is no stamp, LateStampError for seconds far too late, which may
        be in another unit, and OpenStampError where zone or day are not known.
        """
        text = row["t"].strip()
        try:
            seconds = float(text)
        except ValueError:
            day = (row.get("date") or "").strip() if is_time_of_day(text) else ""
            return self._date_and_time_ns(f"{day} {text}" if day else text)
        if seconds > LATEST_S:
            raise LateStampError(seconds)
        if seconds < -LATEST_S:
            raise ValueError(f"the stamp {seconds:g} lies before any log")
        return _exact_ns(text, seconds)

    def _date_and_time_ns(self, text: str) -> int:
        """Read a date and time of ISO 8601 with its zone, or one whose zone the clock tells."""
        for name, sign in ZONES.items():
            text = text.removesuffix(f" {name}") + (sign if text.endswith(f" {name}") else "")
        try:
            since = datetime.fromisoformat(text) - datetime(1970, 1, 1, tzinfo=UTC)
        except (ValueError, TypeError):  # none that Python reads, or without a zone
            return self._local_ns(text)
        return since // timedelta(microseconds=1) * 1000

    def _local_ns(self, text: str) -> int:
        """Read a date and time, or a time of day alone, by the clock's zone and day."""
        *before, last = re.split(r"[ T_]+", text)
        zone_at = re.search(r"(Z|[+-]\d\d:?\d\d)$", last)
        of_day_ns = _time_of_day_ns(last[: zone_at.start()] if zone_at else last)
        day = _day(before[0]) if len(before) == 1 else None
        if of_day_ns is None or len(before) > 1 or (before and day is None):
            raise ValueError(f"t = {text!r} is no number of seconds since 1970, {FORMS}")
        if zone_at is None and self._clock.zone is None:
            raise OpenStampError(f"t = {text!r} has no time zone", ZONE_OPEN)
        if not before and self._clock.day is None:
            raise OpenStampError(f"t = {text!r} is a time of day without a date", DAY_OPEN)
        ahead_ns = _ahead_ns(zone_at.group() if zone_at else None, self._clock.zone)
        lacks = {"logs.time_zone": zone_at is None, "dive.date": not before}
        self.open += [key for key, is_open in lacks.items() if is_open and key not in self.open]
        if day is not None:
            return (day - EPOCH).days * DAY_NS + of_day_ns - ahead_ns
        assert self._clock.day is not None
        t_ns = (self._clock.day - EPOCH).days * DAY_NS + of_day_ns - ahead_ns
        if self._last_ns is not None:  # the day on which it is nearest to the stamp before
            t_ns += round((self._last_ns - t_ns) / DAY_NS) * DAY_NS
        self._last_ns = t_ns
        return t_ns


def is_time_of_day(text: str) -> bool:
    """Tell whether a stamp is a time of day without a date."""
    return TIME.match(text.strip()) is not None


def words_for_unit(value: float) -> str:
    """Word the likely unit of a stamp that cannot be in seconds. "" where no unit fits."""
    fits = [name for name, size in UNITS.items() if EARLIEST_S <= value / size <= LATEST_S]
    return f", which look like {fits[0]}" if fits else ""


def zone_of(name: str | None) -> timezone | None:
    """Make the time zone of `logs.time_zone`, "UTC" or as "+02:00". None for None."""
    if name is None:
        return None
    return UTC if name == "UTC" else timezone(timedelta(microseconds=_ahead_ns(name, None) // 1000))


def _exact_ns(text: str, seconds: float) -> int:
    """Convert seconds to ns, exact to the digits that are written."""
    whole, _, fraction = text.partition(".")
    is_plain = whole.lstrip("-").isdigit() and (not fraction or fraction.isdigit())
    if is_plain and not whole.startswith("-"):
        return int(whole) * NS + int((fraction + "0" * 9)[:9])
    return round(seconds * 1e9)


def _time_of_day_ns(text: str) -> int | None:
    """Read a time of day, ns from midnight. None for what is none."""
    found = TIME.fullmatch(text)
    if found is None:
        return None
    hour, minute, second = (int(found.group(k)) for k in (1, 2, 3))
    if hour > 23 or minute > 59 or second > 59:
        return None
    fraction = found.group(4) or ""
    return (hour * 3600 + minute * 60 + second) * NS + int((fraction + "0" * 9)[:9])


def _day(text: str) -> date | None:
    """Read a date with the year first, or day.month.year. None for any other."""
    first, last = YEAR_FIRST.fullmatch(text), YEAR_LAST.fullmatch(text)
    try:
        if first is not None:
            return date(int(first.group(1)), int(first.group(3)), int(first.group(4)))
        if last is not None:
            return date(int(last.group(3)), int(last.group(2)), int(last.group(1)))
        return date.fromisoformat(text)
    except ValueError:
        return None


def _ahead_ns(written: str | None, zone: timezone | None) -> int:
    """Compute by how many ns local time is ahead of UTC.

    written: the zone as "Z", "+02:00" or "+0200" after the time, None where there is none. zone:
    that of the clock, which then holds. None: UTC.
    """
    if written is None:
        return 0 if zone is None else zone.utcoffset(None) // timedelta(microseconds=1) * 1000
    if written == "Z":
        return 0
    sign = -1 if written.startswith("-") else 1
    return sign * (int(written[1:3]) * 60 + int(written[-2:])) * 60 * NS
