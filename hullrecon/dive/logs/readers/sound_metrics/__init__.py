# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Files of Sound Metrics' sonars: their frames, beam directions, and the reader of an ARIS."""
