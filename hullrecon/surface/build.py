# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Build a triangulated surface with its sigma from points on the chart (docs/methods.md 11).

The offsets of DVL returns or landmarks from the chart's base surface are regressed at the nodes of
a grid on the chart. The grid is refined, and its vertices are moved along the chart's normals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.mesh import Mesh, face_cross_products
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.neighbours import count_within, nearest
from hullrecon.geometry.robust import robust_sigma
from hullrecon.records.surface import Surface
from hullrecon.rows import Rows
from hullrecon.surface.gaussian import (
    MOST,
    Kernel,
    Observations,
    cell_means,
    fit_robust,
    maximise_likelihood,
    regress,
)
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, object]
GRID_STEP_M = 0.2  # spacing of the chart's grid, subdivided afterwards
ROUGHNESS_SIGMA_M = 0.01  # sigma of a single return about the smooth hull
# Least cosine between the normals of chart and datum with which a height becomes an offset
MIN_FACING = 0.2
STRUCTURE_SIGMAS = 3.0  # an observation farther off a smooth surface is of a structure
# Side of a cell of averaging, as a share of the kernel's lengths, where there are more observations
# than one regression takes
WIDE_CELL = 0.05
# Observations from which the marginal likelihood is computed: a step of the search takes some 10 ms
LIKELIHOOD_POINTS = 400


@dataclass(frozen=True, kw_only=True)
class SurfacePoints(Rows):
    """The n points from which the surface is regressed, in the chart's frame, without outliers."""

    point: Array  # (n, 3) m
    noise: Array  # (n,) m, sigma of the part that is independent from point to point
    pose_sigma: Array  # (n,) m, sigma of the part that neighbours have in common
    # (n,) whether the surface covers the hull around the point: returns, or landmarks without any
    gives_support: Mask


# From chart points (n, 3), the observations there, and chart points wanted (k, 2), computes offsets
# (k,) m and sigmas (k,) m, with facts for surface.json
Regression = Callable[[Array, SurfacePoints, Array, SurfaceOptions], tuple[Array, Array, Facts]]


def gaussian_process(
    charted: Array,
    observed: SurfacePoints,
    wanted: Array,
    options: SurfaceOptions,
    form: type[Kernel] = Kernel,
) -> tuple[Array, Array, Facts]:
    """Regress offsets by a Gaussian process (docs/methods.md 11).

    Its mean is the observations' median, to which the surface returns far from all observations.

    Parameters
    ----------
    charted
        Along, girth and offset (n, 3) m of the observations.
    observed
        The same observations (n,). Of their sigmas only the independent `noise` is used:
        `build_surface` adds what poses share afterwards.
    wanted
        Along and girth (k, 2) m at which offsets are predicted.
    options
        The section [surface] of dive.toml.
    form
        Class of the kernel, whose lengths and sigma come from the options or are fitted.

    Returns
    -------
    offset, sigma, facts
        (k,) m each, the sigma without the error that poses share, and facts for surface.json.
    """
    noise = np.hypot(observed.noise, ROUGHNESS_SIGMA_M)
    seen = cell_means(charted[:, :2], charted[:, 2], noise, options.cell_m)
    kernel = form((options.length_along_m, options.length_girth_m), options.offset_sigma_m)
    scale = 1.0
    middle = float(np.median(seen.offset))
    if options.fit:
        few = _on_smooth_hull(kernel, _sample(seen), middle)
        limit = (4 * options.cell_m, 60.0)
        kernel, scale = maximise_likelihood(kernel, few.at, few.offset - middle, few.noise, limit)
    # Means over a fraction of the kernel's lengths describe a smooth hull as well
    if len(seen.at) > MOST:
        seen = cell_means(
            charted[:, :2],
            charted[:, 2],
            noise,
            np.maximum(options.cell_m, WIDE_CELL * np.array(kernel.length)),
        )
    seen = replace(seen, offset=seen.offset - middle, noise=seen.noise * scale)
    found = regress(kernel, seen, wanted)
    facts: Facts = {
        "method": "gp",
        "kernel": kernel.NAME,
        "lengths_m": [round(x, 4) for x in kernel.length],
        "sigma_m": kernel.sigma,
        "noise_scale": scale,
        "observations": len(seen.at),
        "mean_offset_m": middle,
        "tiles": found.tiles,
    }
    return middle + found.mean, found.sigma, facts


def build_surface(
    observed: SurfacePoints,
    chart: Chart,
    options: SurfaceOptions,
    datum: PlaneChart | None = None,
    regression: Regression = gaussian_process,
) -> tuple[Surface, Facts]:
    """Build the surface (deviation NaN), with facts for surface.json.

    Without a datum, offsets from the chart's base surface are regressed. Far from returns the
    result is then the base surface, moved by the returns' median offset. With a datum, heights
    above that plane are regressed instead, and the shape of the chart does not enter the result.
    Where the chart is too steep on the datum there is no surface.

    Parameters
    ----------
    observed
        Points of the hull. Those off the chart are left out.
    chart
        Gives each point its position along and in girth, and the normals along which vertices move.
    options
        The section [surface] of dive.toml.
    datum
        Plane from which heights are regressed. None: offsets from the chart are.
    regression
        The method of regression.

    Raises
    ------
    StageError
        Where no return lies on the chart, or where they are too sparse.
    """
    # Points on the chart, (along, girth, what is regressed).
    charted = chart.to_chart(observed.point)
    known = np.asarray(np.isfinite(charted).all(axis=1))
    if not (known & observed.gives_support).any():
        raise StageError("no return lies on the chart", where="surface")
    charted, observed = charted[known], observed.take(known)
    if datum is not None:
        charted[:, 2] = datum.to_chart(observed.point)[:, 2]
    grid = supported_lattice(charted[observed.gives_support, :2], GRID_STEP_M, options.reach_m)
    if not len(grid.faces):
        raise StageError(
            "the returns are too sparse for a surface",
            where="surface",
            remedy="raise surface.reach_m",
        )
    # Offsets at the nodes of a grid, then at a finer mesh's vertices.
    offset, sigma, facts = regression(charted, observed, grid.vertices[:, :2], options)
    if datum is not None:
        offset, sigma = _heights_to_offsets(offset, sigma, grid.vertices[:, :2], chart, datum)
    mesh, values = refine(grid, options.max_edge_m, np.stack([offset, sigma], axis=1))
    shared = _nearest(charted[:, :2], observed.pose_sigma, mesh.vertices[:, :2])
    support = count_within(
        charted[observed.gives_support, :2], mesh.vertices[:, :2], options.reach_m
    )
    surface = _lift_to_space(
        mesh, values[:, 0], np.hypot(values[:, 1], shared), np.maximum(support, 1), chart
    )
    return surface, {**facts, "vertices": len(surface.vertices), "faces": len(surface.faces)}


def _heights_to_offsets(
    height: Array, sigma: Array, at: Array, chart: Chart, datum: PlaneChart
) -> tuple[Array, Array]:
    """Convert heights (n,) m above the datum to offsets (n,) m along the chart's normals.

    With them vertices are lifted off the chart, as without a datum. NaN where the chart is too
    steep on the datum. sigma: (n,) m of the heights, converted too. at: (n, 2) m on the chart.
    """
    base, normal = chart.from_chart(at)
    # Cosine between the two normals: a step along the chart's rises by this much over the datum
    lean = normal @ datum.axes[2]
    lean = np.where(lean > MIN_FACING, lean, np.nan)
    return (height - datum.to_chart(base)[:, 2]) / lean, sigma / lean


def _on_smooth_hull(kernel: Kernel, seen: Observations, middle: float) -> Observations:
    """Leave out observations beyond STRUCTURE_SIGMAS of a smooth surface with this kernel.

    The marginal likelihood has no outliers. It would take structures for noise, and flatten the
    hull. middle: m, the offset from which the field is regressed.
    """
    off = (
        seen.offset
        - middle
        - fit_robust(kernel, seen.at, seen.offset - middle, seen.noise).mean(seen.at)
    )
    return seen.take(np.abs(off) <= STRUCTURE_SIGMAS * np.maximum(robust_sigma(off), seen.noise))


def _sample(seen: Observations) -> Observations:
    """Choose LIKELIHOOD_POINTS observations: half from a compact part, half spread evenly.

    The marginal likelihood of all would take too long. The compact part shows short correlation
    lengths, the others long ones.
    """
    far = np.linalg.norm(
        (seen.at - np.median(seen.at, axis=0)) / np.maximum(np.std(seen.at, axis=0), 1e-9), axis=1
    )
    spread = np.linspace(0, len(far) - 1, LIKELIHOOD_POINTS // 2).astype(np.int64)
    part = np.union1d(np.argsort(far, kind="stable")[: LIKELIHOOD_POINTS // 2], spread)
    return seen.take(part)


def _lift_to_space(mesh: Mesh, offset: Array, sigma: Array, support: Ints, chart: Chart) -> Surface:
    """Move the vertices of a mesh on the chart into space, and drop faces outside the chart.

    Faces are oriented outward.

    Parameters
    ----------
    mesh
        Its vertices (n, 3) are along, girth, 0.
    offset, sigma, support
        (n,) of each vertex: offset from the chart and its sigma, m, and number of returns near by.
    chart
        Gives the points in space from which vertices are moved, and the normals along which.
    """
    base, normal = chart.from_chart(mesh.vertices[:, :2])
    vertices = base + normal * offset[:, None]
    placed = np.asarray(np.isfinite(vertices).all(axis=1))
    used, renumbered = np.unique(mesh.faces[placed[mesh.faces].all(axis=1)], return_inverse=True)
    faces = renumbered.reshape(-1, 3).astype(np.int32)
    vertices, normal = vertices[used], normal[used]
    inward = (
        np.einsum("ni,ni->n", face_cross_products(Mesh(vertices, faces)), normal[faces[:, 0]]) < 0
    )
    faces[inward] = faces[inward][:, ::-1]
    nothing = np.full(len(used), np.nan)
    return Surface(
        vertices=vertices, faces=faces, deviation=nothing, sigma=sigma[used], support=support[used]
    )


def _nearest(at: Array, values: Array, wanted: Array) -> Array:
    """Look up the value (n,) of the point (n, 2) nearest to each wanted point (k, 2)."""
    return np.asarray(values[nearest(at, wanted, 1)[1][:, 0]])


def supported_lattice(at: Array, step_m: float, reach_m: float) -> Mesh:
    """Triangulate the nodes of a grid on the chart that lie within `reach_m` of a return.

    Only cells with four such nodes have faces. Vertices are (along, girth, 0), and faces are
    counter-clockwise in (along, girth).

    at (n, 2): returns on the chart, m. step_m: of the grid.
    """
    from scipy.spatial import cKDTree

    # A grid around the returns, and which of its nodes have a return near by.
    low = np.floor((at.min(axis=0) - reach_m) / step_m)
    count = (np.ceil((at.max(axis=0) + reach_m) / step_m) - low).astype(int) + 1
    along, girth = np.meshgrid(
        *(step_m * (low[k] + np.arange(count[k])) for k in (0, 1)), indexing="ij"
    )
    nodes = np.stack([along.ravel(), girth.ravel()], axis=1)
    near = np.isfinite(cKDTree(at).query(nodes, distance_upper_bound=reach_m)[0]).reshape(count)

    # Two triangles for each cell with four such nodes.
    number = np.arange(nodes.shape[0]).reshape(count)
    corners = (np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:])
    whole = np.all([near[corner] for corner in corners], axis=0)
    a, b, c, d = (number[corner][whole] for corner in corners)
    faces = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    used, renumbered = np.unique(faces, return_inverse=True)
    vertices = np.hstack([nodes[used], np.zeros((len(used), 1))])
    return Mesh(vertices, renumbered.reshape(-1, 3).astype(np.int32))
