# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What was found about a dive, as data: a code and its values.

A Finding is made wherever the code detects something. Its sentence for the user is written once, in
the tables of this package (one module for each subject), for `check`, the log and the report alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from hullrecon.findings import adjustment, logs, package, sensors
from hullrecon.findings.logs import Words

# error: no run is possible; warning: a run goes on, and its result may be wrong;
# note: what was read, assumed, repaired or lost
Severity = Literal["error", "warning", "note"]
TABLES: tuple[tuple[Severity, Mapping[str, Words]], ...] = (
    ("error", package.ERRORS),
    ("error", adjustment.ERRORS),
    ("error", sensors.ERRORS),
    ("warning", package.WARNINGS),
    ("warning", adjustment.WARNINGS),
    ("warning", sensors.WARNINGS),
    ("note", package.NOTES),
    ("note", logs.NOTES),
)
SEVERITY: Mapping[str, Severity] = {code: level for level, table in TABLES for code in table}
WORDS: Mapping[str, Words] = {code: words for _, table in TABLES for code, words in table.items()}


@dataclass(frozen=True)
class Finding:
    """One finding. Raises KeyError for a code without words."""

    code: str  # a key of WORDS, such as "clocks-apart"
    # by the names that the words use: numbers, texts and lists of these, as JSON takes them
    values: Mapping[str, object] = field(default_factory=dict)
    where: str = ""  # the stream, topic or file that it is about; the sentence begins with it

    def __post_init__(self) -> None:
        if self.code not in WORDS:
            raise KeyError(f"the finding {self.code} has no words")

    @property
    def severity(self) -> Severity:
        return SEVERITY[self.code]

    @property
    def sentence(self) -> str:
        """The finding in words, for the user."""
        words = WORDS[self.code]
        text = words.format(**self.values) if isinstance(words, str) else words(**self.values)
        return f"{self.where}: {text}" if self.where else text

    def inside(self, place: str) -> Finding:
        """Return the finding as one of a larger place, such as the file of a folder."""
        return replace(self, where=f"{place}: {self.where}" if self.where else place)

    def document(self) -> dict[str, object]:
        """Return the finding as `--json` prints it."""
        return {
            "code": self.code,
            "severity": self.severity,
            "where": self.where,
            "values": dict(self.values),
            "sentence": self.sentence,
        }


def sentences(findings: Iterable[Finding]) -> list[str]:
    """Word findings for the user, one sentence each."""
    return [finding.sentence for finding in findings]
