# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Import all steps, for the server that the processes of steps and workers are copies of.

What this imports must start no threads. Libraries that do, and large ones, are imported by the
functions that use them.
"""

import gc
from importlib import import_module

from hullrecon.steps.chain import NAMES

# New objects after which the garbage of cycles is collected. With Python's 700 it was looked for
# a thousand times while the report was written, a twelfth of the time.
gc.set_threshold(50_000, 50)
OF_MOST_STEPS = ("scipy.ndimage", "scipy.optimize")  # imported where they are used
STEPS = [f"hullrecon.steps.{name.replace('-', '_')}" for name in NAMES]
for name in (*STEPS, *OF_MOST_STEPS):
    import_module(name)
gc.freeze()  # a collection in a copy would copy all pages of what was imported
