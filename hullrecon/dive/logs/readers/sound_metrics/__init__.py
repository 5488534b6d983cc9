# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Files of Sound Metrics' sonars: where frames lie, where beams point, the reader of an ARIS."""
