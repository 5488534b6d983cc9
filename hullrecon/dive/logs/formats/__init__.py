# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What lies in the bytes of formats of log (of further ones in `readers/<maker>/`), every length
checked before it is used.
"""
