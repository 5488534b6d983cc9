# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What links do to a path: its sigma, the nodes they join, and one two-view model alone.

[KimEustice2009 Figs 3, 4, 5(a), 5(b)].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.trajectory import hull_from_start, rms_length
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.records.links import NodePairs
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rows import spread_rows
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    LIGHT,
    RED,
    PublishedFigure,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.typing import Array, Ints

ELLIPSES = 40  # drawn along a path
OF_PATHS = (COLOURS["geva"], COLOURS["maxmix"], GREEN)


@dataclass(frozen=True, kw_only=True)
class LinkedBy:
    """A path in g tied by links of one two-view model."""

    track: VehicleTrack
    joined: int  # pairs of images that gave a link


def sigma_along_path(tracks: Mapping[str, VehicleTrack]) -> PublishedFigure:
    """Draw the horizontal sigma along the path [KimEustice2009 Fig. 4].

    All tracks have the same nodes.
    """
    figure, axes = new_canvas(7.4, 3.6)
    way = path_length(list(tracks.values())[-1].poses.translation)
    sigma = {name: horizontal_sigma(track) for name, track in tracks.items()}
    for (name, value), ink in zip(sigma.items(), OF_PATHS, strict=False):
        axes[0][0].plot(way, 1e3 * value, color=ink, linewidth=1.8, label=name)
    axes[0][0].set(xlabel="path (m)", ylabel="sigma of the horizontal position (mm)")
    axes[0][0].set_yscale("symlog", linthresh=1.0)
    axes[0][0].set_ylim(bottom=0)
    label_log_axis(axes[0][0].yaxis)
    axes[0][0].legend(fontsize=8, frameon=False)
    table = [",".join(["path_m", *(f"{name.replace(' ', '_')}_m" for name in sigma)])]
    table += [
        f"{at:.3f}," + ",".join(f"{value[k]:.6f}" for value in sigma.values())
        for k, at in enumerate(way)
    ]
    ends = ", ".join(f"{name} {1e3 * value[-1]:.3g} mm" for name, value in sigma.items())
    caption = (
        "One sigma of the horizontal position from where the path begins. "
        f"After {way[-1]:.0f} m: {ends}."
    )
    return finish_figure("sigma_along_path", figure, table, caption)


def links_on_hull(
    reckoned: VehicleTrack, linked: VehicleTrack, pairs: NodePairs, truth: Truth
) -> PublishedFigure:
    """Draw the links over the hull from the side, and the paths from above.

    The links are [KimEustice2009 Fig. 5(a)]. From above: dead reckoning [Fig. 3], the path with
    links, the truth, and ellipses of three sigma. Paths lie where they do if both begin at the true
    pose.
    """
    figure, axes = new_canvas(9.6, 6.4, 2, 1, sharex="col")
    side, above = axes[0][0], axes[1][0]
    at, drifted = in_hull(linked, truth), in_hull(reckoned, truth)
    kinds = {
        "between neighbours": (pairs.joined & ~pairs.across, GREEN),
        "across legs": (pairs.joined & pairs.across, RED),
        "contradicted, left out": (pairs.rejected, INK),
    }
    for name, (which, ink) in kinds.items():
        _draw_pairs(
            side,
            at.translation,
            pairs.first[which],
            pairs.second[which],
            ink,
            f"{name}: {which.sum():,}",
        )
    side.set(ylabel="height in the hull frame (m)")
    true = truth.vehicle_at(linked.t_ns / 1e9).translation
    above.plot(true[:, 0], true[:, 1], color=LIGHT, linewidth=5, label="truth")
    above.plot(
        *drifted.translation[:, :2].T, color=COLOURS["geva"], linewidth=1.2, label="dead reckoned"
    )
    above.plot(*at.translation[:, :2].T, color=COLOURS["maxmix"], linewidth=1.2, label="with links")
    few = spread_rows(len(linked.t_ns), ELLIPSES)
    for track, placed, ink in (
        (reckoned, drifted, COLOURS["geva"]),
        (linked, at, COLOURS["maxmix"]),
    ):
        for outline in error_ellipses(track, placed, few):
            above.plot(*outline.T, color=ink, linewidth=0.6, alpha=0.7)
    above.set(xlabel="along the hull (m)", ylabel="across it (m)")
    for axis in (side, above):
        axis.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    table = ["first,second,across,joined,rejected"]
    columns = zip(
        pairs.first, pairs.second, pairs.across, pairs.joined, pairs.rejected, strict=True
    )
    table += [f"{a},{b},{c:d},{j:d},{r:d}" for a, b, c, j, r in columns]
    counts = ", ".join(f"{which.sum():,} {name}" for name, (which, _) in kinds.items())
    off = [f"{1e3 * rms_length(path.translation - true):.3g} mm" for path in (drifted, at)]
    words = (
        f"From its true start the path is off by {off[0]} dead reckoned and by {off[1]} with "
        "links (rms)"
    )
    return finish_figure(
        "links_on_hull",
        figure,
        table,
        f"Links over the hull: {counts}. {words}; ellipses of three sigma.",
    )


def two_view_models(paths: Mapping[str, LinkedBy], truth: Truth) -> PublishedFigure:
    """Draw the path by links of each two-view model from above [KimEustice2009 Fig. 5(b)]."""
    figure, axes = new_canvas(9.0, 2.2 * len(paths), len(paths), 1, sharex="col", sharey="col")
    table, words = ["model,pairs_joined,from_start_rms_m,rigid_rms_m"], []
    for (name, found), row in zip(paths.items(), axes, strict=True):
        at, true = (
            in_hull(found.track, truth).translation,
            truth.vehicle_at(found.track.t_ns / 1e9).translation,
        )
        whole, rigid = rms_length(at - true), rms_length(fit_rigid(at, true).apply(at) - true)
        row[0].plot(true[:, 0], true[:, 1], color=LIGHT, linewidth=5, label="truth")
        row[0].plot(
            at[:, 0],
            at[:, 1],
            color=COLOURS["maxmix"],
            linewidth=1.2,
            label=f"{name}: {found.joined:,} pairs",
        )
        row[0].set(ylabel="across the hull (m)")
        row[0].legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
        table.append(f"{name},{found.joined},{whole:.5f},{rigid:.5f}")
        words.append(f"{name} {1e3 * whole:.3g} mm ({1e3 * rigid:.3g} mm after rigid alignment)")
    axes[-1][0].set_xlabel("along the hull (m)")
    return finish_figure(
        "two_view_models",
        figure,
        table,
        f"Error of the path from its true start, rms: {'; '.join(words)}.",
    )


def path_length(translation: Array) -> Array:
    """Accumulate the distance (n,) m along positions (n, 3)."""
    return np.asarray(np.r_[0, np.cumsum(np.linalg.norm(np.diff(translation, axis=0), axis=1))])


def horizontal_sigma(track: VehicleTrack) -> Array:
    """Compute the sigma (n,) m of the positions over the ground.

    It is the root of the trace of their covariance. Depths are left out: their error, a pressure
    sensor's bias, is common to the whole path.
    """
    return np.asarray(np.linalg.norm(track.sigma[:, :2], axis=1))


def in_hull(track: VehicleTrack, truth: Truth) -> Poses:
    """Transform a track from g to M such that it begins at the true pose."""
    timed = TimedPoses(t_s=track.t_ns / 1e9, poses=track.poses)
    hull_from_global: Poses = hull_from_start(timed, truth)
    return hull_from_global @ track.poses


def error_ellipses(track: VehicleTrack, in_hull: Poses, nodes: Ints) -> list[Array]:
    """Compute three-sigma ellipses (k, 2) m of some nodes' positions, seen from above in M.

    in_hull: poses of all the track's nodes in M.
    """
    # from the track's frame to M
    turn = (in_hull[nodes].rotation * track.poses[nodes].rotation.inv()).as_matrix()
    covariance = (turn @ track.covariance[nodes, :3, :3] @ turn.swapaxes(1, 2))[:, :2, :2]
    values, vectors = np.linalg.eigh(covariance)
    around = np.linspace(0, 2 * np.pi, 33)
    circle = np.stack([np.cos(around), np.sin(around)])
    outline = vectors @ (3.0 * np.sqrt(np.maximum(values, 0))[:, :, None] * circle)
    return [
        np.asarray(part.T + middle)
        for part, middle in zip(outline, in_hull.translation[nodes, :2], strict=True)
    ]


def _draw_pairs(axis: Axes, at: Array, first: Ints, second: Ints, ink: str, name: str) -> None:
    """Draw lines between pairs of nodes as seen from the side, and an entry of the legend.

    at: (n, 3) m in M, of the nodes. first, second: (k,) nodes of each pair.
    """
    from matplotlib.collections import LineCollection

    ends = np.stack([at[first][:, [0, 2]], at[second][:, [0, 2]]], axis=1)
    axis.add_collection(
        LineCollection(list(ends), colors=ink, linewidths=0.6, label=name), autolim=True
    )
    axis.autoscale_view()
