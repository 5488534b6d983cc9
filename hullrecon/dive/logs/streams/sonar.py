# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the pings of an imaging sonar into a record: images of 8 bits, of one geometry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.dvl_beams import unit
from hullrecon.dive.logs.ping_spool import Images, KeepImages, bright_pixel
from hullrecon.dive.logs.samples import SonarSample, stamps
from hullrecon.dive.logs.sonar_geometry import (
    choose_directions,
    evenly_spaced,
    image_in_ranges,
    pings_of_one_window,
)
from hullrecon.findings.finding import Finding
from hullrecon.records.sensors import SonarPings
from hullrecon.typing import Array

# percentile of the pings' bright pixels that is scaled to white: a few pings are disturbed
BRIGHT_PINGS_PERCENT = 99.0


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
        Nothing says where the beams point, or the ranges are no sonar's.
    """
    kept, range_m = pings_of_one_window(samples, notes)
    if not kept:
        return None
    directions = choose_directions(kept[0], azimuth_deg, notes)
    range_m = evenly_spaced(np.asarray(range_m, float))
    scale = _scale_to_eight_bits(kept, notes)
    shape = (len(kept), len(directions), len(range_m))
    image = keep(
        shape, (_eight_bits(image_in_ranges(load(sample), range_m), scale) for sample in kept)
    )
    return SonarPings(
        t_ns=stamps(kept),
        image=image,
        directions=unit(directions),
        range_m=range_m,
    )


def _scale_to_eight_bits(samples: Sequence[SonarSample], notes: list[Finding]) -> float | None:
    """Find the factor that brings the bright pixel of nearly all pings to 255 at most.

    None where all pixels have 8 bits, 0 where all are black.
    """
    if all(sample.image.dtype == np.uint8 for sample in samples):
        return None
    bright = np.array([float(bright_pixel(sample.image)) for sample in samples])
    bright = bright[bright > 0]
    white = 0.0
    if len(bright):
        white = float(np.percentile(bright, BRIGHT_PINGS_PERCENT, method="higher"))
    values = {"dtype": str(samples[0].image.dtype), "white": white}
    notes.append(Finding("sonar-scaled", values, "sonar"))
    return 255.0 / white if white > 0 else 0.0


def _eight_bits(image: NDArray[np.generic], scale: float | None) -> NDArray[np.uint8]:
    """Scale an image to 8 bits. scale: None for one that has 8 bits already."""
    if scale is None:
        return image.astype(np.uint8)
    return np.asarray(np.clip(np.nan_to_num(image.astype(float)) * scale, 0, 255).round(), np.uint8)
