# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The options of the step as the native module takes them."""

from __future__ import annotations

from hullrecon import native
from hullrecon.adjustment.options import AdjustOptions


def native_settings(options: AdjustOptions) -> native.Options:
    """Return the method, the sigmas of its labels and the threads; all else as by default."""
    return native.Options(
        method=options.method,
        sigma_on=options.on_hull_sigma_m,
        sigma_off=options.off_hull_sigma_m,
        threads=options.threads,
    )
