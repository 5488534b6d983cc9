# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Import all steps, for the server that the processes of steps and workers are copies of.

What this imports must start no threads. Libraries that do, and large ones, are imported by the
functions that use them.
"""

import gc
from importlib import import_module

from hullrecon.steps.chain import NAMES

for name in NAMES:
    import_module(f"hullrecon.steps.{name.replace('-', '_')}")
gc.freeze()  # a collection in a copy would copy all pages of what was imported
