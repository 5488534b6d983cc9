# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write all deliverables of a survey. A failed deliverable does not stop the others."""

from __future__ import annotations

import traceback
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from hullrecon.errors import HullreconError
from hullrecon.report.deliverables import DELIVERABLES, Deliverable, Delivery
from hullrecon.report.export.summary import summary_document
from hullrecon.report.stream import Stream, in_turn, one_by_one
from hullrecon.report.survey import Survey
from hullrecon.report.writer import FOLDER, DeliverableWriter, FileWriter


@dataclass(frozen=True, kw_only=True)
class DeliveryFailure:
    """A deliverable that could not be written because of a fault in hullrecon."""

    name: str
    reason: str  # type and message of the error, in a line
    traceback: str


def deliver(
    survey: Survey,
    out: FileWriter,
    only: Collection[str] | None = None,
    stream: Stream = one_by_one,
) -> list[DeliveryFailure]:
    """Write the deliverables of a survey, the report last, then summary.json, which lists them.

    Parameters
    ----------
    survey
        All that the steps found.
    out
        Writes the files of the artifact.
    only
        Names of the deliverables to write, all if None.
    stream
        Computes many results in order, as `Context.stream` does on several processes.

    Returns
    -------
    list of DeliveryFailure
        The deliverables that could not be written. All others are.

    Raises
    ------
    HullreconError, MemoryError, OSError
        Faults of the input, the memory or the disk: they concern all deliverables.
    """
    delivery = Delivery(survey, DeliverableWriter(out), in_turn(stream))

    wanted = [
        entry
        for entry in DELIVERABLES
        if entry.name not in survey.provenance.missing and (only is None or entry.name in only)
    ]
    own = [entry for entry in wanted if not entry.is_about_others]
    about_others = [entry for entry in wanted if entry.is_about_others]
    failures = [*_write_all(own, delivery), *_write_all(about_others, delivery)]
    document = summary_document(survey, delivery.out.entries, delivery.failed)
    out.json(f"{FOLDER}/summary.json", document)
    return failures


def _write_all(entries: Sequence[Deliverable], delivery: Delivery) -> Iterator[DeliveryFailure]:
    """Write deliverables, and yield those that could not be written, in their order.

    Those that wait for workers or the disk are written in threads beside the others.
    """
    with ThreadPoolExecutor() as beside:
        begun = {
            entry.name: beside.submit(_write, entry, delivery) for entry in entries if entry.waits
        }
        for entry in entries:
            failure = begun[entry.name].result() if entry.name in begun else _write(entry, delivery)
            if failure is not None:
                yield failure


def _write(entry: Deliverable, delivery: Delivery) -> DeliveryFailure | None:
    """Write a deliverable that the dive can give. Returns why it could not be written."""
    try:
        if not entry.why_absent(delivery.survey):
            entry.write(delivery)
    except Exception as error:
        if _concerns_all(error):
            raise
        failure = _failure(entry.name, error)
        delivery.failed[entry.name] = failure.reason
        return failure
    return None


def _concerns_all(error: Exception) -> bool:
    """Test whether an error concerns all deliverables: faults of the input, the memory or the disk.

    Libraries raise OSError without a number for faults of a single picture or raster.
    """
    if isinstance(error, OSError):
        return error.errno is not None
    return isinstance(error, HullreconError | MemoryError)


def _failure(name: str, error: Exception) -> DeliveryFailure:
    """Describe an error in one line of at most 200 characters, with its traceback."""
    reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
    trace = "".join(traceback.format_exception(error))
    return DeliveryFailure(name=name, reason=reason, traceback=trace)
