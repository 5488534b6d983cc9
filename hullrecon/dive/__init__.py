# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive package: dive.toml, logs, plain files, calibration, and the reading of them into records."""
