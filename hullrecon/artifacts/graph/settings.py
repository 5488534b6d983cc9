# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Select the part of the configuration that one stage sees."""

from __future__ import annotations

import math
from collections.abc import Mapping

from msgspec import Struct, structs

from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.graph.stage_settings import StageSettings
from hullrecon.artifacts.storage.documents import Json, plain
from hullrecon.errors import UsageError


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
