# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A problem that a test may change field by field: `draft.stereo.pixel = ...`,
`draft.unknowns.pose[0, 2] = ...`.

A Problem is frozen, and that is right for those who solve one. Tests damage and rearrange theirs.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from hullrecon import native
from hullrecon.native import Covariance, Evaluation, Options, Problem, Result


class Draft:
    """Mirrors a record: its parts are drafts too."""

    def __init__(self, record: Any) -> None:
        object.__setattr__(self, "_kind", type(record))
        for field in dataclasses.fields(record):
            value = getattr(record, field.name)
            setattr(self, field.name, value)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"{self._kind.__name__} has no field {name}")

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._kind.__dataclass_fields__:
            raise AttributeError(f"{self._kind.__name__} has no field {name}")
        object.__setattr__(self, name, Draft(value) if dataclasses.is_dataclass(value) else value)

    def build(self) -> Any:
        """The record of the fields as they are now."""
        values = {f.name: getattr(self, f.name) for f in dataclasses.fields(self._kind)}
        return self._kind(
            **{
                name: value.build() if isinstance(value, Draft) else value
                for name, value in values.items()
            }
        )


def built(problem: Problem | Draft) -> Problem:
    return problem.build() if isinstance(problem, Draft) else problem


def solve(problem: Problem | Draft, options: Options = Options()) -> Result:  # noqa: B008
    return native.solve(built(problem), options)


def evaluate(problem: Problem | Draft, options: Options = Options()) -> Evaluation:  # noqa: B008
    return native.evaluate(built(problem), options)


def covariance(problem: Problem | Draft, options: Options = Options()) -> Covariance:  # noqa: B008
    return native.covariance(built(problem), options)


def leaves(draft: Draft, prefix: str = "") -> dict[str, Any]:
    """What stands in a draft by path: "stereo.pixel"."""
    found: dict[str, Any] = {}
    for name in (field.name for field in dataclasses.fields(draft._kind)):
        value = getattr(draft, name)
        found |= (
            leaves(value, f"{prefix}{name}.")
            if isinstance(value, Draft)
            else {prefix + name: value}
        )
    return found


def change(draft: Draft, path: str, value: Any) -> None:
    """Sets the field of that path."""
    *parts, name = path.split(".")
    for part in parts:
        draft = getattr(draft, part)
    setattr(draft, name, value)


def clear(draft: Draft, *tables: str) -> None:
    """Leaves out all rows of these tables of a problem."""
    for table in tables:
        for path, value in leaves(getattr(draft, table)).items():
            if path != "mount":  # one for all rows of odometry
                change(getattr(draft, table), path, value[:0])
