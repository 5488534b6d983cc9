# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""JSON as artifacts hold it: sorted keys, finite numbers, and a seal that a flipped bit breaks."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping

import msgspec
import numpy as np

SEAL = "seal"
# The seal's line in a document as `encode` writes it. Nested members are indented further, and text
# has no line breaks
_LINE = re.compile(rb'\n "seal": "[0-9a-f]{64}"(,?)')
Json = None | bool | int | float | str | list["Json"] | dict[str, "Json"]


class DamagedArtifactError(ValueError):
    """A document whose bytes differ from those that were sealed."""


def encode(value: object) -> bytes:
    """Write a value as indented UTF-8 with sorted keys.

    Raises ValueError with the path of a NaN or an infinity.
    """
    shown = plain(value)
    try:
        text = json.dumps(shown, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False)
    except ValueError as error:
        place = _not_finite(shown, "") or "an unknown path"
        raise ValueError(f"not a finite number at {place}") from error
    # File names may hold bytes that are not UTF-8.
    return (text + "\n").encode(errors="backslashreplace")


def digest(value: object) -> str:
    """Hash the encoded value (SHA-256)."""
    return hashlib.sha256(encode(value)).hexdigest()


def seal(value: Mapping[str, object]) -> bytes:
    """Encode a mapping with its own hash (SHA-256) as a further member."""
    blank = "0" * 64
    document = encode({**value, SEAL: blank})
    stated = hashlib.sha256(_without_seal(document)).hexdigest()
    return document.replace(f'\n "{SEAL}": "{blank}'.encode(), f'\n "{SEAL}": "{stated}'.encode())


def unseal(data: bytes) -> dict[str, object]:
    """Decode a sealed mapping. Raises DamagedArtifactError if any byte differs."""
    try:
        value = json.loads(data)
        content = {k: v for k, v in value.items() if k != SEAL}
    except (ValueError, AttributeError, RecursionError) as error:
        raise DamagedArtifactError("not readable as JSON") from error
    is_sorted = list(value) == sorted(value)
    if not is_sorted or hashlib.sha256(_without_seal(data)).hexdigest() != value.get(SEAL):
        raise DamagedArtifactError("its seal does not fit its content")
    return content


def _without_seal(document: bytes) -> bytes:
    """Cut the seal's line out of a document, to the bytes of which it is the hash.

    A document that `encode` did not write so is left as it is.
    """
    line = _LINE.search(document)
    if line is None:
        return document
    before, after = document[: line.start()], document[line.end() :]
    if line[1]:
        return before + after
    if before.endswith(b","):  # it is the last member
        return before[:-1] + after
    return b"{}\n" if document == b"{" + line[0] + b"\n}\n" else document


def plain(value: object) -> Json:
    """Convert structs, NumPy scalars and arrays to JSON's types, keys to text.

    Raises TypeError with the name of any other type.
    """
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if value is None or isinstance(value, str | int | float):
        return value
    return plain(msgspec.to_builtins(value, enc_hook=_convert_numpy))


def _convert_numpy(value: object) -> object:
    """Convert NumPy's values to Python's. Raises TypeError for any other type."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} cannot be written as JSON")


def _not_finite(value: Json, path: str) -> str | None:
    """Find the path of the first number that is not finite, such as `objects[2].height`.

    None where all are finite. path: of `value` in the document.
    """
    if isinstance(value, float):
        return None if math.isfinite(value) else path
    members: list[tuple[str, Json]] = []
    if isinstance(value, dict):
        members = [(f"{path}.{k}" if path else k, v) for k, v in sorted(value.items())]
    elif isinstance(value, list):
        members = [(f"{path}[{i}]", v) for i, v in enumerate(value)]
    for name, member in members:
        found = _not_finite(member, name)
        if found is not None:
            return found
    return None
