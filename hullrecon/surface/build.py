# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From returns on the chart to a triangulated surface with its sigma (docs/methods.md 11)."""

from __future__ import annotations

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
from hullrecon.surface.lattice import supported_lattice
from hullrecon.surface.options import SurfaceOptions
from hullrecon.surface.regression.gaussian import fit_robust, maximise_likelihood
from hullrecon.surface.regression.kernels import Kernel
from hullrecon.surface.regression.linear import interpolate, scatter_sigma
from hullrecon.surface.regression.thinning import Observations, cell_means
from hullrecon.surface.regression.tiles import MOST, regress
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, object]
# cosine between the chart's normal and the datum's below which a height places nothing
MIN_FACING = 0.2
STRUCTURE_SIGMAS = 3.0  # off a smooth surface beyond which an observation is of a structure
# of the kernel's lengths: side of a cell where there are more observations than one regression
# takes
WIDE_CELL = 0.05
# observations that the marginal likelihood looks at: a step of the search takes some 10 ms
LIKELIHOOD_POINTS = 400


@dataclass(frozen=True, kw_only=True)
class SurfacePoints:
    """Inliers in the chart's frame. point (n, 3); noise (n,) m, white; pose_sigma (n,) m, what
    neighbours share; gives_support (n,) bool: the surface covers what lies around it (a DVL return;
    a landmark where there is no DVL).
    """

    point: Array
    noise: Array
    pose_sigma: Array
    gives_support: Mask


def build_surface(
    observed: SurfacePoints, chart: Chart, options: SurfaceOptions, datum: PlaneChart | None = None
) -> tuple[Surface, Facts]:
    """Return the surface (deviation NaN) and what was found on the way, for surface.json.

    Without a datum, offsets from the chart's base surface are regressed; so the mean, far from
    returns, is the base surface. With a datum, heights over that plane are: the chart only numbers
    places, its shape does not enter the mean. Where the chart stands too steep on the datum there
    is no surface.
    """
    charted = chart.to_chart(observed.point)
    known = np.asarray(np.isfinite(charted).all(axis=1))
    if not (known & observed.gives_support).any():
        raise StageError(
            "no return lies on the chart",
            where="surface",
            remedy="check hull.pose, dvl.mount and tray.origin",
        )
    charted, observed = charted[known], _take(observed, known)
    if datum is not None:
        charted[:, 2] = datum.to_chart(observed.point)[:, 2]
    grid = supported_lattice(
        charted[observed.gives_support, :2], options.grid_step_m, options.reach_m
    )
    if not len(grid.faces):
        raise StageError(
            "the returns are too sparse for a surface",
            where="surface",
            remedy="raise surface.reach_m",
        )
    estimate = _by_gaussian_process if options.method == "gp" else _by_triangles
    offset, sigma, facts = estimate(charted, observed, grid.vertices[:, :2], options)
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


def _by_gaussian_process(
    charted: Array, observed: SurfacePoints, wanted: Array, options: SurfaceOptions
) -> tuple[Array, Array, Facts]:
    noise = np.hypot(observed.noise, options.roughness_sigma_m)
    seen = cell_means(charted[:, :2], charted[:, 2], noise, options.cell_m)
    kernel, scale = (
        Kernel(
            options.kernel, (options.length_along_m, options.length_girth_m), options.offset_sigma_m
        ),
        1.0,
    )
    middle = float(np.median(seen.offset))
    if options.fit:
        few = _on_smooth_hull(kernel, _sample(seen), middle)
        limit = (4 * options.cell_m, 60.0)
        kernel, scale = maximise_likelihood(kernel, few.at, few.offset - middle, few.noise, limit)
    # a smooth hull is seen as well by means over a fraction of the kernel's lengths
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
        "kernel": kernel.form,
        "lengths_m": [round(x, 4) for x in kernel.length],
        "sigma_m": kernel.sigma,
        "noise_scale": scale,
        "observations": len(seen.at),
        "mean_offset_m": middle,
        "tiles": found.tiles,
    }
    return middle + found.mean, found.sigma, facts


def _by_triangles(
    charted: Array, observed: SurfacePoints, wanted: Array, options: SurfaceOptions
) -> tuple[Array, Array, Facts]:
    seen = cell_means(charted[:, :2], charted[:, 2], observed.noise, 0.25 * options.cell_m)
    sigma = scatter_sigma(seen.at, seen.offset)
    facts: Facts = {"method": "linear", "observations": len(seen.at), "scatter_m": sigma}
    return interpolate(seen.at, seen.offset, wanted), np.full(len(wanted), sigma), facts


def _heights_to_offsets(
    height: Array, sigma: Array, at: Array, chart: Chart, datum: PlaneChart
) -> tuple[Array, Array]:
    """Return how far along the chart's normals places of height (n,) over the datum lie, and their
    sigma; NaN: too steep.
    """
    base, normal = chart.from_chart(at)
    lean = normal @ datum.axes[2]
    lean = np.where(lean > MIN_FACING, lean, np.nan)
    return (height - datum.to_chart(base)[:, 2]) / lean, sigma / lean


def _on_smooth_hull(kernel: Kernel, seen: Observations, middle: float) -> Observations:
    """Return the observations within three sigmas of a smooth surface by this kernel: the
    likelihood, which knows no outliers, would take what stands off the hull for noise and flatten
    the hull.
    """
    off = (
        seen.offset
        - middle
        - fit_robust(kernel, seen.at, seen.offset - middle, seen.noise).mean(seen.at)
    )
    return seen.take(np.abs(off) <= STRUCTURE_SIGMAS * np.maximum(robust_sigma(off), seen.noise))


def _sample(seen: Observations) -> Observations:
    """Return half of them as a compact part around the middle, where short lengths show, half
    spread evenly, where long do.
    """
    far = np.linalg.norm(
        (seen.at - np.median(seen.at, axis=0)) / np.maximum(np.std(seen.at, axis=0), 1e-9), axis=1
    )
    spread = np.linspace(0, len(far) - 1, LIKELIHOOD_POINTS // 2).astype(np.int64)
    part = np.union1d(np.argsort(far, kind="stable")[: LIKELIHOOD_POINTS // 2], spread)
    return seen.take(part)


def _lift_to_space(mesh: Mesh, offset: Array, sigma: Array, support: Ints, chart: Chart) -> Surface:
    """Return the chart's mesh moved into space; faces that it cannot place are dropped, orientation
    follows the normals.
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


def _take(observed: SurfacePoints, which: Mask) -> SurfacePoints:
    return SurfacePoints(
        point=observed.point[which],
        noise=observed.noise[which],
        pose_sigma=observed.pose_sigma[which],
        gives_support=observed.gives_support[which],
    )


def _nearest(at: Array, values: Array, wanted: Array) -> Array:
    return np.asarray(values[nearest(at, wanted, 1)[1][:, 0]])
