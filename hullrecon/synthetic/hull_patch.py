# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The surveyed part of a hull as a regular grid in (along, girth).

Sections of the CAD model are found by ray casting, and resampled at equal steps of arc length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.open3d_import import import_open3d
from hullrecon.typing import Array, Floats32


@dataclass(frozen=True)
class Hits:
    """What n rays hit."""

    range_m: Floats32  # (n,) infinite where nothing was hit
    face: NDArray[np.int64]  # (n,)
    weight: Floats32  # (n, 3) barycentric weights of the face's corners

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Rays (n,) that hit."""
        return np.asarray(np.isfinite(self.range_m))


class Rays:
    """A mesh to cast rays at. Its middle is subtracted from origins, as rays are in float32."""

    def __init__(self, mesh: Mesh) -> None:
        """Load the mesh into Open3D's ray caster, with its middle at the origin."""
        o3d = import_open3d()
        self.middle: Array = mesh.vertices.mean(0)
        self._tensor = o3d.core.Tensor
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=2)
        self._scene.add_triangles(
            self._tensor(np.ascontiguousarray(mesh.vertices - self.middle, np.float32)),
            self._tensor(np.ascontiguousarray(mesh.faces, np.uint32)),
        )

    def cast(self, origins: Array, directions: NDArray[Any]) -> Hits:
        """Find the nearest hits from origins (n, 3) or (3,) along unit directions (n, 3)."""
        answer = self._scene.cast_rays(self._pack(origins, directions))
        uv = answer["primitive_uvs"].numpy()
        weight = np.stack([1 - uv[:, 0] - uv[:, 1], uv[:, 0], uv[:, 1]], axis=1)
        face = answer["primitive_ids"].numpy().astype(np.int64)
        return Hits(answer["t_hit"].numpy(), np.where(face == 0xFFFFFFFF, 0, face), weight)

    def is_blocked(
        self, origins: Array, directions: NDArray[Any], reach_m: NDArray[Any]
    ) -> NDArray[np.bool_]:
        """Decide for each ray (n,) whether it hits something nearer than `reach_m` (n,)."""
        answer = self._scene.cast_rays(self._pack(origins, directions))["t_hit"].numpy()
        return np.asarray(answer < reach_m)

    def _pack(self, origins: Array, directions: NDArray[Any]) -> Any:
        """Convert rays to the tensor (n, 6) that Open3D takes."""
        rows = np.empty((len(directions), 6), np.float32)
        rows[:, :3], rows[:, 3:] = origins - self.middle, directions
        return self._tensor(rows)


GAP_M = 0.6  # a larger gap between hits of neighbouring rays is an edge, which ends a section
BLOCK_CELLS = 4e5  # cells of the grid in a block, whose meshes take some 0.3 GB
# Hull on both sides of a block that is built with it: more than any sensor sees along the hull.
MARGIN_M = 4.0


@dataclass(frozen=True)
class HullPatch:
    """A part of the CAD model on evenly spaced chart coordinates, in the hull's frame."""

    along_m: Array  # (a,)
    girth_m: Array  # (g,)
    point: Array  # (a, g, 3)
    normal: Array  # (a, g, 3) outward unit vectors

    def sample(self, grid: Array, along_m: Array, girth_m: Array) -> Array:
        """Interpolate a grid (a, g, k) at chart points (n,); outside, the edge's values."""
        i, p = _cell_and_share(self.along_m, along_m)
        j, q = _cell_and_share(self.girth_m, girth_m)
        p, q = p[:, None], q[:, None]
        low = (1 - p) * grid[i, j] + p * grid[i + 1, j]
        high = (1 - p) * grid[i, j + 1] + p * grid[i + 1, j + 1]
        return np.asarray((1 - q) * low + q * high)

    def smooth(self, width_m: float) -> HullPatch:
        """Smooth the normals by a Gaussian whose sigma is width_m: the vehicle follows these."""
        from scipy.ndimage import gaussian_filter

        sigma = width_m / (self.along_m[1] - self.along_m[0])
        blur = np.stack(
            [gaussian_filter(self.normal[..., k], sigma, mode="nearest") for k in range(3)], -1
        )
        return HullPatch(
            self.along_m,
            self.girth_m,
            self.point,
            blur / np.linalg.norm(blur, axis=2, keepdims=True),
        )


class HullSkin:
    """The surveyed part of the CAD model's port side, cut block by block along the hull.

    Girth is arc length along a section, upwards. It is 0 at z = zero_z_m, so that legs of constant
    girth keep their depth near bow and stern. It reaches up to z = top_z_m and down to -down_m,
    past the keel if that far. The whole grid is along_m (a,), girth_m (g,).
    """

    def __init__(
        self,
        cad_model: Mesh,
        span_m: tuple[float, float],
        *,
        zero_z_m: float,
        top_z_m: float,
        down_m: float,
        step_m: float = 0.03,
        block_cells: float = BLOCK_CELLS,
    ) -> None:
        """Lay the grid over span_m along the hull, and over the girths that every section has.

        zero_z_m, top_z_m, down_m: as in the class. step_m: between nodes of the grid. block_cells:
        most cells of a block. Raises InputError if the CAD model has too little skin there.
        """
        self._caster, self._zero_z_m = Rays(cad_model), zero_z_m
        self._high_z_m = float(cad_model.vertices[:, 2].max())
        self._far_m = 2.0 * float(np.abs(cad_model.vertices[:, 1:]).max())
        self.along_m = (
            np.arange(np.floor(span_m[0] / step_m), np.ceil(span_m[1] / step_m) + 1) * step_m
        )
        # Girths that every section has
        low, high = -down_m, np.inf
        for arc, line in self._sections(self.along_m):
            low, high = max(low, float(arc[0])), min(high, _arc_at(arc, line, top_z_m))
        self.girth_m = np.arange(np.ceil(low / step_m), np.floor(high / step_m) + 1) * step_m
        if len(self.girth_m) < 10:
            remedy = "move `along_m`, or dive deeper with `top_m`"
            raise InputError("the hull has too little skin where the dive is", remedy=remedy)
        blocks = int(np.ceil(len(self.along_m) * len(self.girth_m) / block_cells))
        self._edges = np.rint(np.linspace(0, len(self.along_m) - 1, blocks + 1)).astype(int)
        self._margin = int(np.ceil(MARGIN_M / step_m))

    def __len__(self) -> int:
        """Count the blocks."""
        return len(self._edges) - 1

    def core_m(self, block: int) -> tuple[float, float]:
        """Look up where a block begins and ends along the hull, without its margin."""
        first, last = self._edges[block : block + 2]
        return float(self.along_m[first]), float(self.along_m[last])

    def block_of(self, along_m: Array) -> NDArray[np.int64]:
        """Find the block (n,) of positions along the hull, the first or last for those outside."""
        return np.searchsorted(self.along_m[self._edges[1:-1]], along_m, side="right")

    def patch(self, block: int) -> HullPatch:
        """Cut a block with its margin on both sides."""
        first = max(0, int(self._edges[block]) - self._margin)
        last = min(len(self.along_m), int(self._edges[block + 1]) + self._margin + 1)
        return self._cut_patch(first, last)

    def follow(self, along_m: Array, girth_m: Array, width_m: float) -> tuple[Array, Array]:
        """Sample points (n, 3) of the hull at chart coordinates (n,), and their normals (n, 3).

        The normals are smoothed over width_m. along_m, girth_m: the chart coordinates.
        """
        point, normal = np.empty((len(along_m), 3)), np.empty((len(along_m), 3))
        block = self.block_of(along_m)
        for k in np.unique(block).tolist():
            rows, smooth = block == k, self.patch(k).smooth(width_m)
            point[rows] = smooth.sample(smooth.point, along_m[rows], girth_m[rows])
            normal[rows] = smooth.sample(smooth.normal, along_m[rows], girth_m[rows])
        return point, normal

    @cached_property
    def middle(self) -> Array:
        """The mean (3,) of the grid's points."""
        total = np.zeros(3)
        for first, last in zip(
            self._edges[:-1], [*self._edges[1:-1], len(self.along_m)], strict=True
        ):
            total += self._cut_patch(int(first), int(last)).point.reshape(-1, 3).sum(0)
        return np.asarray(total / (len(self.along_m) * len(self.girth_m)))

    def _cut_patch(self, first: int, last: int) -> HullPatch:
        """Cut the columns first to last of the grid from the CAD model."""
        along = self.along_m[first:last]
        point = np.empty((len(along), len(self.girth_m), 3))
        for row, (arc, line) in zip(point, self._sections(along), strict=True):
            row[:] = np.stack([np.interp(self.girth_m, arc, line[:, k]) for k in range(3)], -1)
        return HullPatch(along, self.girth_m, point, _normals(point))

    def _sections(self, along_m: Array, rays: int = 3000) -> Iterator[tuple[Array, Array]]:
        """Yield for each section arc lengths (k,) and points (k, 3) of the skin.

        Arc length is 0 where the port side passes zero_z_m. The points are hits of rays that go
        from far outside towards a point inside the hull, from below the keel on starboard around to
        port. along_m: stations of the sections. rays: cast at each.
        """
        spine = np.array([0.0, 1e-3 * self._high_z_m, 0.55 * self._high_z_m])
        angle = np.linspace(-1.25, 2.5, rays)
        outward = np.stack([np.zeros(rays), np.sin(angle), -np.cos(angle)], 1)
        for x in along_m:
            arc, line = _section(
                self._caster, spine + np.array([x, 0.0, 0.0]), outward, self._far_m, angle
            )
            yield arc - _arc_at(arc, line, self._zero_z_m), line


def _section(
    caster: Rays, spine: Array, out: Array, far: float, angle: Array
) -> tuple[Array, Array]:
    """Cast the rays of one section: arc lengths (k,) and points (k, 3), up to the first gaps.

    Raises InputError where fewer than two rays hit the hull.

    Parameters
    ----------
    caster
        The CAD model.
    spine
        Point (3,) inside the hull.
    out
        Unit vectors (r, 3) from the spine outward.
    far
        Distance from the spine at which rays begin, m.
    angle
        (r,) of each ray, 0 straight down. Arc length counts from there.
    """
    hits = caster.cast(spine + far * out, -out)
    good = hits.hit & (hits.range_m < far)  # a hit beyond the spine is on the hull's other side
    if good.sum() < 2:
        raise InputError(
            "the hull has no section", where=f"x = {spine[0]:.2f} m", remedy="move `along_m`"
        )
    line = spine + (far - hits.range_m[good, None].astype(float)) * out[good]
    # The section goes from straight down to the first gap on either side
    middle = int(np.argmin(np.abs(angle[good])))
    jump = np.linalg.norm(np.diff(line, axis=0), axis=1)
    gap = np.flatnonzero(jump > GAP_M)
    first = int(np.max(gap[gap < middle], initial=-1)) + 1
    last = int(np.min(gap[gap >= middle], initial=len(jump)))
    arc = np.concatenate([[0.0], np.cumsum(jump[first:last])])
    return arc - arc[middle - first], line[first : last + 1]


def _arc_at(arc: Array, line: Array, z_m: float) -> float:
    """Find the arc length where the port side of a section first passes that height."""
    lowest = int(np.argmin(line[:, 2]))
    return float(np.interp(z_m, np.maximum.accumulate(line[lowest:, 2]), arc[lowest:]))


def _normals(point: Array) -> Array:
    """Compute outward unit normals (a, g, 3) of a grid of points."""
    along, girth = np.gradient(point, axis=0), np.gradient(point, axis=1)
    normal = np.cross(girth, along)
    return np.asarray(normal / np.linalg.norm(normal, axis=2, keepdims=True))


def _cell_and_share(axis: Array, value: Array) -> tuple[NDArray[np.int64], Array]:
    """Find the cell of each value (n,) on an even axis, and how far in the cell it is, 0..1."""
    at = np.clip((value - axis[0]) / (axis[1] - axis[0]), 0, len(axis) - 1 - 1e-9)
    cell = np.floor(at).astype(np.int64)
    return cell, at - cell
