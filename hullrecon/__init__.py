# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Underwater hull inspection: from a vehicle's logs and the ship's CAD model to the hull as found.

In a notebook, `hullrecon.run`, `evaluate`, `diff` and the others below do what the commands of the
same name do (examples/). Each is loaded when it is first used, so that importing hullrecon is free.
What reproduces the sources is in hullrecon.studies.
"""

from importlib import import_module

_FUNCTIONS = {  # name: the module that defines it
    "check": "hullrecon.api.package",
    "diff": "hullrecon.api.change",
    "evaluate": "hullrecon.api.dive_run",
    "export_colmap": "hullrecon.api.export",
    "init": "hullrecon.api.package",
    "open_dive": "hullrecon.api.dive_run",
    "run": "hullrecon.api.dive_run",
}
__all__ = ["__version__", *_FUNCTIONS]


def __getattr__(name: str) -> object:
    """Load a function, or the version, when it is first asked for."""
    if name == "__version__":
        from hullrecon.version import version

        return version()
    if name not in _FUNCTIONS:
        raise AttributeError(f"module 'hullrecon' has no attribute {name!r}")
    return getattr(import_module(_FUNCTIONS[name]), name)
