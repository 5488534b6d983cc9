# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated hull: its shape, how it was built, what stands and grows on it, and its colour."""
