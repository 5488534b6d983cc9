# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""JSON as artifacts hold it: sorted keys, finite numbers, and a seal that a flipped bit breaks."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

SEAL = "seal"


class DamagedError(ValueError):
    """A document whose bytes are not those that were sealed."""


def encode(value: object) -> bytes:
    """Indented UTF-8 with sorted keys and a line's end. ValueError names the place of a NaN or an infinity."""
    shown = plain(value)
    try:
        text = json.dumps(shown, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    except ValueError as error:
        raise ValueError(f"not a finite number at {_not_finite(shown, '') or 'an unknown place'}") from error
    return (text + "\n").encode()


def digest(value: object) -> str:
    """SHA-256 of the encoded value."""
    return hashlib.sha256(encode(value)).hexdigest()


def seal(value: Mapping[str, Any]) -> bytes:
    """The encoded mapping with a member that holds the hash of all others."""
    return encode({**value, SEAL: digest(value)})


def unseal(data: bytes) -> dict[str, Any]:
    """The mapping without its seal; DamagedError unless every byte is as it was sealed."""
    try:
        value = json.loads(data)
        rest = {k: v for k, v in value.items() if k != SEAL}
        whole = seal(rest) == data
    except (ValueError, AttributeError, RecursionError) as error:
        raise DamagedError("not readable as JSON") from error
    if not whole:
        raise DamagedError("its seal does not fit its content")
    return rest


def plain(value: Any) -> Any:
    """Structs, NumPy scalars and arrays as what JSON knows; keys as text so that they sort."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, str | int | float):
        return value
    return plain(msgspec.to_builtins(value))


def _not_finite(value: Any, place: str) -> str | None:
    """The place of the first number that is not finite, such as `objects[2].height`."""
    if isinstance(value, float):
        return None if math.isfinite(value) else place
    members: list[tuple[str, Any]] = []
    if isinstance(value, dict):
        members = [(f"{place}.{k}" if place else k, v) for k, v in sorted(value.items())]
    elif isinstance(value, list):
        members = [(f"{place}[{i}]", v) for i, v in enumerate(value)]
    return next((found for name, member in members if (found := _not_finite(member, name)) is not None), None)
