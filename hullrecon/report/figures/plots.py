# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The plots of deliver/plots: the solution, the vehicle's motion, the deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.records.iterations import broken, reached_cost
from hullrecon.records.sensors import DvlPings
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.report.content.deviation import weighted_percentiles
from hullrecon.report.content.phrases import count as phrase
from hullrecon.report.content.phrases import signed_range
from hullrecon.report.export.tables import numbers, seconds
from hullrecon.report.figures.style import (
    BLUE,
    GRAY,
    GREEN,
    ORANGE,
    Plot,
    finish_plot,
    label_counts,
    label_log_axis,
    new_figure,
)
from hullrecon.report.stream import Drawing
from hullrecon.report.survey import FactorResiduals, Survey
from hullrecon.typing import Array, Arrays, Ints

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEARD_S = 2.0  # longest gap between DVL pings over which the distance is interpolated
# of the histogram's bins; on the CAD model is the middle of a bin, not a border
EDGES_M = np.asarray(0.004 * (np.arange(-50, 52) - 0.5), float)
NAMES = {  # of the histogram's curves
    "landmarks": "landmarks, offset included",
    "as_found": "area seen, offset included",
    "form": "form of the area seen",
}


def plot_drawings(survey: Survey) -> list[Drawing]:
    """List the drawings of the plots whose numbers a survey has, in the order of the page.

    Each gives a Plot, or None where its numbers turn out to be missing.
    """
    has_depth = survey.facts.has_depth
    depth = survey.trajectory.translation[:, 2] if has_depth else None
    found: list[Drawing] = [
        partial(depth_and_standoff, survey.track.t_ns, depth, survey.facts.dvl),
        partial(sigmas, survey.track),
    ]
    adjusted = survey.adjusted
    if adjusted is not None:
        iterations, summary = adjusted.iterations, adjusted.summary
        if len(iterations.get("cost", ())):
            found.append(partial(convergence, iterations))
            if {"on_surface", "label_changes"} <= set(iterations) and adjusted.has_cad_model:
                found.append(partial(labels, iterations))
        if set(summary.residuals_before) & set(summary.residuals_after):
            found.append(partial(residuals, summary.residuals_before, summary.residuals_after))
    if survey.is_in_hull_frame:
        shares = deviation_shares(
            adjusted.solution if adjusted is not None else None,
            survey.surfaces.as_found,
            survey.surfaces.deviation,
        )
        if shares is not None:
            found.append(partial(deviation_histogram, shares))
    return found


def convergence(iterations: Arrays) -> Plot:
    """Draw the cost by iteration, and by kind of factor if the record has it.

    Lines break between rounds: their costs cannot be compared, as sigmas and landmarks change.
    """
    cost = _reached(iterations)
    rounds = _rounds(iterations, len(cost))
    step = np.arange(len(cost))
    by_factor = {
        n.removeprefix("cost_"): v
        for n, v in iterations.items()
        if n.startswith("cost_") and n != "cost_change"
    }
    parts = {name: np.asarray(values, float) for name, values in by_factor.items()}
    figure, (axis,) = new_figure(7.2, 3.4)
    axis.semilogy(
        *broken(step, np.maximum(cost, 1e-12), rounds), color=BLUE, linewidth=2, label="all factors"
    )
    for k, (name, values) in enumerate(sorted(parts.items())):
        if (values > 0).any():
            shown = np.where(values > 0, values, np.nan)
            axis.semilogy(
                *broken(step, shown, rounds),
                linewidth=1,
                linestyle=("-", "--", ":")[k % 3],
                label=name,
            )
    axis.set(xlabel="iteration, all rounds", ylabel="cost (half sum of squares)")
    _mark_rounds(axis, iterations, rounds)
    axis.legend(fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    spans = [cost[rounds == r] for r in np.unique(rounds)]
    falls = [f"from {c[0]:.4g} to {c[-1]:.4g} in {phrase(len(c) - 1, 'iteration')}" for c in spans]
    if len(falls) == 1:
        alt = f"The cost falls {falls[0]}."
    else:
        alt = f"The cost falls {', then '.join(falls)}."
        alt += " Costs of two rounds do not compare: sigmas and landmarks change."
    table = {
        "round": rounds.tolist(),
        "iteration": step.tolist(),
        "cost": numbers(cost, ".9g"),
        **{n: numbers(v, ".9g") for n, v in sorted(parts.items())},
    }
    return finish_plot(figure, "convergence", "Cost by iteration", alt, table)


def labels(iterations: Arrays) -> Plot:
    """Draw the share of landmarks on the hull and the labels changed [Ozog2016 Fig. 4.12].

    iterations: the record of the solve, one row an iteration.
    """
    on_hull, changed = (
        np.asarray(iterations[k], np.int64) for k in ("on_surface", "label_changes")
    )
    rounds, step = _rounds(iterations, len(on_hull)), np.arange(len(on_hull))
    total = (
        np.asarray(iterations["landmarks"], np.int64)
        if "landmarks" in iterations
        else np.full(len(on_hull), on_hull.max())
    )
    figure, (left, right) = new_figure(7.2, columns=2)
    left.plot(*broken(step, 100 * on_hull / np.maximum(total, 1), rounds), color=BLUE, linewidth=2)
    left.set(xlabel="iteration, all rounds", ylabel="landmarks on the hull (%)")
    right.plot(*broken(step, changed.astype(float), rounds), color=ORANGE, linewidth=2)
    right.set(xlabel="iteration, all rounds", ylabel="labels changed")
    label_counts(right.yaxis)
    for axis in (left, right):
        _mark_rounds(axis, iterations, rounds, names=False)
    alt = f"{on_hull[-1]:,} of {total[-1]:,} landmarks end as on the hull; "
    alt += f"{changed[-1]:,} labels changed at the last iteration."
    table = {
        "round": rounds.tolist(),
        "iteration": step.tolist(),
        "landmarks": total.tolist(),
        "on_surface": on_hull.tolist(),
        "label_changes": changed.tolist(),
    }
    return finish_plot(figure, "labels", "Labels by iteration", alt, table)


def _reached(iterations: Arrays) -> Array:
    """Select the cost (k,) of the last accepted solution at each iteration.

    Where the record does not say which steps were accepted, it is the cost as recorded.
    """
    cost = np.asarray(iterations["cost"], float)
    if "accepted" not in iterations:
        return cost
    return reached_cost(cost, np.asarray(iterations["accepted"], bool))


def _rounds(iterations: Arrays, count: int) -> Ints:
    """Select the round (count,) of each row, 1 if the record does not say."""
    return np.asarray(iterations.get("round", np.ones(count)), np.int64)


def _mark_rounds(axis: Axes, iterations: Arrays, rounds: Ints, names: bool = True) -> None:
    """Draw a line where each round begins, with its number and its sigma of a feature, px.

    rounds: (k,) round of each iteration. names: whether the sigma is written.
    """
    starts = np.r_[0, np.flatnonzero(np.diff(rounds)) + 1]
    if len(starts) == 1:
        return
    for k in starts:
        if k:
            axis.axvline(k - 0.5, color=GRAY, linewidth=0.8, linestyle=":")
        text = f"round {rounds[k]}"
        if names and "pixel_sigma_px" in iterations:
            text += f"\n{float(iterations['pixel_sigma_px'][k]):.2g} px"
        axis.annotate(
            text,
            (k, 1.0),
            fontsize=7,
            color=GRAY,
            va="bottom",
            annotation_clip=False,
            xycoords=axis.get_xaxis_transform(),
            xytext=(3, 2),
            textcoords="offset points",
        )


def residuals(before: Mapping[str, FactorResiduals], after: Mapping[str, FactorResiduals]) -> Plot:
    """Draw the whitened residuals of each kind of measurement before and after the adjustment."""
    names = sorted(n for n in before if n in after)
    low, high = (np.array([s[n].rms for n in names]) for s in (before, after))
    at = np.arange(len(names))
    figure, (axis,) = new_figure(height_in=0.9 + 0.36 * len(names))
    axis.barh(at - 0.2, np.maximum(low, 1e-2), 0.36, color=GRAY, label="before")
    axis.barh(at + 0.2, np.maximum(high, 1e-2), 0.36, color=BLUE, label="after")
    axis.axvline(1.0, color=ORANGE, linewidth=1, label="expected")
    axis.set_xscale("log")
    label_log_axis(axis.xaxis)
    axis.set_yticks(at, names)
    axis.invert_yaxis()
    axis.set(xlabel="root mean square residual, in its own sigma")
    axis.legend(fontsize=7, frameon=False)
    changes = "; ".join(
        f"{n} from {a:.2f} to {b:.2f} sigma" for n, a, b in zip(names, low, high, strict=True)
    )
    alt = f"RMS residuals: {changes}."
    table: dict[str, Sequence[object]] = {
        "factor": names,
        "rms_before": numbers(low, ".6g"),
        "rms_after": numbers(high, ".6g"),
        "count": [int(after[n].count) for n in names],
    }
    return finish_plot(figure, "residuals", "Residuals before and after", alt, table)


def standoff(dvl: DvlPings) -> Array:
    """Compute the distance (n,) m from the DVL to the hull along the instrument's axis.

    It is the median over the beams, NaN for a ping without any range.
    """
    along_axis = dvl.ranges * dvl.beams[:, 2]
    distance = np.full(len(along_axis), np.nan)
    heard = np.isfinite(along_axis).any(axis=1)
    distance[heard] = np.nanmedian(along_axis[heard], axis=1)
    return distance


def depth_and_standoff(t_ns: Ints, depth_m: Array | None, dvl: DvlPings | None) -> Plot | None:
    """Draw depth and distance to the hull over the dive, as far as they were measured.

    None if neither was. t_ns, depth_m: of the nodes (n,). dvl: pings, at times of their own.
    """
    distance = standoff(dvl) if dvl is not None and np.isfinite(dvl.ranges).any() else None
    if depth_m is None and distance is None:
        return None
    start, parts, table = t_ns[0], [], {"t_s": seconds(t_ns)}
    rows = int(depth_m is not None) + int(distance is not None)
    figure, axes = new_figure(height_in=0.4 + 1.7 * rows, rows=rows)
    if depth_m is not None:
        axes[0].plot((t_ns - start) * 1e-9, depth_m, color=BLUE)
        axes[0].invert_yaxis()
        axes[0].set(ylabel="depth (m)")
        table["depth_m"] = numbers(depth_m, ".4f")
        parts.append(f"depth from {np.nanmin(depth_m):.2f} to {np.nanmax(depth_m):.2f} m")
    if dvl is not None and distance is not None:
        axes[-1].plot((dvl.t_ns - start) * 1e-9, distance, color=GREEN, linewidth=1)
        axes[-1].set(ylabel="distance to hull (m)")
        good = np.isfinite(distance)
        table["standoff_m"] = numbers(_while_heard(t_ns, dvl.t_ns[good], distance[good]), ".4f")
        parts.append(f"distance to the hull {np.nanmedian(distance):.2f} m (median)")
    axes[-1].set(xlabel="time since the first pose (s)")
    names = {"depth": depth_m is not None, "distance to the hull": distance is not None}
    title, alt = (
        " and ".join(name for name, measured in names.items() if measured),
        "; ".join(parts),
    )
    title, alt = f"{title[0].upper()}{title[1:]}", f"{alt[0].upper()}{alt[1:]}."
    return finish_plot(figure, "depth_standoff", title, alt, table)


def _while_heard(t_ns: Ints, heard_ns: Ints, value: Array) -> Array:
    """Interpolate values (m,) that were measured at heard_ns (m,) to times t_ns (n,).

    NaN in gaps of more than HEARD_S without a measured value, and more than that before the first
    or after the last.
    """
    after = np.searchsorted(heard_ns, t_ns)
    before = np.clip(after - 1, 0, len(heard_ns) - 1)
    apart_ns = heard_ns[np.clip(after, 0, len(heard_ns) - 1)] - heard_ns[before]
    away_ns = np.maximum(heard_ns[0] - t_ns, t_ns - heard_ns[-1])
    return np.where(
        np.maximum(apart_ns, away_ns) <= 1e9 * HEARD_S, np.interp(t_ns, heard_ns, value), np.nan
    )


def sigmas(track: VehicleTrack) -> Plot:
    """Draw one sigma of the vehicle's position by axis over time."""
    figure, (axis,) = new_figure()
    for k, (name, color) in enumerate(zip("xyz", (BLUE, ORANGE, GREEN), strict=True)):
        axis.semilogy(
            (track.t_ns - track.t_ns[0]) * 1e-9,
            np.maximum(track.sigma[:, k], 1e-5),
            color=color,
            label=name,
        )
    axis.set(
        xlabel="time since the first pose (s)", ylabel=f"one sigma of position in {track.frame} (m)"
    )
    label_log_axis(axis.yaxis)
    axis.legend(fontsize=8, frameon=False, ncols=3)
    middle = np.median(track.sigma[:, :3], axis=0)
    alt = (
        "Median one sigma: "
        + ", ".join(f"{n} {v:.3f} m" for n, v in zip("xyz", middle, strict=True))
        + "."
    )
    table = {
        "t_s": seconds(track.t_ns),
        **{f"sigma_{n}_m": numbers(track.sigma[:, k], ".6g") for k, n in enumerate("xyz")},
    }
    return finish_plot(figure, "position_sigma", "Uncertainty of position", alt, table)


@dataclass(frozen=True, kw_only=True)
class DeviationShares:
    """How landmarks and the area seen spread about the CAD model."""

    percent: Mapping[str, Array]  # of each curve of NAMES, in the bins between EDGES_M
    offset_m: float  # of the whole patch, outward positive
    offset_sigma_m: float
    form: str  # how far the form spreads, in words


def deviation_shares(
    solution: Solution | None, as_found: Surface | None, split: DeviationSplit | None
) -> DeviationShares | None:
    """Count landmarks and the area seen by distance to the CAD model, and the area by its form.

    What lies beyond the outermost bins is counted in them. None without a form of the hull as
    found.
    """
    if as_found is None or split is None:
        return None
    area = np.where(as_found.support > 0, vertex_areas(as_found.mesh()), 0.0)
    groups = {"as_found": (as_found.deviation, area), "form": (split.form, area)}
    if solution is not None:
        groups = {
            "landmarks": (solution.landmarks.deviation, np.ones(len(solution.landmarks))),
            **groups,
        }
    shares = {n: (v[np.isfinite(v)], w[np.isfinite(v)]) for n, (v, w) in groups.items()}
    shares = {n: (v, w / w.sum()) for n, (v, w) in shares.items() if w.sum() > 0}
    if "form" not in shares:
        return None
    inside = EDGES_M[0], EDGES_M[-1] - 1e-9
    return DeviationShares(
        percent={
            name: np.asarray(100 * np.histogram(np.clip(v, *inside), EDGES_M, weights=w)[0], float)
            for name, (v, w) in shares.items()
        },
        offset_m=float(split.offset),
        offset_sigma_m=float(split.offset_sigma),
        form=_form_words(*shares["form"], split),
    )


def deviation_histogram(shares: DeviationShares) -> Plot:
    """Draw the shares by distance to the CAD model, with the offset and its sigma."""
    figure, (axis,) = new_figure()
    table = {"from_m": numbers(EDGES_M[:-1], ".3f"), "to_m": numbers(EDGES_M[1:], ".3f")}
    for (name, percent), color in zip(shares.percent.items(), (BLUE, ORANGE, GREEN), strict=False):
        axis.stairs(percent, 1000 * EDGES_M, color=color, linewidth=1.6, label=NAMES[name])
        table[f"{name}_percent"] = numbers(percent, ".6f")
    offset_mm, sigma_mm = 1000 * shares.offset_m, 1000 * shares.offset_sigma_m
    axis.errorbar(
        [offset_mm],
        [60],
        xerr=[sigma_mm],
        color=ORANGE,
        marker="o",
        markersize=4,
        capsize=3,
        label="offset, one sigma",
    )
    axis.axvline(0, color=GRAY, linewidth=1)
    axis.set(xlabel="distance to the CAD model, outward positive (mm)", ylabel="share (%)")
    axis.set_yscale("symlog", linthresh=0.1)
    axis.legend(fontsize=8, frameon=False)
    alt = (
        f"{shares.form}; offset of the whole patch {offset_mm:+.0f} mm, "
        f"one sigma {sigma_mm:.0f} mm."
    )
    return finish_plot(figure, "deviation_histogram", "Deviation from the CAD model", alt, table)


def _form_words(form: Array, weight: Array, split: DeviationSplit) -> str:
    """Write how far the form spreads, with its sigma, for readers who do not see the plot.

    form, weight: (n,) m of the seen vertices, and the area of each.
    """
    low, high = 1000 * weighted_percentiles(form, weight, (5, 95))
    sigma = 1000 * float(np.nanmedian(split.form_sigma))
    spread = f"5th to 95th percentile {signed_range(low, high, 1)} mm"
    return f"Form: {spread}, median one sigma {sigma:.1f} mm"
