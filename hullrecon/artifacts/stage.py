# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Declare a step: its inputs, the settings that it reads, and what its function is given."""

from __future__ import annotations

import logging
import math
import multiprocessing
import struct
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Generic, Literal, TypeVar

import numpy as np
from msgspec import Struct, structs
from numpy.typing import NDArray

from hullrecon.artifacts.documents import Json, plain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.machine import peak_rss
from hullrecon.artifacts.parts import PartStore
from hullrecon.artifacts.progress import Outlook, Progress, raise_if_requested
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.errors import UsageError

Value = TypeVar("Value")
Parameters = TypeVar("Parameters", bound=Struct)
Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)


class StageSettings(Mapping[str, object]):
    """The sections and single keys of dive.toml that one step reads, by dotted name.

    The value is None if the section is absent. Reading a key that the step did not declare is an
    internal error: its artifact would stay up to date after a change of the key.
    """

    def __init__(self, stage: str, sections: Mapping[str, object]) -> None:
        self._stage, self._sections = stage, dict(sections)

    def __getitem__(self, name: str) -> object:
        """Look up a section that the step declared. Any other is an error of the step's code."""
        if name not in self._sections:
            raise RuntimeError(
                f"step {self._stage} reads section {name!r} without naming it in its `uses`"
            )
        return self._sections[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sections)

    def __len__(self) -> int:
        return len(self._sections)

    def replaced(self, values: Mapping[str, object]) -> StageSettings:
        """Copy the settings with other values for some of the names that the step declared."""
        sections = {name: values.get(name, value) for name, value in self._sections.items()}
        return StageSettings(self._stage, sections)

    def read(self, name: str, kind: type[Value]) -> Value:
        """Read a value that must be there. Raises TypeError if it is not of that type."""
        value = self[name]
        if kind is float and isinstance(value, int):
            value = float(value)
        if not isinstance(value, kind):
            raise TypeError(f"setting {name} is {value!r}, where {kind.__name__} is expected")
        return value

    def read_optional(self, name: str, kind: type[Value]) -> Value | None:
        """Read a value, None if its section is absent. Raises TypeError as `read` does."""
        return None if self[name] is None else self.read(name, kind)


@dataclass(frozen=True)
class Stage:
    """A step, declared once."""

    name: str  # on the command line, of its folder in RUNS/<dive> and its section in dive.toml
    summary: str
    inputs: tuple[str, ...]  # stages that it needs
    parameters: type[Struct]  # its own options: frozen, keyword-only, all with defaults
    version: int  # raised when the function's result changes for the same input
    run: Callable[[Context[Any]], None]
    uses: tuple[str, ...] = ()  # other sections and keys of dive.toml that it reads, "camera.top"
    optional: tuple[str, ...] = ()  # stages that it uses when they are part of this dive's chain
    # lists the files of the package that it reads, given the settings and the package's folder
    external: Callable[[StageSettings, Path], list[Path]] | None = None
    # says why this dive cannot have the step, None if it can, given the same
    applies: Callable[[StageSettings, Path], str | None] | None = None
    fails_alone: bool = False  # if it fails, steps of which it is an optional input still run


class Context(Generic[Parameters]):
    """What a step's function is given: settings, inputs, a writer, an executor."""

    def __init__(
        self,
        stage: Stage,
        settings: StageSettings,
        inputs: Mapping[str, Path],
        out: ArtifactWriter,
        *,
        source: Path | None = None,
        failures: Mapping[str, str] | None = None,
        executor: Executor | None = None,
        progress: Progress | None = None,
        outlook: Outlook | None = None,
        parts: PartStore | None = None,
    ) -> None:
        """Take what a stage works with.

        stage: whose function is called. source: folder of the package. executor: of heavy work.
        progress, outlook: show and predict how far it is. parts: keeps finished parts of the step.
        """
        self.settings = settings  # those in the stage's `uses` and its own
        self.inputs = inputs  # folder of each input artifact that exists, by stage name
        self.failures = failures or {}  # why optional inputs left no artifact, by stage name
        self.out = out
        self.warnings: list[str] = []
        self.times: dict[str, list[float]] = {}  # s
        self.workers_peak_rss = 0  # bytes
        self._stage, self._source = stage, source
        self._executor, self._progress = executor or Executor(), progress or Progress()
        self._outlook, self._parts = outlook or Outlook(), parts

    @property
    def source(self) -> Path:
        """Folder of the package, for stages with `external` files."""
        if self._source is None or self._stage.external is None:
            raise RuntimeError(
                f"step {self._stage.name} reads the package without declaring `external` files"
            )
        return self._source

    @property
    def parameters(self) -> Parameters:
        """The stage's own section, an instance of its `parameters`."""
        own: Any = self.settings[self._stage.name]
        return own  # type: ignore[no-any-return]

    def progress(self, items: Iterable[Item], label: str) -> Iterable[Item]:
        """Yield the same items, shown as a bar on a terminal and as log lines elsewhere."""
        return self._track(items, label, len(items) if isinstance(items, Sized) else None)

    def _track(
        self, items: Iterable[Item], label: str, total: int | None, kept: int = 0
    ) -> Iterator[Item]:
        """Yield the items and show progress, unless the run is interrupted.

        kept: items that an earlier run made, which are logged and take no time.
        """
        shown = f"{self._outlook.mark}{self._stage.name}: {label}"
        if kept:
            log.info("%s: %d of %d are there from a run that did not end", shown, kept, total)
            self._outlook.resume()
        return self._progress.track(_until_interrupted(items), shown, total, self._outlook, kept)

    def stream(
        self,
        function: Callable[[Item], Result],
        items: Sequence[Item],
        label: str,
        *,
        by: Callable[[Callable[[Item], Result], Sequence[Item]], Iterator[Result]] | None = None,
        depends: Callable[[Item], object] | None = None,
    ) -> Iterator[Result]:
        """Apply a function to all items and yield the results in order.

        Each result is kept until the step has ended, so that a run after a kill does not compute it
        again.

        Parameters
        ----------
        function
            Must give the same result for the same item, inputs and settings.
        items
            All items, in order.
        label
            What the items are, for progress and the names of kept results. Loops over other kinds
            of items in the same step must have other labels.
        by
            Applies the function to items. None: the executor of --jobs or --scheduler, for which
            the function must be picklable. The results do not depend on it.
        depends
            Gives the part of the inputs' content on which an item's result depends. None: on the
            item and all inputs.
        """
        compute = partial(by or self._executor.map, function)
        kept = 0
        if self._parts is None:
            results = compute(items)
        else:
            kept, results = self._parts.resume(label, items, compute, depends)
        yield from self._track(results, label, len(items), kept)
        if by is None:  # other workers are threads, whose memory is this process's
            workers = (peak_rss(worker.pid) for worker in multiprocessing.active_children())
            self.workers_peak_rss = max(self.workers_peak_rss, *workers, 0)

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> list[Result]:
        """Compute results in order, as `stream` does by the executor."""
        return list(self.stream(function, items, label))

    def once(
        self,
        make: Callable[[], Result],
        label: str,
        given: Mapping[str, object] = MappingProxyType({}),
    ) -> Result:
        """Call `make`, or take its result from a run that was killed after it.

        label: what is made, for the log and the name of the kept result. given: large objects that
        every run has anyway, by name, to which the result may refer.
        """
        if self._parts is None:
            return make()
        compute: Callable[[Sequence[str]], Iterator[Result]] = lambda _: iter([make()])  # noqa: E731
        kept, results = self._parts.resume(label, [label], compute, given=given)
        if kept:
            log.info("%s: %s: there from a run that did not end", self._stage.name, label)
            self._outlook.resume()
        return next(results)

    def warn(self, message: str) -> None:
        """Add a sentence to the log, the manifest and summary.json."""
        log.warning("%s: %s", self._stage.name, message)
        self.warnings.append(message)

    def record_times(self, name: str, seconds: Sequence[float]) -> None:
        """Record wall-clock times in the manifest's run block: they differ between equal runs."""
        self.times[name] = [round(float(s), 3) for s in seconds]


# Readers of a header by version of the .npy format
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
_LENGTHS_AT = 26  # byte of a member's header in a zip at which the lengths of name and extra begin


def _until_interrupted(items: Iterable[Item]) -> Iterator[Item]:
    """Yield the items. Raise KeyboardInterrupt once a signal has come: libraries may hide it."""
    for item in items:
        raise_if_requested()
        yield item


def load_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Read all members of an .npz."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def map_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Map all members of an uncompressed .npz as memory-mapped arrays.

    They need not fit into memory. Members without elements are arrays in memory. Rows are to be
    read with `rows.read_rows`.
    """
    arrays: dict[str, NDArray[Any]] = {}
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            with archive.open(member) as stream:
                version = np.lib.format.read_magic(stream)
                read = _HEADERS[version]
                shape, is_fortran, dtype = read(stream)
                begin = stream.tell()
            order: Literal["F", "C"] = "F" if is_fortran else "C"
            offset = _first_byte(path, member) + begin
            empty = not np.prod(shape)  # numpy cannot map an array without elements
            arrays[member.filename.removesuffix(".npy")] = (
                np.zeros(shape, dtype)
                if empty
                else np.memmap(path, dtype, "r", offset, shape, order)
            )
    return arrays


def _first_byte(path: Path, member: zipfile.ZipInfo) -> int:
    """Find where the data of an archive's member begin, behind its own header."""
    with path.open("rb") as file:
        file.seek(member.header_offset + _LENGTHS_AT)
        name, extra = struct.unpack("<HH", file.read(4))
    return member.header_offset + _LENGTHS_AT + 4 + int(name) + int(extra)


def settings_for(stage: Stage, sections: Mapping[str, object]) -> StageSettings:
    """Select the settings of a stage: those in its `uses`, and its own section.

    Where its own section is absent, it has its defaults.
    """
    own = _section(sections, stage.name)
    chosen = {name: _section(sections, name) for name in stage.uses}
    chosen[stage.name] = stage.parameters() if own is None else own
    return StageSettings(stage.name, chosen)


def resolve_settings(settings: Mapping[str, object]) -> dict[str, Json]:
    """Convert settings to plain values for the manifest.

    Raises UsageError for a number that is not finite.
    """
    values = {name: plain(value) for name, value in settings.items()}
    for name, value in flatten(values).items():
        if isinstance(value, float) and not math.isfinite(value):
            raise UsageError(
                f"option {name} is {value}", where="dive.toml", remedy="give a finite number"
            )
    return values


def flatten(value: Mapping[str, Json], prefix: str = "") -> dict[str, Json]:
    """List options by dotted name. Lists are not flattened."""
    flat: dict[str, Json] = {}
    for name, member in value.items():
        if isinstance(member, Mapping) and member:
            flat.update(flatten(member, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{name}"] = member
    return flat


def _section(sections: Mapping[str, object], dotted: str) -> object:
    """Look up a section or key. `camera.top` is the field `top` of section `camera`."""
    if dotted in sections:
        return sections[dotted]
    outer, _, inner = dotted.rpartition(".")
    section = _section(sections, outer) if outer else None
    if isinstance(section, Struct):  # a key such as `from` is a field of another name
        names = {field.encode_name: field.name for field in structs.fields(type(section))}
        inner = names.get(inner, inner)
    if section is not None and not hasattr(section, inner):
        raise RuntimeError(f"section {outer} has no option {inner}")
    return getattr(section, inner, None)
