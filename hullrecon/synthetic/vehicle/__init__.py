# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated vehicle: how it carries its sensors and the path that it takes."""
