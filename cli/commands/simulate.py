# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""simulate: a dive package with truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import click

from hullrecon.synthetic.options import Option, options, spec_from

from ..dives import FOLDER
from ..state import state_of


def _with_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add an option for each option of a simulated dive."""
    for option in reversed(options()):
        command = _click_option(option)(command)
    return command


def _click_option(option: Option) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make the command's option of an option of a simulated dive."""
    flag = option.name.replace("_", "-")
    flags = f"--{flag}/--no-{flag}" if isinstance(option.default, bool) else f"--{flag}"
    kind: click.Choice[str] | type = option.kind
    if option.meta.choices:
        kind = click.Choice(option.meta.choices)
    bounds = f" ({option.meta.bounds()})" if option.meta.bounds() else ""
    return click.option(
        flags,
        option.name,
        type=kind,
        default=option.default,
        show_default=True,
        help=option.meta.description + bounds,
    )


@click.command()
@click.argument("folder", type=FOLDER)
@_with_options
def simulate(folder: Path, **values: object) -> None:
    """Make a dive package with truth in FOLDER.

    A vehicle follows legs along the side of a ship. What its DVL, IMU, pressure cell, cameras and
    sonar measure goes to FOLDER/logs; what is true goes to FOLDER/truth, for `hullrecon evaluate`.
    The same options give the same bytes. FOLDER must be new or empty; it appears when all of it is
    written.

    A second dive of the same hull has the same options, another --seed and the first one's seed as
    --hull-seed; --added,
    --removed and --grown-m say what has changed since.
    """
    from hullrecon.artifacts.progress import choose_progress
    from hullrecon.synthetic.package import write_package

    state = state_of()
    dive = write_package(folder, spec_from(**values), choose_progress(quiet=state.quiet).track)
    objects = sum(item.height_m != 0 and item.kind != "barnacles" for item in dive.items)
    made = {
        "package": str(folder),
        "seconds": round(float(dive.motion.t_s[-1]), 1),
        "frames": len(dive.frame_s),
        "objects": objects,
    }
    to_find = "1 object" if objects == 1 else f"{objects} objects"
    line = f"wrote {folder}: {made['seconds']} s, {made['frames']} camera frames"
    state.emit(made, [f"{line}, {to_find} to be found"])
