# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run all dives of a folder that are new or out of date. A failure stays with its dive."""

from hullrecon.api.fleet.fleet import preview_fleet, run_fleet
from hullrecon.api.fleet.outcome import FleetDive, FleetResult

__all__ = ["FleetDive", "FleetResult", "preview_fleet", "run_fleet"]
