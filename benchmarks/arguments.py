# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the command lines of benchmarks share."""

from __future__ import annotations

import argparse
import json
from pathlib import Path


def parser_for(description: str | None) -> argparse.ArgumentParser:
    """Make the parser of a benchmark, whose docstring is its help."""
    return argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def keep(found: object, file: Path | None) -> None:
    """Write what was found as JSON, where --json names a file."""
    if file is not None:
        file.write_text(json.dumps(found, indent=1, default=float), encoding="utf-8")
