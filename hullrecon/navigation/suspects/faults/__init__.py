# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What may be wrong with a sensor, a module for each, and its records without the fault."""
