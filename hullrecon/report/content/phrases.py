# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as a surveyor writes them: unit and sigma beside each, no more digits than the sigma deserves."""

from __future__ import annotations

import math
from collections.abc import Sequence


def decimals(sigma: float) -> int:
    """Digits after the point so that a sigma keeps one significant one, two when it begins with a 1."""
    if not math.isfinite(sigma) or sigma <= 0:
        return 3
    power = math.floor(math.log10(sigma))
    return max(0, -power + (sigma / 10.0**power < 1.95))


def with_sigma(value: float, sigma: float | None, unit: str) -> str:
    """0.112 ± 0.004 m. Without a sigma the value alone; a lost value is a dash."""
    if not math.isfinite(value):
        return "–"
    if sigma is None or not math.isfinite(sigma):
        return f"{value:.3f} {unit}"
    shown = min(4, decimals(sigma))
    return f"{value:.{shown}f} ± {sigma:.{shown}f} {unit}"


def length(metres: float) -> str:
    """A length in the unit that reads best."""
    if not math.isfinite(metres):
        return "–"
    if abs(metres) < 0.0995:
        return f"{1000 * metres:.1f} mm" if abs(metres) < 0.00995 else f"{1000 * metres:.0f} mm"
    return f"{metres:.2f} m" if abs(metres) < 100 else f"{metres:,.0f} m"


def duration(seconds: float) -> str:
    """117 s, 12 min 5 s, 3 h 02 min."""
    whole = round(seconds)
    if whole < 180:
        return f"{whole} s"
    if whole < 7200:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def probability(p: float | None) -> str:
    """A p-value; very small ones as a bound, since a tail is not known to thirty digits."""
    if p is None or not math.isfinite(p):
        return "–"
    return "< 0.0001" if p < 1e-4 else f"{p:.4f}"


def count(number: int, one: str, many: str = "") -> str:
    """1 object, 1,024 objects."""
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def join(parts: Sequence[str]) -> str:
    """a, b and c."""
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1] if parts else ""
