# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""objects.json and coverage.json as records."""

from __future__ import annotations

import msgspec
import pytest

from hullrecon.records.deliverables import Coverage, ReportedObject

ROW = {
    "id": 3,
    "center": [1, 2.5, 3.0],
    "normal": [0, 1, 0],
    "height": 0.1,
    "height_sigma": 0.004,
    "deviation": None,
    "extent": [0.2, 0.1],
    "area": 0.02,
    "volume": 0.001,
    "views": 7,
    "p_value": 1e-9,
    "address": "frame 3",
    "images": ["a"],
    "outline": [[1, 2, 3], [1, 2, 4]],
}


def test_a_row_of_objects_json_is_a_record() -> None:
    found = msgspec.convert(ROW, ReportedObject)
    assert found.center == (1.0, 2.5, 3.0)
    assert found.deviation is None
    assert found.outline == ((1.0, 2.0, 3.0), (1.0, 2.0, 4.0))
    assert found.images == ("a",)


def test_a_row_goes_back_as_it_came() -> None:
    again = msgspec.json.decode(msgspec.json.encode(msgspec.convert(ROW, ReportedObject)))
    assert again == msgspec.json.decode(msgspec.json.encode(ROW))


def test_members_of_a_later_version_are_passed_over() -> None:
    assert msgspec.convert({**ROW, "along": 3.0}, ReportedObject).id == 3


@pytest.mark.parametrize("missing", ["center", "height"])
def test_a_row_without_centre_or_height_is_refused(missing: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=missing):
        msgspec.convert({k: v for k, v in ROW.items() if k != missing}, ReportedObject)


def test_a_centre_of_two_numbers_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="center"):
        msgspec.convert({**ROW, "center": [1, 2]}, ReportedObject)


def test_a_sensor_that_was_not_carried_is_none() -> None:
    coverage = msgspec.convert(
        {"frame": "M", "camera": {"area_m2": 4.0}, "sonar": None, "holes": []}, Coverage
    )
    assert coverage.sonar is None
    assert coverage.dvl is None
    assert coverage.camera is not None
    assert (coverage.camera.area_m2, coverage.camera.gsd_m) == (4.0, None)
    assert len(coverage.holes) == 0


def test_holes_have_area_and_address() -> None:
    (hole,) = msgspec.convert(
        {"holes": [{"area_m2": 0.2, "address": "frame 3", "sigma_along": 0.3}]}, Coverage
    ).holes
    assert (hole.area_m2, hole.address, hole.sigma_along) == (0.2, "frame 3", 0.3)
