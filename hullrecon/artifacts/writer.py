# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write the files of one artifact into a folder under construction."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path, PurePosixPath
from typing import BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.disk import (
    complete_file,
    complete_path,
    make_folder,
    storage_errors,
)
from hullrecon.artifacts.documents import encode
from hullrecon.artifacts.manifest import FILE_NAME

_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # a fixed date, the earliest of a zip: equal runs, equal bytes
_UNIX = 3  # system in a zip member's header


def write_blocks(
    path: Path,
    dtype: np.dtype[np.generic],
    shape: tuple[int, ...],
    blocks: Iterable[NDArray[np.generic]],
) -> None:
    """Write a .npy block by block, for an array that need not fit into memory.

    shape: of the whole array, whose rows the blocks are in order.
    """
    layout = np.lib.format.dtype_to_descr(dtype)
    with path.open("wb") as file:
        header = {"descr": layout, "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(file, header)
        for block in blocks:
            file.write(np.ascontiguousarray(block).data)


class ArtifactWriter:
    """Writes the files of one artifact. Nothing else opens a file for writing in RUNS.

    Each is there whole or not at all. They are on the disk once the artifact is committed.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def arrays(self, name: str, arrays: Mapping[str, NDArray[np.generic]]) -> None:
        """Write an uncompressed .npz: the same bytes for the same arrays, whatever their order.

        Raises ValueError for arrays of objects.
        """
        with (
            complete_file(self._place(name)) as file,
            zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive,
        ):
            for member_name, array in sorted(arrays.items()):
                member = zipfile.ZipInfo(f"{member_name}.npy", _ZIP_EPOCH)
                member.create_system = _UNIX
                member.external_attr = 0o644 << 16
                with archive.open(member, "w", force_zip64=True) as stream:
                    np.lib.format.write_array(
                        cast(BinaryIO, stream), np.asarray(array, order="C"), allow_pickle=False
                    )

    def json(self, name: str, value: object) -> None:
        """Write indented JSON with sorted keys. Raises ValueError for a NaN."""
        try:
            data = encode(value)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error
        self.bytes(name, data)

    def text(self, name: str, value: str) -> None:
        self.bytes(name, value.encode())

    def bytes(self, name: str, value: bytes) -> None:
        with complete_file(self._place(name)) as file:
            file.write(value)

    def path(self, name: str) -> AbstractContextManager[Path]:
        """Yield a temporary path for a library to write to, renamed at the end of the `with`."""
        return complete_path(self._place(name))

    @contextmanager
    def scratch(self) -> Iterator[BinaryIO]:
        """Yield an empty temporary file, which is gone at the end of the `with`."""
        with storage_errors(self._folder):
            make_folder(self._folder)
            with tempfile.TemporaryFile(dir=self._folder) as file:
                yield cast(BinaryIO, file)

    def _place(self, name: str) -> Path:
        """Locate a file of the artifact. Raises ValueError for a name that leads out of it."""
        parts = PurePosixPath(name).parts
        if not parts or parts[0] == "/" or ".." in parts or name == FILE_NAME:
            raise ValueError(f"{name!r} is no name for a file of an artifact")
        return self._folder.joinpath(*parts)
