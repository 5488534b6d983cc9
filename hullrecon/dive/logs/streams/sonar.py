# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the pings of an imaging sonar into a record: images of 8 bits, of one geometry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.dvl_beams import unit
from hullrecon.dive.logs.ping_spool import Images, KeepImages, PingLook, look_of
from hullrecon.dive.logs.samples import SonarSample, stamps
from hullrecon.dive.logs.sonar_geometry import (
    choose_directions,
    evenly_spaced,
    image_in_ranges,
    pings_of_one_window,
)
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.sensors import SonarPings
from hullrecon.typing import Array

# percentile of the pings' bright pixels that is scaled to white: a few pings are disturbed
BRIGHT_PINGS_PERCENT = 99.0
# Neighbours differ by less than this share of what they do as they are stored, in most pings, where
# the bytes of their pixels are exchanged. Pings of water alone are noise either way: 1
MUCH_SMOOTHER = 0.8


def keep_in_memory(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Stack the images into one array."""
    kept = np.empty(shape, np.uint8)
    for row, image in zip(kept, images, strict=True):
        row[:] = image
    return kept


def leave_black(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Return black images that take no memory, in place of `keep_in_memory`.

    It is for calls that look at no image.
    """
    return np.broadcast_to(np.uint8(0), shape)


@np.errstate(all="ignore")
def sonar_pings(
    samples: Sequence[SonarSample],
    notes: list[Finding],
    azimuth_deg: Array | None = None,
    keep: KeepImages = keep_in_memory,
    load: Callable[[SonarSample], SonarSample] = lambda sample: sample,
) -> SonarPings | None:
    """Stack pings of the most common geometry as images of 8 bits. None without any.

    Pings of other windows and fans are dropped. All are scaled by one factor, so that their
    brightness stays comparable.

    Parameters
    ----------
    samples : pings in order of time
    notes : what was assumed or left out is added
    azimuth_deg : (beams,) of dive.toml, for logs that do not say where the beams point
    keep : stores the images, and returns them as one array
    load : reads the image of a ping back, where `samples` hold stand-ins (ping_spool)

    Raises
    ------
    InputError
        Nothing says where the beams point, the ranges are no sonar's, or the pixels are decibels.
    """
    kept, range_m = pings_of_one_window(samples, notes)
    if not kept:
        return None
    directions = choose_directions(kept[0], azimuth_deg, notes)
    range_m = evenly_spaced(np.asarray(range_m, float))
    dtype, looks = kept[0].image.dtype, [look_of(sample) for sample in kept]
    _refuse_decibels(looks)
    exchanged = _are_exchanged(looks, notes)
    scale = None
    if any(sample.image.dtype != np.uint8 for sample in kept):
        scale = _scale_to_eight_bits(looks, str(dtype), exchanged, notes)
    shape = (len(kept), len(directions), len(range_m))
    image = keep(
        shape,
        (_eight_bits(image_in_ranges(load(sample), range_m), scale, exchanged) for sample in kept),
    )
    return SonarPings(
        t_ns=stamps(kept),
        image=image,
        directions=unit(directions),
        range_m=range_m,
    )


def _refuse_decibels(looks: Sequence[PingLook]) -> None:
    """Raise InputError for pixels that are decibels: they have no black."""
    if 2 * sum(look.is_negative for look in looks) > len(looks):
        raise InputError(
            "most of the sonar's pixels are below zero: are they decibels?",
            where="sonar",
            remedy="log amplitudes, of which black is 0, or leave topics.sonar away",
        )


def _are_exchanged(looks: Sequence[PingLook], notes: list[Finding]) -> bool:
    """Tell whether the bytes of the pixels stand in the other order than the log says."""
    rougher = float(np.median([look.rougher for look in looks]))
    if rougher < MUCH_SMOOTHER:
        notes.append(Finding("sonar-bytes-exchanged", {"smoother": 1 / rougher}, "sonar"))
    if not any(look.bright > 0 for look in looks):
        notes.append(Finding("sonar-black", where="sonar"))
    return rougher < MUCH_SMOOTHER


def _scale_to_eight_bits(
    looks: Sequence[PingLook], dtype: str, exchanged: bool, notes: list[Finding]
) -> float:
    """Find the factor that brings the bright pixel of nearly all pings to 255 at most.

    0 where all are black.

    Parameters
    ----------
    looks : what was seen of each ping
    dtype : of the pixels, for the finding
    exchanged : whether their bytes are exchanged first
    notes : a finding is added
    """
    bright = np.array([look.exchanged_bright if exchanged else look.bright for look in looks])
    bright = bright[bright > 0]
    white = 0.0
    if len(bright):
        white = float(np.percentile(bright, BRIGHT_PINGS_PERCENT, method="higher"))
    notes.append(Finding("sonar-scaled", {"dtype": dtype, "white": white}, "sonar"))
    return 255.0 / white if white > 0 else 0.0


def _eight_bits(
    image: NDArray[np.generic], scale: float | None, exchanged: bool
) -> NDArray[np.uint8]:
    """Scale an image to 8 bits.

    Parameters
    ----------
    image : pixels as logged
    scale : None for one that has 8 bits already
    exchanged : whether the bytes of its pixels are exchanged first
    """
    if scale is None:
        return image.astype(np.uint8)
    pixels = image.byteswap() if exchanged else image
    return np.asarray(
        np.clip(np.nan_to_num(pixels.astype(float)) * scale, 0, 255).round(), np.uint8
    )
