# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Files of Nortek's DVLs and Signature instruments (AD2CP): blocks, records, the reader."""
