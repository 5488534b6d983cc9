# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Targets on the sea floor, in side-scan sonar and in images [Aulinas2011 4.3, 4.4]."""
