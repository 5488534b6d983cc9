# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Declare a step: its inputs, the settings that it reads, and what its function is given."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Protocol, TypeVar

import numpy as np
from msgspec import Struct, structs
from numpy.typing import NDArray

from hullrecon.artifacts.documents import Json, plain
from hullrecon.errors import UsageError

Value = TypeVar("Value")


class StageSettings(Mapping[str, object]):
    """Sections and single keys of dive.toml by dotted name; None where the section is absent.

    Reading one that the step did not declare is a fault of ours: its artifact would not be out of
    date after a change of it.
    """

    def __init__(self, stage: str, sections: Mapping[str, object]) -> None:
        self._stage, self._sections = stage, dict(sections)

    def __getitem__(self, name: str) -> object:
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
        """Return settings with other values of some of the names that the step declared."""
        return StageSettings(
            self._stage, {name: values.get(name, value) for name, value in self._sections.items()}
        )

    def read(self, name: str, kind: type[Value]) -> Value:
        """Return a value that must be there. Raises TypeError where it is absent or of another
        type.
        """
        value = self[name]
        if kind is float and isinstance(value, int):
            value = float(value)
        if not isinstance(value, kind):
            raise TypeError(f"setting {name} is {value!r}, where {kind.__name__} is expected")
        return value

    def read_optional(self, name: str, kind: type[Value]) -> Value | None:
        """Return a value, or None where its section is absent. Raises TypeError where it is of
        another type.
        """
        return None if self[name] is None else self.read(name, kind)


Parameters = TypeVar("Parameters", bound=Struct, covariant=True)
Item = TypeVar("Item")
Result = TypeVar("Result")


class Writer(Protocol):
    """Writes the files of one artifact; nothing else opens a file for writing in RUNS."""

    def arrays(self, name: str, arrays: Mapping[str, NDArray[np.generic]]) -> None:
        """Write an .npz with those members, same bytes for the same arrays."""

    def json(self, name: str, value: object) -> None:
        """Write indented JSON with sorted keys; NaN is refused."""

    def text(self, name: str, value: str) -> None: ...

    def bytes(self, name: str, value: bytes) -> None: ...

    def path(self, name: str) -> AbstractContextManager[Path]:
        """Give a temporary path to let a library write to; it is made durable and renamed at the
        end of the `with`.
        """

    def scratch(self) -> AbstractContextManager[BinaryIO]:
        """Give an empty file without a name, to write and to read, which is gone at the end of the
        `with`.
        """


class Context(Protocol[Parameters]):
    """What a step's function gets: its own options are of type Parameters."""

    settings: StageSettings  # those in the stage's `uses` and its own
    inputs: Mapping[str, Path]  # folder of each input artifact that exists, by stage name
    failures: Mapping[str, str]  # why optional inputs left no artifact, a sentence by stage name
    out: Writer

    @property
    def source(self) -> Path:
        """Return the folder of the package (stages with `external` only)."""

    @property
    def parameters(self) -> Parameters:
        """Return the stage's own section, an instance of its `parameters`."""

    def progress(
        self, items: Iterable[Item], label: str, total: int | None = None
    ) -> Iterable[Item]:
        """Yield the same items, shown as a bar on a terminal and as log lines elsewhere."""

    def map(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> list[Result]:
        """Return the results in order, computed by the executor (`--jobs`, `--scheduler`);
        `function` must pickle. Same results whichever executor.
        """

    def warn(self, message: str) -> None:
        """Add a sentence to the log, the manifest and summary.json."""

    def record_times(self, name: str, seconds: Sequence[float]) -> None:
        """Record wall-clock times, s, for the manifest's run block: they differ between equal runs,
        so no file holds them.
        """


@dataclass(frozen=True)
class Stage:
    """A step, declared once.

    name: as on the command line ("mosaic-optical"); also its folder in RUNS/<dive> and its section
    in dive.toml. inputs: stages it needs. optional: stages it uses when they are part of this
    dive's chain. uses: sections of dive.toml it reads besides its own, dotted where nested
    ("camera.top"). parameters: msgspec Struct (frozen, keyword only, unknown fields forbidden, all
    fields with defaults). version: raised when the function's result changes for the same input.
    external: for stages that read files of the package: from the settings and the package's folder
    to those files. applies: None, or a function from the settings and the package's folder to None
    (applies) or the reason why this dive cannot
        have it. fails_alone: where it reaches no result, steps that only use it when it is there go
        on without it.
    """

    name: str
    summary: str
    inputs: tuple[str, ...]
    parameters: type[Struct]
    version: int
    run: Callable[[Context[Any]], None]
    uses: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    external: Callable[[StageSettings, Path], list[Path]] | None = None
    applies: Callable[[StageSettings, Path], str | None] | None = None
    fails_alone: bool = False


def load_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Return the members of an .npz, read whole."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def settings_for(stage: Stage, sections: Mapping[str, object]) -> StageSettings:
    """Return the sections in the stage's `uses` (None where absent) and its own (its defaults where
    absent).
    """
    own = _section(sections, stage.name)
    chosen = {name: _section(sections, name) for name in stage.uses}
    return StageSettings(
        stage.name, {**chosen, stage.name: stage.parameters() if own is None else own}
    )


def resolve_settings(settings: Mapping[str, object]) -> dict[str, Json]:
    """Return the settings as plain values for the manifest. Raises UsageError for a number that is
    not finite.
    """
    values = {name: plain(value) for name, value in settings.items()}
    for name, value in flatten(values).items():
        if isinstance(value, float) and not math.isfinite(value):
            raise UsageError(
                f"option {name} is {value}", where="dive.toml", remedy="give a finite number"
            )
    return values


def flatten(value: Mapping[str, Json], prefix: str = "") -> dict[str, Json]:
    """Return options by dotted name; lists stay whole."""
    flat: dict[str, Json] = {}
    for name, member in value.items():
        dotted = f"{prefix}{name}"
        if isinstance(member, Mapping) and member:
            flat.update(flatten(member, f"{dotted}."))
        else:
            flat[dotted] = member
    return flat


def _section(sections: Mapping[str, object], dotted: str) -> object:
    """Return the section of that dotted name, None below an absent one.

    `camera.top` is the field `top` of section `camera`, unless a section has that very name.
    """
    if dotted in sections:
        return sections[dotted]
    outer, _, inner = dotted.rpartition(".")
    section = _section(sections, outer) if outer else None
    if isinstance(section, Struct):  # as it is written: an option `from` is a field of another name
        inner = {field.encode_name: field.name for field in structs.fields(type(section))}.get(
            inner, inner
        )
    if section is not None and not hasattr(section, inner):
        raise RuntimeError(f"section {outer} has no option {inner}")
    return getattr(section, inner, None)
