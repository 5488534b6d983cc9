# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces as the sources make them: other kernels, references and interpolation, fusion by rays."""
