# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the beams of a DVL point: from the messages, else from dive.toml, else from the one instrument their type names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.samples import DvlSample
from hullrecon.errors import InputError
from hullrecon.typing import Array

A50 = "Water Linked A50"
A50_ANGLE_DEG = 22.5
A50_AZIMUTH_DEG = (135.0, -135.0, -45.0, 45.0)  # of beams 1 to 4 about z of `dvl`, from x towards y
SAME_DEG = 0.5  # directions that differ by less are the same
ADVICE = (
    "give [dvl] beams as unit vectors, or beam_angle_deg with beam_azimuth_deg, from the instrument's manual; "
    "a guess would cost several per cent of every distance"
)


def tilted_beams(angle_deg: float, azimuth_deg: Sequence[float]) -> Array:
    """Return (b, 3) unit vectors in `dvl`, tilted from its z axis by one angle, each towards its azimuth (from x towards y)."""
    tilt, azimuth = np.radians(angle_deg), np.radians(np.asarray(azimuth_deg, float))
    across = np.sin(tilt)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.full(len(azimuth), np.cos(tilt))], axis=1)


def a50_beams() -> Array:
    """Return (4, 3) unit vectors in `dvl` of a Water Linked A50."""
    return tilted_beams(A50_ANGLE_DEG, A50_AZIMUTH_DEG)


def choose_beams(samples: Sequence[DvlSample], configured: Array | None, width: int, remarks: list[str]) -> Array:
    """Return (width, 3) unit vectors in `dvl`. InputError where neither messages nor dive.toml (`configured`) nor type say."""
    if not width:
        return np.zeros((0, 3))
    if configured is not None and len(configured) != width:
        raise InputError(f"[dvl] of dive.toml describes {len(configured)} beams, the log has {width}", where="dvl.beams")
    described = [s for s in samples if s.beams is not None and len(s.beams) == width]
    logged = [s.beams for s in described if not s.instrument and s.beams is not None]
    if logged:
        return _logged_beams(logged, configured, remarks)
    if configured is not None:
        return unit(configured)
    if described and described[0].beams is not None:
        remarks.append(f"dvl: the messages have no beam directions; those of a {described[0].instrument} were used")
        return unit(described[0].beams)
    raise ask_for_beams(width)


def ask_for_beams(count: int) -> InputError:
    """Return the error that asks where so many beams point."""
    return InputError(f"nothing says where the DVL's {count} beams point", where="dvl.beams", remedy=ADVICE)


def _logged_beams(logged: Sequence[Array], configured: Array | None, remarks: list[str]) -> Array:
    if max(float(np.abs(b - logged[0]).max()) for b in logged) > 1e-6:
        remarks.append("dvl: the beams' directions change during the dive; their mean was used")
    beams = unit(np.mean(logged, axis=0))
    if configured is not None:
        apart = float(np.degrees(np.arccos(np.clip(np.sum(beams * unit(configured), axis=1), -1, 1))).max())
        if apart > SAME_DEG:
            remarks.append(
                f"dvl: the beams of dive.toml are up to {apart:.1f} degrees off those of the messages, which were used"
            )
    return beams


def unit(vectors: Array) -> Array:
    """Return the vectors (n, 3) at length 1."""
    v = np.asarray(vectors, float)
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))
