# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Underwater hull inspection: from a vehicle's logs and the ship's CAD model to the hull as found."""

__version__ = "0.1.0"
