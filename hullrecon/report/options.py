# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the report."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from hullrecon.dive.config.config_errors import ONE_LINE
from hullrecon.dive.config.schema import FileName, Section

Line = Annotated[str, Meta(pattern=ONE_LINE, max_length=200)]
LongText = Annotated[str, Meta(max_length=4000)]


class ReportOptions(Section, frozen=True):
    """What the page says of the inspection; what is empty is not shown."""

    client: Annotated[Line | None, Meta(description="who asked for the inspection")] = None
    operator: Annotated[Line | None, Meta(description="who inspected")] = None
    vessel_operator: Annotated[Line | None, Meta(description="who runs the ship")] = None
    equipment: Annotated[
        tuple[Line, ...],
        Meta(max_length=20, description="vehicle, cameras, sonar, lights: a text each"),
    ] = ()
    water: Annotated[Line | None, Meta(description="place, visibility, temperature, current")] = (
        None
    )
    conclusion: Annotated[
        LongText | None,
        Meta(description="the inspector's own words; a blank line parts paragraphs"),
    ] = None
    logo: Annotated[
        FileName | None, Meta(description="PNG, JPEG or WebP, relative to dive.toml")
    ] = None

    def rows(self) -> list[tuple[str, str]]:
        """List the heading and text of each block that dive.toml fills in."""
        rows = [
            ("Client", self.client),
            ("Inspected by", self.operator),
            ("Operator of the vessel", self.vessel_operator),
            ("Equipment", "; ".join(self.equipment)),
            ("Water", self.water),
        ]
        return [(name, text.strip()) for name, text in rows if text and text.strip()]

    def paragraphs(self) -> list[str]:
        """Split the conclusion into paragraphs at its blank lines."""
        parts = (self.conclusion or "").replace("\r\n", "\n").split("\n\n")
        return [" ".join(part.split()) for part in parts if part.strip()]
