# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A whole package looked over in words, without keeping anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any, BinaryIO

import msgspec

from hullrecon.dive.check.consistency_checks import first_difference, suspicions
from hullrecon.dive.check.to_fill_in import to_fill_in
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.ingest import Ingested, Request, ingest
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.read_streams import Watch
from hullrecon.dive.logs.summary import missing
from hullrecon.dive.logs.timeline import rate_hz


class _Nowhere(BytesIO):
    """A file that keeps nothing."""

    def write(self, data: Any, /) -> int:
        return len(data)


def _nowhere(camera: str) -> BinaryIO:
    return _Nowhere()


@dataclass(frozen=True)
class Check:
    """What `check` says about a package."""

    name: str
    vessel: str
    found: Ingested
    missing: list[str]
    to_fill_in: list[str]
    suspicious: list[str]
    defaults: dict[str, Any]

    def lines(self) -> list[str]:
        told = self.found.findings()
        defaults = ", ".join(f"{key} = {_toml(value)}" for key, value in sorted(self.defaults.items()))
        return [
            f"{self.name}: {self.vessel}" if self.vessel else self.name,
            *told["spans"], *first_difference(self.found.records, self.found.images), *told["hull"],
            *(f"lost: {line}" for line in told["lost"]), *(f"note: {line}" for line in told["remarks"]), *self.missing,
            *self.to_fill_in,
            *(f"suspicious: {line}" for line in self.suspicious), f"defaults used: {defaults}",
        ]  # fmt: skip

    def document(self) -> dict[str, Any]:
        streams = {
            name: {
                "count": len(s.t_ns),
                "start_ns": int(s.t_ns[0]),
                "end_ns": int(s.t_ns[-1]),
                "rate_hz": round(rate_hz(s.t_ns), 3),
            }
            for name, s in {**self.found.records, **self.found.images}.items()
            if s is not None and len(s.t_ns)
        }
        return {
            "name": self.name, "vessel": self.vessel, "streams": streams, **self.found.findings(), "missing": self.missing,
            "to_fill_in": self.to_fill_in,
            "suspicious": self.suspicious, "topics": self.found.counts,
            "offset": first_difference(self.found.records, self.found.images), "defaults": self.defaults,
        }  # fmt: skip


def check_package(loaded: LoadedConfig, request: Request, watch: Watch = iter) -> Check:
    """Reads the whole package. Raises InputError for what cannot be used."""
    found = ingest(loaded.package, request, _nowhere, watch)
    held = {name: record for name, record in {**found.records, **found.images}.items() if record is not None}
    present = {"joints" if name == "tray" else name for name, record in held.items() if len(record.t_ns)}
    named = {sensor for sensor, topic in request.topics.items() if topic in found.counts}
    logged = named | (TYPES.keys() & found.counts.keys())
    return Check(
        loaded.config.dive.name,
        loaded.config.dive.vessel,
        found,
        missing(present, hull=found.hull is not None),
        to_fill_in(loaded, logged),
        suspicions(loaded.config, found.records, found.images),
        defaults_of(loaded),
    )


def defaults_of(loaded: LoadedConfig) -> dict[str, Any]:
    """The keys of the vehicle's sections that dive.toml leaves to their defaults, where these are values."""
    vehicle = ("tray", "imu", "pressure", "dvl", "camera.top", "camera.bottom", "sonar", "hull")
    sections: Mapping[str, Any] = {name: loaded.sections[name] for name in vehicle}
    return {
        f"{name}.{key}": value
        for name, section in sections.items()
        if section is not None
        for key, value in msgspec.to_builtins(section).items()
        if value is not None and f"{name}.{key}" not in loaded.given
    }


def _toml(value: Any) -> str:
    return (
        f"[{', '.join(map(_toml, value))}]"
        if isinstance(value, list | tuple)
        else f'"{value}"'
        if isinstance(value, str)
        else f"{value:g}"
    )
