# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""open3d without what its views in a browser need, in a process that has not imported it yet."""

import subprocess
import sys

PROGRAM = """
import sys
from hullrecon.geometry.open3d_import import import_open3d
cloud = import_open3d().geometry.PointCloud()
assert cloud.is_empty()
print(*sorted({name.split(".")[0] for name in sys.modules} & {"dash", "plotly"}))
import dash, plotly.graph_objects
assert dash.Dash is not None and plotly.graph_objects.Figure is not None
"""


def test_open3d_is_imported_without_dash_and_plotly_which_still_can_be():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr
