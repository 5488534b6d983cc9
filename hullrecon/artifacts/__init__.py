# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run a chain of steps: what is out of date, manifests, locks, workers. Knows nothing of hulls."""
