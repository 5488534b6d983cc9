# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses

import numpy as np
import pytest

from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.dive.logs.sonar_geometry import image_in_ranges, pings_of_one_window
from hullrecon.dive.logs.streams.sonar import sonar_pings
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding, sentences

BEAMS = 3
AZIMUTH_DEG = np.array([-10.0, 1.0, 9.0])


def ping(t, last=5.0, bins=50, first=None, *, known=True):
    """A ping whose pixel is the number of its range bin."""
    range_m = np.linspace(last / bins if first is None else first, last, bins)
    directions = in_fan(np.radians(AZIMUTH_DEG)) if known else None
    return SonarSample(t, np.tile(np.arange(bins, dtype=np.uint8), (BEAMS, 1)), directions, range_m)


def test_pings_of_other_sound_speeds_are_put_on_same_ranges():
    notes: list[Finding] = []
    found = sonar_pings([ping(0), ping(1), ping(2, 5.02), ping(3, 4.98)], notes)
    np.testing.assert_array_equal(found.range_m, ping(0).range_m)
    np.testing.assert_array_equal(found.image[1, 0], np.arange(50))
    for row, last in ((2, 5.02), (3, 4.98)):
        ranges = np.linspace(last / 50, last, 50)[found.image[row, 0]]
        assert np.abs(ranges - found.range_m).max() <= 0.051  # half a bin
    assert sentences(notes) == [
        "sonar: 2 of 4 pings have ranges that differ by up to 20 mm, as by another speed of sound, "
        "and were put onto one"
    ]


def test_samples_beyond_a_pings_own_ranges_are_dark():
    short = ping(2, 4.98, 500)
    kept, range_m = pings_of_one_window([ping(0, bins=500), ping(1, bins=500), short], [])
    assert kept[2] is short
    image = image_in_ranges(short, range_m)
    assert not image[:, -1].any()
    assert image[0, -3] == short.image[0, -1]


def test_a_window_that_was_set_anew_is_left_out_and_counted():
    notes: list[Finding] = []
    samples = [ping(0), ping(1), ping(2, 5.0, first=2.0), ping(3, 8.0), ping(4, bins=40)]
    assert [s.t_ns for s in pings_of_one_window(samples, notes)[0]] == [0, 1]
    assert sentences(notes) == [
        "sonar: 3 of 5 pings have another range or number of beams than 3 beams to 5.0 m and were "
        "left out"
    ]


def test_of_two_windows_with_as_many_pings_the_first_stays():
    assert [
        s.t_ns for s in pings_of_one_window([ping(0, 8.0), ping(1), ping(2, 8.0), ping(3)], [])[0]
    ] == [0, 2]


def test_pings_of_another_mode_s_fan_are_left_out_and_counted():
    wide = [
        dataclasses.replace(ping(t), directions=in_fan(np.radians(6 * AZIMUTH_DEG))) for t in (0, 2)
    ]
    nearly = dataclasses.replace(ping(5), directions=in_fan(np.radians(AZIMUTH_DEG + 0.1)))
    notes: list[Finding] = []
    found = sonar_pings([wide[0], ping(1), wide[1], ping(3), ping(4), nearly], notes)
    assert found.t_ns.tolist() == [1, 3, 4, 5]
    np.testing.assert_allclose(found.directions, ping(1).directions)
    assert sentences(notes) == [
        "sonar: the beams of 2 of 6 pings point elsewhere, as in another mode of the sonar, than "
        "those of the others; "
        "they were left out"
    ]


def test_pings_whose_directions_were_never_filled_in_are_one_fan():
    empty = [dataclasses.replace(ping(t), directions=np.zeros((BEAMS, 3))) for t in range(3)]
    assert len(pings_of_one_window(empty, [])[0]) == 3


@pytest.mark.parametrize(
    "directions",
    [
        in_fan(AZIMUTH_DEG),  # taken as radians
        np.zeros((BEAMS, 3)),  # never filled in
        in_fan(np.radians(AZIMUTH_DEG))[:, [2, 1, 0]],  # around x
    ],
)
def test_directions_that_are_no_fan_are_asked_for(directions):
    samples = [dataclasses.replace(ping(0), directions=directions)]
    with pytest.raises(InputError, match="are no fan around z"):
        sonar_pings(samples, [])
    healed = sonar_pings(samples, [], AZIMUTH_DEG)
    np.testing.assert_allclose(healed.directions, ping(0).directions)


def test_beams_may_be_listed_from_either_side():
    turned = dataclasses.replace(ping(0), directions=ping(0).directions[::-1])
    np.testing.assert_allclose(sonar_pings([turned], []).directions, turned.directions)


@pytest.mark.parametrize(("unit", "why"), [(1000, "millimetres"), (100, "centi"), (0, "not grow")])
def test_ranges_that_are_no_sonars_are_refused(unit, why):
    samples = [dataclasses.replace(ping(0), range_m=unit * ping(0).range_m)]
    with pytest.raises(InputError, match=f"{why}.*log them in metres, growing"):
        sonar_pings(samples, [])
    assert sonar_pings([ping(0)], []) is not None


def test_ranges_that_are_not_even_are_put_onto_even_ones():
    """The mosaic looks pixels up by an even step."""
    uneven = np.linspace(1.0, 2.0, 50) ** 2
    found = sonar_pings([dataclasses.replace(ping(0), range_m=uneven)], [])
    assert np.diff(found.range_m) == pytest.approx(3 / 49)
    assert np.abs(uneven[found.image[0, 0]] - found.range_m).max() < 0.041  # half a bin


def test_pings_of_one_window_stay_as_they_are():
    samples = [ping(0), ping(1)]
    kept, range_m = pings_of_one_window(samples, [])
    assert all(one is other for one, other in zip(kept, samples, strict=True))
    assert all(image_in_ranges(sample, range_m) is sample.image for sample in samples)
    assert pings_of_one_window([], [])[0] == []


def test_ranges_that_do_not_grow_are_not_interpolated():
    odd = SonarSample(1, np.ones((BEAMS, 3), np.uint8), None, np.array([1.0, 0.5, 5.001]))
    even = SonarSample(0, np.ones((BEAMS, 3), np.uint8), None, np.array([1.0, 0.5, 5.0]))
    kept, range_m = pings_of_one_window([even, even, odd], [])
    assert len(kept) == 3
    assert image_in_ranges(odd, range_m) is odd.image


def test_beams_that_nothing_describes_are_asked_for():
    with pytest.raises(InputError, match="nothing says where the sonar's 3 beams point") as caught:
        sonar_pings([ping(0, known=False)], [])
    assert caught.value.where == "sonar.beam_azimuth_deg"
    assert "growing from port to starboard" in caught.value.remedy
    growing = np.array([-1.0, 0.0, 1.0])
    assert sonar_pings([ping(0, known=False)], [], growing) is not None


def test_beams_of_dive_toml_serve_where_the_log_has_none():
    found = sonar_pings([ping(0, known=False)], [], AZIMUTH_DEG)
    np.testing.assert_allclose(found.directions, in_fan(np.radians(AZIMUTH_DEG)))


def test_beams_of_the_log_come_before_those_of_dive_toml():
    notes: list[Finding] = []
    found = sonar_pings([ping(0)], notes, AZIMUTH_DEG + 1)
    np.testing.assert_allclose(found.directions, in_fan(np.radians(AZIMUTH_DEG)))
    assert sentences(notes) == [
        "sonar: the log says where the beams point; sonar.beam_azimuth_deg was not used"
    ]


@pytest.mark.parametrize("azimuth", [[-1.0, 1.0], [-1.0, 1.0, 0.0]])
def test_angles_that_do_not_fit_the_beams_are_refused(azimuth):
    with pytest.raises(InputError, match="for 3 beams, or they do not grow"):
        sonar_pings([ping(0, known=False)], [], np.array(azimuth))
    growing = np.array([-1.0, 0.0, 1.0])
    assert sonar_pings([ping(0, known=False)], [], growing) is not None
