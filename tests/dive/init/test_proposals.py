# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `init` takes from a log: topics, frames, calibrations, mounts; and what it asks for."""

import numpy as np

from benchmarks.fuzz.seed_ad2cp import DF21, block, dvl_file, dvl_record
from benchmarks.fuzz.seed_aris import aris_file
from hullrecon.dive.config.load import load_config
from hullrecon.dive.config.mounts import ChosenMount
from hullrecon.dive.init.log_summary import guess_topics, summarise_log, summarise_logs
from hullrecon.dive.init.proposals import (
    imu_frame,
    missing_calibrations,
    proposed_mounts,
    questions,
)
from hullrecon.dive.init.template import fill_template
from hullrecon.dive.logs.readers.ad2cp.log import Ad2cpLog
from hullrecon.dive.logs.readers.mcap import McapLog
from hullrecon.dive.logs.readers.pd0 import Pd0Log
from hullrecon.dive.logs.readers.sound_metrics.aris import ArisLog
from hullrecon.findings.finding import sentences
from tests.dive.logs.test_descriptions import info


def summary_of(kit, path, entries):
    return summarise_log(McapLog(kit.mcap(path, entries)))


def entries_of(kit, more=(), without=()):
    dive = kit.dive()
    return [e for e in dive if e.topic not in without] + [type(dive[0])(*entry) for entry in more]


def written(summary, folder):
    (folder / "dive.toml").write_text(fill_template(summary, [folder / "x.mcap"], folder))
    return load_config(folder)


def test_gravity_says_in_which_frame_the_attitude_is_logged(kit, tmp_path):
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit))
    assert imu_frame(summary) == ("ned", "by gravity in the first message")
    up = kit.imu(kit.start_ns)
    up.linear_acceleration.z = 9.81
    turned = summary_of(
        kit,
        tmp_path / "y.mcap",
        entries_of(kit, [("/imu", "sensor_msgs/msg/Imu", 1, up)], ["/imu"]),
    )
    assert imu_frame(turned)[0] == "enu"
    assert written(turned, tmp_path).config.imu.frame == "enu"


def test_without_gravity_a_ros_log_is_taken_by_its_standard(kit, tmp_path):
    still = kit.imu(kit.start_ns, linear_acceleration_covariance=np.array([-1.0, *[0.0] * 8]))
    entries = entries_of(kit, [("/imu", "sensor_msgs/msg/Imu", 1, still)], ["/imu"])
    frame, why = imu_frame(summary_of(kit, tmp_path / "x.mcap", entries))
    assert frame == "enu"
    assert "REP 145" in why


def test_absolute_pressure_is_chosen_whatever_the_names(kit, tmp_path):
    kind, t = "sensor_msgs/msg/FluidPressure", kit.start_ns
    more = [
        ("/a_pressure", kind, t, kit.pressure(t, 120.0)),
        ("/mavros/imu/diff_pressure", kind, t, kit.pressure(t, 101e3)),
    ]
    more.append(("/z_pressure", kind, t, kit.pressure(t, 131e3)))
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit, more, ["/pressure"]))
    assert guess_topics(summary.topics)["pressure"] == "/z_pressure"


def test_a_type_of_many_uses_is_chosen_by_its_name_alone(kit, tmp_path):
    kind, t = "std_msgs/msg/Float64", kit.start_ns
    number = kit.make(kind, data=1.0)
    summary = summary_of(
        kit, tmp_path / "x.mcap", entries_of(kit, [("/battery", kind, t, number)], ["/pressure"])
    )
    assert "pressure" not in guess_topics(summary.topics)
    more = [("/battery", kind, t, number), ("/depth", kind, t, number)]
    summary = summary_of(kit, tmp_path / "y.mcap", entries_of(kit, more, ["/pressure"]))
    assert guess_topics(summary.topics)["pressure"] == "/depth"


def test_calibration_is_proposed_from_camera_info(kit, tmp_path):
    t, kind = kit.start_ns, "sensor_msgs/msg/CompressedImage"
    image = kit.image(t, kit.jpeg(1))
    more = [
        ("/left/image_raw/compressed", kind, t, image),
        ("/left/camera_info", "sensor_msgs/msg/CameraInfo", t, info(kit)),
        ("/other/camera_info", "sensor_msgs/msg/CameraInfo", t, info(kit, width=7)),
    ]
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit, more, ["/cam"]))
    (found,) = missing_calibrations(summary, tmp_path).items()
    assert found[0] == "calibration/camera_top.yaml"
    assert "image_width: 640" in found[1]
    (tmp_path / "calibration").mkdir()
    (tmp_path / found[0]).write_text(found[1])
    assert missing_calibrations(summary, tmp_path) == {}
    assert written(summary, tmp_path).config.camera.top.calibration == "calibration/camera_top.yaml"


def static(kit, parent, child, x):
    where = kit.make(
        "geometry_msgs/msg/Transform",
        translation=kit.vector(x, 0.1, 0.0),
        rotation=kit.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
    )
    header = kit.header(0)
    header.frame_id = parent
    frame = kit.make(
        "geometry_msgs/msg/TransformStamped", header=header, child_frame_id=child, transform=where
    )
    return kit.make("tf2_msgs/msg/TFMessage", transforms=[frame])


def test_mounts_are_proposed_from_the_fixed_frames_of_the_log(kit, tmp_path):
    kind, t = "tf2_msgs/msg/TFMessage", kit.start_ns
    more = [
        ("/tf_static", kind, t, static(kit, "base_link", "rig", 0.3)),
        ("/tf_static", kind, t + 1, static(kit, "rig", "x", 0.1)),
    ]
    # the kit's messages are in the frame "x"
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit, more))
    found = proposed_mounts(summary)
    assert found["dvl.mount"] == ChosenMount(
        value=(0.4, -0.2, 0.0, 180.0, 0.0, 0.0), source="tf_static, frame x"
    )
    assert found["pressure.origin"].value == (0.4, -0.2, 0.0)
    loaded = written(summary, tmp_path)
    assert loaded.config.dvl.mount == (0.4, -0.2, 0.0, 180.0, 0.0, 0.0)
    assert {"dvl.mount", "pressure.origin", "tray.origin"} <= loaded.given
    assert "camera.top.mount" not in loaded.given  # without a calibration its section is a comment


def test_unconnected_frames_leave_mounts_to_be_filled_in(kit, tmp_path):
    more = [("/tf_static", "tf2_msgs/msg/TFMessage", kit.start_ns, static(kit, "odom", "x", 0.3))]
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit, more))
    assert proposed_mounts(summary) == {}
    assert "dvl.mount" not in written(summary, tmp_path).given


def test_what_no_log_says_is_asked_for(data, tmp_path):
    summary = summarise_log(Pd0Log(data / "dvl-pd0-slocum" / "LA100204.PD0"))
    (line,) = sentences(questions(summary))
    assert line.startswith("to fill in: imu.mount_deg: ")
    (tmp_path / "dive.toml").write_text(fill_template(summary, [tmp_path / "x.pd0"], tmp_path))
    assert "# mount_deg = " in (tmp_path / "dive.toml").read_text()
    assert load_config(tmp_path).config.imu.mount_deg is None


def test_nortek_dvl_without_beam_directions_is_asked_for_them(tmp_path):
    for content, asked in ((block(DF21, dvl_record()), True), (dvl_file(), False)):
        (tmp_path / "x.ad2cp").write_bytes(content)
        summary = summarise_log(Ad2cpLog(tmp_path / "x.ad2cp"))
        assert (
            any(
                "nothing says where the DVL's 4 beams point" in line
                for line in sentences(questions(summary))
            )
            == asked
        )
        (tmp_path / "dive.toml").write_text(
            fill_template(summary, [tmp_path / "x.ad2cp"], tmp_path)
        )
        assert ("# beam_angle_deg" in (tmp_path / "dive.toml").read_text()) == asked
        assert load_config(tmp_path).config.dvl.beams is None


def test_a_file_of_a_dvl_beside_a_log_takes_no_topic_from_it(kit, data, tmp_path):
    """The PD0 file gives the DVL; its own compass and depth cell yield to the IMU and the pressure
    of the log.
    """
    log = McapLog(kit.mcap(tmp_path / "x.mcap", entries_of(kit, without=["/dvl"])))
    summary = summarise_logs([log, Pd0Log(data / "dvl-pd0-slocum" / "LA100204.PD0")])
    guessed = guess_topics(summary.topics)
    assert (guessed["dvl"], guessed["imu"], guessed["pressure"]) == ("dvl", "/imu", "/pressure")
    topics = written(summary, tmp_path).config.topics
    assert (topics.dvl, topics.imu, topics.pressure, topics.joints) == (
        None,
        "/imu",
        "/pressure",
        "/joints",
    )
    assert sentences(questions(summary)) == []


def test_of_two_imus_the_one_with_an_attitude_is_chosen(kit, tmp_path):
    raw = kit.imu(kit.start_ns, orientation_covariance=np.array([-1.0, *[0.0] * 8]))
    empty = kit.imu(kit.start_ns, quaternion=(0, 0, 0, 0))
    kind = "sensor_msgs/msg/Imu"
    more = [
        ("/a/imu/raw", kind, 1, raw),
        ("/b/imu/empty", kind, 1, empty),
        ("/z/imu/data", kind, 1, kit.imu(kit.start_ns)),
    ]
    summary = summary_of(kit, tmp_path / "x.mcap", entries_of(kit, more, ["/imu"]))
    assert guess_topics(summary.topics)["imu"] == "/z/imu/data"


def test_sonar_file_without_published_beams_is_asked_about_them(kit, tmp_path):
    log = McapLog(kit.mcap(tmp_path / "x.mcap", entries_of(kit)))
    (tmp_path / "known.aris").write_bytes(aris_file(1))
    (tmp_path / "telephoto.aris").write_bytes(aris_file(1, lens=1))
    known, unknown = (
        summarise_logs([log, ArisLog(tmp_path / f"{name}.aris")]) for name in ("known", "telephoto")
    )
    assert sentences(questions(known)) == []
    assert "beam_azimuth_deg" not in fill_template(known, [tmp_path / "x.mcap"], tmp_path)
    (line,) = sentences(questions(unknown))
    assert line.startswith(
        "to fill in: nothing says where the sonar's 64 beams point (sonar.beam_azimuth_deg): give "
        "the azimuth"
    )
    config = written(unknown, tmp_path)
    assert config.value("sonar.elevation_deg") == 14.0
    assert "# beam_azimuth_deg = " in (tmp_path / "dive.toml").read_text()
