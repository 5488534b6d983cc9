# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What was lost, rejected or not delivered, and every resolved option."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from hullrecon.records.clock import NS, format_time
from hullrecon.records.deliverables import RejectedRegion
from hullrecon.report.content.phrases import count, with_sigma
from hullrecon.report.survey import AdjustSummary, Interval, NavigationFacts, StepRun, Survey


def rejected_groups(survey: Survey) -> list[tuple[str, list[str]]]:
    """List what was lost, rejected or not delivered, by heading. Empty groups are left out."""
    facts = survey.facts
    failed = sorted(facts.pairs.failed.items())
    pairs = [f"{reason}: {count(number, 'pair')}" for reason, number in failed]
    navigation = facts.navigation
    outages = [f"no DVL {_between(navigation, interval)}" for interval in navigation.outages_s]
    gaps = [
        f"no attitude {_between(navigation, interval)}" for interval in navigation.attitude_gaps_s
    ]
    groups = [
        (
            "Deliverables that this dive cannot give",
            [f"{name}: {why}" for name, why in survey.provenance.missing.items()],
        ),
        ("Lost data", list(facts.log.lost)),
        ("CAD model, as checked", list(facts.log.hull)),
        ("Navigation", [*outages, *gaps, *navigation.remarks]),
        ("Image pairs without a relative pose", pairs),
        (
            "Observations",
            _observations(survey.adjusted.summary) if survey.adjusted is not None else [],
        ),
        (
            "Regions examined and not reported as objects",
            [_region(r) for r in survey.findings.not_reported],
        ),
        ("Warnings of the steps", survey.provenance.warnings()),
        ("Remarks on the log", list(facts.log.notes)),
    ]
    return [(heading, items) for heading, items in groups if items]


def _between(navigation: NavigationFacts, interval_s: Interval) -> str:
    """Write the times of day at which an interval of navigation.json begins and ends."""
    first, last = (format_time(navigation.start_ns + round(NS * t_s)) for t_s in interval_s)
    return f"from {first} to {last}"


def _observations(summary: AdjustSummary) -> list[str]:
    """Say how many observations of landmarks in images were rejected. Empty for none."""
    out, used = summary.observations_left_out, summary.observations
    if not used or not out:
        return []
    return [f"{out:,} of {used + out:,} image observations rejected as outliers"]


def _region(region: RejectedRegion) -> str:
    height = with_sigma(region.height, region.height_sigma, "m")
    return f"{region.reason} (height {height}, {region.address or 'at a point without an address'})"


def settings_rows(steps: Iterable[StepRun]) -> list[tuple[str, str]]:
    """List every resolved option once, as section.key and value."""
    rows: dict[str, str] = {}
    for step in steps:
        for section, values in step.settings.items():
            if isinstance(values, Mapping):
                rows.update({f"{section}.{key}": _value(value) for key, value in _flatten(values)})
    return sorted(rows.items())


def _flatten(values: Mapping[str, object], above: str = "") -> list[tuple[str, object]]:
    """List the values of nested tables by dotted names, which begin with `above`."""
    out: list[tuple[str, object]] = []
    for key, value in values.items():
        if isinstance(value, Mapping):
            out += _flatten(value, f"{above}{key}.")
        else:
            out.append((above + key, value))
    return out


def _value(value: object) -> str:
    """Write a value, or a list or table of values, in plain words."""
    if isinstance(value, Mapping):
        return " ".join(f"{key} {_value(member)}" for key, member in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(_value, value))
    return "not set" if value is None else str(value)
