# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Binary little-endian PLY files as bytes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

_NAMES = {"float32": "float", "float64": "double", "uint8": "uchar", "int32": "int"}


def ply_bytes(
    vertex: Mapping[str, NDArray[np.generic]],
    faces: NDArray[np.integer] | None = None,
    comments: Sequence[str] = (),
) -> bytes:
    """Encode vertex properties (n,), in the order given, and triangles (m, 3) as PLY.

    Raises KeyError for a property that is not float32, float64, uint8 or int32.
    """
    columns = {name: np.asarray(values) for name, values in vertex.items()}
    count = len(next(iter(columns.values())))
    header = ["ply", "format binary_little_endian 1.0", *(f"comment {line}" for line in comments)]
    header += [
        f"element vertex {count}",
        *(f"property {_NAMES[v.dtype.name]} {n}" for n, v in columns.items()),
    ]
    rows = np.empty(
        count, [(name, values.dtype.newbyteorder("<")) for name, values in columns.items()]
    )
    for name, values in columns.items():
        rows[name] = values
    body = rows.tobytes()
    if faces is not None:
        header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        triangles = np.empty(len(faces), [("n", "u1"), ("v", "<i4", 3)])
        triangles["n"], triangles["v"] = 3, faces
        body += triangles.tobytes()
    return "\n".join([*header, "end_header", ""]).encode("ascii", "replace") + body


def columns(points: NDArray[np.float64]) -> dict[str, NDArray[np.generic]]:
    """Split points (n, 3) into columns x, y, z of double precision.

    Single precision has steps of 4 mm at a ship's length from a harbour's origin.
    """
    return {name: np.ascontiguousarray(points[:, k]) for k, name in enumerate("xyz")}
