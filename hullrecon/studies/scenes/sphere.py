# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sphere that a vehicle spirals around, mapped with planes [Ozog2016 Figs C.1, C.2]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.evaluation.trajectory import rms, rms_length
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    LIGHT,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.paths.link_plots import path_length
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array

INSET_M = 1.0
RECKONED, PLANES = "dead reckoning", "with planes"
PATH_COLOURS = {RECKONED: COLOURS["geva"], PLANES: COLOURS["maxmix"]}


@dataclass(frozen=True, kw_only=True)
class MappedSphere:
    """A path around a sphere as it was solved, in g."""

    path: Array  # (n, 3) m
    sigma: Array  # (n,) m, of its positions in all directions together
    points: Array  # (m, 3) m, ends of its DVL beams

    def off_sphere_m(self) -> Array:
        """Measure how far (n,) m the path lies outside its best-fitting sphere."""
        middle, radius = fit_sphere(self.path)
        return np.asarray(np.linalg.norm(self.path - middle, axis=1) - radius)

    def error_m(self, truth: Array) -> Array:
        """Measure the distance (n,) m of the path from the true one (n, 3) m."""
        return np.asarray(np.linalg.norm(self.path - truth, axis=1))

    def aligned_error_m(self, truth: Array) -> float:
        """Compute the rms distance from the true path (n, 3) m after rigid alignment."""
        return rms_length(fit_rigid(self.path, truth).apply(self.path) - truth)


def fit_sphere(points: Array) -> tuple[Array, float]:
    """Fit a sphere's middle (3,) and radius to points (n, 3) by linear least squares.

    |p|^2 = 2 p . middle + (radius^2 - |middle|^2) is linear in the middle and the last term.
    """
    solution = np.linalg.lstsq(
        np.c_[2 * points, np.ones(len(points))], np.sum(points**2, axis=1), rcond=None
    )[0]
    middle = solution[:3]
    return middle, float(np.sqrt(solution[3] + middle @ middle))


@dataclass(frozen=True, kw_only=True)
class SphereSurvey:
    """A survey around a sphere, in g."""

    radius_m: float
    middle: Array  # (3,) m
    truth: Array  # (n, 3) m, the true path
    reckoned: MappedSphere  # by odometry, depth and attitude
    planes: Mapping[float, MappedSphere]  # with planes too, by their characteristic radius in m

    @property
    def drawn(self) -> dict[str, MappedSphere]:
        """Choose dead reckoning and the planes with the radius nearest to the sphere's."""
        return {
            RECKONED: self.reckoned,
            PLANES: self.planes[min(self.planes, key=lambda r: abs(r - self.radius_m))],
        }


def sphere(survey: SphereSurvey) -> PublishedFigure:
    """Draw [Ozog2016 Figs C.1, C.2]: the paths around the sphere, and how well they lie on it.

    Both paths from above, how they lie on their spheres, the same by characteristic radius, and how
    sure they are of their positions.
    """
    figure, axes = new_canvas(10.4, 8.2, 2, 2)
    _draw_from_above(axes[0][0], survey)
    _draw_off_sphere(axes[0][1], survey)
    _draw_by_radius(axes[1][0], survey)
    _draw_sigma(axes[1][1], survey)
    table = [
        "path,characteristic_radius_m,off_sphere_rms_m,map_off_sphere_rms_m,map_radius_m,aligned_rms_m,end_sigma_m,end_error_m"
    ]
    table.append(_row(RECKONED, "", survey.reckoned, survey.truth))
    table += [
        _row(PLANES, f"{radius:g}", found, survey.truth) for radius, found in survey.planes.items()
    ]
    return finish_figure("sphere", figure, table, _caption(survey), _compare(survey))


def _compare(survey: SphereSurvey) -> tuple[ComparedValue, ...]:
    """Set what [Ozog2016 C] says of characteristic radii beside ours."""
    off = [1e3 * rms(found.off_sphere_m()) for found in survey.planes.values()]
    ends = survey.drawn[PLANES]
    return (
        ComparedValue(
            what=f"path off its sphere, characteristic radii {min(survey.planes):g} to "
            f"{max(survey.planes):g} m: worst over best",
            ours=max(off) / max(min(off), 1e-9),
            note=f'printed "very similar", of a sphere of 8 m; ours has {survey.radius_m:g} m',
        ),
        ComparedValue(
            what="error of the path's end over its sigma, with planes",
            ours=float(ends.error_m(survey.truth)[-1] / ends.sigma[-1]),
            note="along closed turns the sigma with planes is too small",
        ),
    )


def _draw_from_above(axis: Axes, survey: SphereSurvey) -> None:
    """Draw the sphere and the paths, and in an inset where they end."""
    angle = np.linspace(0, 2 * np.pi, 181)
    circle = survey.middle[:2] + survey.radius_m * np.column_stack([np.cos(angle), np.sin(angle)])
    near = survey.truth[-1, :2] + INSET_M * np.array([[-1.0, -0.6], [1.0, 1.4]])
    inset = axis.inset_axes((0.36, 0.47, 0.28, 0.32), xlim=near[:, 0], ylim=near[:, 1])
    for panel, wide in ((axis, 3.0), (inset, 5.0)):
        panel.fill(
            *circle.T,
            facecolor="#eef1f4",
            edgecolor=LIGHT,
            label=f"sphere of {survey.radius_m:g} m",
        )
        panel.plot(*survey.truth[:, :2].T, color=GREEN, linewidth=wide, alpha=0.45, label="truth")
        panel.plot(*survey.truth[-1, :2], color=GREEN, marker="o", markersize=4)
        for name, found in survey.drawn.items():
            panel.plot(*found.path[:, :2].T, color=PATH_COLOURS[name], linewidth=1.0, label=name)
            panel.plot(*found.path[-1, :2], color=PATH_COLOURS[name], marker="o", markersize=4)
        panel.set_aspect("equal", adjustable="datalim" if panel is axis else "box")
    inset.set_title("where they end", fontsize=8)
    inset.tick_params(labelsize=7)
    axis.indicate_inset_zoom(inset, edgecolor=INK)
    axis.set(xlabel="x (m)", ylabel="y (m)")
    axis.legend(fontsize=8, frameon=False, loc="center", bbox_to_anchor=(0.5, 0.28))


def _draw_off_sphere(axis: Axes, survey: SphereSurvey) -> None:
    """Draw how far each path lies outside the sphere that fits it, mm."""
    travelled = path_length(survey.truth)
    for name, found in survey.drawn.items():
        off = 1e3 * found.off_sphere_m()
        axis.plot(
            travelled,
            off,
            color=PATH_COLOURS[name],
            linewidth=1.4,
            label=f"{name}: {rms(off):.1f} mm rms",
        )
    axis.set(xlabel="along the path (m)", ylabel="path outside the sphere that fits it (mm)")
    _leave_room(axis)
    axis.legend(fontsize=8, frameon=False, loc="upper right")


def _draw_by_radius(axis: Axes, survey: SphereSurvey) -> None:
    """Draw errors of path and map by characteristic radius, mm."""
    radii = list(survey.planes)
    off_path = [1e3 * rms(found.off_sphere_m()) for found in survey.planes.values()]
    off_radius = [
        1e3 * (fit_sphere(found.points)[1] - survey.radius_m) for found in survey.planes.values()
    ]
    before = (
        1e3 * rms(survey.reckoned.off_sphere_m()),
        1e3 * (fit_sphere(survey.reckoned.points)[1] - survey.radius_m),
    )
    for values, level, marker, shade, what in (
        (off_path, before[0], "o", COLOURS["maxmix"], "path off its sphere, rms"),
        (off_radius, before[1], "s", INK, "radius of the map less the true one"),
    ):
        axis.plot(
            radii,
            values,
            color=shade,
            marker=marker,
            markersize=5,
            linewidth=1.4,
            label=f"{what}, {PLANES}",
        )
        axis.axhline(level, color=shade, linestyle="--", linewidth=1.0, label=f"{what}, {RECKONED}")
    axis.set_xticks(radii, [f"{radius:g}" for radius in radii])
    axis.set(xlabel="characteristic radius (m)", ylabel="error (mm)", ylim=(0, None))
    _leave_room(axis, 0.5)
    axis.legend(fontsize=8, frameon=False, loc="upper left")


def _draw_sigma(axis: Axes, survey: SphereSurvey) -> None:
    """Draw sigma and error of the position along each path, m."""
    travelled = path_length(survey.truth)
    for name, found in survey.drawn.items():
        axis.plot(
            travelled, found.sigma, color=PATH_COLOURS[name], linewidth=1.6, label=f"sigma, {name}"
        )
        error = found.error_m(survey.truth)
        axis.plot(
            travelled,
            error,
            color=PATH_COLOURS[name],
            linewidth=1.0,
            linestyle="--",
            label=f"error, {name}",
        )
    axis.set(
        xlabel="along the path (m)",
        ylabel="position: sigma (root of the trace), error (m)",
        ylim=(0, None),
    )
    _leave_room(axis)
    axis.legend(fontsize=8, frameon=False, loc="upper left")


def _leave_room(axis: Axes, share: float = 0.25) -> None:
    """Let the ordinate end higher by a share of its range, for the legend."""
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + share * (high - low))


def _row(name: str, radius: str, found: MappedSphere, truth: Array) -> str:
    """Write the figures of one path as a row of the figure's table. truth: (n, 3) m."""
    middle, map_radius = fit_sphere(found.points)
    off_map = np.linalg.norm(found.points - middle, axis=1) - map_radius
    errors = (found.aligned_error_m(truth), found.sigma[-1], found.error_m(truth)[-1])
    numbers = (rms(found.off_sphere_m()), rms(off_map), map_radius, *errors)
    return f"{name},{radius},{','.join(f'{v:.5f}' for v in numbers)}"


def _caption(survey: SphereSurvey) -> str:
    """Write the caption: how well the paths lie on a sphere, and their errors at the end."""
    radii, planes = list(survey.planes), list(survey.planes.values())
    before, off = (
        1e3 * rms(survey.reckoned.off_sphere_m()),
        [1e3 * rms(found.off_sphere_m()) for found in planes],
    )
    map_before, maps = (
        fit_sphere(survey.reckoned.points)[1],
        [fit_sphere(found.points)[1] for found in planes],
    )
    ends = [
        f"{found.error_m(survey.truth)[-1]:.2f} m (sigma {found.sigma[-1]:.2f} m)"
        for found in survey.drawn.values()
    ]
    return (
        f"Around a sphere of {survey.radius_m:g} m: the path lies on a sphere to {before:.1f} mm "
        f"rms by dead reckoning, to {min(off):.1f} to {max(off):.1f} mm with planes of "
        f"characteristic radii of {min(radii):g} to {max(radii):g} m; the radius of the map is "
        f"{min(maps):.3f} to {max(maps):.3f} m, by dead reckoning {map_before:.3f} m. Planes do "
        f"not tell where on the sphere the vehicle is: the path ends {ends[0]} from the truth by "
        f"dead reckoning, {ends[1]} with planes: along closed turns their sigma is too small."
    )
