# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The errors that a user can act on: what is wrong, where, what to do, and an exit code."""

from __future__ import annotations


class HullreconError(Exception):
    """An error that a user can act on. Printed as one line: `what (where): remedy`."""

    exit_code = 1

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what, self.where, self.remedy = what, where, remedy
        super().__init__(self.line())

    def line(self) -> str:
        place = f" ({self.where})" if self.where else ""
        advice = f": {self.remedy}" if self.remedy else ""
        return f"{self.what}{place}{advice}"


class UsageError(HullreconError):
    """Wrong arguments or configuration."""

    exit_code = 2


class InputError(HullreconError):
    """The input cannot be used: missing, corrupt or contradictory."""

    exit_code = 3


class ContradictionError(InputError):
    """Measurements contradict each other by more than a correction may take out."""


class StageError(HullreconError):
    """A step could not reach a result: too few matches, no convergence."""

    exit_code = 4


class LockedError(HullreconError):
    """Another run holds the workspace."""

    exit_code = 5


class StorageError(HullreconError):
    """No space or no permission."""

    exit_code = 6
