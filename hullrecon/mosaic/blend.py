# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Blend views into a tile of the mosaic, in three bands [Ozog2016 3.2.4] (docs/methods.md 13)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.imagery.camera_views import ImageView
from hullrecon.mosaic.imagery.radiometry import Part
from hullrecon.mosaic.mosaic_surface import (
    COUNTS,
    MosaicSurface,
    SurfacePatch,
    find_visible,
    interpolate_values,
    sample_surface,
)
from hullrecon.native import BlendSums, insert_view
from hullrecon.typing import Array, Floats32, Ints, Ints32, Mask

# k of the weights B_k (docs/methods.md, 44), from the coarsest band to the finest: how steeply
# they fall with r / R
STEEPNESS = (5.0, 10.0, 50.0)
BLUR_PX = (10.0, 2.5)  # sigmas of the Gaussian low-passes that separate the bands
# The coarsest band is computed at a quarter of the size, which is six times faster. The middle band
# is the difference to it, so that the sum stays exact.
REDUCED = 4
# Pixels around a sampled pixel on which its coarsest band depends: four sigmas of both blurs, and
# the reach of reducing and enlarging
MARGIN_PX = 64
ALIGN_PX = 32  # corners of a crop are multiples of it, and it is a multiple of REDUCED
VIEWS = 4  # most views that are blended in a texel [Ozog2016 3.2.4]
BLOCK = 64  # texels, side of the squares for which views are ruled out together


def split_bands(picture: Floats32) -> tuple[Floats32, Floats32, Floats32]:
    """Split a picture into a coarse, a middle and a fine band, which sum to it.

    Coarse bands of several views are blended softly, so that differences of brightness show no
    seam, and fine ones sharply, so that texture is not doubled. All are (h, w, channels).
    """
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


@dataclass(frozen=True, kw_only=True)
class BestViews:
    """The best views of each texel, the best first."""

    view: Ints32  # (4, h, w) numbers of views, -1 where fewer see the texel
    cost: Floats32  # (4, h, w) of these views, inf where fewer see the texel


@dataclass(frozen=True, kw_only=True)
class Tile:
    """One tile of the mosaic."""

    value: Floats32  # (h, w, channels) 0 to 255
    variance: Floats32  # (h, w) of the blended views' intensities, squared gray levels
    views: NDArray[np.uint8]  # (h, w) number of views that were blended
    # (h, w) values of the surface by name, of `interpolate_values`
    of_surface: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def padded(self, shape: tuple[int, int]) -> Tile:
        """Add unseen rows below and unseen columns to the right, up to a shape.

        So tiles that stick out of the raster have the size of all others.
        """
        more = [(0, n - m) for n, m in zip(shape, self.views.shape, strict=True)]
        return Tile(
            value=np.pad(self.value, [*more, (0, 0)]),
            variance=np.pad(self.variance, more, constant_values=np.nan),
            views=np.pad(self.views, more),
            of_surface={
                name: np.pad(v, more, constant_values=0 if name == COUNTS else np.nan)
                for name, v in self.of_surface.items()
            },
        )


@dataclass(frozen=True, kw_only=True)
class ViewLimits:
    """Which views are used."""

    min_cosine: float = 0.25  # of the incidence angle, below which a view is too oblique
    slant: float = 0.5  # weight of 1 - cosine of the incidence against the ratio r / R


def blend_tile(
    surface: MosaicSurface,
    grid: TexelGrid,
    window: Window,
    image_views: Sequence[ImageView],
    windows: Sequence[Window],
    limits: ViewLimits,
    channels: int,
) -> Tile:
    """Blend the four best views of each texel of a tile, in weighted bands.

    Texels without surface, or that no view sees, are left empty, as are those beyond the raster.
    The surface's own values at the texels are in the tile, too.

    Parameters
    ----------
    surface, grid
        The surface, and the raster on its chart.
    window
        Rows and columns of the tile. It may stick out of the raster.
    image_views
        All views of the dive.
    windows
        For each view the texels that it may see. It is considered at these alone.
    limits
        How oblique a view may be, and how much that costs.
    channels
        Number of channels of the images.
    """
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
    tile = blend(patch, choice, image_views, channels)
    tile = replace(tile, of_surface=interpolate_values(surface, patch))
    return tile.padded(window.shape)


def choose_views(
    surface: MosaicSurface,
    patch: SurfacePatch,
    window: Window,
    image_views: dict[int, ImageView],
    windows: dict[int, Window],
    limits: ViewLimits,
) -> BestViews:
    """Choose the views of least cost for each texel, block by block.

    Where fewer than four see a texel, the rest is -1. Costs are those of `view_cost`. Rays that
    test for occlusion take much of the time. So views are first ranked without them, and only the
    best are tested. Texels at which a best view is occluded are ranked again, with all views
    tested.

    Parameters
    ----------
    surface, patch, window
        The surface, its points at the texels of a tile, and the tile's rows and columns.
    image_views, windows
        Views by number, and the texels that each may see.
    limits
        How oblique a view may be, and how much that costs.
    """
    best = _no_views(window.shape)
    for block, near in _blocks(patch, window, image_views, windows):
        chosen = _rank(None, block, near, image_views, limits)
        hidden = _find_hidden(surface, block.patch, chosen, image_views, limits)
        if len(hidden):
            again = _rank(surface, block.only(hidden), near, image_views, limits)
            chosen.view[:, hidden], chosen.cost[:, hidden] = again.view, again.cost
        best.view.reshape(VIEWS, -1)[:, block.texel] = chosen.view
        best.cost.reshape(VIEWS, -1)[:, block.texel] = chosen.cost
    return best


def _no_views(shape: tuple[int, ...]) -> BestViews:
    """Start the ranking of views of texels (shape) with none: number -1, cost inf."""
    return BestViews(
        view=np.full((VIEWS, *shape), -1, np.int32),
        cost=np.full((VIEWS, *shape), np.inf, np.float32),
    )


@dataclass(frozen=True, kw_only=True)
class _Block:
    """The n texels of a square at which there is surface."""

    window: Window  # of the square
    row: Ints  # (n,) in the raster
    column: Ints  # (n,) in the raster
    texel: Ints  # (n,) flat index in the tile
    patch: SurfacePatch  # of shape (n, 1)

    def only(self, rows: Ints) -> _Block:
        """Keep some of the texels. rows: (k,) among those of the block."""
        return replace(
            self,
            row=self.row[rows],
            column=self.column[rows],
            texel=self.texel[rows],
            patch=_texels(self.patch, rows),
        )

    def within(self, window: Window) -> Mask:
        """Tell which texels (n,) lie in a window of the raster."""
        rows = (self.row >= window.top) & (self.row < window.bottom)
        return np.asarray(rows & (self.column >= window.left) & (self.column < window.right))


def _block(patch: SurfacePatch, window: Window, tile: Window) -> _Block:
    """Cut the block of a window out of the patch of a tile."""
    row, column = np.nonzero(np.isfinite(patch.point[window.within(tile)][..., 0]))
    row, column = row + window.top, column + window.left
    texel = (row - tile.top) * tile.shape[1] + column - tile.left
    return _Block(window=window, row=row, column=column, texel=texel, patch=_texels(patch, texel))


def _texels(patch: SurfacePatch, rows: Ints) -> SurfacePatch:
    """Take the texels with flat indices `rows` (n,) of a patch, as a patch of shape (n, 1)."""
    return SurfacePatch(
        point=patch.point.reshape(-1, 1, 3).take(rows, axis=0),
        normal=patch.normal.reshape(-1, 1, 3).take(rows, axis=0),
        face=patch.face.reshape(-1, 1).take(rows, axis=0),
        free_below=patch.free_below.reshape(-1, 1).take(rows, axis=0),
    )


@dataclass(frozen=True, kw_only=True)
class _Candidate:
    """A view that may see texels of a block."""

    view: int  # number of the view
    window: Window  # texels of the raster that it may see
    least: float  # lower bound of its cost at the texels of the block


def _blocks(
    patch: SurfacePatch,
    window: Window,
    image_views: dict[int, ImageView],
    windows: dict[int, Window],
) -> Iterator[tuple[_Block, list[_Candidate]]]:
    """Yield the blocks where there is surface, with the views that may see them.

    Views are sorted by the lower bound of their cost, so that a ranking can stop early.
    """
    squares, center, radius = _bounding_balls(patch, window)
    views = sorted(image_views)
    least = np.array([image_views[k].least_ratio(center, radius) for k in views])
    least = least.reshape(len(views), len(squares)).T  # (squares, views)
    top, bottom, left, right = (
        np.array([(w.top, w.bottom, w.left, w.right) for w in (windows[k] for k in views)], int)
        .reshape(-1, 4)
        .T
    )
    for square, low in zip(squares, least, strict=True):
        rows = np.minimum(bottom, square.bottom) > np.maximum(top, square.top)
        columns = np.minimum(right, square.right) > np.maximum(left, square.left)
        near = np.flatnonzero((low < np.inf) & rows & columns)
        near = near[np.argsort(low[near], kind="stable")]
        candidates = [
            _Candidate(view=views[i], window=windows[views[i]], least=float(low[i]))
            for i in near.tolist()
        ]
        yield _block(patch, square, window), candidates


def _bounding_balls(patch: SurfacePatch, window: Window) -> tuple[list[Window], Array, Array]:
    """Find a ball around the surface in each square of a tile.

    Views that cannot see any point of a ball are ruled out for its square. Squares without surface
    are left out.

    Returns
    -------
    squares, centers, radii
        Windows of the n squares with surface, (n, 3) m and (n,) m.
    """
    squares, center, radius = [], [], []
    for square in window.parts(BLOCK):
        point = patch.point[square.within(window)]
        point = point[np.isfinite(point[..., 0])]
        if len(point):
            squares.append(square)
            axes = np.ascontiguousarray(point.T)
            center.append(0.5 * (axes.min(axis=1) + axes.max(axis=1)))
            x, y, z = axes - center[-1][:, None]
            radius.append(np.sqrt((x * x + y * y + z * z).max()))
    return squares, np.array(center).reshape(-1, 3), np.array(radius)


def _rank(
    surface: MosaicSurface | None,
    block: _Block,
    near: Sequence[_Candidate],
    image_views: dict[int, ImageView],
    limits: ViewLimits,
) -> BestViews:
    """Rank the views of each of the n texels of a block, and keep the best, (4, n).

    Parameters
    ----------
    surface
        The surface, which may occlude a view. None: occlusion is not tested.
    block
        The texels.
    near
        Candidates by rising lower bound. The ranking stops at the first one whose bound is above
        all costs so far.
    image_views
        Views by number.
    limits
        How oblique a view may be, and how much that costs.
    """
    best = _no_views(block.texel.shape)
    for candidate in near:
        # 1e-5: costs are in single precision
        if candidate.least > float(best.cost[-1].max()) + 1e-5:
            break
        cost = view_cost(surface, block.patch, image_views[candidate.view], limits)
        if candidate.window.meet(block.window) != block.window:
            cost[~block.within(candidate.window)] = np.inf
        insert_view(best.view, best.cost, candidate.view, cost)
    return best


def _find_hidden(
    surface: MosaicSurface,
    patch: SurfacePatch,
    best: BestViews,
    image_views: dict[int, ImageView],
    limits: ViewLimits,
) -> Ints:
    """List the rows of a patch (n, 1) at which one of the best views (4, n) is occluded.

    Texels that no point of the surface can occlude (`free_below` is inf) are not tested.
    """
    doubtful = np.flatnonzero(np.isfinite(patch.free_below[:, 0]))
    hidden = np.zeros(len(patch.free_below), bool)
    for k, which in _texels_by_view(best.view[:, doubtful]):
        rows = doubtful[which]
        free, _ = find_visible(surface, patch, rows, image_views[k].center, limits.min_cosine)
        hidden[rows[~free]] = True
    return np.flatnonzero(hidden)


def view_cost(
    surface: MosaicSurface | None, patch: SurfacePatch, image_view: ImageView, limits: ViewLimits
) -> Floats32:
    """Compute a view's cost (n,) for the texels (n, 1) of a patch, inf where it does not see them.

    The cost is r / R of the projected texel (`ImageView.project`), plus `limits.slant` times one
    minus the cosine of the incidence. `surface`: may occlude the view. None: occlusion is not
    tested.
    """
    _, ratio = image_view.project(patch.point[:, 0])
    free = np.isfinite(ratio)
    if surface is None:
        cosine = patch.cosines(None, image_view.center)
        free &= cosine > limits.min_cosine
    else:
        rows, cosine = np.flatnonzero(free), np.zeros(len(free))
        free[rows], cosine[rows] = find_visible(
            surface, patch, rows, image_view.center, limits.min_cosine
        )
    cost = ratio + limits.slant * (1 - cosine)
    return np.where(free, cost, np.inf).astype(np.float32)


def blend(
    patch: SurfacePatch, choice: BestViews, image_views: Sequence[ImageView], channels: int
) -> Tile:
    """Blend the chosen views of a patch: in each band a weighted mean, summed over the bands.

    The variance of a texel is that of its views' intensities, weighted by the mean of the bands'
    weights. It shows where views disagree. Views whose picture cannot be read are left out.

    Parameters
    ----------
    patch
        The surface at the texels of a tile.
    choice
        The views of each texel, by their numbers in `image_views`.
    image_views
        All views.
    channels
        Number of channels of the images.
    """
    shape = choice.view.shape[1:]
    sums = BlendSums.zero(len(STEEPNESS), channels, shape[0] * shape[1])
    point = patch.point.reshape(-1, 3)
    for k, rows in _texels_by_view(choice.view):
        pixel, ratio = image_views[k].project(point.take(rows, axis=0))
        part, at = crop_around(pixel, image_views[k].size)
        picture = image_views[k].picture(part)
        if picture is not None:
            sums.add(split_bands(picture), rows, at, ratio, STEEPNESS)
    return Tile(
        value=_normalise(sums.value, sums.weight).reshape(*shape, channels),
        variance=_variance(sums.moment).reshape(shape),
        views=sums.views.reshape(shape),
    )


def _texels_by_view(best: Ints32) -> Iterator[tuple[int, Ints]]:
    """Yield each view with the flat indices of the texels that it was chosen for.

    Views chosen for no texel are left out. best (4, ...): numbers of the views of each texel, -1
    where fewer see it.
    """
    chosen = best.reshape(VIEWS, -1) >= 0
    texel = np.broadcast_to(np.arange(chosen.shape[1], dtype=np.int32), chosen.shape)[chosen]
    view = best[best >= 0]
    used = np.flatnonzero(np.bincount(view))
    # Views are renumbered in 16 bits, which NumPy sorts in a fraction of the time
    new_number = np.zeros(used.max(initial=0) + 1, np.uint16)
    new_number[used] = np.arange(len(used))
    renumbered = new_number[view]
    order = np.argsort(renumbered, kind="stable")
    last = np.cumsum(np.bincount(renumbered, minlength=len(used)))
    yield from zip(used.tolist(), np.split(texel[order], last[:-1]), strict=False)


def crop_around(pixel: Array, size: tuple[int, int]) -> tuple[Part, Floats32]:
    """Crop an image around pixels, so that their bands equal those of the whole image.

    Filtering the crop takes less time. The whole image is taken where its size is no multiple of
    REDUCED.

    Parameters
    ----------
    pixel
        (n, 2) px that are sampled.
    size
        Width and height of the image.

    Returns
    -------
    part
        Rows and columns of the crop.
    at
        (n, 2) px of the pixels in the crop.
    """
    width, height = size
    at = np.asarray(pixel, np.float32)
    # The reduced raster of a crop would not coincide with that of the image
    if width % REDUCED or height % REDUCED:
        return (slice(0, height), slice(0, width)), at
    u, v = np.ascontiguousarray(at.T)
    low = np.array([u.min(), v.min()]) - MARGIN_PX
    high = np.array([u.max(), v.max()]) + 1 + MARGIN_PX
    low, high = np.floor(low / ALIGN_PX) * ALIGN_PX, np.ceil(high / ALIGN_PX) * ALIGN_PX
    left, top = np.maximum(low, 0).astype(int).tolist()
    right, bottom = np.minimum(high, [width, height]).astype(int).tolist()
    return (slice(top, bottom), slice(left, right)), at - np.array([left, top], np.float32)


def _normalise(total: Floats32, weight: Floats32) -> Floats32:
    """Divide the sums of each band by its weights, and add the bands: (n, channels), 0 to 255.

    total (n, bands, channels): weighted sums. weight (n, bands): sums of weights.
    """
    coarse, middle, fine = (total / np.where(weight > 0, weight, 1)[:, :, None]).swapaxes(0, 1)
    return np.asarray(np.clip(coarse + middle + fine, 0, 255))


def _variance(moment: Floats32) -> Floats32:
    """Compute the variance (n,) from the moments (n, 3), NaN where nothing was blended.

    The moments are the sums of w, w x and w x^2 of intensities x with weights w.
    """
    norm = np.where(moment[:, 0] > 0, moment[:, 0], np.nan)
    mean, square = moment[:, 1] / norm, moment[:, 2] / norm
    return np.asarray(np.maximum(square - mean**2, 0), np.float32)
