# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every record comes back from disk as it was, whatever it holds."""

from __future__ import annotations

import tempfile
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from records.every_record import SHAPES, random_record

from hullrecon.artifacts.stage import load_arrays
from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.geometry.poses import Poses
from hullrecon.native import PlanePairTable, PlaneRangeTable, PlaneTable
from hullrecon.records import planes, sensors, solution, surface, tracks, trajectory
from hullrecon.records.sensors import PressureSamples, SensorRecords
from hullrecon.records.serialisation import from_arrays, to_arrays

QUICK = settings(max_examples=25, deadline=None, derandomize=True)
KINDS = pytest.mark.parametrize("kind", list(SHAPES), ids=lambda kind: kind.__name__)
SIZES = st.fixed_dictionaries({letter: st.integers(0, 4) for letter in "nmkbrp"})
SEEDS = st.integers(0, 2**32)
FULL = dict.fromkeys("nmkbrp", 3)


def through_a_file(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    with tempfile.TemporaryDirectory() as folder:
        ArtifactWriter(Path(folder)).arrays("record.npz", arrays)
        return load_arrays(Path(folder) / "record.npz")


def assert_same(before: object, after: object) -> None:
    assert type(before) is type(after)
    for field in fields(before):  # type: ignore[arg-type]
        old, new = getattr(before, field.name), getattr(after, field.name)
        if is_dataclass(old):
            assert_same(old, new)
        elif old is None:
            assert new is None, field.name
        else:
            assert (new.dtype, new.shape) == (old.dtype, old.shape), field.name
            np.testing.assert_array_equal(new, old, err_msg=field.name)


@KINDS
@QUICK
@given(seed=SEEDS, sizes=SIZES)
def test_record_reads_back_with_types_shapes_missing_parts(
    kind: type, seed: int, sizes: dict[str, int]
) -> None:
    before = random_record(kind, np.random.default_rng(seed), sizes)
    assert_same(before, from_arrays(kind, through_a_file(to_arrays(before))))


@KINDS
def test_any_member_that_is_missing_is_named(kind: type) -> None:
    arrays = to_arrays(random_record(kind, np.random.default_rng(2), FULL))
    for name in arrays:
        rest = {other: value for other, value in arrays.items() if other != name}
        with pytest.raises(KeyError) as raised:
            from_arrays(kind, rest)
        assert raised.value.args == (name,)


@KINDS
def test_members_are_named_by_the_fields_that_lead_to_them(kind: type) -> None:
    record = random_record(kind, np.random.default_rng(3), FULL)
    for name, array in to_arrays(record).items():
        value: object = record
        for part in name.split("."):
            value = getattr(value, part)
        assert value is array


@KINDS
def test_members_of_a_later_version_are_no_hindrance(kind: type) -> None:
    before = random_record(kind, np.random.default_rng(4), FULL)
    arrays = to_arrays(before) | {"zz_new": np.zeros(3)}
    assert_same(before, from_arrays(kind, arrays))


def test_every_record_of_arrays_is_tried() -> None:
    defined = {
        value
        for module in (planes, sensors, solution, surface, tracks, trajectory)
        for value in vars(module).values()
        if isinstance(value, type) and is_dataclass(value) and value.__module__ == module.__name__
    }
    # made of a Solution or a Trajectory, and not stored
    assert defined - set(SHAPES) == {trajectory.VehicleTrack}
    assert set(SHAPES) - defined == {Poses, PlaneTable, PlaneRangeTable, PlanePairTable}


def test_the_shapes_tried_are_those_of_all_fields() -> None:
    for kind, shapes in SHAPES.items():
        assert list(shapes) == [field.name for field in fields(kind)], kind.__name__


def test_empty_sensor_is_told_from_absent_one() -> None:
    empty = PressureSamples(t_ns=np.zeros(0, np.int64), depth=np.zeros(0))
    after = from_arrays(SensorRecords, through_a_file(to_arrays(SensorRecords(pressure=empty))))
    assert after.pressure is not None
    assert len(after.pressure.t_ns) == 0
    assert replace(after, pressure=None) == SensorRecords()


@QUICK
@given(seed=SEEDS)
def test_sensors_are_listed_by_name_in_the_order_of_the_fields(seed: int) -> None:
    records = random_record(SensorRecords, np.random.default_rng(seed), FULL)
    by_name = records.by_name()
    order = ["dvl", "imu", "pressure", "tray", "sonar_tray", "sonar", "position"]
    assert list(by_name) == [name for name in order if getattr(records, name) is not None]
    assert all(record is getattr(records, name) for name, record in by_name.items())
