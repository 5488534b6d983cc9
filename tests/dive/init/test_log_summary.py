# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from dive.conftest import Entry

from benchmarks.fuzz.seed_ad2cp import TEXT, block
from hullrecon.dive.check.requirements import missing, to_fill_in
from hullrecon.dive.config.load import load_config
from hullrecon.dive.init.depth_signal import DepthSignal
from hullrecon.dive.init.log_summary import (
    LogSummary,
    TopicNote,
    guess_topics,
    summarise_log,
    summarise_logs,
)
from hullrecon.dive.init.proposals import questions
from hullrecon.dive.init.template import beams_to_ask_for, fill_template
from hullrecon.dive.logs.formats.stamps import ASSUMED
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.findings.finding import sentences
from hullrecon.steps.ingest import ingest_settings, request_of

IMAGE = "sensor_msgs/msg/CompressedImage"


def notes(**kinds: str) -> list[TopicNote]:
    return [
        TopicNote(channel=Channel("/" + topic.replace("__", "/"), kind, "cdr"), count=1)
        for topic, kind in kinds.items()
    ]


def test_a_log_is_told_topic_by_topic(kit, tmp_path):
    found = summarise_log(open_log(kit.mcap(tmp_path / "x.mcap", kit.dive())))
    lines = found.lines()
    assert lines[0] == "MCAP: 96 messages on 5 topics, 3.9 s from 2026-05-04T09:30:00.000Z"
    assert "/imu: 40 messages in 3.9 s, 10.0 Hz, sensor_msgs/msg/Imu" in lines
    assert "/cam can be the camera_top" in lines
    assert "no sonar: there will be no sonar mosaic" in lines
    assert found.document()["guessed"]["dvl"] == "/dvl"


def test_a_real_ros1_bag_is_told_with_what_is_missing_for_a_run(data):
    lines = summarise_log(open_log(data / "ros1-micron-bag" / "static_sonar.bag")).lines()
    assert lines[0] == "ROS 1 bag: 2784 messages on 7 topics, 25.4 s from 2020-02-10T14:53:22.362Z"
    assert any(line.startswith("/tritech_micron/scan: 553 messages") for line in lines)
    assert any("a run would not use" in line and "/tritech_micron/scan" in line for line in lines)
    assert any(line.startswith("no dvl") for line in lines)


def test_a_damaged_log_is_told_with_its_loss(kit, tmp_path):
    path = kit.mcap(tmp_path / "x.mcap", kit.dive())
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert any("is lost" in line for line in summarise_log(open_log(path)).lines())


@pytest.mark.parametrize(
    ("topics", "top", "bottom"),
    [
        ({"cam__bottom": IMAGE, "cam__top": IMAGE}, "/cam/top", "/cam/bottom"),
        ({"left": IMAGE, "right": IMAGE}, "/left", "/right"),
        ({"bottom_camera": IMAGE}, "/bottom_camera", None),
        ({"a": IMAGE, "b": IMAGE}, "/a", "/b"),
        (
            {"a__image": "sensor_msgs/msg/Image", "a__image__compressed": IMAGE},
            "/a/image/compressed",
            None,
        ),
        ({"depth": IMAGE, "color": IMAGE}, "/color", None),
    ],
)
def test_cameras_are_guessed_by_name(topics, top, bottom):
    found = guess_topics(notes(**topics))
    assert (found.get("camera_top"), found.get("camera_bottom")) == (top, bottom)


def test_a_dvl_of_a_common_type_needs_its_name():
    kind = "geometry_msgs/msg/TwistWithCovarianceStamped"
    assert guess_topics(notes(odom=kind)) == {}
    assert guess_topics(notes(dvl__velocity=kind)) == {"dvl": "/dvl/velocity"}


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("bar30__depth", "std_msgs/msg/Float64"),
        ("bar30__pressure", "sensor_msgs/msg/FluidPressure"),
        ("mavros__vfr_hud", "mavros_msgs/msg/VfrHud"),
        ("mavros__vfr_hud", "mavros_msgs/VFR_HUD"),  # as ROS 1 calls it
    ],
)
def test_depth_topic_named_by_instrument_is_pressure_sensor(topic, kind):
    assert guess_topics(notes(**{topic: kind})) == {"pressure": "/" + topic.replace("__", "/")}


def test_of_several_imus_the_one_that_is_called_so_is_taken():
    assert (
        guess_topics(notes(other="sensor_msgs/msg/Imu", my_imu="sensor_msgs/msg/Imu"))["imu"]
        == "/my_imu"
    )


@pytest.mark.parametrize(("count", "quaternions", "can_be"), [
    (60, [(0.0, 0.0, 0.0, 1.0)], False),
    (60, [(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.6, 0.8)], True),
    (20, [(0.0, 0.0, 0.0, 1.0)], True),
])  # fmt: skip
def test_imu_without_orientation_is_not_chosen(kit, tmp_path, count, quaternions, can_be):
    kind, t = "sensor_msgs/msg/Imu", kit.start_ns
    each = [quaternions[min(k, len(quaternions) - 1)] for k in range(count)]
    entries = [
        Entry("/imu", kind, t + k * 10**7, kit.imu(t + k * 10**7, quaternion=q))
        for k, q in enumerate(each)
    ]
    path = kit.mcap(tmp_path / "x.mcap", entries)
    assert ("imu" in guess_topics(summarise_log(open_log(path)).topics)) == can_be


def test_what_is_missing_depends_on_what_else_there_is():
    stereo = sentences(missing({"camera_top", "camera_bottom"}))
    assert "no dvl: motion comes from stereo images" in stereo
    alone = sentences(missing({"sonar"}))
    assert any("no run is possible" in line for line in alone)
    assert not any(line.startswith("no camera_bottom") for line in alone)
    everything = {"dvl", "imu", "pressure", "joints", "camera_top", "camera_bottom", "sonar"}
    assert sentences(missing(everything, hull=True)) == []
    assert "without a CAD model" in sentences(missing(everything, hull=False))[0]


def test_a_dvl_without_an_imu_can_not_be_run_even_with_stereo():
    stereo = {"dvl", "camera_top", "camera_bottom"}
    assert any(
        line.startswith("no imu: ") and "no run is possible" in line
        for line in sentences(missing(stereo))
    )
    assert "no imu: attitude comes from stereo images and drifts" in sentences(
        missing(stereo - {"dvl"})
    )
    assert "no imu: there is no attitude: no run is possible" in sentences(missing({"camera_top"}))


def test_scale_comes_from_dvl_only_where_one_was_logged():
    assert "no camera_bottom: one camera: scale and depth come from the DVL" in sentences(
        missing({"camera_top", "dvl"})
    )
    assert "no camera_bottom: one camera: no scale without a DVL" in sentences(
        missing({"camera_top", "imu"})
    )


def test_unchosen_topics_differ_from_unreadable_topics(kit, tmp_path):
    entries = kit.dive()
    entry = type(entries[0])
    second = [
        entry("/second_imu", "sensor_msgs/msg/Imu", e.t_ns, e.message)
        for e in entries
        if e.topic == "/imu"
    ]
    text = kit.make("std_msgs/msg/String", data="hello")
    log = kit.mcap(
        tmp_path / "x.mcap",
        [*entries, *second, entry("/talk", "std_msgs/msg/String", entries[0].t_ns, text)],
    )
    lines = summarise_log(open_log(log)).lines()
    assert (
        "not chosen, though of a type that is read: /second_imu (could be imu); name it in "
        "[topics] to use it" in lines
    )
    assert "a run would not use /talk: of other types than it reads" in lines


def test_first_dive_toml_loads_and_names_all_that_was_found(kit, tmp_path, calibration):
    path = kit.mcap(tmp_path / "logs" / "x.mcap", kit.dive())
    (tmp_path / "ship.stl").write_bytes(b"")
    calibration(tmp_path / "cal" / "my_top.yaml")
    text = fill_template(summarise_log(open_log(path)), [path], tmp_path)
    (tmp_path / "dive.toml").write_text(text)
    loaded = load_config(tmp_path)
    assert loaded.config.logs.files == ("logs/x.mcap",)
    assert loaded.config.topics.dvl == "/dvl"
    assert loaded.config.topics.sonar is None
    assert loaded.config.tray.joint == "tray"
    assert "its name in the joint messages: tray, other" in text
    assert loaded.value("hull.mesh") == "ship.stl"
    assert loaded.value("camera.top.calibration") == "cal/my_top.yaml"
    assert loaded.value("camera.bottom") is None
    assert str(loaded.config.dive.date) == "2026-05-04 09:30:00+00:00"


def test_the_first_configuration_of_plain_files_has_no_topics(tmp_path):
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "pressure.csv").write_text("t,pascal\n1777887000,101325\n")
    text = fill_template(summarise_log(open_log(tmp_path / "logs")), [tmp_path / "logs"], tmp_path)
    (tmp_path / "dive.toml").write_text(text)
    assert load_config(tmp_path).config.logs.files == ("logs",)
    assert load_config(tmp_path).config.topics.pressure is None
    assert "the names of the files say which sensor is which" in text


@pytest.mark.parametrize("stamp", ["09:30:00", "2026-05-04 09:30:00", "2026-05-04 09:30:00Z"])
def test_what_stamps_of_tables_leave_open_is_asked_for(tmp_path, stamp):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n{stamp},101325\n")
    summary = summarise_logs([open_log(tmp_path, clock=ASSUMED)])
    text = fill_template(summary, [tmp_path], tmp_path)
    asked = " ".join(sentences(questions(summary)))
    assert ("logs.time_zone" in asked, "dive.date" in asked) == (
        "Z" not in stamp,
        "2026" not in stamp,
    )
    assert ('# time_zone = "+00:00"' in text) == ("Z" not in stamp)
    assert ("\n# date = " in text) == ("2026" not in stamp)
    (tmp_path / "dive.toml").write_text(
        text.replace("# time_zone", "time_zone").replace("# date", "date")
    )
    request = request_of(ingest_settings(load_config(tmp_path)))
    (message,) = open_log(tmp_path, clock=request.clock).messages()
    assert message.t_ns == 1_777_887_000 * 10**9


def test_a_sonar_in_the_log_gives_a_sonar_section(kit, tmp_path):
    entry = type(kit.dive()[0])
    ping = entry(
        "/sonar",
        "marine_acoustic_msgs/msg/ProjectedSonarImage",
        5,
        kit.sonar(5, np.zeros((3, 2), np.uint8)),
    )
    path = kit.mcap(tmp_path / "x.mcap", [*kit.dive(), ping])
    (tmp_path / "dive.toml").write_text(
        fill_template(summarise_log(open_log(path)), [path], tmp_path)
    )
    assert load_config(tmp_path).sections["sonar"].elevation_deg == 14.0


@pytest.mark.parametrize(
    "evil", ['/imu"\n[dive]\nname = "x\x7f', "/" + "a" * 70_000], ids=["quotes", "long"]
)
def test_what_a_log_names_can_not_break_out_of_the_configuration(kit, tmp_path, evil):
    entries = kit.dive()
    entry = type(entries[0])
    path = kit.mcap(
        tmp_path / "x.mcap",
        [entry(evil if e.topic == "/imu" else e.topic, e.kind, e.t_ns, e.message) for e in entries],
    )
    (tmp_path / "dive.toml").write_text(
        fill_template(summarise_log(open_log(path)), [path], tmp_path)
    )
    assert load_config(tmp_path).config.topics.imu == printable(evil)


def test_cameras_without_a_calibration_stand_in_comments(kit, tmp_path):
    path = kit.mcap(tmp_path / "x.mcap", kit.dive())
    (tmp_path / "dive.toml").write_text(
        fill_template(summarise_log(open_log(path)), [path], tmp_path)
    )
    loaded = load_config(tmp_path)
    assert loaded.config.camera.top is None
    assert "# [camera.top]" in (tmp_path / "dive.toml").read_text()
    assert any(
        "camera.top.calibration" in line for line in sentences(to_fill_in(loaded, {"camera_top"}))
    )


def test_what_no_log_tells_is_asked_for_and_not_written(kit, tmp_path, calibration):
    path = kit.mcap(tmp_path / "x.mcap", kit.dive())
    calibration(tmp_path / "top.yaml")
    (tmp_path / "dive.toml").write_text(
        fill_template(summarise_log(open_log(path)), [path], tmp_path)
    )
    lines = sentences(to_fill_in(load_config(tmp_path), {"dvl", "imu", "pressure", "camera_top"}))
    keys = [line.split(": ")[1] for line in lines]
    assert keys == ["tray.origin", "pressure.origin", "dvl.mount", "camera.top.mount"]
    assert lines[1].endswith("until then what the log's tf_static says, else [0, 0, 0] is used")


def test_what_is_given_or_not_carried_is_not_asked_for(package):
    assert (
        sentences(
            to_fill_in(load_config(package, {}, ["pressure.origin=[0, 0, 1]"]), {"pressure", "imu"})
        )
        == []
    )


def test_several_logs_are_told_as_one(kit, tmp_path):
    entries = kit.dive()
    logs = [
        kit.mcap(tmp_path / "a.mcap", entries[:50]),
        kit.mcap(tmp_path / "b.mcap", entries[50:]),
    ]
    both = summarise_logs([open_log(log) for log in logs])
    whole = summarise_log(open_log(kit.mcap(tmp_path / "c.mcap", entries)))
    assert both.lines() == whole.lines()


def test_beams_are_asked_for_only_where_ranges_come_without_them(kit, tmp_path):
    (tmp_path / "dvl.csv").write_text("t,vx,vy,vz,range_1,range_2,range_3\n0,1,0,0,1,1,1\n")
    assert beams_to_ask_for(summarise_log(open_log(tmp_path))) == 3
    (tmp_path / "dvl.csv").write_text("t,vx,vy,vz\n0,1,0,0\n")
    assert beams_to_ask_for(summarise_log(open_log(tmp_path))) == 0
    assert beams_to_ask_for(summarise_log(open_log(kit.mcap(tmp_path / "x.mcap", kit.dive())))) == 0


def test_what_readers_say_of_several_files_is_told_with_the_file(tmp_path):
    for name in ("a.ad2cp", "b.ad2cp"):
        (tmp_path / name).write_bytes(block(TEXT, b"x" * 20))
    logs = [open_log(path) for path in find_logs(tmp_path)]
    assert [
        line.split(": ")[0]
        for line in sentences(summarise_logs(logs).notes)
        if "bottom-track" in line
    ] == ["a.ad2cp", "b.ad2cp"]
    assert not any(line.startswith("a.ad2cp") for line in sentences(summarise_logs(logs[:1]).notes))


def test_log_without_readable_dvl_names_the_unreadable_one():
    note = TopicNote(
        channel=Channel("/teledyne/ensemble", "teledyne_navigator/Ensemble", "ros1"), count=3
    )
    (line,) = sentences(LogSummary(kind="ROS 1 bag", topics=[note]).needs())
    assert line.startswith(
        "missing: a DVL with an IMU, or two cameras; /teledyne/ensemble "
        "(teledyne_navigator/Ensemble) is a DVL's"
    )


FLUID, HUD = "sensor_msgs/msg/FluidPressure", "mavros_msgs/msg/VfrHud"
DEPTH_M = np.linspace(0.3, 2.0, 50)


def with_depths(**topics):
    """Topics of (type, readings)."""
    out = notes(**{name: kind for name, (kind, _) in topics.items()})
    for note, (kind, values) in zip(out, topics.values(), strict=True):
        note.depth = DepthSignal(values=list(values), is_pressure=kind == FLUID)
    return out


def pressure_topic(**topics):
    return guess_topics(with_depths(**topics)).get("pressure")


def test_the_pressure_that_follows_the_dive_is_chosen():
    """Not the air in the enclosure, though its type says pressure alone."""
    air, water = 102_950 + 5 * np.sin(np.arange(50)), 101_325 + 10_055 * DEPTH_M
    assert pressure_topic(static_pressure=(FLUID, air), vfr_hud=(HUD, -DEPTH_M)) == "/vfr_hud"
    both = {"a_pressure": (FLUID, air), "z_pressure": (FLUID, water)}
    assert pressure_topic(**both) == "/z_pressure"
    both = {"a_pressure": (FLUID, air), "bar30": (FLUID, water / 100)}
    assert pressure_topic(**both) == "/bar30"


def test_a_height_and_a_temperature_are_told_from_a_depth():
    air, number = (FLUID, 102_950 + np.zeros(50)), "std_msgs/msg/Float64"
    assert pressure_topic(a_pressure=air, rel_alt=(number, -DEPTH_M)) == "/rel_alt"
    assert pressure_topic(bar30__temperature=(number, 11 + DEPTH_M)) is None
    assert pressure_topic(depth__setpoint=(number, DEPTH_M), depth=(number, DEPTH_M)) == "/depth"
    assert DepthSignal(values=list(-DEPTH_M), is_number=True).grows_up
    assert not DepthSignal(values=list(DEPTH_M), is_number=True).grows_up


def test_a_bag_without_metadata_is_found_in_a_package(kit, tmp_path):
    bag = tmp_path / "logs" / "rosbag2_2026"
    bag.mkdir(parents=True)
    kit.mcap(bag / "rosbag2_2026_0.mcap", kit.dive())
    assert find_logs(tmp_path) == [bag]


def test_where_nothing_moves_the_pressure_is_chosen_by_type():
    air = 102_950 + np.zeros(50)
    topics = {"static_pressure": (FLUID, air), "vfr_hud": (HUD, np.full(50, -1.5))}
    assert pressure_topic(**topics) == "/static_pressure"


@pytest.mark.parametrize(
    ("scale", "unit"), [(1.0, "Pa"), (1e2, "hPa"), (1e3, "kPa"), (1e4, "dbar"), (1e5, "bar")]
)
def test_the_unit_of_a_pressure_is_told_by_its_values(scale, unit):
    absolute = (101_325 + 10_055 * DEPTH_M) / scale
    assert DepthSignal(values=list(absolute), is_pressure=True).unit == unit


def test_a_pressure_over_that_of_the_air_is_not_chosen():
    assert pressure_topic(pressure=(FLUID, 10_055 * DEPTH_M)) is None


def test_the_unit_stands_in_the_first_dive_toml(kit, tmp_path):
    entries = kit.dive()
    for entry in entries:
        if entry.topic == "/pressure":
            entry.message.fluid_pressure /= 100.0
    summary = summarise_log(open_log(kit.mcap(tmp_path / "x.mcap", entries)))
    text = fill_template(summary, [tmp_path / "x.mcap"], tmp_path)
    assert 'unit = "hPa"' in text
    (tmp_path / "dive.toml").write_text(text)
    assert load_config(tmp_path).config.pressure.unit == "hPa"


def test_a_camchain_calibrates_both_cameras_of_the_first_dive_toml(kit, tmp_path):
    kit.mcap(tmp_path / "x.mcap", kit.dive())
    pose = "[[1, 0, 0, 0], [0, 1, 0, -0.12], [0, 0, 1, 0], [0, 0, 0, 1]]"
    (tmp_path / "results.yaml").write_text(f"cam0: {{}}\ncam1:\n  T_cn_cnm1: {pose}\n")
    summary = summarise_log(open_log(tmp_path / "x.mcap"))
    summary.topics += notes(right=IMAGE)
    text = fill_template(summary, [tmp_path / "x.mcap"], tmp_path)
    assert text.count('calibration = "results.yaml"') == 2
    assert "pose_in_top = [0, 0.12, 0, 0, 0, 0]  # by results.yaml" in text
