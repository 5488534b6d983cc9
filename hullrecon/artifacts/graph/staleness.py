# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Explain why an artifact is not what a run would make now."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

from hullrecon.artifacts.graph.settings import flatten
from hullrecon.artifacts.storage.documents import Json
from hullrecon.artifacts.storage.manifest import FileRecord, Recipe

_ABSENT = object()


def differences(made: Recipe, now: Recipe) -> list[str]:
    """Return a sentence for each part of the recipe that changed; none exactly when the keys are
    equal.
    """
    return [
        *_options(made.settings, now.settings),
        *_inputs(made.inputs, now.inputs),
        *_external(made.external, now.external),
        *_failures(made.failures, now.failures),
        *([f"code version {made.version} -> {now.version}"] if made.version != now.version else []),
        *([f"it was made by step {made.stage}"] if made.stage != now.stage else []),
    ]


def _options(made: Mapping[str, Json], now: Mapping[str, Json]) -> Iterator[str]:
    """Yield a sentence for each changed option; one for a whole section that came or went, or that
    the step reads no longer.
    """
    for section in sorted({*made, *now}):
        before, after = made.get(section, _ABSENT), now.get(section, _ABSENT)
        if isinstance(before, dict) and isinstance(after, dict):
            yield from _changed_options(
                flatten(before, f"{section}."), flatten(after, f"{section}.")
            )
        elif after is _ABSENT:
            yield f"{section} is no longer read, it was {_as_text(before)}"
        elif before is _ABSENT:
            yield f"{section} is read now, it is {_as_text(after)}"
        elif before != after:
            yield f"{section} changed from {_as_text(before)} to {_as_text(after)}"


def _changed_options(before: Mapping[str, Json], after: Mapping[str, Json]) -> Iterator[str]:
    for name in sorted({*before, *after}):
        one, two = before.get(name, _ABSENT), after.get(name, _ABSENT)
        if one is _ABSENT:
            yield f"option {name} is new, it is {_as_text(two)}"
        elif two is _ABSENT:
            yield f"option {name} is gone, it was {_as_text(one)}"
        elif one != two or type(one) is not type(two):
            yield f"option {name} changed from {_as_text(one)} to {_as_text(two)}"


def _inputs(made: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield f"input {name} {_verb(name in made, name in now)}"


def _external(made: Mapping[str, FileRecord], now: Mapping[str, FileRecord]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield f"external file {name} {_verb(name in made, name in now)}"


def _failures(made: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*made, *now}):
        if made.get(name) != now.get(name):
            yield (
                f"{name} failed: {now[name]}"
                if name in now
                else f"it was made without {name}, which had failed"
            )


def _verb(before: bool, after: bool) -> str:
    return "changed" if before and after else "is new" if after else "is gone"


def _as_text(value: object) -> str:
    """Return a whole section as the word for it, any other value as in JSON."""
    if value is None:
        return "none"
    return "a section" if isinstance(value, dict) else json.dumps(value, ensure_ascii=False)
