# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.staleness: what changed, in words."""

from __future__ import annotations

from typing import Any

import pytest

from hullrecon.artifacts.manifest import FileRecord, Recipe
from hullrecon.artifacts.recipe import differences

MADE = Recipe(
    stage="matches",
    version=1,
    settings={
        "matches": {"max_pairs": 40, "ratio": 0.8, "roi": [1, 2]},
        "camera.top": {"mount": [0.0]},
        "sonar": None,
        "logs": ["a"],
    },
    inputs={"features": "f1", "navigate": "n1"},
    external={"logs/dive.mcap": FileRecord("aa", 10)},
)


def changed(**parts: Any) -> Recipe:
    return Recipe(**{name: parts.get(name, getattr(MADE, name)) for name in MADE.__struct_fields__})


def with_option(section: str, value: Any) -> Recipe:
    return changed(settings={**MADE.settings, section: value})


@pytest.mark.parametrize(
    ("now", "words"),
    [
        (
            with_option("matches", {"max_pairs": 60, "ratio": 0.8, "roi": [1, 2]}),
            ["option matches.max_pairs changed from 40 to 60"],
        ),
        (
            with_option("matches", {"max_pairs": 40, "ratio": 0.9, "roi": [1, 3]}),
            [
                "option matches.ratio changed from 0.8 to 0.9",
                "option matches.roi changed from [1, 2] to [1, 3]",
            ],
        ),
        (
            with_option("matches", {"max_pairs": 40, "ratio": 0.8}),
            ["option matches.roi is gone, it was [1, 2]"],
        ),
        (
            with_option("matches", {"max_pairs": 40, "ratio": 0.8, "roi": [1, 2], "new": "x"}),
            ['option matches.new is new, it is "x"'],
        ),
        (with_option("sonar", {"elevation_deg": 14.0}), ["sonar changed from none to a section"]),
        (with_option("camera.top", None), ["camera.top changed from a section to none"]),
        (
            changed(
                settings={
                    name: value
                    for name, value in MADE.settings.items()
                    if name not in ("logs", "sonar")
                }
            ),
            ['logs is no longer read, it was ["a"]', "sonar is no longer read, it was none"],
        ),
        (with_option("dvl.mount", [0.5]), ["dvl.mount is read now, it is [0.5]"]),
        (with_option("tray", None), ["tray is read now, it is none"]),
        (with_option("logs", ["b"]), ['logs changed from ["a"] to ["b"]']),
        (changed(inputs={"features": "f2", "navigate": "n1"}), ["input features changed"]),
        (changed(inputs={"features": "f1"}), ["input navigate is gone"]),
        (changed(inputs={**MADE.inputs, "adjust": "a"}), ["input adjust is new"]),
        (
            changed(external={"logs/dive.mcap": FileRecord("bb", 10)}),
            ["external file logs/dive.mcap changed"],
        ),
        (changed(external={}), ["external file logs/dive.mcap is gone"]),
        (
            changed(external={**MADE.external, "hull.stl": FileRecord("cc", 1)}),
            ["external file hull.stl is new"],
        ),
        (changed(version=2), ["code version 1 -> 2"]),
        (changed(stage="pairs"), ["it was made by step matches"]),
    ],
)
def test_a_change_is_said_in_words_and_changes_the_key(now: Recipe, words: list[str]) -> None:
    assert differences(MADE, now) == words
    assert now.key != MADE.key


def test_nothing_changed_is_no_words_and_the_same_key() -> None:
    assert differences(MADE, changed()) == []
    assert changed().key == MADE.key


def test_integer_in_place_of_float_is_a_change() -> None:
    now = with_option("matches", {"max_pairs": 40.0, "ratio": 0.8, "roi": [1, 2]})
    assert now.key != MADE.key
    assert differences(MADE, now) == ["option matches.max_pairs changed from 40 to 40.0"]
