# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What two clocks make of one motion that both sensors measured, as residuals over offsets."""
