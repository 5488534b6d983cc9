# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces as the sources make them: kernels, references, interpolation, fusion by rays."""
