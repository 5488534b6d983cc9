# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The preview and the textured mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO

import numpy as np
import trimesh
from PIL import Image

from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.preview import Caption, preview_png, stretch_contrast
from hullrecon.mosaic.output.textured_mesh import UPRIGHT, build_textured_mesh, encode_glb

GRID = TexelGrid(west=-0.8, north=0.6, step_m=0.01, height=120, width=160)


def checks() -> np.ndarray:
    picture = np.zeros((120, 160, 4), np.uint8)
    picture[..., :3] = np.where((np.indices((120, 160)).sum(axis=0) // 20) % 2, 90, 140)[..., None]
    picture[:, 20:, 3] = 255
    return picture


def test_the_preview_is_a_picture_with_the_same_bytes_each_time() -> None:
    caption = Caption(title="Optical mosaic", legend="a legend", frame="M", frame_spacing_m=0.6, flips=(True, False))
    first, second = (preview_png(checks(), -0.8, 0.6, 0.01, caption) for _ in range(2))
    assert first == second
    with Image.open(BytesIO(first)) as picture:
        assert picture.width > picture.height > 500
        assert "Software" not in picture.info


def test_a_flipped_preview_shows_the_unseen_side_on_the_right() -> None:
    plain, flipped = (
        np.asarray(
            Image.open(
                BytesIO(
                    preview_png(
                        checks(), -0.8, 0.6, 0.01, Caption(title="t", legend="l", frame="M", frame_spacing_m=None, flips=f)
                    )
                )
            ).convert("RGB")
        )
        for f in ((False, False), (True, False))
    )
    unseen = [np.mean(np.nonzero((p == (0xE9, 0xED, 0xF1)).all(axis=2))[1]) / p.shape[1] for p in (plain, flipped)]
    assert unseen[0] < 0.4
    assert unseen[1] > 0.6


def test_stretching_spreads_the_seen_brightness_and_leaves_alpha() -> None:
    picture = checks()
    out = stretch_contrast(picture)
    np.testing.assert_array_equal(out[..., 3], picture[..., 3])
    assert np.ptp(out[:, 20:, 0].astype(int)) > 200


def test_stretching_an_empty_mosaic_changes_nothing() -> None:
    empty = np.zeros((4, 5, 4), np.uint8)
    np.testing.assert_array_equal(stretch_contrast(empty), empty)


def test_the_sheet_covers_what_was_seen_and_faces_outward(flat_surface: Callable[..., MosaicSurface]) -> None:
    mesh = build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, most_faces=5000)
    assert 2000 < len(mesh.faces) < 6000
    assert mesh.vertices[:, 0].min() > -0.62  # the first 20 columns were not seen
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.uv[:, 0], (mesh.vertices[:, 0] + 0.8) / 1.6, atol=0.01)
    np.testing.assert_allclose(mesh.uv[:, 1], (mesh.vertices[:, 1] + 0.6) / 1.2, atol=0.01)


class LeftHanded:
    """along is x, girth is against y, outward is z: as the charts of hulls are (geometry.chart)."""

    def to_chart(self, points: np.ndarray) -> np.ndarray:
        return points * [1, -1, 1]

    def from_chart(self, along_girth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.column_stack([along_girth * [1, -1], np.zeros(len(along_girth))]), np.tile(
            [0.0, 0.0, 1.0], (len(along_girth), 1)
        )


def test_on_a_left_handed_chart_the_sheet_faces_outward_too(flat_surface: Callable[..., MosaicSurface]) -> None:
    mesh = build_textured_mesh(replace(flat_surface(), chart=LeftHanded()), GRID, checks()[..., 3], 1, most_faces=5000)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.uv[:, 1], (0.6 - mesh.vertices[:, 1]) / 1.2, atol=0.01)


def test_the_glb_opens_upright_with_its_texture_and_the_same_bytes_each_time(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    mesh = build_textured_mesh(flat_surface(), GRID, checks()[..., 3], 1, most_faces=2000)
    data = encode_glb(mesh, checks(), upright=True)
    assert data == encode_glb(mesh, checks(), upright=True)
    scene = trimesh.load(BytesIO(data), file_type="glb")
    (mesh,) = scene.geometry.values()
    assert len(mesh.faces) == len(mesh.faces)
    assert mesh.visual.material.baseColorTexture.size == (160, 120)
    turn, _ = scene.graph[scene.graph.nodes_geometry[0]]
    np.testing.assert_allclose(turn, UPRIGHT)
    np.testing.assert_allclose(UPRIGHT[:3, :3] @ [0, 0, 1], [0, 1, 0])  # up in M is up in glTF
