# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Depth: the DVL's vertical path, held to the pressure sensor slowly.

Over a second the DVL knows the vertical step to a millimetre, while one pressure reading scatters
by centimetres. Over minutes the pressure is right. So the difference of the two is smoothed, over
WIDTH_S. Of ten readings a second with a sigma of 0.02 m that leaves some 1.5 mm. A drift that is
steady over half a minute (by scale or mount) is followed without lag.

Where the DVL was silent its path goes straight on, whatever the vehicle does. There the depth is
that of the pressure sensor alone, and its readings are not smoothed together with those beside the
silence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.dead_reckoning.reckoning import Reckoning
from hullrecon.navigation.sensors.smoothing import local_line, running_median
from hullrecon.records.clock import describe_silence, silent_spans, unread_s
from hullrecon.records.sensors import PressureSamples
from hullrecon.typing import Array, Ints, Mask

WIDTH_S = 5.0  # sigma of the Gaussian weights
STEP_M = 0.3  # between two readings, in excess of the DVL's motion: a jump of the pressure
LEAST_SIGMA_M = 1e-3
UNKNOWN_SIGMA_M = 1e3  # of a depth that nothing measured
# time on either side of a node within which nodes and readings are counted: this many seconds, or
# this many periods of the sensor, whichever is longer
AROUND_S, AROUND_PERIODS = 5.0, 2.5
# sigma of a line that is fitted to readings on one side, over that of one fitted to both sides
AT_AN_EDGE = 2.5


@dataclass(frozen=True, kw_only=True)
class Depth:
    """The pressure sensor's correction to the DVL's vertical path at the nodes (n)."""

    shift: Array  # (n,) m, to be added to z
    sigma: Array  # (n,) m, of shift
    measured: Array  # (n,) m, depth of the sensor
    shared: Array  # (n,) nodes per reading, 0 without a reading nearby
    steps: Ints  # (k,) stamps where the pressure jumped against the DVL
    white: float  # scatter of one reading, m
    unread_s: Array  # (n,) to the nearest reading, 0 where the depth was measured
    silence: str  # how long the sensor was silent, in words, "" if it never was


def hold_to_pressure(
    pressure: PressureSamples, path: Reckoning, nodes_ns: Ints, window_s: float
) -> Depth:
    """Correct the depth of the DVL's path by the pressure sensor.

    Parameters
    ----------
    pressure
        Depths by the pressure sensor, at least two. Those that are not finite are left out.
    path
        By DVL and attitude, whose vertical motion is corrected.
    nodes_ns
        Stamps (n,) of the nodes.
    window_s
        Half the time between nodes: the width over which readings are averaged where the DVL was
        silent, and for the measured depth of a node.
    """
    known = np.isfinite(pressure.depth)
    t_ns, depth = pressure.t_ns[known], pressure.depth[known]
    t, at = path_seconds(path, t_ns), path_seconds(path, nodes_ns)
    # the difference to be smoothed, and that without single outliers
    difference = depth - _reckoned_depth(path, t_ns)
    steady = running_median(difference[:, None], 5)[:, 0]
    step = float(np.median(np.diff(t)))
    widths = WIDTH_S, max(window_s, step)
    first_ns, last_ns = min(t_ns[0], nodes_ns[0]), max(t_ns[-1], nodes_ns[-1])
    edges = path_seconds(
        path, silent_spans(path.velocities.t_ns, int(first_ns), int(last_ns)).ravel()
    )
    # at the nodes, and at the readings themselves
    smooth = _smooth_segments(t, steady, np.concatenate([at, t]), edges, widths)
    slow, fitted, unread = smooth[: len(at)], smooth[len(at) :], unread_s(t_ns, nodes_ns)
    # between readings far apart a line fitted to noise would lead far astray
    shift = np.where(unread > 0, np.interp(at, t, fitted), slow)
    white = robust_sigma(difference - fitted, about=0.0)
    sigma = np.maximum(white * np.sqrt(step) * _smoothed_noise(at, edges, widths), LEAST_SIGMA_M)
    # what the sensor alone measured at the nodes, over a shorter window
    near, _ = local_line(t, steady, at, window_s)
    jumps = np.abs(np.diff(steady)) > max(STEP_M, 6 * white)
    measured = near[:, 0] + _reckoned_depth(path, nodes_ns)
    return Depth(
        shift=shift,
        sigma=sigma,
        measured=measured,
        shared=nodes_per_reading(t_ns, nodes_ns, unread == 0),
        steps=t_ns[1:][jumps],
        white=white,
        unread_s=unread,
        silence=describe_silence(t_ns, nodes_ns),
    )


def nodes_per_reading(read_ns: Ints, nodes_ns: Ints, measured: Mask) -> Array:
    """Count the nodes for each pressure reading near each node (n,), at least 1.

    Depths of nodes that share a reading are fully correlated. The count is 0 at nodes whose depth
    was not measured.

    Parameters
    ----------
    read_ns, nodes_ns
        Stamps of the readings (m,) and of the nodes (n,).
    measured
        Nodes (n,) whose depth was measured.
    """
    period_s = float(np.median(np.diff(read_ns))) * 1e-9 if len(read_ns) > 1 else 0.0
    half_ns = round(1e9 * max(AROUND_S, AROUND_PERIODS * period_s))
    nodes, readings = (
        np.searchsorted(stamps, nodes_ns + half_ns, side="right")
        - np.searchsorted(stamps, nodes_ns - half_ns)
        for stamps in (nodes_ns[measured], read_ns)
    )
    return np.asarray(np.where(measured, np.maximum(1.0, nodes / np.maximum(readings, 1)), 0.0))


def depth_at_nodes_sigma(sigma_m: float, shared: Array) -> Array:
    """Compute the sigma (n,), m, of depths at the nodes so that no reading counts twice.

    The sigma of a reading, sigma_m, is inflated by the square root of the nodes that share it.
    UNKNOWN_SIGMA_M without a reading nearby (`shared` is 0).
    """
    return np.where(shared > 0, sigma_m * np.sqrt(shared), UNKNOWN_SIGMA_M)


def _smooth_segments(
    t_s: Array, values: Array, at_s: Array, edges_s: Array, widths_s: tuple[float, float]
) -> Array:
    """Smooth readings by local lines, separately in each segment between edges.

    So readings beside a silence of the DVL do not mix with those in it. A segment with fewer than
    two readings uses all readings.

    Parameters
    ----------
    t_s, values
        Readings (n,).
    at_s
        Times (m,) at which the result is wanted.
    edges_s
        Begin and end of each silence of the DVL, alternately.
    widths_s
        Sigmas of the weights where the DVL was heard, and where it was silent.
    """
    out = np.zeros(len(at_s))
    segment, segment_at = (np.searchsorted(edges_s, times, side="right") for times in (t_s, at_s))
    for number in np.unique(segment_at):
        inside, width = segment == number, widths_s[int(_is_silent(number))]
        rows = inside if inside.sum() > 1 else np.ones(len(t_s), bool)
        out[segment_at == number] = local_line(
            t_s[rows], values[rows], at_s[segment_at == number], width
        )[0][:, 0]
    return out


def _smoothed_noise(at_s: Array, edges_s: Array, widths_s: tuple[float, float]) -> Array:
    """Compute the sigma (n,), 1/sqrt(s), that smoothing leaves of noise of density 1.

    Multiplied by the sigma of a reading and the square root of the readings' period it is the sigma
    of the smoothed value. It is larger at the edges of a segment, which have readings on one side
    only. at_s, edges_s, widths_s: as for `_smooth_segments`.
    """
    width = np.where(
        _is_silent(np.searchsorted(edges_s, at_s, side="right")), widths_s[1], widths_s[0]
    )
    # time to the nearest edge of the segment; there is none at the ends of the dive
    far = np.concatenate([[-np.inf], edges_s, [np.inf]])
    after = np.searchsorted(far, at_s)
    to_edge_s = np.minimum(at_s - far[after - 1], far[after] - at_s)
    return np.asarray(
        (1 + (AT_AN_EDGE - 1) * np.exp(-0.5 * (to_edge_s / width) ** 2))
        / np.sqrt(2 * np.sqrt(np.pi) * width)
    )


def _is_silent(segment: Ints) -> Mask:
    """Tell in which segments, by number, the DVL was silent: every second one."""
    return np.asarray(segment % 2 == 1)


def path_seconds(path: Reckoning, t_ns: Ints) -> Array:
    """Convert stamps (n,) to seconds since the start of the path."""
    return np.asarray((t_ns - path.start_ns) * 1e-9)


def _reckoned_depth(path: Reckoning, t_ns: Ints) -> Array:
    """Compute z (n,), m, of the pressure sensor on the DVL's path."""
    return np.asarray(path.at(t_ns).poses().apply(path.rig.pressure_origin)[:, 2])
