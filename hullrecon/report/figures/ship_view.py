# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The ship of the CAD model from the side or below, with the surveyed patch on it, as SVG."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np

from hullrecon.geometry.meshes.mesh import Mesh, face_areas, face_normals
from hullrecon.native import draw_triangles
from hullrecon.report.figures.plan_view import nice_below
from hullrecon.report.figures.style import encode_png, picture_uri
from hullrecon.report.format_limits import reduction
from hullrecon.typing import Array

WIDTH, MARGIN, FOOT = 1000.0, 26.0, 26.0  # of the SVG, its units
TALLEST = 1000.0  # largest height, of a model that is taller than long
PICTURE_PX = 1600  # longer side of the drawn ship
# least side of the rectangle around the patch, so that a small patch is found on a long ship
LEAST_FRAME = 26.0
STEEL, PATCH = np.array([0.50, 0.58, 0.66]), np.array([0.88, 0.42, 0.10])


@dataclass(frozen=True, kw_only=True)
class Side:
    """A direction of view of a ship whose axes are forward, port, up."""

    right: Array  # (3,) of the picture
    up: Array
    words: str  # where the viewer is

    @property
    def toward(self) -> Array:
        """Direction (3,) from the ship to the viewer."""
        return np.cross(self.right, self.up)

    def project(self, points: Array) -> Array:
        """Project points (..., 3) onto the picture (..., 2), m."""
        return np.asarray(points @ np.stack([self.right, self.up], axis=1))

    @property
    def bow_is_left(self) -> bool:
        """Whether the bow lies on the left."""
        return bool(self.right[0] < 0)


PORT = Side(right=np.array([-1.0, 0, 0]), up=np.array([0, 0, 1.0]), words="port side")
STARBOARD = Side(right=np.array([1.0, 0, 0]), up=np.array([0, 0, 1.0]), words="starboard side")
BELOW = Side(
    right=np.array([1.0, 0, 0]),
    up=np.array([0, -1.0, 0]),
    words="bottom, seen from below, starboard on top",
)


def facing_side(patch: Mesh) -> Side:
    """Choose the side from which most of a patch is seen. The patch has axes forward, port, up."""
    area = face_areas(patch) @ face_normals(patch)
    if -area[2] > abs(area[1]):
        return BELOW
    return PORT if area[1] > 0 else STARBOARD


def ship_svg(ship: Mesh, patch: Mesh) -> tuple[str, str]:
    """Draw a ship with a patch, and name the side that it shows.

    Ship and patch are in axes forward, port, up, metres.
    """
    side = facing_side(patch)
    at = side.project(ship.vertices)
    low, high = at.min(axis=0), at.max(axis=0)
    wide, tall = np.maximum(high - low, 1e-3)
    scale = min((WIDTH - 2 * MARGIN) / wide, TALLEST / tall)
    width, height = scale * wide, scale * tall
    text = (
        f"The ship from its CAD model, {side.words}; the surveyed patch is in colour. "
        f"The bow is on the {'left' if side.bow_is_left else 'right'}."
    )
    surveyed = side.project(patch.vertices[np.unique(patch.faces)])
    picture = picture_uri(_render(ship, patch, side, (low, high)))
    box = f'x="{MARGIN}" y="{MARGIN}" width="{width:.1f}" height="{height:.1f}"'
    svg = (
        f'<svg class="ship" viewBox="0 0 {WIDTH:.0f} {height + 2 * MARGIN + FOOT:.0f}" role="img" '
        f'aria-label="{escape(text, quote=True)}" xmlns="http://www.w3.org/2000/svg">'
        f"<title>{escape(text)}</title>"
        f'<image {box} preserveAspectRatio="none" href="{picture}"/>'
        f"{_frame(surveyed, low, scale, height)}{_foot(side, scale, height)}</svg>"
    )
    return svg, side.words


def _frame(patch: Array, low: Array, scale: float, height: float) -> str:
    """Draw a rectangle around the patch.

    Parameters
    ----------
    patch
        Its vertices (n, 2), projected, m.
    low
        (2,) lower left corner of the projected ship, m.
    scale
        SVG units of a metre.
    height
        Height of the picture, SVG units.
    """
    (x0, y0), (x1, y1) = (patch.min(axis=0) - low) * scale, (patch.max(axis=0) - low) * scale
    x, y = MARGIN + (x0 + x1) / 2, MARGIN + height - (y0 + y1) / 2
    w, h = (max(LEAST_FRAME, span + 12) for span in (x1 - x0, y1 - y0))
    box = f'x="{x - w / 2:.1f}" y="{y - h / 2:.1f}" width="{w:.1f}" height="{h:.1f}"'
    return f'<rect class="patch" {box}/>'


def _foot(side: Side, scale: float, height: float) -> str:
    """Draw bow, stern and between them a scale bar, below the ship, as SVG.

    scale: of the drawing, its units in a metre. height: of the ship in the drawing.
    """
    y = 2 * MARGIN + height + 8
    left, right = ("bow", "stern") if side.bow_is_left else ("stern", "bow")
    metres = nice_below(0.25 * WIDTH / scale)
    bar, middle = metres * scale, WIDTH / 2
    return (
        f'<text x="{MARGIN:.0f}" y="{y:.1f}">{left}</text>'
        f'<text x="{WIDTH - MARGIN:.0f}" y="{y:.1f}" class="end">{right}</text>'
        f'<path class="bar" d="M{middle - bar / 2:.1f} {y - 10:.1f}v10m0 -5h{bar:.1f}m0 -5v10"/>'
        f'<text x="{middle + bar / 2 + 8:.1f}" y="{y:.1f}">{metres:g} m</text>'
    )


def _render(ship: Mesh, patch: Mesh, side: Side, bounds: tuple[Array, Array]) -> bytes:
    """Draw the shaded ship with the patch as PNG, transparent around it.

    The picture fills the bounds, lower left and upper right corner (2,) of the projected ship, m.
    It is drawn twice as large and halved, which smooths outlines.
    """
    import cv2

    low, high = bounds
    wide, tall = np.maximum(high - low, 1e-3)
    shrink = reduction(1.0, tall / wide, 1.0)
    width, height = (max(20, round(share * PICTURE_PX / shrink)) for share in (1.0, tall / wide))
    shaded = [_shaded_faces(mesh, side, tint) for mesh, tint in ((ship, STEEL), (patch, PATCH))]
    corners, colours = (np.concatenate(parts) for parts in zip(*shaded, strict=True))
    places = (corners.reshape(-1, 2) - [low[0], high[1]]) / [wide, -tall] * [2 * width, 2 * height]
    faces = np.arange(len(places)).reshape(-1, 3)
    drawn = draw_triangles(
        places, faces, np.repeat(255 * colours, 3, axis=0), (2 * height, 2 * width)
    )
    seen = np.isfinite(drawn[..., 0])
    drawn[~seen] = 0
    share, colour = (
        np.asarray(cv2.resize(layer, (width, height), interpolation=cv2.INTER_AREA))
        for layer in (seen.astype(np.float32), drawn)
    )
    colour /= np.maximum(share, 0.25)[..., None]  # of the pixels that were drawn
    return encode_png(np.rint(np.dstack([colour, 255 * share])).astype(np.uint8))


def _shaded_faces(mesh: Mesh, side: Side, tint: Array) -> tuple[Array, Array]:
    """Project the faces that the viewer sees, farthest first, and shade their tint, RGB 0 to 1.

    Returns their corners (m, 3, 2) m in the picture's axes, and their RGB colours (m, 3), 0 to 1.
    Drawn in this order, nearer faces cover farther ones. Faces turned away are left out.
    """
    normal = face_normals(mesh)
    facing = normal @ side.toward
    depth = mesh.vertices[mesh.faces].mean(axis=1) @ side.toward
    shown = np.flatnonzero(facing > 0)
    shown = shown[np.argsort(depth[shown], kind="stable")]
    light = 0.55 * side.toward + 0.75 * side.up + 0.25 * side.right
    shade = 0.62 + 0.38 * np.clip(normal[shown] @ light / np.linalg.norm(light), 0, 1)
    return side.project(mesh.vertices[mesh.faces[shown]]), np.clip(
        shade[:, None] * tint * 1.12, 0, 1
    )
