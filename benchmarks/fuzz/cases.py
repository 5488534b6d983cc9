# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run one case: make the damaged input, read it within limits, and judge what came of it."""

from __future__ import annotations

import shutil
import signal
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random
from types import FrameType

from benchmarks.fuzz.formats import Seed, seeds
from benchmarks.fuzz.mutators import mutate
from benchmarks.fuzz.readings import READERS, Reading
from benchmarks.fuzz.records import record_starts
from hullrecon.errors import HullreconError

SECONDS = 2.0  # of the processor: other programs on the machine do not count
LARGEST_BYTES = 512 << 20
LONGEST_LINE = 1000
# unnoticed: other data without a word, where the format has no checksum
GOOD = ("same", "refused", "named", "unnoticed")
BAD = ("traceback", "hang", "memory", "crash", "silence", "lines")


@dataclass(frozen=True)
class Verdict:
    """kind: one of GOOD or BAD; text: the error, the traceback, or what was lost; what reading took
    of the processor and of memory, which differs from run to run.
    """

    kind: str
    text: str = ""
    seconds: float = field(default=0.0, compare=False)
    grown_bytes: int = field(default=0, compare=False)


class _TimeIsUpError(BaseException):
    """Not an Exception: readers that catch whatever a parser raises must not catch this."""


class Bench:
    """Runs the cases of one process in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._sound: dict[tuple[str, int], Reading] = {}

    def run(self, form: str, seed: int, case: int) -> Verdict:
        """Return the verdict on a case, the same whenever and wherever it runs."""
        number, data = damaged_input(form, seed, case)
        return self.judge(form, number, data)

    def judge(self, form: str, number: int, data: bytes) -> Verdict:
        """Return the verdict on damaged bytes in place of those of a sound input of that number."""
        sound, start = seeds()[form][number], self._baseline(form, number)
        place = self._place(form, number)
        _put(place / sound.target, sound.finish(data))
        verdict = judge(sound, start, place)
        return (
            replace(verdict, kind="unnoticed")
            if verdict.kind == "silence" and sound.blind(data)
            else verdict
        )

    def _place(self, form: str, number: int) -> Path:
        return self._folder / f"{form}-{number}"

    def _baseline(self, form: str, number: int) -> Reading:
        """Lay out the files of a sound input and read them."""
        if (form, number) not in self._sound:
            sound, place = seeds()[form][number], self._place(form, number)
            shutil.rmtree(place, ignore_errors=True)
            for name, data in sound.files.items():
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                (place / name).write_bytes(sound.finish(data) if name == sound.target else data)
            self._sound[form, number] = READERS[sound.read](place, sound.name)
        return self._sound[form, number]


def damaged_input(form: str, seed: int, case: int) -> tuple[int, bytes]:
    """Return the number of a sound input of the format and the bytes that stand in for its target,
    before they are finished.
    """
    dice = Random(f"{form} {seed} {case}")
    number = dice.randrange(len(seeds()[form]))
    sound, other = seeds()[form][number], dice.choice(seeds()[form])
    marks = record_starts(sound.files[sound.target])
    return number, mutate(
        sound.files[sound.target], other.files[other.target], dice, text=sound.text, marks=marks
    )


def judge(sound: Seed, start: Reading, place: Path) -> Verdict:
    """Read a damaged input and compare it with what the sound one gives."""
    peak, begun = _PeakMemory(), time.process_time()
    verdict = _outcome(sound, start, place)
    seconds, grown = time.process_time() - begun, peak.grown()
    if grown > LARGEST_BYTES and verdict.kind in GOOD:
        verdict = Verdict("memory", f"{grown >> 20} MiB; {verdict.text}")
    return replace(verdict, seconds=seconds, grown_bytes=grown)


def _outcome(sound: Seed, start: Reading, place: Path) -> Verdict:
    try:
        with _time_limit():
            found = READERS[sound.read](place, sound.name)
    except HullreconError as error:
        return _judge_line(str(error))
    except _TimeIsUpError:
        return Verdict(
            "hang", f"more than {SECONDS:g} s of the processor\n{traceback.format_exc()}"
        )
    except MemoryError:
        return Verdict("memory", traceback.format_exc())
    except Exception:
        return Verdict("traceback", traceback.format_exc())
    return _compare(start, found, sound.checksummed)


def _judge_line(line: str) -> Verdict:
    if len(line.splitlines()) != 1 or len(line) > LONGEST_LINE or "MemoryError" in line:
        return Verdict("lines", line)
    return Verdict("refused", line)


def _compare(start: Reading, found: Reading, checksummed: bool) -> Verdict:
    said = found.said - start.said
    odd = [line for line in said if len(line.splitlines()) != 1 or len(line) > LONGEST_LINE]
    if odd:
        return Verdict("lines", odd[0])
    if found.digest == start.digest:
        return Verdict("same")
    if said:
        return Verdict("named", "; ".join(sorted(said)))
    return Verdict("silence" if checksummed else "unnoticed")


def _put(path: Path, data: bytes) -> None:
    path.unlink(missing_ok=True)
    path.write_bytes(data)


@contextmanager
def _time_limit() -> Iterator[None]:
    """Raise _TimeIsUpError after SECONDS of the processor."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise _TimeIsUpError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


class _PeakMemory:
    """The largest resident memory from now on, by the kernel's own high-water mark."""

    def __init__(self) -> None:
        try:
            Path("/proc/self/clear_refs").write_text("5")
            self._start = _status("VmRSS")
        except OSError:
            self._start = -1

    def grown(self) -> int:
        """Return bytes over the start; 0 where the kernel does not say."""
        return _status("VmHWM") - self._start if self._start >= 0 else 0


def _status(key: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1]) << 10
    return 0
