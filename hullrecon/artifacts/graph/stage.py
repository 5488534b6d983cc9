# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Declare a step, and what it is given when it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Protocol, TypeVar

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from hullrecon.artifacts.graph.stage_settings import StageSettings

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
