# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.formats.sonar_file import read_ping

QUICK = settings(
    max_examples=75,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
GOOD = {
    "image": np.arange(12, dtype=np.uint8).reshape(4, 3),
    "azimuth": np.linspace(-0.2, 0.2, 4),
    "range": [1.0, 2.0, 3.0],
}


def ping(folder: Path, compressed: bool = True, **more) -> Path:
    (np.savez_compressed if compressed else np.savez)(folder / "p.npz", **{**GOOD, **more})
    return folder / "p.npz"


@pytest.mark.parametrize("compressed", [True, False])
@pytest.mark.parametrize("dtype", ["u1", "<f4", ">f8", "<u2", "i4"])
def test_a_ping_comes_back_as_it_was_written(tmp_path, compressed, dtype):
    image, azimuth, range_m = read_ping(
        ping(tmp_path, compressed, image=GOOD["image"].astype(dtype))
    )
    np.testing.assert_array_equal(image, GOOD["image"])
    assert image.dtype == np.dtype(dtype)
    np.testing.assert_array_equal(azimuth, GOOD["azimuth"])
    np.testing.assert_array_equal(range_m, GOOD["range"])


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"image": np.zeros((3, 4))}, "shape"),
        ({"image": np.array([["a"] * 3] * 4)}, "no numbers"),
        ({"image": np.zeros((4, 3), complex)}, "no numbers"),
        ({"image": np.full((4, 3), None)}, "no numbers"),
        ({"azimuth": 0.5}, "shape"),
        ({"azimuth": np.zeros((4, 1))}, "shape"),
        ({"azimuth": [0, 0, np.nan, 0]}, "not all numbers"),
        ({"range": [1, np.inf, 2]}, "not all numbers"),
        ({"image": np.zeros((0, 3)), "azimuth": []}, "shape"),
    ],
)
def test_arrays_of_another_kind_are_refused_with_the_reason(tmp_path, more, why):
    with pytest.raises(ValueError, match=why):
        read_ping(ping(tmp_path, **more))


def test_a_file_without_an_array_names_it(tmp_path):
    np.savez(tmp_path / "p.npz", image=GOOD["image"])
    with pytest.raises(ValueError, match="no azimuth and no range"):
        read_ping(tmp_path / "p.npz")


def test_a_ping_over_the_head_of_another_is_refused(tmp_path):
    content = ping(tmp_path).read_bytes()
    (tmp_path / "q.npz").write_bytes(content[:63] + content)
    with pytest.raises(ValueError, match="63 bytes that are none of its own"):
        read_ping(tmp_path / "q.npz")


def test_an_array_that_would_unpack_to_gigabytes_is_not_unpacked(tmp_path):
    head = b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little")
    head += (
        b"{'descr': '|u1', 'fortran_order': False, 'shape': (16, 16777216), }".ljust(117) + b"\n"
    )
    path = ping(tmp_path)
    with zipfile.ZipFile(path) as archive:
        rest = {name: archive.read(name) for name in ("azimuth.npy", "range.npy")}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in rest.items():
            archive.writestr(name, content)
        with archive.open("image.npy", "w") as stream:
            stream.write(head)
            for _ in range(256):
                stream.write(bytes(1 << 20))
    tracemalloc.start()
    with pytest.raises(ValueError, match="would unpack to 2684"):
        read_ping(path)
    assert tracemalloc.get_traced_memory()[1] < 1 << 22
    tracemalloc.stop()


def test_a_head_that_claims_more_than_there_is_is_not_believed(tmp_path):
    path = ping(tmp_path, compressed=False)
    path.write_bytes(path.read_bytes().replace(b"(4, 3)", b"(9, 9)"))
    with pytest.raises(ValueError, match=r"Bad CRC|not as long"):
        read_ping(path)


def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "p.npz")
    with pytest.raises(ValueError, match="is a pipe"):
        read_ping(tmp_path / "p.npz")


@QUICK
@given(st.data())
def test_any_damage_is_a_reason_or_the_same_ping(tmp_path, data):
    content = bytearray(ping(tmp_path, data.draw(st.booleans())).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(content))) if data.draw(st.booleans()) else len(content)
    (tmp_path / "q.npz").write_bytes(content[:cut])
    try:
        image, azimuth, range_m = read_ping(tmp_path / "q.npz")
    except ValueError:
        return
    assert image.shape == (len(azimuth), len(range_m))


def test_a_ping_of_an_oculus_is_read_by_its_number(data):
    path = data / "oculus-pings" / "three_pings_8bit.raw"
    found = [read_ping(path, number) for number in range(3)]
    assert all(image.shape == (256, 703) for image, _, _ in found)
    assert not np.array_equal(found[0][0], found[1][0])
    with pytest.raises(ValueError, match="no ping of that number"):
        read_ping(path, 3)


def test_a_cut_ping_of_an_oculus_is_refused(data, tmp_path):
    (tmp_path / "x.raw").write_bytes(
        (data / "oculus-pings" / "one_ping_8bit.raw").read_bytes()[:-1]
    )
    with pytest.raises(ValueError, match="no whole ping"):
        read_ping(tmp_path / "x.raw")
