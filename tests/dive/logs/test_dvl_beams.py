# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.dive.config.load import load_config
from hullrecon.dive.logs.dvl_beams import (
    A50,
    a50_beams,
    check_beams,
    choose_beams,
    put_ranges_right,
    range_scale_sigma,
    tilted_beams,
    unit,
)
from hullrecon.dive.logs.messages.samples import DVL_TYPES
from hullrecon.dive.logs.samples import DvlSample
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.errors import InputError, UsageError
from hullrecon.findings.finding import sentences
from hullrecon.steps.ingest import ingest_settings, request_of

JANUS = tilted_beams(30.0, (180.0, 0.0, 90.0, -90.0))


def ping(beams=None, instrument="", ranges=(1.0, 2.0, 3.0, 4.0)):
    return DvlSample(0, np.zeros(3), np.nan, np.array(ranges, float), beams, instrument)


def test_a_tilted_beam_leans_from_z_towards_its_azimuth():
    fore, starboard = tilted_beams(30.0, (0.0, 90.0))
    assert fore == pytest.approx([0.5, 0.0, 0.75**0.5])
    assert starboard == pytest.approx([0.0, 0.5, 0.75**0.5])


def test_the_beams_of_an_a50_lie_between_the_axes():
    beams = a50_beams()
    assert np.degrees(np.arccos(beams[:, 2])) == pytest.approx(np.full(4, 22.5))
    assert np.sign(beams[:, :2]).tolist() == [[-1, 1], [-1, -1], [1, -1], [1, 1]]


def test_beams_that_nothing_describes_are_asked_for():
    with pytest.raises(InputError, match="nothing says where the DVL's 4 beams point") as caught:
        choose_beams([ping()], None, 4, [])
    assert caught.value.exit_code == 3
    assert caught.value.where == "dvl.beams"
    for key in ("beams as unit vectors", "beam_angle_deg", "beam_azimuth_deg"):
        assert key in caught.value.remedy


def test_five_beams_that_nothing_describes_are_asked_for():
    with pytest.raises(InputError, match="5 beams"):
        dvl_pings([ping(ranges=[1.0] * 5)], None, 0.003, [])


def test_configured_beams_are_used_for_messages_without_beams():
    notes = []
    assert choose_beams([ping()], 2 * JANUS, 4, notes) == pytest.approx(JANUS)
    assert sentences(notes) == []


def test_beams_of_messages_override_configured_with_a_note():
    notes = []
    turned = tilted_beams(25.0, (180.0, 0.0, 90.0, -90.0))
    assert choose_beams([ping(JANUS)], turned, 4, notes) == pytest.approx(JANUS)
    assert sentences(notes) == [
        "dvl: the beams of dive.toml are up to 5.0 degrees off those of the messages, which were "
        "used"
    ]


def test_beams_that_agree_with_the_messages_are_not_remarked():
    notes = []
    choose_beams([ping(JANUS)], JANUS, 4, notes)
    assert sentences(notes) == []


def test_configured_beams_override_those_of_instrument_type():
    assert choose_beams([ping(a50_beams(), A50)], JANUS, 4, []) == pytest.approx(JANUS)


def test_beams_of_instrument_type_are_used_last_with_a_note():
    notes = []
    assert choose_beams([ping(a50_beams(), A50)], None, 4, notes) == pytest.approx(a50_beams())
    assert sentences(notes) == [
        "dvl: the messages have no beam directions; those of a Water Linked A50 were used"
    ]


def test_a_dvl_without_ranges_needs_no_beams():
    assert choose_beams([ping(ranges=())], None, 0, []).shape == (0, 3)


def test_dvl_without_any_range_needs_no_beams_with_a_note():
    notes = []
    pings = dvl_pings([ping(ranges=[np.nan, 0.0, -1.0, np.nan])], None, 0.003, notes)
    assert pings.ranges.shape == (1, 0)
    assert pings.beams.shape == (0, 3)
    assert sentences(notes) == ["dvl: every range is lost; it measures no distance to the hull"]


def test_another_number_of_beams_than_the_log_has_is_refused():
    with pytest.raises(InputError, match="describes 3 beams, the log has 4"):
        choose_beams([ping(JANUS)], JANUS[:3], 4, [])


def water_linked(beams: int):
    reports = [SimpleNamespace(id=i, valid=True, distance=1.0 + i) for i in range(beams)]
    velocity = SimpleNamespace(x=0.1, y=0.2, z=0.3)
    return SimpleNamespace(
        velocity_valid=True, beams=reports, fom=0.01, altitude=1.0, velocity=velocity
    )


@pytest.mark.parametrize("kind", ["waterlinked_a50_ros_driver/msg/DVL", "dvl_msgs/msg/DVL"])
def test_the_reports_of_an_a50_carry_its_beams_by_their_type(kind):
    (sample,) = DVL_TYPES[kind](water_linked(4), 0, "dvl")
    assert sample.beams == pytest.approx(a50_beams())
    assert sample.instrument == "Water Linked A50"


def test_a_report_of_another_number_of_beams_is_none_of_an_a50():
    (sample,) = DVL_TYPES["dvl_msgs/msg/DVL"](water_linked(3), 0, "dvl")
    assert sample.beams is None
    assert sample.instrument == ""


def test_vectors_are_brought_to_length_one():
    assert unit(np.array([[0.0, 3.0, 4.0]])) == pytest.approx(np.array([[0.0, 0.6, 0.8]]))


def beams_of(package, *overrides):
    loaded = load_config(package, {}, overrides)
    return request_of(ingest_settings(loaded)).beams


def test_the_configuration_gives_beams_by_angle_and_azimuth(package):
    found = beams_of(package, "dvl.beam_angle_deg=30", "dvl.beam_azimuth_deg=[180, 0, 90, -90]")
    assert found == pytest.approx(JANUS)
    assert beams_of(package) is None


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["dvl.beam_angle_deg=30"], "dvl.beam_angle_deg without dvl.beam_azimuth_deg"),
        (["dvl.beam_azimuth_deg=[0, 90]"], "dvl.beam_azimuth_deg without dvl.beam_angle_deg"),
        (
            ["dvl.beam_angle_deg=30", "dvl.beam_azimuth_deg=[0]", "dvl.beams=[[0, 0, 1]]"],
            "are both given",
        ),
        (["dvl.beam_angle_deg=0", "dvl.beam_azimuth_deg=[0]"], "beam_angle_deg = 0"),
        (["dvl.beam_angle_deg=90", "dvl.beam_azimuth_deg=[0]"], "beam_angle_deg = 90"),
        (["dvl.beam_angle_deg=30", "dvl.beam_azimuth_deg=[400]"], "400"),
        (["dvl.beam_angle_deg=30", "dvl.beam_azimuth_deg=[]"], "beam_azimuth_deg"),
    ],
)
def test_senseless_beams_are_refused(package, overrides, message):
    with pytest.raises(UsageError, match=message):
        load_config(package, {}, overrides)


def pings(beams, altitude, count=12, stand_off=2.0):
    """Ranges of a DVL that looks squarely at a plane, and the altitude that it says."""
    ranges = np.tile(stand_off / beams[:, 2], (count, 1))
    return ranges, np.full(count, altitude)


def test_beams_that_contradict_the_altitude_are_named():
    truth, guess = a50_beams(), tilted_beams(30.0, (0, 90, 180, -90))
    ranges, altitude = pings(truth, 2.0)
    assert sentences(check_beams(truth, ranges, altitude)) == []
    (line,) = sentences(check_beams(guess, ranges, altitude))
    assert "6 % shorter than the altitude" in line
    assert sentences(check_beams(guess, ranges[:5], altitude[:5])) == []  # too few to say
    assert sentences(check_beams(guess, ranges, np.full(12, np.nan))) == []


def test_beams_that_stand_far_off_or_lean_to_one_side_are_named():
    nothing = np.zeros((0, 4)), np.zeros(0)
    assert (
        "up to 67 degrees off"
        in sentences(check_beams(tilted_beams(67.0, (0, 90, 180, -90)), *nothing))[0]
    )
    assert "up to 158 degrees off" in sentences(check_beams(a50_beams() * [1, 1, -1], *nothing))[0]
    assert (
        "mean direction is 16 degrees off"
        in sentences(check_beams(tilted_beams(30.0, (0, 0, 90, -90)), *nothing))[0]
    )
    assert sentences(check_beams(tilted_beams(30.0, (0, 90, 180, -90)), *nothing)) == []


@pytest.mark.parametrize("factor", [0.7, 0.85, 1.2])
def test_ranges_that_no_beams_reconcile_with_the_altitude_are_refused(factor):
    ranges, altitude = pings(a50_beams(), 2.0)
    with pytest.raises(InputError, match=f"ranges reach {factor:.2f} times the altitude"):
        put_ranges_right(a50_beams(), factor * ranges, altitude)


def test_an_altitude_that_stands_still_says_nothing_of_the_ranges():
    ranges, altitude = pings(a50_beams(), 2.0)
    ranges = 1.3 * ranges * np.linspace(1, 1.1, len(ranges))[:, None]
    assert put_ranges_right(a50_beams(), ranges, altitude) == (ranges, [])
    assert check_beams(a50_beams(), ranges, altitude) == []


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("ft", 0.3048)])
def test_ranges_in_another_unit_than_the_altitude_are_put_right(unit, metres):
    ranges, altitude = pings(a50_beams(), 2.0)
    found, findings = put_ranges_right(a50_beams(), ranges / metres, altitude)
    np.testing.assert_allclose(found, ranges)
    assert findings[0].values == {"unit": unit}


@pytest.mark.parametrize("beams", [a50_beams(), JANUS])
def test_vertical_distances_become_ranges_along_their_beams(beams):
    ranges, altitude = pings(beams, 2.0)
    rough = ranges * np.random.default_rng(1).normal(1, 0.01, ranges.shape)
    found, findings = put_ranges_right(beams, rough * beams[:, 2], altitude)
    np.testing.assert_allclose(found, rough)
    assert [one.code for one in findings] == ["ranges-along-axis"]


@pytest.mark.parametrize("guess", [tilted_beams(30.0, (0, 90, 180, -90)), a50_beams()])
def test_ranges_stay_where_beams_are_guessed_or_no_altitude_tells(guess):
    ranges, altitude = pings(a50_beams(), 2.0)
    assert put_ranges_right(guess, ranges, altitude)[0] is ranges
    assert put_ranges_right(guess, ranges * 0.924, np.full(12, np.nan))[1] == []


@pytest.mark.parametrize(
    ("factor", "by_hand", "sigma", "said"),
    [(1.0, True, 0.0, []), (1.08, True, 0.08, []), (np.nan, False, 0.0, [])],
)
def test_ranges_are_as_sure_as_their_altitude(factor, by_hand, sigma, said):
    """A contradicted altitude leaves the scale of all ranges open by as much."""
    ranges = np.full((12, 4), 1.5) / a50_beams()[:, 2]
    altitude = np.full(12, 1.5)
    found = range_scale_sigma(a50_beams(), ranges * factor, altitude, by_hand)
    assert found == (pytest.approx(sigma), said)


def test_ranges_of_a_table_without_altitude_are_unconfirmed():
    ranges = np.full((12, 4), 1.5)
    sigma, (note,) = range_scale_sigma(a50_beams(), ranges, np.full(12, np.nan), by_hand=True)
    vertical = 1 / np.cos(np.radians(22.5)) - 1
    assert vertical == pytest.approx(1.96 * sigma)  # the end of an interval of 95 %
    assert note.severity == "note"
    assert "column altitude" in note.sentence


def test_beams_into_the_instrument_are_asked_for():
    inward = [ping(JANUS * [1, 1, -1])]
    with pytest.raises(InputError, match="point into the instrument") as caught:
        choose_beams(inward, None, 4, [])
    assert caught.value.where == "dvl.beams"
    assert choose_beams(inward, JANUS, 4, []) == pytest.approx(JANUS)
