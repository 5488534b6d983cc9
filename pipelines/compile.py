# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Called by setup.sh: imports whatever the modules of these folders import, in functions too.

So all that a run needs is compiled once, at set-up, and whether a later process may write compiled
modules makes no difference to it.
"""

import ast
import importlib
import sys
from pathlib import Path

sys.dont_write_bytecode = False
imported = set()
for folder in sys.argv[1:]:
    for path in Path(folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                imported |= {name.name for name in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                imported.add(node.module)
for name in sorted(imported):
    importlib.import_module(name)
