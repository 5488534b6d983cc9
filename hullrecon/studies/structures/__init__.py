# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Structures on the hull as [Ozog2016 ch. 4] finds them: step by step, by threshold, by stereo."""
