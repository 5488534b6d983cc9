# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses

import pytest

from hullrecon.dive.logs.read_streams import read_streams
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.errors import InputError

TOPICS = {"/imu": "imu", "/pressure": "pressure", "/joints": "joints", "/dvl": "dvl", "/cam": "camera_top"}


def run(path, topics=TOPICS):
    images = []
    return read_streams([McapLog(path)], topics, lambda sample, logged: images.append((sample, logged))), images


def test_samples_are_sorted_by_sensor_and_images_are_handed_on(kit, tmp_path):
    found, images = run(kit.mcap(tmp_path / "x.mcap", kit.dive()))
    assert {name: len(samples) for name, samples in found.samples.items() if samples} == {
        "imu": 40, "pressure": 20, "joints": 40, "dvl": 8,
    }  # fmt: skip
    assert len(images) == 8
    assert images[1][0].encoded == kit.jpeg(5)
    assert images[1][0].camera == "camera_top"
    assert found.logged_ns["imu"][3] == kit.start_ns + 300_000_000
    assert {c.topic: n for c, n in found.counts.items()}["/imu"] == 40


def test_topics_that_are_not_wanted_are_counted_but_not_decoded(kit, tmp_path):
    found, images = run(kit.mcap(tmp_path / "x.mcap", kit.dive()), {"/imu": "imu"})
    assert images == []
    assert not found.samples["dvl"]
    assert {c.topic: n for c, n in found.counts.items()}["/dvl"] == 8


def test_a_topic_of_another_type_is_an_input_error_that_names_both(kit, tmp_path):
    with pytest.raises(InputError, match="/imu holds sensor_msgs/msg/Imu, which is not read as dvl") as caught:
        run(kit.mcap(tmp_path / "x.mcap", kit.dive()), {"/imu": "dvl"})
    assert "marine_acoustic_msgs/msg/Dvl" in str(caught.value)
    assert caught.value.where == "topics.dvl"


def test_messages_without_a_stamp_take_the_time_of_logging_and_are_counted(kit, tmp_path):
    entries = [dataclasses.replace(e, message=kit.imu(0)) if e.topic == "/imu" else e for e in kit.dive()]
    found, _ = run(kit.mcap(tmp_path / "x.mcap", entries))
    assert found.samples["imu"][1].t_ns == kit.start_ns + 100_000_000
    assert "/imu: 40 messages have no stamp; their logging time was used" in found.remarks


def test_messages_that_do_not_decode_are_counted_with_the_reason(kit, tmp_path):
    import numpy as np

    entries = kit.dive()
    sonar = [
        dataclasses.replace(entries[0], topic="/sonar", kind="marine_acoustic_msgs/msg/ProjectedSonarImage", message=m)
        for m in (kit.sonar(1, np.zeros((2, 2), np.uint8)), kit.sonar(2, np.zeros((3, 2), np.uint8)))
    ]
    found, _ = run(kit.mcap(tmp_path / "x.mcap", entries + sonar), {"/sonar": "sonar"})
    assert len(found.samples["sonar"]) == 1
    assert found.remarks == ["/sonar: 1 messages could not be used: a sonar image of 4 pixels for 2 beams and 3 ranges"]
