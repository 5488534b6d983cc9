# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import fields

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.consistency_checks import check_consistency
from hullrecon.dive.check.contents import describe_start_offset
from hullrecon.dive.config.schema import (
    CameraBottom,
    Cameras,
    CameraTop,
    Dive,
    DiveConfig,
    Dvl,
    Imu,
    Logs,
)
from hullrecon.dive.logs.dvl_beams import tilted_beams
from hullrecon.findings.finding import sentences
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
)

NS = 1_000_000_000
T = np.arange(100, dtype=np.int64) * NS // 5

JANUS = tilted_beams(30.0, (180.0, 0.0, 90.0, -90.0))


def told(*dive) -> list[str]:
    return sentences(check_consistency(*dive))


def config(**more) -> DiveConfig:
    return DiveConfig(
        dive=Dive(name="x"),
        logs=Logs(files=("l",)),
        **{"dvl": Dvl(mount=(0, 0, 0, 0, 90, 0)), **more},
    )


def dive(
    depth=3.0, mount_pitch_deg=90.0, turn: Rotation | None = None, acceleration=(0.0, 0.0, -9.81)
):
    """A level vehicle that bobs by 0.3 m; the DVL looks as its mount says and measures that motion.
    turn: of the attitude.
    """
    bob = 0.3 * np.sin(T / NS)
    down = 0.3 * np.cos(T / NS)
    attitude = turn or Rotation.identity()
    vehicle_from_dvl = Rotation.from_euler("y", mount_pitch_deg, degrees=True)
    velocity = (attitude * vehicle_from_dvl).inv().apply(np.outer(down, [0, 0, 1.0]))
    n = len(T)
    return {
        "dvl": DvlPings(
            t_ns=T,
            velocity=velocity,
            velocity_sigma=np.full(n, 0.003),
            ranges=np.ones((n, 4)),
            beams=JANUS,
        ),
        "imu": ImuSamples(
            t_ns=T,
            quaternion=np.tile(attitude.as_quat(), (n, 1)),
            angular_velocity=np.zeros((n, 3)),
            acceleration=np.tile(acceleration, (n, 1)).astype(float),
        ),
        "pressure": PressureSamples(t_ns=T, depth=depth + bob),
        "tray": JointSamples(t_ns=T, angle=np.zeros(n)),
    }


def index(t_ns) -> ImageIndex:
    n = len(t_ns)
    return ImageIndex(
        t_ns=np.array(t_ns, np.int64),
        file=np.full(n, ""),
        offset=np.zeros(n, int),
        size=np.zeros(n, int),
        usable=np.ones(n, bool),
    )


def test_a_dive_that_fits_together_raises_no_suspicion():
    assert told(config(), SensorRecords(**dive()), {"camera_top": index(T)}) == []


def test_returns_above_the_water_raise_suspicion_of_the_mount():
    """At 0.4 m depth with the DVL looking up, ranges of 1 m end in the air."""
    records = dive(depth=0.4, mount_pitch_deg=180.0)
    (line,) = told(config(dvl=Dvl(mount=(0, 0, 0, 0, 180, 0))), SensorRecords(**records), {})
    assert "% of the DVL's returns lie above the water" in line


@pytest.mark.parametrize(("frame", "other"), [("ned", "enu"), ("enu", "ned")])
def test_inverted_gravity_suggests_other_imu_frame(frame, other):
    records = {"imu": dive(acceleration=(0, 0, 9.81))["imu"]}
    assert told(config(imu=Imu(frame=frame)), SensorRecords(**records), {}) == [
        f'imu: gravity pulls upward with imu.frame = "{frame}": it is "{other}", or the '
        "accelerations are those of gravity, with the other sign"
    ]


def test_gravity_aslant_is_told_in_degrees():
    records = {"imu": dive(acceleration=(9.81, 0, -9.81))["imu"]}
    assert (
        "gravity is 45 degrees off the vertical" in told(config(), SensorRecords(**records), {})[0]
    )


def test_an_imu_without_accelerations_raises_none():
    assert told(config(), SensorRecords(imu=dive(acceleration=(np.nan,) * 3)["imu"]), {}) == []


def test_a_joint_that_was_read_once_says_nothing_about_clocks():
    """As one that stands still, put at the start of a time window, before the IMU's first reading
    in it.
    """
    once = JointSamples(t_ns=T[:1] - NS, angle=np.zeros(1))
    assert told(config(), SensorRecords(**{**dive(), "tray": once}), {}) == []


def test_an_imu_that_was_read_once_is_named():
    imu = dive()["imu"]
    single = ImuSamples(**{f.name: getattr(imu, f.name)[:1] for f in fields(imu)})
    found = told(config(), SensorRecords(pressure=dive()["pressure"], imu=single), {})
    assert found == ["the IMU gave a single reading, which tells no attitude"]


def test_a_camera_that_looks_away_from_the_dvl_is_named():
    cameras = Cameras(top=CameraTop(calibration="c", mount=(0, 0, 0, 0, 0, 0)))
    assert "looks 90 degrees away" in told(config(camera=cameras), SensorRecords(), {})[0]


@pytest.mark.parametrize(("metres", "shown"), [(100.0, "100.000 m"), (0.0, "0.000 m"), (0.1, None)])
def test_a_baseline_in_millimetres_or_of_nothing_is_named(metres, shown):
    bottom = CameraBottom(calibration="c", pose_in_top=(0, metres, 0, 0, 0, 0))
    found = told(
        config(
            camera=Cameras(
                top=CameraTop(calibration="c", mount=(0, 0, 0, 90, 0, 90)), bottom=bottom
            )
        ),
        SensorRecords(),
        {},
    )
    assert [line.split(" apart")[0] for line in found] == (
        [f"the cameras are {shown}"] if shown else []
    )


def test_the_first_image_is_told_against_the_first_ping():
    records = dive()
    assert sentences(
        describe_start_offset(SensorRecords(**records), {"camera_top": index(T[2:])})
    ) == ["the first camera image is 0.4 s after the first DVL ping"]
    assert sentences(
        describe_start_offset(SensorRecords(**records), {"camera_top": index(T - NS)})
    ) == ["the first camera image is 1.0 s before the first DVL ping"]
    assert sentences(describe_start_offset(SensorRecords(**records), {})) == []


def test_imu_ending_midway_warns_without_images():
    records = dive()
    imu = records["imu"]
    half = ImuSamples(**{f.name: getattr(imu, f.name)[:50] for f in fields(imu)})
    records["imu"] = half
    (words,) = told(config(), SensorRecords(**records), {})
    assert (
        words
        == "45 % of the DVL's velocities lie where no attitude was read: a run cannot use them"
    )
    assert told(config(), SensorRecords(**records), {"camera_top": index(T)}) == []


def test_dvl_ending_midway_warns_unless_logger_is_on_deck():
    records = dive()
    records["dvl"].velocity[30:] = np.nan
    (words,) = told(config(), SensorRecords(**records), {})
    assert words.startswith(
        "the IMU was read for 14.0 s under water before the first or after the last velocity of "
        "the DVL"
    )
    records["pressure"].depth[30:] = 0.1
    assert not [
        words for words in told(config(), SensorRecords(**records), {}) if "IMU was read" in words
    ]
