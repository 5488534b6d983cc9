# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read images of a dive by index, from the ingest artifact or from files of the package."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from hullrecon.dive.files import read_regular
from hullrecon.dive.images.encoded import LARGEST_PIXELS, decode
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import from_arrays
from hullrecon.typing import Pixels

CAMERAS = tuple(camera.key for camera in Camera)
Encoded = bytes  # of an image, in a class that has a method of that name
LARGEST_BYTES = 4 * LARGEST_PIXELS  # of one image in a file, unpacked pixels with some room


@dataclass(frozen=True)
class ImageStore:
    """The images of one camera. It opens nothing until it is read, and is pickled as its paths."""

    ingest: Path  # the ingest artifact
    package: Path | None  # its folder, needed where images are plain files
    camera: str  # "camera_top" or "camera_bottom"

    @property
    def index(self) -> ImageIndex:
        """Stamps, files and offsets of the images, in order of time."""
        path = self.ingest / f"images_{self.camera}.npz"
        return _index(path, path.stat().st_mtime_ns)

    def __len__(self) -> int:
        return len(self.index.t_ns)

    def bytes(self, i: int) -> bytes:
        """Read the encoded image i, as it was logged. Raises InputError when its file is gone."""
        return self._bytes(self.index, i)

    def _bytes(self, index: ImageIndex, i: int) -> Encoded:
        """Read image i from its file in the package, or from the file of bytes that ingest kept."""
        file = str(index.file[i])
        path = self.ingest / f"images_{self.camera}.bin"
        if file:
            if self.package is None:
                raise InputError(
                    f"image {file} lies in the package", remedy="give the package's folder"
                )
            path = self.package / file
        try:
            if file:
                return read_regular(path, LARGEST_BYTES)
            with path.open("rb") as stream:
                stream.seek(int(index.offset[i]))
                return stream.read(int(index.size[i]))
        except OSError as error:
            raise InputError(
                f"an image cannot be read: {error.strerror}", where=str(path)
            ) from error

    def read(self, i: int) -> Pixels | None:
        """Decode image i into (h, w, 3) RGB. None for one that is unusable or does not decode."""
        index = self.index
        return decode(self._bytes(index, i), int(index.bits)) if index.usable[i] else None


@lru_cache(maxsize=8)
def _index(path: Path, mtime_ns: int) -> ImageIndex:
    """Read an index once. An artifact that was rewritten has another `mtime_ns`."""
    with np.load(path, allow_pickle=False) as arrays:
        return from_arrays(ImageIndex, arrays)
