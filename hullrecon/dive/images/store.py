# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read images of a dive by index: their bytes lie in the ingest artifact or, for plain files, in
the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from hullrecon.dive.files import read_regular
from hullrecon.dive.images.deep import decode_deep, is_deep, upper_eight
from hullrecon.dive.images.header import LARGEST_PIXELS, fits, header_size
from hullrecon.errors import InputError
from hullrecon.geometry.frames import Camera
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import from_arrays
from hullrecon.typing import Pixels

CAMERAS = tuple(camera.key for camera in Camera)
LARGEST_BYTES = 4 * LARGEST_PIXELS  # of one image in a file, unpacked pixels with some room


@dataclass(frozen=True)
class ImageStore:
    """The images of one camera ("camera_top" or "camera_bottom"). Opens nothing until read; pickles
    to its paths.

    ingest: the ingest artifact. package: the package's folder, needed where images are plain files.
    """

    ingest: Path
    package: Path | None
    camera: str

    @property
    def index(self) -> ImageIndex:
        """Return stamps, files and offsets of the images, in order of time."""
        path = self.ingest / f"images_{self.camera}.npz"
        return _index(path, path.stat().st_mtime_ns)

    def __len__(self) -> int:
        return len(self.index.t_ns)

    def bytes(self, i: int) -> bytes:
        """Return the encoded image i, as it was logged. Raises InputError when its file is gone."""
        index = self.index
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
        """Return image i (h, w, 3) RGB; None for one that ingest found unusable or that does not
        decode.
        """
        return decode(self.bytes(i), int(self.index.bits)) if self.index.usable[i] else None


def decode(encoded: bytes, bits: int = 16) -> Pixels | None:
    """Return the image (h, w, 3) RGB of JPEG, PNG, TIFF, BMP, PNM, WebP, GIF or JPEG 2000, without
    EXIF rotation.

    bits: of samples of 16 bits the upper 8 of so many lower ones are returned, larger values as
    255. None for bytes that are none of these, that are damaged beyond decoding, or that say a size
    of more than LARGEST_PIXELS.
    """
    import cv2

    size = header_size(encoded)
    if size is None or not fits(size):
        return None
    deep = decode_deep(encoded) if bits < 16 and is_deep(encoded) else None
    if deep is not None:
        return upper_eight(deep, bits)
    flags = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        image = cv2.imdecode(np.frombuffer(encoded, np.uint8), flags)
    except cv2.error:
        return None
    return None if image is None else np.asarray(image, np.uint8)


@lru_cache(maxsize=8)
def _index(path: Path, mtime_ns: int) -> ImageIndex:
    """Return the index from memory; an artifact that was rewritten has another `mtime_ns` and is
    read again.
    """
    with np.load(path, allow_pickle=False) as arrays:
        return from_arrays(ImageIndex, arrays)
