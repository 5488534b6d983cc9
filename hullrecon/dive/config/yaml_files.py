# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read YAML files, refusing nesting, values and aliases beyond what such files have."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml.constructor import SafeConstructor
from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.nodes import Node

from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.files import MIB, read_text
from hullrecon.errors import InputError

# bytes; a calibration has a thousand, the metadata of a long recording some hundred thousand
LARGEST_YAML = 4 * MIB
ROOM = 10_000  # values that a document may hold beyond one for each character of its text
MOST_VALUES = 20_000  # the parser takes some 60 us for each: more than a second in all
DEEPEST = 100  # brackets within each other: the parser looks through all of them at every value
OPENCV_MATRIX = "tag:yaml.org,2002:opencv-matrix"  # a table of rows, cols, dt and data
ENDS = re.compile(r"(\n---[ \t\r]*)+\s*\Z")  # of a document, after which none follows
BRACKETS = re.compile(r"[\[{\]}]")


def read_yaml(path: Path) -> Mapping[str, object]:
    """Read the table of a YAML file. Raises InputError when it holds none."""
    where = str(path.parent)
    try:
        data = parse_yaml(read_text(path, LARGEST_YAML))
    except FileNotFoundError:
        raise InputError(
            f"{path.name} is missing", where=where, remedy="correct the path in dive.toml"
        ) from None
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {error.strerror}", where=where) from None
    except ValueError as error:
        raise InputError(
            f"{path.name} is not YAML: {shorten(str(error), 160)}", where=where
        ) from None
    if not isinstance(data, Mapping):
        raise InputError(f"{path.name} holds no table", where=where)
    return data


def parse_yaml(text: str) -> object:
    """Parse YAML text, also with OpenCV's head, or the end that `ros2 topic echo` writes.

    Raises ValueError for text that is no YAML, nests too deeply, holds too many values, or whose
    aliases expand to too many.
    """
    refuse_floods(text)
    yaml = YAML(typ="safe", pure=True)
    yaml.Constructor = _BoundedConstructor
    yaml.constructor.largest_count = len(text) + ROOM
    try:
        data: object = yaml.load(ENDS.sub("\n", text.removeprefix("%YAML:1.0\n")))
    except RecursionError:
        raise ValueError("nested too deeply") from None
    # ruamel raises whatever damaged text leads it to, beside its own errors
    except Exception as error:
        raise ValueError(_describe(error)) from None
    return data


def _describe(error: Exception) -> str:
    """Say in one line what the parser stumbled over, and in which line of the text."""
    said = error.problem if isinstance(error, MarkedYAMLError) else None
    first = (str(said or error).splitlines() or [type(error).__name__])[0]
    mark = error.problem_mark if isinstance(error, MarkedYAMLError) else None
    return first if mark is None else f"{first}, in line {mark.line + 1}"


def refuse_floods(text: str) -> None:
    """Raise ValueError for more values or nested brackets than the parser reads in about a second.

    Commas, lines and brackets are counted, also those in texts: files that are read here have few.
    """
    if text.count(",") + text.count("\n") > MOST_VALUES:
        raise ValueError(f"it holds more than {MOST_VALUES} lines and values")
    depth = 0
    for bracket in BRACKETS.finditer(text):
        depth += 1 if bracket[0] in "[{" else -1
        if depth > DEEPEST:
            raise ValueError("nested too deeply")


class _BoundedConstructor(SafeConstructor):
    """Refuses documents whose aliases stand for too many values, before these are made."""

    largest_count = ROOM  # set anew for each document

    def construct_document(self, node: Node) -> object:
        if count_values(node, {}) > self.largest_count:
            raise ValueError("its aliases stand for more values than a file of its size could hold")
        return super().construct_document(node)


_BoundedConstructor.add_constructor(OPENCV_MATRIX, SafeConstructor.construct_yaml_map)


def count_values(node: Node, known: dict[int, int]) -> int:
    """Count the values at and below a node, with those of an alias wherever it is used.

    Raises ValueError for an alias of a node that contains it.

    known: counts by the id of nodes that were counted already, 0 while they are being counted.
    """
    if id(node) in known:
        count = known[id(node)]
        if not count:
            raise ValueError("an alias names what it lies in")
        return count
    known[id(node)], count = 0, 1
    members = node.value if isinstance(node.value, list) else ()
    for member in members:
        for part in member if isinstance(member, tuple) else (member,):
            count += count_values(part, known)
    known[id(node)] = count
    return count
