# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz.seed_aris import aris_file
from hullrecon.change.options import EarlierDive
from hullrecon.dive.check.package_check import check_package, defaults_of
from hullrecon.dive.check.requirements import missing, needs
from hullrecon.dive.config.load import load_config
from hullrecon.findings.finding import sentences
from hullrecon.report.options import ReportOptions
from hullrecon.steps.ingest import ingest_settings, request_of
from tests.dive.readers.test_pd0 import ensemble_bytes


def check(package: Path, *overrides: str):
    loaded = load_config(package, {}, overrides)
    return check_package(
        loaded,
        request_of(ingest_settings(loaded)),
    )


def test_a_package_is_told_with_what_it_lacks(package):
    lines = check(package).lines()
    assert lines[0] == "tiny"
    assert any(line.startswith("camera_top: 8 images in 3.5 s") for line in lines)
    assert "the first camera image is 0.0 s after the first DVL ping" in lines
    assert "no camera_bottom: one camera: scale and depth come from the DVL" in lines
    assert (
        "no hull: without a CAD model the run maps onto its own surface, in the frame global"
        in lines
    )
    assert not any(line.startswith(("no dvl", "no imu", "no joints")) for line in lines)


def test_a_pressure_sensor_that_never_gave_a_number_is_none(package, kit):
    lost = [
        dataclasses.replace(e, message=kit.pressure(e.t_ns, float("nan")))
        if e.topic == "/pressure"
        else e
        for e in kit.dive()
    ]
    kit.mcap(package / "logs" / "dive.mcap", lost)
    lines = check(package).lines()
    why = "are no finite numbers, or marked as lost, and were left out"
    assert f"note: pressure: 20 of 20 readings {why}" in lines
    assert any(line.startswith("no pressure") for line in lines)
    assert lines[-1].startswith("verdict: ready")


def test_dive_that_measured_no_hull_is_not_ready(package, kit):
    blind = [
        dataclasses.replace(e, message=kit.dvl(e.t_ns, beam_ranges_valid=False))
        if e.topic == "/dvl"
        else e
        for e in kit.dive()
    ]
    kit.mcap(package / "logs" / "dive.mcap", blind)
    assert check(package).run_is_possible
    kit.mcap(package / "logs" / "dive.mcap", [e for e in blind if e.topic != "/cam"])
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(re.sub(r"(?m)^camera_top = .*$", "", text))
    found = check(package)
    assert not found.run_is_possible
    assert "hull-unmeasured" in [finding.code for finding in found.findings]


def test_unnamed_topic_is_listed_with_reason(package, kit):
    entries = kit.dive()
    entry, t = type(entries[0]), entries[0].t_ns
    beam = kit.make(
        "sensor_msgs/msg/Range",
        header=kit.header(t),
        radiation_type=0,
        field_of_view=0.1,
        min_range=0.1,
        max_range=9.0,
        range=2.0,
        variance=0.0,
    )
    kit.mcap(
        package / "logs" / "dive.mcap",
        [*entries, entry("/altimeter", "sensor_msgs/msg/Range", t, beam)],
    )
    found = check(package)
    (line,) = found.document()["unused"]
    assert line.startswith(
        "a run would not use /altimeter (sensor_msgs/msg/Range): ranges are taken along the beams "
        "of a DVL"
    )
    assert f"note: {line}" in found.lines()


def test_the_clock_of_a_sonar_file_is_corrected_by_dive_toml(package):
    (package / "logs" / "sonar.aris").write_bytes(aris_file(2, delay_us=930))
    files = 'logs.files=["logs/dive.mcap","logs/sonar.aris"]'
    own = check(package, files).found.records.sonar.t_ns
    assert (
        check(package, files, "sonar.time_offset=-0.25").found.records.sonar.t_ns.tolist()
        == (own - 250_000_000).tolist()
    )


@pytest.mark.parametrize("lens", [0, 1])
def test_sonar_file_beside_log_is_read_or_asked_for_beams(package, lens):
    (package / "logs" / "sonar.aris").write_bytes(aris_file(3, lens=lens))
    files = 'logs.files=["logs/dive.mcap","logs/sonar.aris"]'
    found = check(package, files)
    if lens:
        assert "nothing says where the sonar's 64 beams point" in found.verdict
        found = check(
            package, files, f"sonar.beam_azimuth_deg={np.linspace(-7, 7, 64).round(2).tolist()}"
        )
    assert found.run_is_possible
    assert found.found.records.sonar.image.shape == (3, 64, 8)
    azimuth = np.degrees(np.arcsin(found.found.records.sonar.directions[:, 1]))
    assert azimuth[[0, -1]] == pytest.approx([-7, 7] if lens else [-14.89, 14.89], abs=0.01)


def test_what_contradicts_itself_is_a_warning(package):
    lines = check(package, "camera.top.mount=[0,0,0,0,0,0]").lines()
    assert any(line.startswith("warning: camera.top looks 90 degrees away") for line in lines)


def test_a_log_of_another_day_than_is_stated_is_a_warning(package):
    logged = "dive.date=2026-05-04T09:30:00Z"
    codes = [f.code for f in check(package, logged).warnings]
    assert "date-differs" not in codes
    assert "date-differs" in [
        f.code for f in check(package, "dive.date=2026-05-01T09:30:00Z").warnings
    ]


def test_a_damaged_log_is_told_as_lost(package):
    path = package / "logs" / "dive.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert sum(line.startswith("lost: dive.mcap: /") for line in check(package).lines()) == 5


def test_defaults_are_those_keys_that_nobody_gave(package):
    loaded = load_config(package, {}, ["dvl.scale_sigma=0.01"])
    defaults = defaults_of(loaded)
    assert "dvl.scale_sigma" not in defaults
    assert defaults["pressure.bias_sigma_m"] == 0.1
    assert not any(
        key.startswith(("hull.", "sonar.", "camera.bottom", "position.")) for key in defaults
    )
    assert "camera.top.calibration" not in defaults


@pytest.mark.parametrize(
    ("roll_deg", "sigma"), [(180, [1, 1, 0.3, 1, 1, 5]), (-90, [1, 0.3, 1, 1, 5, 1])]
)
def test_default_pose_sigma_follows_the_upward_axis(package, roll_deg, sigma):
    given = ["hull.mesh='ship.stl'", f"hull.pose=[0,0,0,{roll_deg},0,0]"]
    assert defaults_of(load_config(package, {}, given))["hull.pose_sigma"] == sigma
    given.append("hull.pose_sigma=[2,2,2,2,2,2]")
    assert "hull.pose_sigma" not in defaults_of(load_config(package, {}, given))


def positions(kit, entry, count, step_m):
    """Points of a USBL, each some metres east of the last."""
    at = [kit.start_ns + k * 500_000_000 for k in range(count)]
    points = [kit.make("geometry_msgs/msg/Point", x=step_m * k, y=0.0, z=0.0) for k in range(count)]
    kind = "geometry_msgs/msg/PointStamped"
    return [
        entry("/usbl", kind, t, kit.make(kind, header=kit.header(t), point=p))
        for t, p in zip(at, points, strict=True)
    ]


@pytest.mark.parametrize(
    ("count", "alone"), [(6, ""), (1, "; one alone tells nothing of the path")]
)
def test_positions_are_told_with_their_number_span_and_sigma(count, alone, package, kit):
    entries = kit.dive()
    kit.mcap(
        package / "logs" / "dive.mcap", [*entries, *positions(kit, type(entries[0]), count, 2.0)]
    )
    found = check(package, "topics.position=/usbl", "position.sigma_m=0.5")
    assert any(line.startswith(f"position: {count} position") for line in found.lines())
    assert (
        f"positions from outside span 0.0 m north and {2 * count - 2:.1f} m east, sigma 0.5 "
        f"m{alone}" in found.lines()
    )
    assert "position.time_offset" in found.defaults
    assert any(
        line.startswith("to fill in: position.origin: transponder of USBL")
        for line in found.lines()
    )
    (unused,) = check(package).document()["unused"]
    assert "/usbl (could be position)" in unused


def test_the_document_has_every_stream_with_its_rate(package):
    streams = check(package).document()["streams"]
    assert streams["imu"] == {
        "count": 40,
        "start_ns": 1_777_887_000_000_000_000,
        "end_ns": 1_777_887_003_900_000_000,
        "rate_hz": 10.0,
    }
    assert set(streams) == {"dvl", "imu", "pressure", "tray", "camera_top"}


def test_the_simulated_dive_raises_no_suspicion(data):
    found = check(data / "dive-a")
    assert sentences(found.warnings) == []
    assert sentences(found.missing) == []
    assert sentences(found.found.lost) == []
    assert "depth runs from 1.1 to 4.2 m" in found.lines()
    assert "the mesh is watertight" in found.lines()


def test_wrong_frame_of_the_simulated_dive_is_a_warning(data):
    found = check(data / "dive-a", "imu.frame=enu")
    assert "imu-upside-down" in {warning.code for warning in found.warnings}


def test_document_lists_findings_and_gates_by_errors(package):
    found = check(package, "topics.imu=/nothing")
    listed = found.document()["findings"]
    assert set(listed[0]) == {"code", "severity", "where", "values", "sentence"}
    errors = [f["sentence"] for f in listed if f["severity"] == "error"]
    assert errors == found.reasons
    assert errors
    assert json.loads(json.dumps(listed)) == listed  # plain values alone
    assert not found.run_is_possible


def test_lever_arms_that_are_left_to_defaults_are_asked_for(package):
    found = check(package)
    asked = [line.split(": ")[1] for line in found.lines() if line.startswith("to fill in: ")]
    assert asked == ["tray.origin", "pressure.origin", "dvl.mount", "camera.top.mount"]
    assert found.document()["to_fill_in"] == sentences(found.to_fill_in)


def test_logged_camera_without_calibration_is_asked_for(package):
    path = package / "dive.toml"
    path.write_text(path.read_text().split("[camera.top]")[0])
    assert any(
        line.startswith("to fill in: camera.top.calibration: ") for line in check(package).lines()
    )


def test_a_dvl_without_an_imu_is_said_to_be_no_run(package):
    path = package / "dive.toml"
    path.write_text(path.read_text().replace('imu = "/imu"\n', ""))
    lines = check(package).lines()
    assert "no imu: the DVL's velocities have no heading: no run is possible" in lines


def test_a_package_whose_files_are_there_can_be_run(package):
    found = check(package)
    assert found.run_is_possible
    assert sentences(found.missing_files) == []


def test_missing_files_are_listed_with_keys_and_prevent_run(package):
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(text + '[hull]\nmesh = "nowhere.stl"\n')
    found = check(package)
    assert found.document()["missing_files"] == ["nowhere.stl (hull.mesh)"]
    assert not found.run_is_possible
    assert found.found.records.dvl is not None
    assert "missing: nowhere.stl (hull.mesh)" in found.lines()


@pytest.mark.parametrize(
    ("logs", "other"),
    [
        ('"logs/none.mcap"', 'hull.mesh="nowhere.stl"'),  # the only log, beside another file
        ('"logs/dive.mcap", "logs/none.mcap"', "topics.sonar=/sonar"),
    ],
)
def test_what_a_missing_log_may_hold_is_not_missed(package, logs, other):
    found = check(package, f"logs.files=[{logs}]", other)
    (line,) = sentences([*found.unusable, *found.needs])
    assert line.startswith("the log none.mcap is missing")


@pytest.mark.parametrize(
    ("sensors", "runnable"),
    [
        ({"dvl", "imu"}, True),
        ({"dvl"}, False),
        ({"imu", "camera_top"}, False),
        ({"camera_top", "camera_bottom"}, True),
        ({"dvl", "camera_top", "camera_bottom"}, False),
        (set(), False),
    ],
)
def test_a_run_needs_velocities_with_a_heading_or_stereo_images(sensors, runnable):
    assert (sentences(needs(sensors)) == []) == runnable
    assert any("no run is possible" in line for line in sentences(missing(sensors))) != runnable


def test_camera_without_logged_images_prevents_run(package, kit):
    kit.mcap(package / "logs" / "dive.mcap", [e for e in kit.dive() if "camera" not in e.topic])
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(
        "\n".join(line for line in text.splitlines() if not line.startswith("camera_top")) + "\n"
    )
    found = check(package)
    assert not found.run_is_possible
    assert (
        "no image of camera.top was logged: take [camera.top] and [camera.bottom] out of dive.toml"
        in found.verdict
    )


def test_photos_that_lie_beside_the_tables_are_not_to_be_given_up(package):
    tables = package / "logs" / "tables"
    tables.mkdir()
    (tables / "pressure.csv").write_text("t,pascal\n1777887000,1e5\n")
    for name in ("a.jpg", "b.jpg"):
        (tables / name).touch()
    verdict = check(package, 'logs.files=["logs/tables"]').verdict
    assert "beside the tables lie 2 photos without times: put beside them camera_top.csv" in verdict
    assert "take [camera.top]" not in verdict


def test_the_last_line_is_the_verdict(package):
    found = check(package)
    assert found.lines()[-1].startswith(
        "verdict: ready, with warnings (to fill in: tray.origin, pressure.origin, dvl.mount"
    )
    assert found.document()["verdict"] == found.verdict
    mounts = [
        "tray.origin=[0,0,0]",
        "pressure.origin=[0,0,0]",
        "dvl.mount=[0,0,0,0,90,0]",
        "camera.top.mount=[0,0,0,90,0,90]",
    ]
    assert check(package, *mounts).lines()[-1] == "verdict: ready"


def test_all_that_is_in_the_way_of_a_run_is_listed_at_once(package):
    (package / "calibration" / "camera_top.yaml").write_text("image_width: many\n")
    (package / "hull.stl").write_text("no mesh")
    (package / "dive.toml").write_text(
        (package / "dive.toml").read_text() + '[hull]\nmesh = "hull.stl"\n'
    )
    text = (
        (package / "dive.toml")
        .read_text()
        .replace('pressure = "/pressure"', 'pressure = "/nothing"')
    )
    (package / "dive.toml").write_text(
        text.replace('joints = "/joints"', 'sonar = "/joints"') + "[sonar]\n"
    )
    found = check(package)
    assert not found.run_is_possible
    for part in (
        "image_width",
        "hull.stl",
        "topic /nothing is not in the log",
        "not read as sonar",
    ):
        assert any(part in line for line in sentences(found.unusable)), part
        assert part in found.verdict
    assert found.found.records.dvl is not None
    assert found.found.records.imu is not None
    assert (
        sum(line.startswith("not usable: ") for line in found.lines())
        == len(sentences(found.unusable))
        == 4
    )


def test_a_dvl_without_any_velocity_is_in_the_way_of_a_run(package, kit):
    lost = np.zeros(9)
    lost[0] = -1
    entries = [e for e in kit.dive() if e.topic != "/dvl"]
    entries += [
        type(e)(
            "/dvl", "marine_acoustic_msgs/msg/Dvl", e.t_ns, kit.dvl(e.t_ns, velocity_covar=lost)
        )
        for e in entries
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries)
    (line,) = sentences(check(package).unusable)
    assert line.endswith(
        "pings have no velocity over ground: log its bottom track, or give two cameras instead"
    )
    with_bottom = [
        type(e)("/cam2", e.kind, e.t_ns, e.message) for e in entries if e.topic == "/cam"
    ]
    kit.mcap(package / "logs" / "dive.mcap", [*entries, *with_bottom])
    text = (
        (package / "dive.toml").read_text().replace("[topics]", '[topics]\ncamera_bottom="/cam2"')
    )
    text += '\n[camera.bottom]\ncalibration = "calibration/camera_top.yaml"\n'
    (package / "dive.toml").write_text(text)
    (line,) = sentences(check(package).unusable)
    assert line.endswith("or leave the DVL away (topics.dvl, or its file in logs.files)")
    (package / "dive.toml").write_text(re.sub(r"(?m)^dvl = .*$", "", text))
    assert check(package).run_is_possible


def test_several_dives_are_refused_until_one_is_given(package, kit):
    entries = [e for e in kit.dive() if e.topic != "/cam"]
    first_ns, imu, dvl = entries[0].t_ns, entries[0], next(e for e in entries if e.topic == "/dvl")
    for later_ns in range(first_ns + 7200 * 10**9, first_ns + 7203 * 10**9, 10**9):
        turned = kit.imu(later_ns, quaternion=(0.0, 0.0, 1e-9 * (later_ns - first_ns) / 1e9, 1.0))
        entries.append(type(imu)(imu.topic, imu.kind, later_ns, turned))
        entries.append(type(dvl)(dvl.topic, dvl.kind, later_ns, kit.dvl(later_ns)))
    kit.mcap(package / "logs" / "dive.mcap", entries)
    text = re.sub(r"(?m)^camera_top = .*$", "", (package / "dive.toml").read_text())
    (package / "dive.toml").write_text(re.sub(r"\[camera\.top\][^\[]*", "", text))
    assert "by other files or by dive.from and dive.to" in check(package).verdict
    assert check(package, "dive.to=3600").run_is_possible


def test_cameras_that_logged_nothing_are_in_the_way_until_left_out(package, kit):
    kit.mcap(package / "logs" / "dive.mcap", [e for e in kit.dive() if e.topic != "/cam"])
    text = re.sub(r"(?m)^camera_top = .*$", "", (package / "dive.toml").read_text())
    (package / "dive.toml").write_text(text)
    assert "take [camera.top] and [camera.bottom] out of dive.toml" in check(package).verdict
    (package / "dive.toml").write_text(re.sub(r"\[camera\.top\][^\[]*", "", text))
    assert check(package).run_is_possible


def test_a_camera_that_shows_one_picture_all_dive_is_refused_until_left_out(package, kit):
    stuck = [
        dataclasses.replace(e, message=kit.image(e.t_ns, kit.jpeg(0))) if e.topic == "/cam" else e
        for e in kit.dive()
    ]
    kit.mcap(package / "logs" / "dive.mcap", stuck)
    assert "all 8 images of camera_top are one picture to the last byte" in check(package).verdict
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(re.sub(r"\[camera\.top\][^\[]*", "", text))
    assert check(package).run_is_possible


def test_lost_profiler_velocities_come_before_its_mount(tmp_path):
    """Else its owner measures mounts of an instrument that cannot be used."""
    (tmp_path / "x.pd0").write_bytes(
        b"".join(ensemble_bytes(n, velocity=(-32768,) * 4, heading=100) for n in range(20))
    )
    (tmp_path / "dive.toml").write_text('[dive]\nname = "x"\n[logs]\nfiles = ["x.pd0"]\n')
    first, second = sentences(check(tmp_path).unusable)
    assert "20 pings have no velocity over ground" in first
    assert "imu.mount_deg" in second


@pytest.mark.parametrize(("mount", "is_told"), [("[0,0,0,0,90,0]", True), ("[1,0,0,0,3,0]", False)])
def test_dvl_mount_and_imu_mount_that_differ_are_warned_of(tmp_path, mount, is_told):
    (tmp_path / "x.pd0").write_bytes(b"".join(ensemble_bytes(n, heading=100) for n in range(20)))
    (tmp_path / "dive.toml").write_text('[dive]\nname = "x"\n[logs]\nfiles = ["x.pd0"]\n')
    warnings = sentences(check(tmp_path, "imu.mount_deg=[0,0,0]", f"dvl.mount={mount}").warnings)
    assert any("turn the DVL's axes 90 degrees apart" in line for line in warnings) == is_told


def test_an_imu_of_its_own_may_sit_otherwise_than_the_dvl(package):
    assert sentences(check(package, "imu.mount_deg=[0,0,0]").warnings) == sentences(
        check(package).warnings
    )


def test_unusable_sensor_is_not_also_called_missing(package, kit):
    entries = [e for e in kit.dive() if e.topic != "/imu"]
    entry = type(entries[0])
    entries += [
        entry("/imu", "sensor_msgs/msg/Imu", e.t_ns, kit.imu(e.t_ns, quaternion=(0, 0, 0, 0)))
        for e in entries
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries)
    found = check(package)
    assert [line for line in sentences(found.unusable) if "no attitude" in line]
    assert not any(line.startswith("no imu") for line in sentences(found.missing))
    assert sentences(found.needs) == []


def test_package_without_named_sensors_gets_a_verdict(package):
    path = package / "dive.toml"
    path.write_text(path.read_text().split("[topics]")[0])
    found = check(package)
    assert found.verdict.startswith("not ready: no sensor could be read from the logs")
    assert found.verdict.endswith("; missing: a DVL with an IMU, or two cameras")


def test_a_logo_that_is_not_there_is_missed(package):
    loaded = load_config(package, {"report": ReportOptions}, ["report.logo=logo.png"])
    request = request_of(ingest_settings(loaded))
    assert sentences(check_package(loaded, request).missing_files) == [
        "missing: logo.png (report.logo)"
    ]
    (package / "logo.png").write_bytes(b"")
    assert sentences(check_package(loaded, request).missing_files) == []


def test_missing_earlier_dive_is_warned_of_and_run_possible(package):
    loaded = load_config(package, {"change": EarlierDive}, ["change.earlier=runs/may"])
    request = request_of(ingest_settings(loaded))
    found = check_package(loaded, request)
    assert (
        "change.earlier names no folder: runs/may; the report will not say what changed"
        in sentences(found.warnings)
    )
    assert found.run_is_possible
    (package / "runs" / "may").mkdir(parents=True)
    assert not any(
        "change.earlier" in line for line in sentences(check_package(loaded, request).warnings)
    )


def test_dvl_of_unreadable_type_is_named_in_needs(package, kit):
    entries = kit.dive()
    entry, t = type(entries[0]), entries[0].t_ns
    warmth = kit.make(
        "sensor_msgs/msg/Temperature", header=kit.header(t), temperature=4.0, variance=0.0
    )
    kit.mcap(
        package / "logs" / "dive.mcap",
        [*entries, entry("/nortek/raw", "sensor_msgs/msg/Temperature", t, warmth)],
    )
    assert check(package).run_is_possible
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(text.replace('dvl = "/dvl"\n', ""))
    (line,) = sentences(check(package).needs)
    assert (
        "/nortek/raw (sensor_msgs/msg/Temperature) is a DVL's but of a type that is not read"
        in line
    )
