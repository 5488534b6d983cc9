# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of many images on disk: .npy files that grow while written, and are read by image."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import IO, Literal

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.frames import Camera
from hullrecon.rows import read_rows
from hullrecon.typing import Array, Floats32, Ints
from hullrecon.vision.features.extraction import Features


class GrowingArray:
    """An .npy file of rows (n, width), written block by block.

    The header is written again at the end with the final n: numpy's header has room for it.
    """

    def __init__(self, path: Path, width: int, dtype: type[np.generic]) -> None:
        self._path, self._width, self._dtype, self._rows = path, width, np.dtype(dtype), 0
        self._file: IO[bytes] | None = None

    def __enter__(self) -> GrowingArray:
        self._file = self._path.open("wb")
        self._header(self._file)
        return self

    def append(self, rows: NDArray[np.generic]) -> None:
        """Write rows (m, width).

        Raises
        ------
        ValueError
            Where they have another width, or outside of a `with`.
        """
        if self._file is None or rows.shape[1:] != (self._width,):
            raise ValueError(
                f"rows of {rows.shape[1:]} do not fit an open array of width {self._width}"
            )
        self._file.write(np.ascontiguousarray(rows, self._dtype).tobytes())
        self._rows += len(rows)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write the number of rows into the header, and close the file."""
        if self._file is not None:
            self._file.seek(0)
            self._header(self._file)
            self._file.close()

    def _header(self, file: IO[bytes]) -> None:
        """Write the .npy header for the rows so far."""
        description = {
            "descr": self._dtype.str,
            "fortran_order": False,
            "shape": (self._rows, self._width),
        }
        np.lib.format.write_array_header_1_0(file, description)


@dataclass(frozen=True)
class FeatureStore:
    """Features by image of one camera in a features artifact. Pickles as a path."""

    folder: Path
    camera: Camera

    def __len__(self) -> int:
        return len(self._open().start) - 1

    def counts(self, images: Ints) -> Ints:
        """Count the features (n,) of images (n,), rows of the camera's ImageIndex. 0 for row -1."""
        size = np.append(np.diff(self._open().start), 0)
        return np.asarray(size[images])

    def read(self, image: int) -> Features:
        """Read the features of a row of the camera's ImageIndex. Empty for row -1."""
        files = self._open()
        rows = slice(0, 0) if image < 0 else slice(*files.start[image : image + 2])
        return Features(
            read_rows(files.keypoints, rows),
            read_rows(files.descriptors, rows),
            read_rows(files.color, rows),
        )

    def saliency(self, image: int) -> float:
        """Look up the local saliency of an image, 0 for -1."""
        return 0.0 if image < 0 else float(self._open().saliency[image])

    def _open(self) -> _Files:
        status = (self.folder / "index.npz").stat()
        return _map(self.folder, self.camera.key, (status.st_ino, status.st_mtime_ns))


@dataclass(frozen=True, kw_only=True)
class _Files:
    """The arrays of one camera, mapped."""

    start: Ints  # (images + 1,) first row of each image in the arrays below
    saliency: Array  # (images,)
    # rows of all images: the fields of `Features`
    keypoints: Floats32
    descriptors: NDArray[np.uint8]
    color: NDArray[np.uint8]


@lru_cache(maxsize=8)
def _map(folder: Path, camera: str, stamp: tuple[int, int]) -> _Files:
    """Map the arrays of a camera. `stamp` tells builds of the artifact in one folder apart."""
    with np.load(folder / "index.npz", allow_pickle=False) as index:
        start = np.asarray(index[f"{camera}_start"], np.int64)
        saliency = np.asarray(index[f"{camera}_saliency"], float)
    mode: Literal["r"] | None = "r" if start[-1] else None  # a file without rows cannot be mapped
    arrays = {
        kind: np.load(folder / f"{kind}_{camera}.npy", mmap_mode=mode, allow_pickle=False)
        for kind in ("keypoints", "descriptors", "color")
    }
    return _Files(start=start, saliency=saliency, **arrays)
