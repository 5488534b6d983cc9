# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""[KimEustice2009]: two images registered by one camera, and what is made of them."""
