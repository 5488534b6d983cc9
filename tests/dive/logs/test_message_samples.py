# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from hullrecon.dive.logs.dvl_beams import A50, a50_beams
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.messages.samples import TYPES, stamp_ns
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import DamagedError

T = 1_777_887_000_123_456_789


def translate(sensor: str, kind: str, message):
    return TYPES[sensor][kind](message, T, sensor)


def dvl(message):
    (ping,) = translate("dvl", "marine_acoustic_msgs/msg/Dvl", message)
    return ping


def test_a_stamp_keeps_its_nanoseconds(kit):
    assert stamp_ns(kit.header(T)) == T


def test_a_ping_has_velocity_sigma_ranges_and_beams(kit):
    ping = dvl(kit.dvl(T))
    assert ping.velocity.tolist() == [0.1, 0.2, 0.3]
    assert ping.sigma == pytest.approx(0.002)
    assert ping.ranges.tolist() == [1, 2, 3, 4]
    assert ping.beams[1] == pytest.approx([0.5, 0, np.sqrt(0.75)])


def test_a_beam_is_lost_by_its_range_or_by_its_covariance(kit):
    ranges = np.array([0.0, -1.0, np.nan, 4.0])
    assert np.isnan(dvl(kit.dvl(T, range=ranges)).ranges).tolist() == [True, True, True, False]
    covariance = np.array([0, -1, 0, 0], np.float32)
    assert np.isnan(dvl(kit.dvl(T, range_covar=covariance)).ranges).tolist() == [
        False,
        True,
        False,
        False,
    ]
    assert np.isnan(dvl(kit.dvl(T, beam_ranges_valid=False)).ranges).all()


def test_velocity_is_lost_by_covariance_or_water_mode(kit):
    lost = np.zeros(9)
    lost[0] = -1
    assert np.isnan(dvl(kit.dvl(T, velocity_covar=lost)).velocity).all()
    of_the_water = dvl(kit.dvl(T, velocity_mode=2))
    assert np.isnan(of_the_water.velocity).all()
    assert of_the_water.not_over_ground == "relative to the water"


def test_a_covariance_of_zero_says_nothing(kit):
    assert np.isnan(dvl(kit.dvl(T, velocity_covar=np.zeros(9))).sigma)


def test_beam_vectors_that_are_not_filled_in_are_not_taken(kit):
    assert dvl(kit.dvl(T, beam_unit_vec=[kit.vector(0, 0, 0)] * 4)).beams is None


def test_a_twist_is_a_ping_without_ranges(kit):
    covariance = np.zeros(36)
    covariance[[0, 7, 14]] = 0.0004
    twist = kit.make(
        "geometry_msgs/msg/Twist", linear=kit.vector(1, 2, 3), angular=kit.vector(0, 0, 0)
    )
    inner = kit.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance)
    message = kit.make(
        "geometry_msgs/msg/TwistWithCovarianceStamped", header=kit.header(T), twist=inner
    )
    (ping,) = translate("dvl", "geometry_msgs/msg/TwistWithCovarianceStamped", message)
    assert ping.velocity.tolist() == [1, 2, 3]
    assert ping.sigma == pytest.approx(0.02)
    assert ping.ranges.shape == (0,)
    plain = kit.make("geometry_msgs/msg/TwistStamped", header=kit.header(T), twist=twist)
    (ping,) = translate("dvl", "geometry_msgs/msg/TwistStamped", plain)
    assert ping.velocity.tolist() == [1, 2, 3]


def test_a_water_linked_report_drops_what_it_calls_invalid(kit):
    kind = "waterlinked_a50_ros_driver/msg/"
    beams = [
        kit.make(
            f"{kind}DVLBeam", id=i, velocity=0.0, distance=1.0 + i, rssi=0.0, nsd=0.0, valid=i != 2
        )
        for i in (1, 0, 2, 3)
    ]
    given = {
        "header": kit.header(T),
        "time": 0.0,
        "fom": 0.01,
        "altitude": 1.0,
        "beams": beams,
        "status": 0,
        "form": "",
    }
    message = kit.make(f"{kind}DVL", velocity=kit.vector(1, 2, 3), velocity_valid=True, **given)
    (ping,) = translate("dvl", f"{kind}DVL", message)
    np.testing.assert_array_equal(ping.ranges, [1, 2, np.nan, 4])
    assert ping.sigma == 0.01
    message = kit.make(f"{kind}DVL", velocity=kit.vector(1, 2, 3), velocity_valid=False, **given)
    assert np.isnan(translate("dvl", f"{kind}DVL", message)[0].velocity).all()


def test_what_an_imu_says_it_does_not_measure_is_nan(kit):
    absent = np.zeros(9)
    absent[0] = -1
    (sample,) = translate(
        "imu", "sensor_msgs/msg/Imu", kit.imu(T, linear_acceleration_covariance=absent)
    )
    assert np.isnan(sample.acceleration).all()
    assert sample.rates.tolist() == [0.1, 0.2, 0.3]
    (sample,) = translate("imu", "sensor_msgs/msg/Imu", kit.imu(T, orientation_covariance=absent))
    assert np.isnan(sample.quaternion).all()


def test_positions_that_no_joint_s_name_stands_beside_are_damaged(kit):
    with pytest.raises(DamagedError, match="name no joint"):
        translate("joints", "sensor_msgs/msg/JointState", kit.joints(T, [], [0.5]))


def test_every_joint_of_a_message_is_a_sample(kit):
    samples = translate(
        "joints", "sensor_msgs/msg/JointState", kit.joints(T, ["a", "b"], [0.5, 0.25])
    )
    assert [(s.name, s.angle) for s in samples] == [("a", 0.5), ("b", 0.25)]


def test_sonar_pixel_index_is_range_times_beams_plus_beam(kit):
    pixels = np.arange(6, dtype=np.uint8).reshape(3, 2)  # [ranges, beams]
    (ping,) = translate(
        "sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage", kit.sonar(T, pixels)
    )
    assert ping.image.tolist() == [[0, 2, 4], [1, 3, 5]]
    assert ping.range_m.tolist() == [1, 2, 3]
    assert np.linalg.norm(ping.directions, axis=1) == pytest.approx([1, 1])


def test_sonar_pixels_of_other_types_keep_their_values(kit):
    pixels = np.arange(6, dtype="<f4").reshape(3, 2) * 100
    (ping,) = translate(
        "sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage", kit.sonar(T, pixels, dtype=8)
    )
    assert ping.image.tolist() == [[0, 200, 400], [100, 300, 500]]


def test_sonar_image_too_short_or_of_unknown_type_is_damaged(kit):
    pixels = np.zeros((2, 2), np.uint8)
    with pytest.raises(DamagedError, match="4 pixels for 2 beams and 3 ranges"):
        translate("sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage", kit.sonar(T, pixels))
    with pytest.raises(DamagedError, match="data type 77"):
        translate(
            "sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage", kit.sonar(T, pixels, dtype=77)
        )


def raw(kit, pixels: np.ndarray, encoding: str, **more):
    given = {
        "header": kit.header(T),
        "height": pixels.shape[0],
        "width": pixels.shape[1],
        "encoding": encoding,
        "is_bigendian": 0,
        "step": pixels.nbytes // pixels.shape[0],
        "data": np.frombuffer(pixels.tobytes(), np.uint8),
        **more,
    }
    return kit.make("sensor_msgs/msg/Image", **given)


def picture(kit, *arguments, **more) -> np.ndarray:
    (sample,) = translate("camera_top", "sensor_msgs/msg/Image", raw(kit, *arguments, **more))
    return cv2.imdecode(np.frombuffer(sample.encoded, np.uint8), cv2.IMREAD_UNCHANGED)


COLORS = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)


@pytest.mark.parametrize(("encoding", "order"), [("bgr8", [0, 1, 2]), ("rgb8", [2, 1, 0])])
def test_a_raw_color_image_becomes_a_png_without_loss(kit, encoding, order):
    np.testing.assert_array_equal(picture(kit, COLORS, encoding), COLORS[:, :, order])


def test_a_raw_gray_image_keeps_its_pixels_and_loses_its_padding(kit):
    padded = np.arange(16, dtype=np.uint8).reshape(2, 8)
    np.testing.assert_array_equal(picture(kit, padded, "mono8", width=5), padded[:, :5])


@pytest.mark.parametrize("encoding", ["mono16", "16UC1"])
def test_sixteen_bits_keep_their_values_in_either_byte_order(kit, encoding):
    pixels = np.array([[0x1234, 0xFF00, 0x03FF]])
    for order, is_bigendian in (("<u2", 0), (">u2", 1)):
        read = picture(kit, pixels.astype(order), encoding, is_bigendian=is_bigendian)
        np.testing.assert_array_equal(read, pixels)
        assert read.dtype == np.uint16


@pytest.mark.parametrize("encoding", ["bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"])
def test_a_bayer_image_of_one_gray_is_that_gray_in_color(kit, encoding):
    np.testing.assert_array_equal(
        picture(kit, np.full((4, 6), 90, np.uint8), encoding), np.full((4, 6, 3), 90)
    )


def test_a_red_bayer_mosaic_is_red(kit):
    pixels = np.zeros((6, 6), np.uint8)
    pixels[0::2, 0::2] = 200  # red sites of rggb
    found = picture(kit, pixels, "bayer_rggb8").reshape(-1, 3).mean(axis=0)
    assert found[2] > 100
    assert max(found[0], found[1]) < 50


@pytest.mark.parametrize("step", [0, 4, 16, 400])
def test_a_step_that_is_not_filled_in_is_that_of_rows_without_padding(kit, step):
    np.testing.assert_array_equal(picture(kit, COLORS, "bgr8", step=step), COLORS)


@pytest.mark.parametrize(("encoding", "order"), [("bgr16", [0, 1, 2]), ("rgb16", [2, 1, 0])])
def test_colours_of_sixteen_bits_keep_their_values(kit, encoding, order):
    deep = COLORS.astype("<u2") * 1000
    np.testing.assert_array_equal(picture(kit, deep, encoding), deep[:, :, order])


def test_a_bayer_mosaic_of_sixteen_bits_is_one_of_eight_bits(kit):
    mosaic = np.random.default_rng(1).integers(0, 256, (6, 8)).astype(np.uint8)
    deep = picture(kit, mosaic.astype("<u2") * 256, "bayer_grbg16")
    assert np.abs(deep / 256 - picture(kit, mosaic, "bayer_grbg8")).max() < 1


@pytest.mark.parametrize("encoding", ["mono16", "bayer_rggb16"])
@pytest.mark.parametrize(("stored", "flag"), [(">u2", 0), ("<u2", 1)])
def test_bytes_in_another_order_than_stated_are_named(kit, stored, flag, encoding):
    smooth = 600 * np.outer(np.linspace(1, 3, 80), np.linspace(1, 2, 120))
    if encoding != "mono16":  # neighbours are of other colours
        smooth[::2, 1::2] *= 4
        smooth[1::2] *= 3
    smooth = smooth.astype(stored)
    assert picture(kit, smooth, encoding, is_bigendian=1 - flag).max() < 20_000
    message = raw(kit, smooth, encoding, is_bigendian=flag)
    with pytest.raises(DamagedError, match=f"is_bigendian = {flag}"):
        translate("camera_top", "sensor_msgs/msg/Image", message)


@pytest.mark.parametrize("more", [{"height": 9}, {"step": 2, "height": 3}, {"width": 0}])
def test_a_raw_image_whose_pixels_are_not_there_is_damaged(kit, more):
    message = raw(kit, COLORS, "bgr8", **more)
    with pytest.raises(DamagedError, match="pixels"):
        translate("camera_top", "sensor_msgs/msg/Image", message)


def test_a_raw_image_in_an_unknown_encoding_is_damaged(kit):
    with pytest.raises(DamagedError, match="'hsv'"):
        translate("camera_top", "sensor_msgs/msg/Image", raw(kit, COLORS, "hsv"))


def test_a_type_without_a_definition_is_read_by_the_bundled_one(kit):
    kind = "marine_acoustic_msgs/msg/Dvl"
    data = bytes(kit.stores[2].serialize_cdr(kit.dvl(T), kind))
    assert decode(Channel("/dvl", kind, "cdr"), data).range[0] == 1.0
    assert decode(Channel("/dvl", "marine_acoustic_msgs/Dvl", "cdr"), data).range[0] == 1.0


@pytest.mark.parametrize(
    "channel",
    [
        Channel("/x", "sensor_msgs/msg/Imu", "protobuf"),
        Channel("/x", "sensor_msgs/msg/Imu", "cdr", "this is no definition ((("),
        Channel("/x", "sensor_msgs/msg/Imu", "cdr", "struct {", "ros2idl"),
        Channel("/x", "sensor_msgs/msg/Imu", "cdr"),
        Channel("/x", "sensor_msgs/msg/Imu", "ros1"),
    ],
)
def test_what_cannot_be_decoded_is_damaged_and_nothing_else(channel):
    with pytest.raises(DamagedError):
        decode(channel, b"\x00\x01\x00\x00short")


def test_a_type_without_a_definition_is_named_as_such():
    with pytest.raises(DamagedError, match="the log has no definition of their type"):
        decode(Channel("/x", "nobody/msg/Knows", "cdr"), b"")


VENDOR = {
    "vendor/msg/Beam": "float64 range\nfloat64 range_covariance\n",
    "stonefish_ros/msg/DVL": "std_msgs/Header header\ngeometry_msgs/Vector3 velocity\nfloat64[9] "
    "velocity_covariance\n"
    "float64 altitude\nvendor/Beam[] beams\n",
    "nortek_dvl/msg/Dvl": "std_msgs/Header header\ngeometry_msgs/Vector3 velocity\nfloat64 "
    "figureOfMerit\n"
    "float64[4] beamDistance\n",
}


@pytest.fixture(scope="module")
def vendors(kit):
    from rosbags.typesys import get_types_from_msg

    for name, text in VENDOR.items():
        kit.stores[2].register(get_types_from_msg(text, name))
    return kit


def test_a_simulators_ping_has_the_ranges_of_its_beams(vendors):
    beams = [
        vendors.make("vendor/msg/Beam", range=r, range_covariance=c)
        for r, c in ((1.0, 0.0), (2.0, -1.0), (0.0, 0.0), (4.0, 0.1))
    ]
    covariance = np.diag([1e-4] * 3).ravel()
    message = vendors.make(
        "stonefish_ros/msg/DVL",
        header=vendors.header(T),
        velocity=vendors.vector(1, 2, 3),
        velocity_covariance=covariance,
        altitude=1.0,
        beams=beams,
    )
    (ping,) = translate("dvl", "stonefish_ros/msg/DVL", message)
    np.testing.assert_array_equal(ping.ranges, [1, np.nan, np.nan, 4])
    assert ping.sigma == pytest.approx(0.01)
    assert ping.velocity.tolist() == [1, 2, 3]


def test_a_ping_of_cola2_has_the_ranges_of_its_beams_if_it_has_any():
    beams = [
        SimpleNamespace(range=r, range_covariance=c) for r, c in ((1.5, 0.0), (-1.0, 0.0), (2, -1))
    ]
    given = {"velocity": SimpleNamespace(x=1, y=2, z=3), "velocity_covariance": np.zeros(9)}
    (ping,) = translate("dvl", "cola2_msgs/msg/DVL", SimpleNamespace(**given, beams=beams))
    np.testing.assert_array_equal(ping.ranges, [1.5, np.nan, np.nan])
    (old,) = translate("dvl", "cola2_msgs/msg/DVL", SimpleNamespace(**given))
    assert old.velocity.tolist() == [1, 2, 3]
    assert not len(old.ranges)


@pytest.mark.parametrize(
    ("velocity", "merit", "lost"),
    [(0.5, 0.01, False), (0.5, 2.0, False), (-32.768, 0.01, True), (0.5, 10.0, True)],
)
def test_nortek_ping_is_lost_by_velocity_or_figure_of_merit(vendors, velocity, merit, lost):
    message = vendors.make(
        "nortek_dvl/msg/Dvl",
        header=vendors.header(T),
        velocity=vendors.vector(velocity, 0, 0),
        figureOfMerit=merit,
        beamDistance=np.array([1.0, 0.0, 3.0, 4.0]),
    )
    (ping,) = translate("dvl", "nortek_dvl/msg/Dvl", message)
    assert np.isnan(ping.velocity).all() == lost
    assert ping.sigma == pytest.approx(np.nan if lost else merit, nan_ok=True)
    np.testing.assert_array_equal(ping.ranges, [1, np.nan, 3, 4])


def transducers(valid=(True, True, True, True)):
    return [
        SimpleNamespace(
            id=i, velocity=0.0, distance=1.0 + i, rssi=0.0, nsd=0.0, beam_valid=valid[i]
        )
        for i in (3, 2, 1, 0)
    ]


def report(**more):
    given = {
        "vx": 0.1,
        "vy": 0.2,
        "vz": 0.3,
        "fom": 0.004,
        "altitude": 0.9,
        "transducers": transducers(),
        "velocity_valid": True,
        "status": 0,
        "format": "json_v3",
    }
    return SimpleNamespace(report=SimpleNamespace(**{**given, **more}))


def test_water_linked_velocity_of_large_merit_figure_is_lost():
    kind = "waterlinked_a50/msg/TransducerReportStamped"
    good, bad = (translate("dvl", kind, report(fom=merit))[0] for merit in (0.39, 0.41))
    assert (good.velocity[0], good.sigma) == (0.1, 0.39)
    assert np.isnan(bad.velocity).all()
    assert np.isnan(bad.sigma)
    assert bad.ranges.tolist() == [1, 2, 3, 4]


def test_only_a50_transducer_report_has_known_beams():
    (ping,) = translate("dvl", "waterlinked_a50/msg/TransducerReportStamped", report())
    assert ping.velocity.tolist() == [0.1, 0.2, 0.3]
    assert ping.ranges.tolist() == [1, 2, 3, 4]
    assert (ping.sigma, ping.altitude, ping.instrument) == (0.004, 0.9, A50)
    np.testing.assert_allclose(ping.beams, a50_beams())
    (ping,) = translate(
        "dvl", "waterlinked_dvl/msg/TransducerReportStamped", report(velocity_valid=False)
    )
    assert (ping.beams, ping.instrument) == (None, "")
    assert np.isnan(ping.velocity).all()
    assert np.isnan(ping.altitude)


def test_a_lost_transducer_is_a_lost_range():
    lost = report(transducers=transducers((True, False, True, True)))
    (ping,) = translate("dvl", "waterlinked_a50/msg/TransducerReportStamped", lost)
    assert np.isnan(ping.ranges).tolist() == [False, True, False, False]


def deep_submergence(kit, **more):
    s, c = 0.5, 0.75**0.5
    given = {
        "velocity": kit.vector(0.1, 0.2, 0.3),
        "velocity_covar": np.diag([4e-6] * 3).ravel(),
        "altitude": 2.5,
        "velocity_mode": 1,
        "coordinate_mode": 1,
        "beam_unit_vec": [kit.vector(*b) for b in ((-s, 0, c), (s, 0, c), (0, s, c), (0, -s, c))],
        "range": np.array([1.0, 2.0, 3.0, 4.0]),
        "range_covar": np.array([0, -1, 0, 0], np.float32),
    }
    return SimpleNamespace(**{**given, **more})


def test_a_dvl_of_the_deep_submergence_laboratory_is_read(kit):
    kind = "ds_sensor_msgs/msg/Dvl"
    (ping,) = translate("dvl", kind, deep_submergence(kit))
    assert ping.velocity.tolist() == [0.1, 0.2, 0.3]
    assert ping.sigma == pytest.approx(0.002)
    np.testing.assert_array_equal(ping.ranges, [1, np.nan, 3, 4])
    assert ping.beams[1] == pytest.approx([0.5, 0, np.sqrt(0.75)])
    assert np.isnan(ping.altitude)  # there it is the mean of the ranges
    for lost in (
        {"coordinate_mode": 3},
        {"velocity_mode": 2},
        {"velocity_covar": np.full(9, -1.0)},
    ):
        (ping,) = translate("dvl", kind, deep_submergence(kit, **lost))
        assert np.isnan(ping.velocity).all()
        assert bool(ping.not_over_ground) == ("velocity_covar" not in lost)


def test_the_altitude_of_a_ping_is_kept_where_it_is_one(kit):
    assert dvl(kit.dvl(T, altitude=1.0)).altitude == 1.0
    assert np.isnan(dvl(kit.dvl(T, altitude=-1.0)).altitude)


def sonar_image(kit, pixels, **more):
    given = {
        "header": kit.header(T),
        "frequency": 1e6,
        "sound_speed": 1500.0,
        "azimuth_beamwidth": 0.01,
        "elevation_beamwidth": 0.2,
        "azimuth_angles": np.array([-0.2, 0.2], np.float32),
        "elevation_angles": np.zeros(0, np.float32),
        "ranges": np.array([1.0, 2.0, 3.0], np.float32),
        "is_bigendian": False,
        "data_size": pixels.itemsize,
        "intensities": np.frombuffer(pixels.tobytes(), np.uint8),
    }
    return kit.make("acoustic_msgs/msg/SonarImage", **{**given, **more})


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_sonar_image_of_the_older_type_is_read_range_by_range(kit, kind):
    pixels = np.arange(6, dtype=kind).reshape(3, 2)  # [ranges, beams]
    (ping,) = translate("sonar", "acoustic_msgs/msg/SonarImage", sonar_image(kit, pixels))
    np.testing.assert_array_equal(ping.image, pixels.T)
    np.testing.assert_allclose(ping.directions[0], [0, np.sin(-0.2), np.cos(0.2)], atol=1e-7)
    assert ping.range_m.tolist() == [1, 2, 3]
    with pytest.raises(DamagedError, match="for 2 beams and 3 ranges"):
        translate("sonar", "acoustic_msgs/msg/SonarImage", sonar_image(kit, pixels[:2]))
    with pytest.raises(DamagedError, match="3 bytes a pixel"):
        translate("sonar", "acoustic_msgs/msg/SonarImage", sonar_image(kit, pixels, data_size=3))


def oculus(pixels, gains=False, **more):
    """oculus_interfaces/Ping; pixels [ranges, beams] of 8 bits."""
    rows = [(b"\x09\0\0\0" if gains else b"") + row.tobytes() for row in pixels]
    given = {
        "range_resolution": 0.5,
        "has_gains": gains,
        "n_ranges": len(pixels),
        "n_beams": pixels.shape[1],
        "step": len(rows[0]),
        "sample_size": 1,
        "bearings": np.array([-3000, 0, 3000], np.int16),
        "ping_data": np.frombuffer(b"".join(rows), np.uint8),
    }
    return SimpleNamespace(**{**given, **more})


@pytest.mark.parametrize("gains", [False, True])
def test_an_oculus_ping_is_read_without_the_gains_of_its_rows(gains):
    pixels = np.arange(12, dtype=np.uint8).reshape(4, 3)
    (ping,) = translate("sonar", "oculus_interfaces/msg/Ping", oculus(pixels, gains))
    np.testing.assert_array_equal(ping.image, pixels.T)
    np.testing.assert_allclose(ping.directions[2], [0, 0.5, np.sqrt(0.75)])
    assert ping.range_m.tolist() == [0.25, 0.75, 1.25, 1.75]
    for wrong in (
        {"n_ranges": 5},
        {"step": 2},
        {"sample_size": 3},
        {"bearings": np.zeros(2, np.int16)},
        {"n_beams": 0},
    ):
        with pytest.raises(DamagedError):
            translate("sonar", "oculus_interfaces/msg/Ping", oculus(pixels, gains, **wrong))


def test_what_an_oculus_sent_byte_by_byte_is_read_from_a_message(data):
    content = (data / "oculus-pings" / "one_ping_8bit.raw").read_bytes()
    (ping,) = translate(
        "sonar", "oculus_sonar_driver/msg/OculusSonarRawMsg", SimpleNamespace(data=content)
    )
    assert ping.image.shape == (256, 703)
    assert np.degrees(
        np.arctan2(ping.directions[[0, -1], 1], ping.directions[[0, -1], 2])
    ) == pytest.approx([-30, 30])


def compressed(kit, form, data):
    message = kit.make(
        "sensor_msgs/msg/CompressedImage",
        header=kit.header(T),
        format=form,
        data=np.frombuffer(data, np.uint8),
    )
    (sample,) = translate("camera_top", "sensor_msgs/msg/CompressedImage", message)
    return sample.encoded


def test_a_compressed_mosaic_becomes_a_picture_in_colour(kit):
    red = np.zeros((8, 8), np.uint8)
    red[::2, ::2] = 200
    data = cv2.imencode(".png", red)[1].tobytes()
    found = cv2.imdecode(
        np.frombuffer(compressed(kit, "bayer_rggb8; png compressed ", data), np.uint8),
        cv2.IMREAD_COLOR,
    )
    assert found[2:6, 2:6, 2].min() > 150
    assert found[2:6, 2:6, :2].max() == 0
    for form in ("png", "bayer_rggb8; jpeg compressed bgr8", "bgr8; png compressed bgr8", ""):
        assert compressed(kit, form, data) == data


@pytest.mark.parametrize("form", ["16UC1; compressedDepth png", "h264", "32FC1; compressedDepth"])
def test_what_is_compressed_but_no_picture_is_refused_by_its_format(kit, form):
    with pytest.raises(DamagedError, match=f"format '{form}'"):
        compressed(kit, form, b"")
