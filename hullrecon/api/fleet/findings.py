# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What stands out of one dive's result, read from its deliverables: the worst first."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

import msgspec

REFUSED = "the CAD model does not fit"
MIN_WEAK_M = 0.1  # a position that is known better does not stand out
_LARGEST_BYTES = 1 << 26
Kind = TypeVar("Kind", bound=msgspec.Struct)


class _Dive(msgspec.Struct, frozen=True):
    vessel: str | None = None
    date: str | None = None


class _Summary(msgspec.Struct, frozen=True):
    dive: _Dive = _Dive()
    absent: Mapping[str, str] = {}
    lost: tuple[str, ...] = ()


class _Object(msgspec.Struct, frozen=True):
    id: int
    height: float
    height_sigma: float | None = None
    address: str | None = None


class _Objects(msgspec.Struct, frozen=True):
    objects: tuple[_Object, ...] = ()


class _WeakDirection(msgspec.Struct, frozen=True):
    kind: str = ""
    sigma: float = 0.0
    sentence: str = ""


class _Alignment(msgspec.Struct, frozen=True):
    weak_directions: tuple[_WeakDirection, ...] = ()


class DiveFindings(msgspec.Struct, frozen=True, kw_only=True):
    """about: vessel and date; sentences: what stands out, the worst first; largest_m: of the
    largest object, 0 without.
    """

    about: str = ""
    sentences: tuple[str, ...] = ()
    largest_m: float = 0.0


def read_findings(deliver: Path) -> DiveFindings | None:
    """Return what stands out of a folder of deliverables; None where there is no summary that can
    be read.
    """
    summary = _read(deliver / "summary.json", _Summary)
    if summary is None:
        return None
    objects = _read(deliver / "objects.json", _Objects)
    alignment = _read(deliver / "alignment.json", _Alignment) or _Alignment()
    largest = (
        max(objects.objects, key=lambda found: abs(found.height), default=None)
        if objects is not None
        else None
    )
    sentences = []
    if summary.absent.get("alignment.json", "").startswith(REFUSED):
        sentences.append("The CAD model was refused: it does not fit the survey.")
    if largest is not None and objects is not None:
        sentences.append(_of_objects(len(objects.objects), largest))
    elif objects is not None:
        sentences.append("No object was found.")
    weak = [w for w in alignment.weak_directions if w.kind == "position" and w.sigma > MIN_WEAK_M]
    sentences += [w.sentence for w in sorted(weak, key=lambda w: -w.sigma)[:1]]
    if summary.lost:
        sentences.append(
            f"Data were lost: {summary.lost[0]}"
            + (f" and {len(summary.lost) - 1} more." if summary.lost[1:] else ".")
        )
    about = " · ".join(
        text for text in (summary.dive.vessel, (summary.dive.date or "")[:10]) if text
    )
    return DiveFindings(
        about=about,
        sentences=tuple(sentences),
        largest_m=0.0 if largest is None else abs(largest.height),
    )


def _of_objects(count: int, largest: _Object) -> str:
    sigma = "" if largest.height_sigma is None else f" ± {largest.height_sigma:.3f}"
    kind = "height" if largest.height >= 0 else "depth"
    where = f", {largest.address}" if largest.address else ""
    of = "One object" if count == 1 else f"{count} objects, the largest no. {largest.id}"
    return f"{of}: {kind} {abs(largest.height):.3f}{sigma} m{where}."


def _read(path: Path, kind: type[Kind]) -> Kind | None:
    """Return a document; None where there is none that can be read."""
    try:
        with path.open("rb") as file:
            return msgspec.json.decode(file.read(_LARGEST_BYTES), type=kind)
    except (OSError, msgspec.MsgspecError):
        return None
