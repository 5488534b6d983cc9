# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as a surveyor writes them: with unit and sigma, and no digits beyond the sigma's."""

from __future__ import annotations

import math
from collections.abc import Sequence


def decimals(sigma: float) -> int:
    """Choose the number of decimals for a value with that sigma.

    The sigma gets one significant digit, two if it begins with a 1.
    """
    if not math.isfinite(sigma) or sigma <= 0:
        return 3
    power = math.floor(math.log10(sigma))
    return max(0, -power + (sigma / 10.0**power < 1.95))


def with_minus(numbers: str) -> str:
    """Replace the hyphens of numbers by minus signs."""
    return numbers.replace("-", "−")


def with_sigma(value: float, sigma: float | None, unit: str) -> str:
    """Write a value as 0.112 ± 0.004 m, alone if it has no sigma, as a dash if it is not finite."""
    if not math.isfinite(value):
        return "–"
    if sigma is None or not math.isfinite(sigma):
        return f"{with_minus(f'{value:.3f}')} {unit}"
    shown = min(4, decimals(sigma))
    return f"{with_minus(f'{value:.{shown}f}')} ± {sigma:.{shown}f} {unit}"


def area_words(area_m2: float, sigma_m2: float | None = None) -> str:
    """Write an area as 5.9 ± 0.2 m², alone if it has no sigma."""
    known = "" if sigma_m2 is None else f" ± {max(sigma_m2, 0.1):.1f}"
    return f"{area_m2:.1f}{known} m²"


def error_with_sigma(error: float, sigma: float, unit: str) -> str:
    """Write an error with its sign, such as −0.12 ± 0.03°. `unit` includes the space before it.

    A sigma of zero counts as unknown and is not written.
    """
    shown = min(4, decimals(sigma)) if sigma > 0 else 2
    known = f" ± {sigma:.{shown}f}" if sigma > 0 else ""
    return f"{with_minus(f'{error:+.{shown}f}')}{known}{unit}"


def length(metres: float) -> str:
    """Write a length, given in metres, in the unit that reads best."""
    if not math.isfinite(metres):
        return "–"
    if abs(metres) < 0.0995:
        return f"{1000 * metres:.1f} mm" if abs(metres) < 0.00995 else f"{1000 * metres:.0f} mm"
    return f"{metres:.2f} m" if abs(metres) < 100 else f"{metres:,.0f} m"


def lengths(metres: Sequence[float]) -> str:
    """Write several lengths in one unit: 0.350 / 0.041 / 0.098 m, in mm if all are below 0.1 m."""
    finite = [abs(m) for m in metres if math.isfinite(m)]
    factor, digits, unit = 1, 3 if finite and min(finite) < 0.0995 else 2, "m"
    if finite and max(finite) < 0.0995:
        factor, digits, unit = 1000, 1 if min(finite) < 0.00995 else 0, "mm"
    texts = (f"{factor * m:.{digits}f}" if math.isfinite(m) else "–" for m in metres)
    return f"{' / '.join(texts)} {unit}"


def signed_range(low: float, high: float, decimals: int = 0) -> str:
    """Write two signed numbers: −10 to +16."""
    return with_minus(f"{low:+.{decimals}f} to {high:+.{decimals}f}")


def duration(seconds: float) -> str:
    """Write a time, given in seconds, as 117 s, 12 min 05 s, 3 h 02 min."""
    whole = round(seconds)
    if whole < 180:
        return f"{whole} s"
    if whole < 7200:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def probability(p: float | None) -> str:
    """Write a probability, a very small one as a bound: no tail is known to thirty digits."""
    if p is None or not math.isfinite(p):
        return "–"
    return "< 0.0001" if p < 1e-4 else f"{p:.4f}"


def count(number: int, one: str, many: str = "") -> str:
    """Write a number of things: 1 object, 1,024 objects."""
    return f"{number:,} {one if number == 1 else many or one + 's'}"


def join(parts: Sequence[str]) -> str:
    """Write a list: a, b and c."""
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))
