# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Each finding that says what to do has a test that does it and sees that it heals."""

import ast
import inspect
import re
from pathlib import Path

import pytest

from hullrecon.findings.finding import WORDS

TESTS = Path(__file__).parents[1]
# What asks a reader to do something
ADVICE = re.compile(
    r"\b(to fill in|give\b|set dvl|set \{|log (its|one|it as)|leave the|take \[|put it there"
    r"|name it in|write them|add it to|states it|are they in|in metres|says in which|off \(\{key"
    r"|gives the path"
    r"|of this.{0,6}type are|it is \"\{other)",
    re.DOTALL,
)
# By code: the test that applies it
APPLIED = {
    "memory-tight": "api/test_costs.py::"
    "test_a_part_of_the_dive_is_advised_only_where_that_can_heal",
    "memory-over-budget": "api/test_costs.py::test_a_dive_over_its_memory_is_refused_until_it_fits",
    "dvl-without-velocity": "dive/check/test_package_check.py::"
    "test_a_dvl_without_any_velocity_is_in_the_way_of_a_run",
    "hull-unmeasured": "steps/test_navigate.py::test_path_is_reckoned_without_any_range",
    "images-not-logged": "dive/check/test_package_check.py::"
    "test_cameras_that_logged_nothing_are_in_the_way_until_left_out",
    "clocks-apart": "dive/test_ingest.py::test_clocks_apart_are_refused_and_the_remedy_heals",
    "motions-apart": "navigation/test_motion_offset.py::"
    "test_motions_over_a_minute_apart_are_told_and_the_remedy_heals",
    "stamps-in-other-unit": "dive/check/test_time_overlap.py::"
    "test_stamps_of_another_unit_are_no_offset",
    "key-open": "dive/check/test_requirements.py::test_a_key_that_is_given_is_not_asked_for",
    "calibration-open": "dive/check/test_requirements.py::"
    "test_a_camera_without_a_section_needs_a_calibration",
    "question": "dive/logs/test_dvl_beams.py::"
    "test_configured_beams_are_used_for_messages_without_beams",
    "mount-of-dvl-open": "dive/check/test_package_check.py::"
    "test_dvl_mount_and_imu_mount_that_differ_are_warned_of",
    "log-outside": "dive/test_package_files.py::"
    "test_file_outside_package_is_refused_with_key_and_option",
    "stations-off": "dive/check/test_bow.py::test_a_zero_amidships_is_no_aft_perpendicular",
    "stream-shifted": "dive/check/test_time_overlap.py::"
    "test_a_stream_that_is_shifted_is_told_with_its_seconds",
    "imu-upside-down": "dive/check/test_package_check.py::"
    "test_the_simulated_dive_raises_no_suspicion",
    "baseline-implausible": "dive/check/test_consistency_checks.py::"
    "test_a_baseline_in_millimetres_or_of_nothing_is_named",
    "bottom-camera-delayed": "vision/stereo/test_delay.py::test_offset_that_is_advised_heals",
    "pressure-unit-open": "navigation/test_suspects.py::"
    "test_pressure_of_a_dive_at_one_depth_asks_for_its_unit",
    "topics-not-chosen": "dive/check/test_topics.py::"
    "test_a_topic_of_a_type_that_is_read_is_told_as_what",
    "topics-of-depths": "dive/check/test_topics.py::test_types_of_depths_that_are_advised_are_read",
    "mesh-small": "dive/hull/test_hull.py::test_units_are_converted",
    "angles-in-degrees": "dive/logs/test_streams.py::test_a_sonars_rotator_may_turn_more_than_once",
    "positions-under-water": "dive/logs/test_positions.py::"
    "test_a_topics_name_or_a_key_says_that_positions_are_acoustic",
    "water-linked-offset": "dive/readers/test_water_linked.py::"
    "test_the_mounting_rotation_offset_is_told",
    "water-linked-no-offset": "dive/readers/test_water_linked.py::"
    "test_the_mounting_rotation_offset_is_told",
}


def words_of(code: str) -> str:
    words = WORDS[code]
    return words if isinstance(words, str) else inspect.getsource(words)


def test_each_finding_with_advice_has_a_test_that_follows_it():
    advising = {code for code in WORDS if ADVICE.search(words_of(code))}
    assert advising == set(APPLIED)


@pytest.mark.parametrize("node", sorted(set(APPLIED.values())))
def test_the_test_that_follows_advice_exists(node):
    file, _, name = node.partition("::")
    tree = ast.walk(ast.parse((TESTS / file).read_text()))
    assert name in {found.name for found in tree if isinstance(found, ast.FunctionDef)}
