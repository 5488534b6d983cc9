# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive_result.mcap by Foxglove's own reader and schemas, and by the mcap package; the point cloud
by laspy.
"""

import json
from collections import Counter

import jsonschema
import laspy
import numpy as np
import plyfile
import pytest
from mcap.reader import NonSeekingReader, make_reader


@pytest.fixture(scope="module")
def mcap(deliver):
    return deliver / "dive_result.mcap"


def test_foxgloves_reader_and_the_mcap_package_find_the_same_messages(mcap, node):
    found = node("read_mcap.mjs", mcap)
    counts, names = Counter(), {}
    with mcap.open("rb") as file:
        for schema, channel, _ in make_reader(file, validate_crcs=True).iter_messages():
            counts[channel.topic] += 1
            names[channel.topic] = schema.name
    assert found["isDone"]
    assert {topic: entry["messages"] for topic, entry in found["topics"].items()} == dict(counts)
    assert {topic: entry["schema"] for topic, entry in found["topics"].items()} == names
    assert len(names) == 9


def test_every_message_keeps_to_foxgloves_own_schema(mcap, node):
    validators = {}
    with mcap.open("rb") as file:
        for schema, _, message in make_reader(file, validate_crcs=True).iter_messages():
            if schema.name.startswith("foxglove."):
                if schema.name not in validators:
                    official = node("read_mcap.mjs", mcap, schema.name.removeprefix("foxglove."))
                    validators[schema.name] = jsonschema.Draft202012Validator(official)
                validators[schema.name].validate(json.loads(message.data))
    assert len(validators) == 5


def test_the_file_reads_from_a_pipe_too_and_says_what_it_is(mcap):
    with mcap.open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        times = [message.log_time for _, _, message in reader.iter_messages()]
    assert times == sorted(times)
    with mcap.open("rb") as file:
        (about,) = make_reader(file).iter_metadata()
    assert about.name == "hullrecon"
    assert set(about.metadata) == {"dive", "frame", "unit"}


def test_laspy_reads_the_points_that_the_ply_has_where_they_were_seen(deliver):
    cloud, vertex = (
        laspy.read(deliver / "as_found.las"),
        plyfile.PlyData.read(deliver / "as_found.ply")["vertex"],
    )
    seen = vertex["support"] > 0
    np.testing.assert_allclose(
        cloud.xyz, np.stack([vertex[axis][seen] for axis in "xyz"], axis=1), atol=0.00006
    )
    for name in ("sigma", "deviation", "form", "form_sigma", "support"):
        np.testing.assert_array_equal(cloud[name], vertex[name][seen])


def test_laspys_system_is_a_local_one_of_three_axes_in_metres(deliver):
    with laspy.open(deliver / "as_found.las") as file:
        system = file.header.parse_crs()
    assert system.type_name == "Engineering CRS"
    assert [(axis.direction, axis.unit_name) for axis in system.axis_info] == [
        ("east", "metre"), ("north", "metre"), ("up", "metre")
    ]  # fmt: skip
