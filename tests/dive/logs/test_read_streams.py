# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hullrecon.dive.logs import read_streams as read_streams_module
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.read_streams import MOST_DEFINITIONS, MOST_REASONS, read_streams
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.protocol import Channel, Message
from hullrecon.dive.logs.samples import PressureSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

TOPICS = {
    "/imu": ("imu",),
    "/pressure": ("pressure",),
    "/joints": ("joints",),
    "/dvl": ("dvl",),
    "/cam": ("camera_top",),
}


def run(path, topics=TOPICS):
    images = []
    return read_streams([McapLog(path)], topics, lambda sample, *_: images.append(sample)), images


def test_samples_are_sorted_by_sensor_and_images_are_handed_on(kit, tmp_path):
    found, images = run(kit.mcap(tmp_path / "x.mcap", kit.dive()))
    assert {name: len(samples) for name, samples in found.samples.items() if samples} == {
        "imu": 40, "pressure": 20, "joints": 40, "dvl": 8,
    }  # fmt: skip
    assert len(images) == 8
    assert images[1].encoded == kit.jpeg(5)
    assert images[1].camera == "camera_top"
    assert found.logged_ns["imu"][3] == kit.start_ns + 300_000_000
    assert {c.topic: n for c, n in found.counts.items()}["/imu"] == 40


def test_topics_that_are_not_wanted_are_counted_but_not_decoded(kit, tmp_path):
    found, images = run(kit.mcap(tmp_path / "x.mcap", kit.dive()), {"/imu": ("imu",)})
    assert images == []
    assert not found.samples["dvl"]
    assert {c.topic: n for c, n in found.counts.items()}["/dvl"] == 8


def test_topic_of_wrong_type_is_refused_with_both_types(kit, tmp_path):
    with pytest.raises(
        InputError, match="/imu holds sensor_msgs/msg/Imu, which is not read as dvl"
    ) as caught:
        run(kit.mcap(tmp_path / "x.mcap", kit.dive()), {"/imu": ("dvl",)})
    assert "marine_acoustic_msgs/msg/Dvl" in str(caught.value)
    assert caught.value.where == "topics.dvl"
    assert run(tmp_path / "x.mcap", {"/dvl": ("dvl",)})[0].samples["dvl"]


def test_messages_that_ros_did_not_encode_are_refused_by_their_encoding(kit, tmp_path, monkeypatch):
    path = kit.mcap(tmp_path / "x.mcap", kit.dive())
    whole = McapLog.messages

    def as_json(log):
        for message in whole(log):
            channel = Channel(message.channel.topic, "sensor_msgs.Imu", "json")
            yield dataclasses.replace(message, channel=channel, data=b"{}")

    monkeypatch.setattr(McapLog, "messages", as_json)
    with pytest.raises(InputError, match="topic /imu is encoded as json"):
        run(path, {"/imu": ("imu",)})


def test_unstamped_messages_take_logging_time_and_are_counted(kit, tmp_path):
    entries = [
        dataclasses.replace(e, message=kit.imu(0)) if e.topic == "/imu" else e for e in kit.dive()
    ]
    found, _ = run(kit.mcap(tmp_path / "x.mcap", entries))
    assert found.samples["imu"][1].t_ns == kit.start_ns + 100_000_000
    assert "/imu: 40 messages have no stamp; their logging time was used" in sentences(found.notes)


def test_messages_that_do_not_decode_are_counted_with_the_reason(kit, tmp_path):
    entries = kit.dive()
    sonar = [
        dataclasses.replace(
            entries[0],
            topic="/sonar",
            kind="marine_acoustic_msgs/msg/ProjectedSonarImage",
            message=m,
        )
        for m in (
            kit.sonar(1, np.zeros((2, 2), np.uint8)),
            kit.sonar(2, np.zeros((3, 2), np.uint8)),
        )
    ]
    found, _ = run(kit.mcap(tmp_path / "x.mcap", entries + sonar), {"/sonar": ("sonar",)})
    assert len(found.samples["sonar"]) == 1
    assert sentences(found.notes) == [
        "/sonar: 1 messages could not be used: a sonar image of 4 pixels for 2 beams and 3 ranges"
    ]


def definition_of(kit, kind):
    return kit.stores[2].generate_msgdef(kind, ros_version=2)[0]


class Recording:
    """A log of one topic whose messages are given, by the definition that is given."""

    gives_samples = False
    kind = "recording"
    path = Path("log.bag")

    def __init__(self, kit, kind, messages, edit=lambda text: text, times=None):
        data = [bytes(kit.stores[2].serialize_cdr(m, kind)) for m in messages]
        texts = (
            [edit(definition_of(kit, kind))]
            if isinstance(edit(""), str)
            else edit(definition_of(kit, kind))
        )
        self.notes = []
        self._messages = [
            Message(
                Channel("/t", kind, "cdr", texts[n % len(texts)]),
                (times or range(1, len(data) + 1))[n],
                d,
            )
            for n, d in enumerate(data)
        ]

    def messages(self):
        return iter(self._messages)

    def losses(self):
        return []


@pytest.mark.parametrize(
    ("sensor", "old", "new"),
    [
        ("imu", "std_msgs/Header header", "std_msgs/Header heade"),
        ("imu", "geometry_msgs/Quaternion orientation", "geometry_msgs/Quaternion orientatio"),
        ("imu", "float64 x", "float64 y_"),
        ("imu", "builtin_interfaces/Time stamp", "uint64 stamp"),
        ("dvl", "float64[4] range\n", "float64[4] ranges\n"),
        ("dvl", "float64[9] velocity_covar", "geometry_msgs/Vector3[3] velocity_covar"),
        ("dvl", "geometry_msgs/Vector3 velocity\n", "float64[3] velocity\n"),
        ("joints", "float64[] position", "string[] position"),
        ("joints", "string[] name", "float64[] name"),
    ],
)
def test_damaged_definition_costs_only_its_own_messages(kit, sensor, old, new):
    """Fields of other names and types lead anywhere; the dive goes on with its other sensors."""
    t = kit.start_ns
    made = {"imu": kit.imu(t), "dvl": kit.dvl(t), "joints": kit.joints(t, ["a"], [0.5])}[sensor]
    kind = {
        "imu": "sensor_msgs/msg/Imu",
        "dvl": "marine_acoustic_msgs/msg/Dvl",
        "joints": "sensor_msgs/msg/JointState",
    }[sensor]
    assert old in definition_of(kit, kind)
    log = Recording(kit, kind, [made, made, made], lambda text: text.replace(old, new))
    if sensor == "joints":  # a tray would be taken to stand still
        with pytest.raises(InputError, match="none of its 3 messages can be used: ") as caught:
            read_streams([log], {"/t": (sensor,)}, lambda *_: None)
        assert caught.value.line().isprintable()
        assert "or leave topics.joints away" in caught.value.remedy
        assert not read_streams([log], {}, lambda *_: None).notes
        return
    found = read_streams([log], {"/t": (sensor,)}, lambda *_: None)
    assert not found.samples[sensor]
    assert sum(found.undecoded.values()) == 3
    assert all(
        note.startswith("/t: 3 messages could not be used: ") and note.isprintable()
        for note in sentences(found.notes)
    )


def test_a_range_that_is_no_number_costs_its_ping(kit):
    pings = [
        kit.sonar(t, np.ones((3, 2), np.uint8), (1, 2, end))
        for t, end in ((1, np.nan), (2, np.inf), (3, 3))
    ]
    log = Recording(kit, "marine_acoustic_msgs/msg/ProjectedSonarImage", pings)
    found = read_streams([log], {"/t": ("sonar",)}, lambda *_: None)
    assert [s.t_ns for s in found.samples["sonar"]] == [3]
    assert sum(found.undecoded.values()) == 2


def test_reasons_of_one_topic_do_not_grow_with_its_messages(kit):
    pings = [kit.sonar(n, np.ones((n, 2), np.uint8)) for n in range(4, 40)]
    log = Recording(kit, "marine_acoustic_msgs/msg/ProjectedSonarImage", pings)
    found = read_streams([log], {"/t": ("sonar",)}, lambda *_: None)
    assert len(sentences(found.notes)) <= MOST_REASONS + 1
    assert sum(found.undecoded.values()) == 36


def test_number_of_compiled_definitions_per_topic_is_bounded(kit, monkeypatch):
    compiled = []
    monkeypatch.setattr(
        read_streams_module, "decode", lambda c, data: compiled.append(c) or decode(c, data)
    )
    readings = [kit.pressure(n + 1, 1e5) for n in range(60)]
    log = Recording(
        kit,
        "sensor_msgs/msg/FluidPressure",
        readings,
        lambda text: [f"# {n}\n{text}" for n in range(60)],
    )
    found = read_streams([log], {"/t": ("pressure",)}, lambda *_: None)
    assert len(set(compiled)) == len(found.samples["pressure"]) == MOST_DEFINITIONS
    assert sum(found.undecoded.values()) == 60 - MOST_DEFINITIONS


@pytest.mark.parametrize("t_ns", [(1 << 62) + 5, 1 << 63, (1 << 64) - 1])
def test_a_time_beyond_int64_costs_its_message(kit, t_ns):
    readings = [kit.pressure(0, 1e5), kit.pressure(0, 2e5)]
    log = Recording(kit, "sensor_msgs/msg/FluidPressure", readings, times=[5, t_ns])
    found = read_streams([log], {"/t": ("pressure",)}, lambda *_: None)
    assert [s.pascal for s in found.samples["pressure"]] == [1e5]
    assert any("beyond the year 2116" in note for note in sentences(found.notes))


def test_a_sample_of_a_table_beyond_int64_is_left_out_too():
    class Table(Recording):
        gives_samples = True

        def __init__(self):
            self.notes = []
            channel = Channel("pressure", "pressure.csv", "sample")
            self._messages = [Message(channel, t, PressureSample(t, 1e5)) for t in (5, -(1 << 70))]

    found = read_streams([Table()], {}, lambda *_: None)
    assert [s.t_ns for s in found.samples["pressure"]] == [5]
    assert sum(found.undecoded.values()) == 1


def test_a_damaged_type_among_good_messages_costs_those_messages(kit):
    log = Recording(kit, "sensor_msgs/msg/FluidPressure", [kit.pressure(1, 1e5)])
    log._messages.append(Message(Channel("/t", "sensor_msgs/msg/FluidPressurf", "cdr"), 2, b""))
    found = read_streams([log], {"/t": ("pressure",)}, lambda *_: None)
    assert len(found.samples["pressure"]) == 1
    assert (
        "/t: 1 messages could not be used: they are sensor_msgs/msg/FluidPressurf, unlike those "
        "before" in sentences(found.notes)
    )


def test_names_of_joints_do_not_reach_the_terminal_as_they_are(kit):
    log = Recording(kit, "sensor_msgs/msg/JointState", [kit.joints(1, ["tray\x1b[31m"], [0.5])])
    assert (
        read_streams([log], {"/t": ("joints",)}, lambda *_: None).samples["joints"][0].name
        == "tray\\x1b[31m"
    )


def test_two_sensors_on_one_topic_are_refused(kit, tmp_path):
    entries = kit.dive()
    for number, entry in enumerate(e for e in entries if e.topic == "/imu"):
        entry.message.header.frame_id = "ahrs" if number % 3 else "dvl"
    with pytest.raises(InputError, match=r"two frames in turn, ahrs \(26\) and dvl \(14\)"):
        run(kit.mcap(tmp_path / "x.mcap", entries))
    for entry in entries:
        if entry.topic == "/imu" and entry.message.header.frame_id == "dvl":
            object.__setattr__(entry, "topic", "/dvl/imu")
    assert run(kit.mcap(tmp_path / "parted.mcap", entries))


def test_a_frame_that_is_renamed_once_is_no_second_sensor(kit, tmp_path):
    entries = kit.dive()
    for number, entry in enumerate(e for e in entries if e.topic == "/imu"):
        entry.message.header.frame_id = "imu" if number < 20 else "imu_link"
    assert len(run(kit.mcap(tmp_path / "x.mcap", entries))[0].samples["imu"]) == 40


def test_a_topic_named_for_two_sensors_has_to_be_of_both(kit, tmp_path):
    with pytest.raises(InputError, match="/imu holds sensor_msgs/msg/Imu, which is not read as pr"):
        run(kit.mcap(tmp_path / "x.mcap", kit.dive()), {"/imu": ("imu", "pressure")})
