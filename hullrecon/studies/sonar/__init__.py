# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What an imaging sonar measures, beside what it shows [Ozog2016 5.2]."""
