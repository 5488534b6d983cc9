# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the configuration that one step is handed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

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
