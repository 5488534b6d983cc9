# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a wrong lens explains matches of a stereo pair that the calibrated rig does not.

A principal point, focal length or distortion of either camera is fitted with the rest held.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.rows import spread_rows
from hullrecon.typing import Array
from hullrecon.vision.pairs.two_view import essential_of, sampson_squared

MOST_MATCHES = 300  # matches that a hypothesis is fitted to, taken evenly from all
EVALUATIONS = 150  # of the cost at most, by Nelder-Mead on one or two numbers
# Size of the first simplex: as a share of the focal length, and in k1 and k2
STEP_SHARE, STEP_RADIAL = 0.1, 0.1
Lenses = tuple[CameraModel, CameraModel]


@dataclass(frozen=True, kw_only=True)
class LensFit:
    """A lens that was fitted to matches."""

    words: str  # what of which camera, and by how much
    error_px: float  # median distance from epipolar lines


def best_lenses(
    lenses: Lenses, bottom_from_top: Array, top_px: Array, bottom_px: Array
) -> list[LensFit]:
    """Fit each hypothesis of a wrong lens to the matches, with the pose held as calibrated.

    The best are named to the user as possible causes. Of each kind (principal point, focal length,
    distortion) only the fit of least epipolar error is returned, sorted by that error.

    Parameters
    ----------
    lenses
        Lens models of the top and the bottom camera as calibrated.
    bottom_from_top
        (4, 4) as calibrated.
    top_px, bottom_px
        Matches (n, 2), pixels in the raw images.
    """
    rows = spread_rows(len(top_px), MOST_MATCHES)
    essential, seen = essential_of(bottom_from_top), (top_px[rows], bottom_px[rows])
    best: dict[str, LensFit] = {}
    for name, wrong, which in _causes():
        fit = _fit(name, wrong, which, lenses, essential, seen)
        if name not in best or fit.error_px < best[name].error_px:
            best[name] = fit
    return sorted(best.values(), key=lambda fit: fit.error_px)


def _causes() -> Iterator[tuple[str, Callable[[CameraModel, Array], CameraModel], str]]:
    """Yield each hypothesis: its kind, the function that changes a lens, and of which camera.

    Errors that matches cannot show, or cannot tell from others, are left out.
    """
    # The cameras look the same way: a shift in the one is a shift back in the other, and a scale of
    # both moves no match off its epipolar line.
    yield "principal point", _shifted, "bottom"
    yield "principal point", _shifted, "both"
    for which in ("top", "bottom"):
        yield "focal length", _scaled, which
    for which in ("top", "bottom", "both"):
        yield "distortion", _distorted, which


def _fit(
    name: str,
    wrong: Callable[[CameraModel, Array], CameraModel],
    which: str,
    lenses: Lenses,
    essential: Array,
    seen: tuple[Array, Array],
) -> LensFit:
    """Fit one kind of wrong lens of one or both cameras, by the least epipolar error.

    Parameters
    ----------
    name
        Kind of the error, as in `_causes`.
    wrong
        Changes a lens by one or two values, 0 for none.
    which
        Camera whose lens is changed: "top", "bottom" or "both".
    lenses
        Both lens models as calibrated, which are changed.
    essential
        Essential matrix (3, 3) of the calibrated rig, which is held.
    seen
        Matches (n, 2) in raw pixels of both images.
    """
    from scipy.optimize import minimize  # a quarter of a second to load, for a rig that is wrong

    def lenses_with(values: Array) -> Lenses:
        """Change the suspected lens, or both, by the error's values (k,)."""
        top, bottom = lenses
        return (
            top if which == "bottom" else wrong(top, values),
            bottom if which == "top" else wrong(bottom, values),
        )

    def error_px(values: Array) -> float:
        return epipolar_error_px(lenses_with(values), essential, seen)

    step = STEP_RADIAL if name == "distortion" else STEP_SHARE
    simplex = step * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    if name == "focal length":
        simplex = simplex[:2, :1]
    found = minimize(
        error_px,
        simplex[0],
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": EVALUATIONS, "xatol": 1e-5, "fatol": 1e-3},
    )
    camera = "both cameras'" if which == "both" else f"the {which} camera's"
    # a shift of the top camera's has the same effect, and is not fitted (`_causes`)
    if which == "bottom" and name == "principal point":
        camera = "one camera's"
    amount = {
        "principal point": f"{lenses[0].fx * np.linalg.norm(found.x):.0f} px from where it is",
        "focal length": f"{1 + found.x[0]:.2f} times as long",
        "distortion": "another",
    }[name]
    return LensFit(words=f"{camera} {name} {amount}", error_px=float(found.fun))


def epipolar_error_px(lenses: Lenses, essential: Array, seen: tuple[Array, Array]) -> float:
    """Compute the median distance, px, of matches from their epipolar lines.

    Matches that a lens cannot have seen (NaN) do not count. lenses: of the top and the bottom
    camera. essential: (3, 3) bottom from top. seen: matches (n, 2) in raw pixels of the top and the
    bottom image.
    """
    ideal = [lens.undistort(pixel) for lens, pixel in zip(lenses, seen, strict=True)]
    squared = sampson_squared(essential, *ideal)
    return float(np.sqrt(np.nanmedian(squared)) * 0.5 * (lenses[0].fx + lenses[1].fx))


def _shifted(lens: CameraModel, values: Array) -> CameraModel:
    """Shift the principal point by values (2,), as shares of the focal length."""
    return replace(lens, cx=lens.cx + values[0] * lens.fx, cy=lens.cy + values[1] * lens.fx)


def _scaled(lens: CameraModel, values: Array) -> CameraModel:
    """Lengthen the focal length by a share of it, values (1,)."""
    factor = max(1 + values[0], 0.1)
    return replace(lens, fx=lens.fx * factor, fy=lens.fy * factor)


def in_other_order(lens: CameraModel) -> CameraModel:
    """Read the coefficients of distortion as k1, k2, k3, p1, p2, which Metashape and others write.

    They were taken as k1, k2, p1, p2, k3, as OpenCV writes them.
    """
    return replace(lens, k3=lens.p1, p1=lens.p2, p2=lens.k3)


def _distorted(lens: CameraModel, values: Array) -> CameraModel:
    """Add values (2,) to the radial distortion k1 and k2."""
    return replace(lens, k1=lens.k1 + values[0], k2=lens.k2 + values[1])
