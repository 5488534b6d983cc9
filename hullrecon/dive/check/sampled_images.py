# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Some of a camera's images, kept in memory while a log streams by: runs of neighbours spread over
the dive.
"""

from __future__ import annotations

from io import BytesIO

RUN = 8  # neighbouring images that are kept together, so that both cameras keep the same ones
MOST = 128  # images: some tens of megabytes


class SampledImages(BytesIO):
    """A file that keeps whole writes by their offset, runs of RUN, fewer of them the more there
    are.
    """

    def __init__(self) -> None:
        super().__init__()
        self._kept: dict[int, tuple[int, bytes]] = {}
        self._count, self._at, self._stride = 0, 0, 1

    def write(self, data: object, /) -> int:
        """Keep one image, or let it go."""
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
        """Return the image that was written at that offset; None where it was let go."""
        kept = self._kept.get(offset)
        return None if kept is None else kept[1]
