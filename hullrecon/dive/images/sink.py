# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Take the images of one camera as they stream by: check each, write its bytes on, keep its offset."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.dive.files import read_regular
from hullrecon.dive.images.deep import significant_bits
from hullrecon.dive.images.integrity import check_image
from hullrecon.dive.images.store import LARGEST_BYTES
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.dive.logs.timeline import put_in_order
from hullrecon.errors import InputError
from hullrecon.records.sensors import ImageIndex

PATIENCE = 5  # images of another size than the calibration's, with none right, before giving up


class ImageSink:
    """size: (width, height) of the calibration. open_file: called once, when the first bytes are to
    be kept.
    """

    def __init__(
        self,
        camera: str,
        size: tuple[int, int],
        offset_ns: int,
        package: Path,
        open_file: Callable[[], BinaryIO],
    ) -> None:
        self._camera, self._size, self._offset_ns, self._package = camera, size, offset_ns, package
        self._open_file, self._at = open_file, 0
        self._file: BinaryIO | None = None
        self._rows: list[tuple[int, int, int, str, int, int, bool]] = []
        self._sizes: Counter[tuple[int, int]] = Counter()
        self._largest: int | None = None  # value of the images of 16 bits

    def take(self, sample: ImageSample, logged_ns: int, log: int) -> None:
        """Check one image of the log of that number and keep its bytes, unless they lie in a file
        of the package.
        """
        encoded = self._bytes(sample)
        found = check_image(encoded, self._size)
        size = found.size
        if size is not None:
            self._sizes[size] += 1
        if found.largest is not None and size == self._size:
            self._largest = max(found.largest, self._largest or 0)
        offset, kept = (0, 0) if sample.file else (self._keep(encoded), len(encoded))
        stamp = sample.t_ns + self._offset_ns
        self._rows.append(
            (stamp, logged_ns + self._offset_ns, log, sample.file, offset, kept, size == self._size)
        )
        if len(self._rows) == PATIENCE:
            self._check_size()

    def finish(self, remarks: list[str]) -> ImageIndex | None:
        """Return the index in order of time; None without images.

        Raises InputError when none can be read or has the calibration's size.
        """
        if not self._rows:
            return None
        self._check_size()
        if not any(row[-1] for row in self._rows):
            many = (
                f"none of the {len(self._rows)} images" if len(self._rows) > 1 else "the only image"
            )
            raise InputError(
                f"{many} of {self._camera} can be read",
                remedy="see that the files are there and whole",
            )
        stamp, logged, log, file, offset, size, usable = (
            list(column) for column in zip(*self._rows, strict=True)
        )
        line = put_in_order(self._camera, stamp, logged, log)
        bits = significant_bits(self._largest)
        remarks += line.remarks + self._bad(usable) + self._deep(bits)
        rows = line.keep
        return ImageIndex(
            t_ns=line.t_ns,
            file=np.array(file, np.str_)[rows],
            offset=np.array(offset, np.int64)[rows],
            size=np.array(size, np.int64)[rows],
            usable=np.array(usable, bool)[rows],
            bits=np.array(bits),
        )

    def _bytes(self, sample: ImageSample) -> bytes:
        if not sample.file:
            return sample.encoded
        try:
            return read_regular(self._package / sample.file, LARGEST_BYTES)
        except (OSError, ValueError):
            return b""  # counted among those that do not decode

    def _keep(self, encoded: bytes) -> int:
        if self._file is None:
            self._file = self._open_file()
        self._file.write(encoded)
        self._at += len(encoded)
        return self._at - len(encoded)

    def _check_size(self) -> None:
        if self._sizes and not self._sizes[self._size]:
            logged = "{} x {}".format(*self._sizes.most_common(1)[0][0])
            raise InputError(
                f"the images of {self._camera} have {logged} pixels, its calibration is for {self._size[0]} x {self._size[1]}",
                remedy="give the calibration of this camera at this size",
            )

    def _deep(self, bits: int) -> list[str]:
        if self._largest is None:
            return []
        what = f"its images have 16 bits with values up to {self._largest}; the upper 8 of {bits} bits are used"
        return [f"{self._camera}: {what}"]

    def _bad(self, usable: list[bool]) -> list[str]:
        count, other = len(usable), sum(self._sizes.values()) - self._sizes[self._size]
        broken = usable.count(False) - other
        lines = (
            [f"{self._camera}: {broken} of {count} images are missing or damaged and are left out"]
            if broken
            else []
        )
        return lines + (
            [f"{self._camera}: {other} of {count} images have another size and are left out"]
            if other
            else []
        )
