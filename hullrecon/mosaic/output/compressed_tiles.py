# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tiles of one kind, kept compressed until they are written."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass
class CompressedTiles:
    """Arrays of one shape and type in the order in which they were added."""

    shape: tuple[int, ...]
    dtype: str
    _data: list[bytes] = field(default_factory=list)

    def add(self, tile: NDArray[np.generic]) -> None:
        """Keep a tile. Raises ValueError for one of another shape."""
        if tile.shape != self.shape:
            raise ValueError(f"a tile of shape {tile.shape} among those of {self.shape}")
        self._data.append(zlib.compress(np.ascontiguousarray(tile, self.dtype).tobytes(), 1))

    def __iter__(self) -> Iterator[NDArray[np.generic]]:
        return (
            np.frombuffer(zlib.decompress(data), self.dtype).reshape(self.shape)
            for data in self._data
        )

    def __len__(self) -> int:
        return len(self._data)
