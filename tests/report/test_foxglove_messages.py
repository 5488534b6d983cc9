# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Foxglove's messages and their schemas, one by one."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from end_to_end.json_schema import violations

from hullrecon.report.foxglove import messages


def test_a_time_keeps_its_nanoseconds() -> None:
    assert messages.time(1_777_887_000_468_241_234) == {"sec": 1_777_887_000, "nsec": 468_241_234}


def test_a_clouds_fields_say_where_each_value_lies() -> None:
    columns = {
        "x": np.array([1.5, 2.5], np.float32),
        "y": np.array([0.0, -1.0]),
        "z": np.array([7, 9], np.uint8),
    }
    value = messages.point_cloud(0, "hull", columns)
    assert [(f["name"], f["offset"], f["type"]) for f in value["fields"]] == [
        ("x", 0, 7),
        ("y", 4, 8),
        ("z", 12, 1),
    ]
    assert value["point_stride"] == 13
    data = base64.b64decode(value["data"])
    assert np.frombuffer(data, "<f4", 1, 13)[0] == 2.5
    assert np.frombuffer(data, "<f8", 1, 17)[0] == -1.0
    assert data[12] == 7
    assert violations(value, messages.POINT_CLOUD) == []


def test_a_number_type_unknown_to_foxglove_is_refused() -> None:
    with pytest.raises(ValueError, match="not in tuple"):
        messages.point_cloud(0, "hull", {"x": np.zeros(2, np.float16)})


def test_an_entity_without_a_required_list_breaks_the_schema() -> None:
    entity = messages.entity(
        0, "hull", "1", facts={"views": 3}, lines=[messages.line_loop(np.eye(3), (1, 0, 0, 1), 2.0)]
    )
    assert violations(messages.scene_update([entity]), messages.SCENE_UPDATE) == []
    assert entity["metadata"] == [{"key": "views", "value": "3"}]
    for name in ("arrows", "models", "lifetime"):
        spoiled = {key: value for key, value in entity.items() if key != name}
        assert violations(messages.scene_update([spoiled]), messages.SCENE_UPDATE)


def test_a_kind_of_line_that_there_is_not_breaks_the_schema() -> None:
    line = messages.line_loop(np.eye(3), (1, 0, 0, 1), 2.0)
    assert violations(line, messages.LINE) == []
    assert violations({**line, "type": 3}, messages.LINE)
