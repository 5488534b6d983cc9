# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.documents: JSON that is the same for the same values and that shows a flipped bit."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from hullrecon.artifacts.documents import (
    DamagedArtifactError,
    digest,
    encode,
    plain,
    seal,
    unseal,
)

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=12,
)


class Point(Struct):
    x: float
    tags: tuple[str, ...]


def test_keys_are_sorted_and_lines_indented() -> None:
    assert encode({"b": 1, "a": [True, None]}) == b'{\n "a": [\n  true,\n  null\n ],\n "b": 1\n}\n'


def test_numpy_values_structs_and_tuples_become_plain() -> None:
    value = {
        "n": np.float32(0.5),
        "i": np.int64(3),
        "b": np.bool_(True),
        "a": np.arange(2),
        "p": Point(1.0, ("x",)),
        "t": (1, 2),
    }
    plain = {"n": 0.5, "i": 3, "b": True, "a": [0, 1], "p": {"x": 1.0, "tags": ["x"]}, "t": [1, 2]}
    assert json.loads(encode(value)) == plain


@pytest.mark.parametrize(
    "bad", [float("nan"), float("inf"), np.float64("nan"), np.array([0.0, np.nan])]
)
def test_a_number_that_is_not_finite_is_refused_with_its_place(bad: object) -> None:
    place = r"objects\[1\]\.height\[1\]" if isinstance(bad, np.ndarray) else r"objects\[1\]\.height"
    with pytest.raises(ValueError, match=f"not a finite number at {place}$"):
        encode({"objects": [{"height": 1.0}, {"height": bad}]})


def test_what_json_does_not_know_is_refused() -> None:
    with pytest.raises(TypeError):
        encode({"a": object()})


@settings(deadline=None)
@given(st.dictionaries(st.text().filter(lambda k: k != "seal"), JSON, max_size=4))
def test_a_sealed_mapping_comes_back(value: dict[str, Any]) -> None:
    assert unseal(seal(value)) == value


@pytest.mark.parametrize("value", [{}, {"a": 1}, {"z": {"seal": "0" * 64}}, {"a": [], "z": {}}])
def test_the_seal_is_the_digest_of_what_is_sealed(value: dict[str, Any]) -> None:
    assert seal(value) == encode({**value, "seal": digest(value)})
    assert unseal(seal(value)) == value


@pytest.mark.parametrize("value", [{"a": 1}, {"a": 1, "z": 2}])
def test_a_sealed_mapping_written_otherwise_is_damaged(value: dict[str, Any]) -> None:
    members = json.loads(seal(value))
    seal_first = {"seal": members["seal"], **value}
    for text in (json.dumps(members, indent=2), json.dumps(seal_first, indent=1)):
        with pytest.raises(DamagedArtifactError):
            unseal(f"{text}\n".encode())


def test_any_flipped_bit_breaks_the_seal() -> None:
    data = seal({"a": 1, "text": "ü", "list": [0.5, -1e-9, True]})
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(DamagedArtifactError):
            unseal(bytes(flipped))


def test_any_cut_breaks_the_seal() -> None:
    data = seal({"a": 1})
    for length in range(len(data)):
        with pytest.raises(DamagedArtifactError):
            unseal(data[:length])


def test_a_list_is_no_sealed_mapping() -> None:
    with pytest.raises(DamagedArtifactError):
        unseal(b"[1, 2]")


def test_digest_does_not_depend_on_order_of_keys() -> None:
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest({"a": 1}) != digest({"a": 2})
    assert digest({"a": 1}) != digest({"a": 1.5})


class Sensed(msgspec.Struct):
    """A struct as a notebook fills it: with what NumPy returned."""

    sigma_m: float
    mount: tuple[float, ...] = ()
    name: str = ""


def test_numpy_numbers_inside_a_struct_are_written_as_numbers() -> None:
    value = Sensed(sigma_m=np.float64(0.25), mount=np.array([1.0, 2.0]), name=np.str_("top"))  # type: ignore[arg-type]
    assert plain({"dvl": value}) == {"dvl": {"sigma_m": 0.25, "mount": [1.0, 2.0], "name": "top"}}
    assert plain(Sensed(sigma_m=np.float32(0.5))) == {"sigma_m": 0.5, "mount": [], "name": ""}  # type: ignore[arg-type]


def test_what_no_document_can_hold_is_named_by_its_type() -> None:
    with pytest.raises(TypeError, match="complex"):
        plain(Sensed(sigma_m=1j))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="object"):
        plain([object()])
