# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read a dive package (dive.toml, logs, images, calibrations, CAD model) into records."""
