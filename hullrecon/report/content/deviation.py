# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The deviation from the CAD model in numbers and words: its form, and the patch's offset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.report.content.phrases import signed_range, with_minus
from hullrecon.report.survey import Survey
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class DeviationFigures:
    """The deviation of the surveyed patch."""

    offset: float  # m, mean distance of the patch from the CAD model, outward positive
    offset_sigma: float
    tilt: Array  # (2,) m/m along and in girth
    tilt_sigma: Array
    # (3,) m, 5th, 50th and 95th percentile over the seen area of the deviation without offset and
    # tilt
    form: Array
    form_sigma: float  # m, median of the seen area

    @property
    def offset_words(self) -> str:
        """The offset in words, with its sigma and whether it is significant."""
        size, sigma = 1000 * abs(self.offset), 1000 * self.offset_sigma
        side = "outside" if self.offset > 0 else "inside"
        known = "" if size > 2 * sigma else ", not significantly different from zero"
        side = "from" if round(size) == 0 else side
        return f"{size:.0f} mm {side} it (one sigma {sigma:.0f} mm{known})"

    @property
    def form_words(self) -> str:
        """The form's percentiles in words, with its sigma."""
        low, _, high = 1000 * self.form
        sigma = f"one sigma {1000 * self.form_sigma:.1f} mm"
        return f"{signed_range(low, high)} mm (5th to 95th percentile; {sigma})"


def weighted_percentiles(values: Array, weights: Array, percent: tuple[float, ...]) -> Array:
    """Interpolate percentiles of weighted values (n,) linearly in cumulated weight."""
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order]) - 0.5 * weights[order]
    return np.asarray(np.interp(np.array(percent) / 100 * weights.sum(), share, values[order]))


def deviation_figures(survey: Survey) -> DeviationFigures | None:
    """Summarise the deviation over the seen area. None without a CAD model or a hull as found."""
    found, split = survey.surfaces.as_found, survey.surfaces.deviation
    if found is None or split is None or not survey.is_in_hull_frame:
        return None
    seen = np.isfinite(split.form)
    weight = vertex_areas(found.mesh())[seen]
    if not weight.sum() > 0:
        return None
    return DeviationFigures(
        offset=float(split.offset),
        offset_sigma=float(split.offset_sigma),
        tilt=split.tilt,
        tilt_sigma=split.tilt_sigma,
        form=weighted_percentiles(split.form[seen], weight, (5, 50, 95)),
        form_sigma=float(weighted_percentiles(split.form_sigma[seen], weight, (50,))[0]),
    )


def deviation_document(figures: DeviationFigures | None) -> dict[str, object] | None:
    """Build the member `deviation` of summary.json. None without figures."""
    if figures is None:
        return None
    low, middle, high = (round(float(v), 5) for v in figures.form)
    return {
        "offset_m": round(figures.offset, 5),
        "offset_sigma_m": round(figures.offset_sigma, 5),
        "tilt": [round(float(v), 6) for v in figures.tilt],
        "tilt_sigma": [round(float(v), 6) for v in figures.tilt_sigma],
        "form_m": {"p05": low, "p50": middle, "p95": high},
        "form_sigma_m": round(figures.form_sigma, 5),
    }


def deviation_rows(figures: DeviationFigures | None) -> list[tuple[str, str]]:
    """Tabulate form, offset and tilt for the page's chapter. Empty without figures."""
    if figures is None:
        return []
    slopes = " / ".join(
        with_minus(f"{1000 * t:+.1f} ± {1000 * s:.1f}")
        for t, s in zip(figures.tilt, figures.tilt_sigma, strict=True)
    )
    return [
        ("Form", figures.form_words),
        (
            "Offset of the surveyed patch",
            with_minus(f"{1000 * figures.offset:+.0f} ± {1000 * figures.offset_sigma:.0f} mm"),
        ),
        ("Tilt of the surveyed patch, along / in girth", f"{slopes} mm per m"),
    ]
