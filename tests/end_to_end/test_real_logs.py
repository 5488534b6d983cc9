# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Real logs of the evaluation data, opened as a user would."""


def test_a_bag_without_camera_or_dvl_is_described_in_words(evaluation_data, shell):
    words = shell("check", evaluation_data / "ros1-micron-bag" / "static_sonar.bag").stdout.lower()
    assert "/tritech_micron/scan" in words
    assert "553" in words
    for missing in ("dvl", "camera"):
        assert missing in words


def test_a_glider_s_pd0_is_described_in_words(evaluation_data, shell):
    words = shell("check", evaluation_data / "dvl-pd0-slocum" / "LA100204.PD0").stdout.lower()
    assert "107" in words
