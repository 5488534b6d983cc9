# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Take the images of one camera as they stream by: check each, and keep its bytes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

import numpy as np

from hullrecon.dive.files import read_regular
from hullrecon.dive.images.encoded import check_image, significant_bits, turn_in_exif
from hullrecon.dive.images.store import LARGEST_BYTES
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.dive.logs.timeline import put_in_order
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.findings.package import WITHOUT_CAMERAS
from hullrecon.records.sensors import ImageIndex
from hullrecon.typing import Ints

PATIENCE = 5  # images after which one of the calibration's size must have come
RUN = 8  # neighbouring images that are sampled together, so that both cameras keep the same ones
LEAST_STILL = 5  # images that are one picture, from which on a camera stands still
LEAST_NAMES = 8  # fewer are in the order of text by chance
WHOLE, DECIMAL = re.compile(r"\d+"), re.compile(r"\d+(?:\.\d+)?")  # numbers in a file's name
MOST = 128  # images that are kept as samples: some tens of megabytes


class ImageSink:
    """Takes the images of one camera."""

    def __init__(
        self,
        camera: str,
        size: tuple[int, int],
        package: Path,
        open_file: Callable[[], BinaryIO],
    ) -> None:
        """Set up the sink of one camera.

        Parameters
        ----------
        camera : "camera_top" or "camera_bottom"
        size : (width, height) of the calibration
        package : the folder that files are relative to
        open_file : called once, when the first bytes are to be kept
        """
        self._camera, self._size, self._package = camera, size, package
        self._open_file, self._at = open_file, 0  # byte of the file at which the next image goes
        self._file: BinaryIO | None = None
        # of each image: stamp and logging time, ns, number of the log, file in the package or "",
        # offset and size in the file of kept bytes, and whether it can be used
        self._rows: list[tuple[int, int, int, str, int, int, bool]] = []
        self._last, self._again = b"", list[bool]()  # the last image; which rows repeat it
        self._sizes: Counter[tuple[int, int]] = Counter()  # images by width and height
        self._largest: int | None = None  # value in the images of 16 bits
        self._mosaics = 0  # images that were Bayer mosaics
        self._turn = ""  # that EXIF asks for in the first image, in words

    def take(self, sample: ImageSample, logged_ns: int, log: int) -> None:
        """Check one image and keep its bytes, unless they lie in a file of the package.

        Images that cannot be used are listed too, so that their stamps count. Raises InputError
        where none of the first PATIENCE has the calibration's size.

        logged_ns: when it was logged. log: the number of its log.
        """
        encoded = self._bytes(sample)
        self._again.append(bool(encoded) and encoded == self._last)
        self._last = encoded
        found = check_image(encoded, self._size)
        size = found.size
        if size is not None and not self._sizes:
            self._turn = turn_in_exif(encoded)
        if size is not None:
            self._sizes[size] += 1
        if found.largest is not None and size == self._size:
            self._largest = max(found.largest, self._largest or 0)
        self._mosaics += found.is_mosaic
        offset, kept = (0, 0) if sample.file else (self._keep(encoded), len(encoded))
        self._rows.append(
            (sample.t_ns, logged_ns, log, sample.file, offset, kept, size == self._size)
        )
        if len(self._rows) == PATIENCE:
            self._check_size(1)  # a camera may start with another size

    def stamps(self) -> tuple[list[int], list[int], list[int]]:
        """List the stamps of all images, when they were logged, and the numbers of their logs."""
        stamp, logged, log = ([row[k] for row in self._rows] for k in range(3))
        return stamp, logged, log  # type: ignore[return-value]

    def move(self, shift_ns: Ints) -> None:
        """Add shifts (n,) to the stamps of the images, in the order in which they came."""
        self._rows = [
            (row[0] + int(more), *row[1:]) for row, more in zip(self._rows, shift_ns, strict=True)
        ]

    @property
    def is_still(self) -> bool:
        """Whether all images are one picture, by their bytes."""
        return len(self._again) >= LEAST_STILL and all(self._again[1:])

    def finish(self, notes: list[Finding], *, is_dive_still: bool = False) -> ImageIndex | None:
        """Index the images in order of time, with whether each can be used. None without any.

        Copies and images with the stamp of another one are left out. Raises InputError where none
        can be read, where most have another size than the calibration's, or where all are one
        picture in a dive without another one.

        notes: findings of what was assumed or left out are added. is_dive_still: no camera moves.
        """
        if not self._rows:
            return None
        self._check_size(-(-sum(self._sizes.values()) // 2))
        if is_dive_still:
            self._refuse_still()
        if not any(row[-1] for row in self._rows):
            count = len(self._rows)
            first = printable(self._rows[0][3])
            what = f"none of the {count} images of {self._camera} can be read"
            what += f" (the first is {first})" if first else ""
            if count == 1:
                what = f"the only image of {self._camera} cannot be read"
            raise InputError(
                what,
                remedy="see that they are there and whole, in a form that docs/dive_package.md "
                "names (JPEG, PNG, TIFF of 8 or 16 bits, ...)",
            )
        usable = [row[-1] for row in self._rows]
        listed = self._without_copies(notes)
        stamp, logged, log, file, offset, size, is_usable = (
            list(column) for column in zip(*listed, strict=True)
        )
        line = put_in_order(self._camera, stamp, logged, log)
        bits = significant_bits(self._largest)
        notes += line.notes + self._describe(usable, bits)
        rows = line.keep
        files = np.array(file, np.str_)[rows]
        self._refuse_order_of_text(files.tolist())
        return ImageIndex(
            t_ns=line.t_ns,
            file=files,
            offset=np.array(offset, np.int64)[rows],
            size=np.array(size, np.int64)[rows],
            usable=np.array(is_usable, bool)[rows],
            bits=np.array(bits),
        )

    def _without_copies(
        self, notes: list[Finding]
    ) -> list[tuple[int, int, int, str, int, int, bool]]:
        """List the images without those whose bytes repeat the one before, or a table holds twice.

        No camera sees the same to the last byte twice: a driver published the image again, or the
        camera had stopped. Of a vehicle at rest they tell nothing new.
        """
        rows, repeated = self._rows, sum(self._again)
        if repeated:
            counts = {"repeated": repeated, "count": len(rows)}
            notes.append(Finding("images-repeated", counts, self._camera))
            rows = [row for row, is_old in zip(rows, self._again, strict=True) if not is_old]
        listed = list(dict.fromkeys(rows))
        if len(listed) < len(rows):
            copies = {"copies": len(rows) - len(listed), "count": len(rows)}
            notes.append(Finding("readings-twice", copies, self._camera))
        return listed

    def _bytes(self, sample: ImageSample) -> bytes:
        """Read the bytes of an image. Empty where its file cannot be read."""
        if not sample.file:
            return sample.encoded
        try:
            return read_regular(self._package / sample.file, LARGEST_BYTES)
        except (OSError, ValueError):
            return b""  # counted among those that do not decode

    def _keep(self, encoded: bytes) -> int:
        """Append an image to the file of kept bytes. Returns the byte at which it begins."""
        if self._file is None:
            self._file = self._open_file()
        self._file.write(encoded)
        self._at += len(encoded)
        return self._at - len(encoded)

    def _check_size(self, least: int) -> None:
        """Raise InputError where fewer than `least` images have the calibration's size.

        Images that cannot be read do not count: nothing is raised where none can.
        """
        right, readable = self._sizes[self._size], sum(self._sizes.values())
        if right >= least or not readable:
            return
        logged, count = self._sizes.most_common(1)[0]
        turn = f" as stored, to be shown {self._turn}" if self._turn else ""
        images = f"{count} of {readable} images" if right else "the images"
        raise InputError(
            f"{images} of {self._camera} have {logged[0]} x {logged[1]} pixels{turn}, its "
            f"calibration is for {self._size[0]} x {self._size[1]}",
            remedy="give the calibration of this camera at this size",
        )

    def _refuse_still(self) -> None:
        """Raise InputError for images that are all one picture.

        Without another camera that moves no two images are left that could be matched.
        """
        raise InputError(
            f"all {len(self._again)} images of {self._camera} are one picture to the last byte: "
            "the camera or its driver stood still",
            remedy=WITHOUT_CAMERAS,
        )

    def _refuse_order_of_text(self, files: Sequence[str]) -> None:
        """Raise InputError for stamps that were given to files in the order of their names as text.

        files: names of the images in order of time, "" for those of a log.
        """
        exchanged = out_of_numbers(files)
        if exchanged is not None:
            before, after = (printable(name) for name in exchanged)
            raise InputError(
                f"the stamps of {self._camera} follow its files in the order of their names as "
                f"text, {after} after {before}, and not in that of their numbers",
                where=f"{self._camera}.csv",
                remedy="list the files in the order of their numbers, as `sort -V` does, and give "
                "each the stamp of its exposure",
            )

    def _describe(self, usable: list[bool], bits: int) -> list[Finding]:
        """Describe images that are left out, and how 16-bit images are read.

        usable: of each image. bits: significant bits of the samples.
        """
        count, others = len(usable), sum(self._sizes.values()) - self._sizes[self._size]
        bad = usable.count(False) - others
        out = []
        if self._turn:
            out.append(Finding("pictures-turned", {"turn": self._turn}, self._camera))
        if bad:
            out.append(Finding("images-bad", {"bad": bad, "count": count}, self._camera))
        if others:
            values = {"others": others, "count": count}
            out.append(Finding("images-other-size", values, self._camera))
        if self._mosaics:
            values = {"mosaics": self._mosaics, "count": count}
            out.append(Finding("images-mosaic", values, self._camera))
        if self._largest is not None:
            deep = {"largest": self._largest, "bits": bits}
            out.append(Finding("images-deep", deep, self._camera))
        return out


def out_of_numbers(files: Sequence[str]) -> tuple[str, str] | None:
    """Find two neighbouring files that are in the order of text, against that of their numbers.

    None where the names are not all in the order of text, or the numbers in them ascend, as whole
    ones or with their decimals, as in names that are stamps. files: names in order of time.
    """
    if len(files) < LEAST_NAMES or any(a >= b for a, b in pairwise(files)):
        return None
    exchanged: list[tuple[str, str]] = []
    for form in (WHOLE, DECIMAL):
        keys = [_numbers(name, form) for name in files]
        # text is compared by the order of text alone, which all names have
        falls = [
            (before, after)
            for (a, before), (b, after) in pairwise(zip(keys, files, strict=True))
            if a[0] == b[0] and a[1] > b[1]
        ]
        if not falls:
            return None
        exchanged = exchanged or falls
    return exchanged[0]


def _numbers(name: str, form: re.Pattern[str]) -> tuple[list[str], list[float]]:
    """Split a name into what stands around its numbers, and these."""
    return form.split(name), [float(number) for number in form.findall(name)]


class SampledImages(BytesIO):
    """Keeps some images in memory by their offset, in runs of RUN spread over the dive.

    It stands in for the file of an ImageSink.
    """

    def __init__(self) -> None:
        super().__init__()
        self._kept: dict[int, tuple[int, bytes]] = {}  # number and bytes, by offset
        # images and bytes written so far, and which runs are kept: every _stride-th
        self._count, self._at, self._stride = 0, 0, 1

    def write(self, data: object, /) -> int:
        """Keep every `_stride`-th run of images, and drop the others.

        The stride doubles whenever more than MOST images are kept. Returns the number of bytes, as
        a file does.
        """
        assert isinstance(data, bytes)
        if (self._count // RUN) % self._stride == 0:
            self._kept[self._at] = (self._count, data)
        if len(self._kept) > MOST:
            self._stride *= 2
            self._kept = {
                at: kept for at, kept in self._kept.items() if (kept[0] // RUN) % self._stride == 0
            }
        self._count += 1
        self._at += len(data)
        return len(data)

    def image_at(self, offset: int) -> bytes | None:
        """Look up the image that was written at an offset. None where it was not kept."""
        kept = self._kept.get(offset)
        return None if kept is None else kept[1]
