# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Views blended into a tile of the mosaic, in three bands [Ozog2016 3.2.4] (docs/methods.md 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.imagery.camera_views import ImageView
from hullrecon.mosaic.mosaic_surface import MosaicSurface, SurfacePatch, sample_surface, seen
from hullrecon.typing import Array, Floats32, Ints32, Mask

STEEPNESS = (5.0, 10.0, 50.0)  # k of B_k, from the coarsest band to the finest
BLUR_PX = (10.0, 2.5)  # sigma of the low-pass below the middle and the finest band
# the coarsest band is made at a quarter of the size: six times faster, and the sum stays exact
REDUCED = 4
VIEWS = 4  # at most so many a texel [Ozog2016 3.2.4]


def split_bands(picture: Floats32) -> tuple[Floats32, Floats32, Floats32]:
    """Split a picture into coarse, middle and fine bands (h, w, channels) that sum to it."""
    import cv2

    size = (picture.shape[1], picture.shape[0])
    middle = np.asarray(cv2.GaussianBlur(picture, (0, 0), BLUR_PX[1]))
    quarter = cv2.resize(
        middle, (-(-size[0] // REDUCED), -(-size[1] // REDUCED)), interpolation=cv2.INTER_AREA
    )
    blurred = cv2.GaussianBlur(quarter, (0, 0), BLUR_PX[0] / REDUCED)
    low, middle = (
        np.asarray(p, np.float32).reshape(picture.shape)
        for p in (cv2.resize(blurred, size), middle)
    )
    return low, middle - low, picture - middle


def band_weight(ratio: NDArray[np.floating], steepness: float) -> Floats32:
    """Weigh by B_k(r) = exp(-k r/R) / (1 + exp(-2 k r/R)). Zero where r/R is NaN."""
    fall = np.exp(-steepness * np.nan_to_num(ratio, nan=0.0))
    return np.where(np.isfinite(ratio), fall / (1 + fall * fall), 0).astype(np.float32)


Part = tuple[slice, slice]


@dataclass(frozen=True, kw_only=True)
class BestViews:
    """The best views of each texel, the best first."""

    view: Ints32  # (4, h, w), -1 where fewer see it
    cost: Floats32  # (4, h, w), inf there


@dataclass(frozen=True, kw_only=True)
class Tile:
    """One tile of the mosaic."""

    value: Floats32  # (h, w, channels) 0 to 255
    variance: Floats32  # (h, w) of the weighted intensities
    views: NDArray[np.uint8]  # (h, w) how many were blended

    def padded(self, shape: tuple[int, int]) -> Tile:
        """Add unseen rows below and columns to the right, up to a shape."""
        more = [(0, n - m) for n, m in zip(shape, self.views.shape, strict=True)]
        return Tile(
            value=np.pad(self.value, [*more, (0, 0)]),
            variance=np.pad(self.variance, more, constant_values=np.nan),
            views=np.pad(self.views, more),
        )


@dataclass(frozen=True, kw_only=True)
class ViewLimits:
    """Which views are used."""

    min_cosine: float = 0.25  # to the surface, below which a view is too oblique
    slant: float = 0.5  # weight of the incidence against the distance to the image's best place


def blend_tile(
    surface: MosaicSurface,
    grid: TexelGrid,
    window: Window,
    image_views: Sequence[ImageView],
    windows: Sequence[Window],
    limits: ViewLimits,
    channels: int,
) -> Tile:
    """Blend the four best views of each texel of a tile, in weighted bands."""
    part = window.meet(grid.whole)
    patch = sample_surface(surface, grid, part)
    near = [k for k, w in enumerate(windows) if not w.meet(part).empty]
    choice = choose_views(
        surface,
        patch,
        part,
        {k: image_views[k] for k in near},
        {k: windows[k] for k in near},
        limits,
    )
    tile = blend(patch, choice, part, image_views, windows, channels)
    return tile.padded(window.shape)


def choose_views(
    surface: MosaicSurface,
    patch: SurfacePatch,
    window: Window,
    image_views: dict[int, ImageView],
    windows: dict[int, Window],
    limits: ViewLimits,
) -> BestViews:
    """Choose the best views of each texel.

    The best are nearest to their image's best place, with a cost for slant. Whether something
    stands in the way is asked of the views that would be the best, and of all only where it does:
    most of the time goes into these rays.
    """
    parts = {k: w.meet(window).within(window) for k, w in windows.items()}
    best = _rank(None, patch, parts, image_views, limits)
    hidden = _find_hidden(surface, patch, best, parts, image_views, limits)
    if hidden.any():
        again = _rank(surface, patch.only(hidden), parts, image_views, limits)
        best.view[:, hidden], best.cost[:, hidden] = again.view[:, hidden], again.cost[:, hidden]
    return best


def _rank(
    surface: MosaicSurface | None,
    patch: SurfacePatch,
    parts: dict[int, Part],
    image_views: dict[int, ImageView],
    limits: ViewLimits,
) -> BestViews:
    """Rank the best views of each texel of the patch."""
    shape = patch.point.shape[:2]
    best = BestViews(
        view=np.full((VIEWS, *shape), -1, np.int32),
        cost=np.full((VIEWS, *shape), np.inf, np.float32),
    )
    for k, image_view in image_views.items():
        if np.isfinite(patch.point[parts[k]][..., 0]).any():
            _insert(best, parts[k], k, view_cost(surface, patch, parts[k], image_view, limits))
    return best


def _find_hidden(
    surface: MosaicSurface,
    patch: SurfacePatch,
    best: BestViews,
    parts: dict[int, Part],
    image_views: dict[int, ImageView],
    limits: ViewLimits,
) -> Mask:
    """Find texels (h, w) where something stands in the way of one of the best views."""
    hidden = np.zeros(best.view.shape[1:], bool)
    for k in np.unique(best.view[best.view >= 0]).tolist():
        rows = patch.rows(parts[k])[(best.view[(slice(None), *parts[k])] == k).any(axis=0)]
        free, _ = seen(surface, patch, rows, image_views[k].center, limits.min_cosine)
        hidden.ravel()[rows[~free]] = True
    return hidden


def view_cost(
    surface: MosaicSurface | None,
    patch: SurfacePatch,
    part: Part,
    image_view: ImageView,
    limits: ViewLimits,
) -> Floats32:
    """Compute a view's cost (h, w) for the part, inf where it does not see the texel.

    `surface`: what may stand in its way, None to ask of nothing.
    """
    known = np.isfinite(patch.point[part][..., 0])
    place, rows = np.flatnonzero(known), patch.rows(part)[known]
    _, ratio = image_view.project(patch.point.reshape(-1, 3)[rows])
    held = np.isfinite(ratio)
    place, rows, ratio = place[held], rows[held], ratio[held]
    if surface is None:
        cosine = patch.cosines(rows, image_view.center)
        free = cosine > limits.min_cosine
    else:
        free, cosine = seen(surface, patch, rows, image_view.center, limits.min_cosine)
    cost = np.full(known.shape, np.inf, np.float32)
    cost.ravel()[place[free]] = ratio[free] + limits.slant * (1 - cosine[free])
    return cost


def _insert(best: BestViews, part: Part, view: int, cost: Floats32) -> None:
    """Insert into the sorted list of each texel."""
    names = np.full(cost.shape, view, np.int32)
    for place in range(VIEWS):
        kept_cost, kept = best.cost[place][part], best.view[place][part]
        better = cost < kept_cost
        cost_out, out = np.where(better, kept_cost, cost), np.where(better, kept, names)
        best.cost[place][part] = np.where(better, cost, kept_cost)
        best.view[place][part] = np.where(better, names, kept)
        cost, names = cost_out, out


def blend(
    patch: SurfacePatch,
    choice: BestViews,
    window: Window,
    image_views: Sequence[ImageView],
    windows: Sequence[Window],
    channels: int,
) -> Tile:
    """Blend the weighted bands, normalised by band.

    The variance is of intensities under the mean of the bands' weights.
    """
    shape = window.shape
    total = [np.zeros((*shape, channels), np.float32) for _ in STEEPNESS]
    weights = [np.zeros(shape, np.float32) for _ in STEEPNESS]
    # of weight, weight x intensity, weight x intensity squared
    moments = np.zeros((3, *shape), np.float32)
    count = np.zeros(shape, np.uint8)
    for k in np.unique(choice.view[choice.view >= 0]).tolist():
        picture = image_views[k].picture()
        if picture is None:
            continue
        part = _bounds(choice, k, windows[k].meet(window).within(window))
        chosen = (choice.view[(slice(None), *part)] == k).any(axis=0)
        pixel, ratio = _project(patch, part, chosen, image_views[k])
        share = [band_weight(ratio, s) for s in STEEPNESS]
        for band, sums, norms, w in zip(split_bands(picture), total, weights, share, strict=True):
            sums[part] += w[..., None] * _sample(band, pixel)
            norms[part] += w
        mean = sum(share) / np.float32(len(share))
        intensity = _sample(picture, pixel).mean(axis=2)
        moments[(slice(None), *part)] += np.stack([mean, mean * intensity, mean * intensity**2])
        count[part] += np.isfinite(ratio)
    return Tile(value=_normalise(total, weights), variance=_variance(moments), views=count)


def _bounds(choice: BestViews, view: int, part: Part) -> Part:
    """Bound the texels, within the part, that the view was chosen for."""
    chosen = (choice.view[(slice(None), *part)] == view).any(axis=0)
    rows, columns = (np.flatnonzero(chosen.any(axis=axis)) for axis in (1, 0))
    return (
        slice(part[0].start + int(rows[0]), part[0].start + int(rows[-1]) + 1),
        slice(part[1].start + int(columns[0]), part[1].start + int(columns[-1]) + 1),
    )


def _project(
    patch: SurfacePatch, part: Part, chosen: Mask, image_view: ImageView
) -> tuple[Floats32, Array]:
    """Project the chosen texels to pixels (h, w, 2) and r/R (h, w), NaN at the others."""
    pixel = np.full((*chosen.shape, 2), -1.0, np.float32)
    ratio = np.full(chosen.shape, np.nan)
    pixel[chosen], ratio[chosen] = image_view.project(patch.point[part][chosen])
    return pixel, ratio


def _sample(picture: Floats32, pixel: Floats32) -> Floats32:
    """Sample bilinearly, (h, w, channels)."""
    import cv2

    taken = cv2.remap(picture, pixel, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(taken, np.float32).reshape(*pixel.shape[:2], -1)


def _normalise(total: list[Floats32], weights: list[Floats32]) -> Floats32:
    parts = [t / np.where(w > 0, w, 1)[..., None] for t, w in zip(total, weights, strict=True)]
    return np.asarray(np.clip(sum(parts[1:], parts[0]), 0, 255), np.float32)


def _variance(moments: Floats32) -> Floats32:
    """Compute the variance, NaN where nothing was blended."""
    norm = np.where(moments[0] > 0, moments[0], np.nan)
    return np.asarray(np.maximum(moments[2] / norm - (moments[1] / norm) ** 2, 0), np.float32)
