# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stop at the first unusable part of a package, as a run does, or list all of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding


class Problems:
    """Raise the first InputError, or collect all of them for `check`."""

    def __init__(self, *, go_on: bool = False) -> None:
        self._go_on = go_on  # collect, as `check` does, instead of raising
        self.found: list[Finding] = []  # what could not be used, in the order of reading

    def refuse(self, finding: Finding) -> None:
        """Collect a finding that no run could go on with, or raise it as InputError."""
        if not self._go_on:
            raise InputError(finding.sentence)
        self.found.append(finding)

    @contextmanager
    def collect(self) -> Iterator[None]:
        """Catch an InputError of the block and collect it, or let it pass."""
        try:
            yield
        except InputError as error:
            if not self._go_on:
                raise
            values = {"what": error.what, "where": error.where, "remedy": error.remedy}
            finding = Finding("unusable", values)
            if finding not in self.found:
                self.found.append(finding)
