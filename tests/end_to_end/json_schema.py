# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""As much of JSON Schema (2020-12) as hullrecon/report/schemas use; a keyword not understood is an
error, not a pass.
"""

import base64
import re

TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}
ANNOTATIONS = {"$schema", "title", "description"}


def violations(value, schema, path="$"):
    """Return a sentence for each place where a value breaks the schema."""
    found = []
    for keyword, wanted in schema.items():
        if keyword not in ANNOTATIONS:
            found += [f"{path}: {words}" for words in KEYWORDS[keyword](value, wanted)]
    for name, member in value.items() if isinstance(value, dict) else ():
        inner = schema.get("properties", {}).get(name, schema.get("additionalProperties"))
        found += violations(member, inner, f"{path}.{name}") if isinstance(inner, dict) else []
    for k, member in enumerate(value if isinstance(value, list) else ()):
        found += violations(member, schema["items"], f"{path}[{k}]") if "items" in schema else []
    unknown = set(value) - set(schema.get("properties", {})) if isinstance(value, dict) else set()
    return found + [
        f"{path}: {name} is not known"
        for name in sorted(unknown)
        if schema.get("additionalProperties") is False
    ]


def _is(value, kind):
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind == "integer":
        return number and float(value).is_integer()
    return number if kind == "number" else isinstance(value, TYPES[kind])


def _when(kind, broken):
    """A keyword that speaks of one type says nothing of the others."""
    return lambda value, wanted: (
        [f"breaks {wanted}"] if isinstance(value, kind) and broken(value, wanted) else []
    )


KEYWORDS = {
    "type": lambda v, w: (
        [] if any(_is(v, k) for k in ([w] if isinstance(w, str) else w)) else [f"{v!r} is no {w}"]
    ),
    "const": lambda v, w: [] if v == w else [f"{v!r} is not {w!r}"],
    "enum": lambda v, w: [] if v in w else [f"{v!r} is none of {w}"],
    "required": _when(dict, lambda v, w: set(w) - set(v)),
    "minimum": _when(int | float, lambda v, w: v < w),
    "maximum": _when(int | float, lambda v, w: v > w),
    "minItems": _when(list, lambda v, w: len(v) < w),
    "maxItems": _when(list, lambda v, w: len(v) > w),
    "pattern": _when(str, lambda v, w: not re.search(w, v)),
    "oneOf": lambda v, w: (
        [] if sum(not violations(v, one) for one in w) == 1 else [f"{v!r} is not one of {w}"]
    ),
    "anyOf": lambda v, w: (
        [] if any(not violations(v, one) for one in w) else [f"{v!r} is none of {w}"]
    ),
    "contentEncoding": lambda v, w: (
        [] if w == "base64" and base64.b64decode(v, validate=True) is not None else [f"no {w}"]
    ),
    "properties": lambda v, w: [],
    "items": lambda v, w: [],
    "additionalProperties": lambda v, w: [],
}
