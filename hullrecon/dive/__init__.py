# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive package: dive.toml, logs, plain files and calibrations, read into records."""
