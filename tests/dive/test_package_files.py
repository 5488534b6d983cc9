# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import shutil
from pathlib import Path

import pytest

from hullrecon.change.options import EarlierDive
from hullrecon.dive.config.load import load_config
from hullrecon.dive.package_files import check_files, check_log, lies_inside, log_files
from hullrecon.errors import InputError
from hullrecon.report.options import ReportOptions

TOML = """[dive]
name = "small"
[logs]
files = ["logs"]
[camera.top]
calibration = "top.yaml"
[hull]
mesh = "hull.stl"
"""


@pytest.fixture
def package(tmp_path) -> Path:
    """A plain package beside a folder of somebody else's files."""
    folder, other = tmp_path / "package", tmp_path / "other"
    (folder / "logs").mkdir(parents=True)
    other.mkdir()
    for path in (
        folder / "hull.stl",
        folder / "top.yaml",
        folder / "logs" / "a.png",
        other / "secret.png",
        other / "secret.bag",
    ):
        path.write_text("x")
    (folder / "dive.toml").write_text(TOML)
    (folder / "logs" / "dvl.csv").write_text("t,vx,vy,vz\n0,1,0,0\n")
    (folder / "logs" / "camera_top.csv").write_text("t,file\n0,a.png\n1,gone.png\n")
    return folder


def refusal(package: Path, *overrides: str, **given) -> str:
    with pytest.raises(InputError) as caught:
        check_files(load_config(package, {}, overrides), **given)
    line = str(caught.value)
    assert len(line.splitlines()) == 1
    return line


def change(package: Path, old: str, new: str) -> None:
    text = (package / "dive.toml").read_text()
    assert old in text
    (package / "dive.toml").write_text(text.replace(old, new))


def outside(key: str, name: str) -> str:
    return f"{key} names a file outside the package: {name}"


def test_a_package_whose_files_lie_in_it_is_taken(package):
    check_files(load_config(package))


def test_so_is_one_given_by_a_relative_path_or_a_link(package, monkeypatch, tmp_path):
    (tmp_path / "link").symlink_to(package)
    monkeypatch.chdir(package.parent)
    for name in ("package", "link", "package/../package"):
        check_files(load_config(Path(name)))
    monkeypatch.chdir(package)
    check_files(load_config(Path()))


@pytest.mark.parametrize(
    ("old", "key"),
    [
        ('"logs"', "logs.files"),
        ('"hull.stl"', "hull.mesh"),
        ('"top.yaml"', "camera.top.calibration"),
    ],
)
@pytest.mark.parametrize(
    "name",
    [
        "../other/secret.bag",
        "logs/../../other/secret.bag",
        "{other}/secret.bag",
        "/etc/hostname",
        "..",
    ],
)
def test_file_outside_package_is_refused_with_key_and_option(package, old, key, name):
    name = name.format(other=package.parent / "other")
    change(package, old, f'"{name}"')
    line = refusal(package)
    assert outside(key, "") in line
    assert "--allow-outside" in line
    check_files(load_config(package), allow_outside=True)


def test_a_logo_outside_is_refused_too(package):
    loaded = load_config(package, {"report": ReportOptions}, ["report.logo=../other/secret.png"])
    with pytest.raises(InputError, match=r"report\.logo names a file outside the package"):
        check_files(loaded)
    check_files(loaded, allow_outside=True)
    check_files(load_config(package, {"report": ReportOptions}, ["report.logo=logos/own.png"]))


@pytest.mark.parametrize("earlier", ["../other", "{other}", "../not-there", "runs"])
def test_earlier_dive_outside_is_refused_unless_allowed(package, earlier):
    (package / "runs").symlink_to(package.parent / "other")
    given = f"change.earlier={earlier.format(other=package.parent / 'other')}"
    loaded = load_config(package, {"change": EarlierDive}, [given])
    with pytest.raises(
        InputError, match=r"change\.earlier names a file outside the package: .*--allow-outside"
    ):
        check_files(loaded)
    check_files(loaded, allow_outside=True)
    check_files(loaded, trusted_keys=["change.earlier"])


def test_earlier_dive_inside_is_refused_if_a_file_leads_out(package):
    (package / "runs" / "may" / "detect").mkdir(parents=True)
    loaded = load_config(package, {"change": EarlierDive}, ["change.earlier=runs/may"])
    check_files(loaded)
    (package / "runs" / "may" / "detect" / "as_found.npz").symlink_to(
        package.parent / "other" / "secret.bag"
    )
    with pytest.raises(
        InputError, match=r"change\.earlier names a file outside .*as_found\.npz \(a link to"
    ):
        check_files(loaded)
    (package / "runs" / "may" / "detect" / "as_found.npz").unlink()
    os.mkfifo(package / "runs" / "may" / "detect" / "as_found.npz")
    with pytest.raises(InputError, match=r"change\.earlier names a FIFO"):
        check_files(loaded, allow_outside=True)


def test_path_that_leaves_and_reenters_package_is_accepted(package):
    change(package, '"hull.stl"', '"../package/hull.stl"')
    check_files(load_config(package))


def test_link_out_of_the_package_is_refused_with_its_target(package):
    (package / "hull.stl").unlink()
    (package / "hull.stl").symlink_to(package.parent / "other" / "secret.bag")
    assert f"{outside('hull.mesh', 'hull.stl')} (a link to " in refusal(package)


def test_a_link_inside_the_package_is_taken(package):
    (package / "hull.stl").rename(package / "real.stl")
    (package / "hull.stl").symlink_to("real.stl")
    check_files(load_config(package))


@pytest.mark.parametrize("member", ["dvl.csv", "camera_top.csv"])
def test_a_table_that_is_a_link_out_of_the_package_is_refused(package, member):
    (package / "logs" / member).unlink()
    (package / "logs" / member).symlink_to(package.parent / "other" / "secret.bag")
    assert outside("logs.files", f"logs/{member}") in refusal(package)


def test_recording_linked_out_of_the_package_is_refused(package):
    shutil.rmtree(package / "logs")
    (package / "logs").mkdir()
    (package / "logs" / "metadata.yaml").write_text("x: 1")
    (package / "logs" / "a.db3").symlink_to(package.parent / "other" / "secret.bag")
    assert outside("logs.files", "logs/a.db3") in refusal(package)


@pytest.mark.parametrize("log", ["logs/a.db3", "logs"])
def test_write_ahead_log_linked_out_of_the_package_is_refused(package, log):
    shutil.rmtree(package / "logs")
    (package / "logs").mkdir()
    (package / "logs" / "a.db3").write_text("x")
    (package / "logs" / "a.db3-wal").symlink_to(package.parent / "other" / "secret.bag")
    change(package, '"logs"', f'"{log}"')
    assert outside("logs.files", "logs/a.db3-wal") in refusal(package)


@pytest.mark.parametrize("name", ["../../other/secret.png", "{other}/secret.png"])
def test_a_file_that_a_table_names_outside_is_refused(package, name):
    name = name.format(other=package.parent / "other")
    (package / "logs" / "camera_top.csv").write_text(f"t,file\n0,a.png\n1,{name}\n")
    assert outside("a table of logs", "") in refusal(package)
    check_files(load_config(package), allow_outside=True)


def test_an_image_that_is_a_link_out_of_the_package_is_refused(package):
    (package / "logs" / "a.png").unlink()
    (package / "logs" / "a.png").symlink_to(package.parent / "other" / "secret.png")
    assert outside("a table of logs", "logs/a.png (a link to") in refusal(package)


def test_a_file_that_the_user_names_himself_may_lie_anywhere(package):
    override = f"hull.mesh={package.parent / 'other' / 'secret.bag'}"
    assert "hull.mesh" in refusal(package, override)
    check_files(load_config(package, {}, [override]), trusted_keys=["hull.mesh"])


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("hull.stl", "hull.mesh"),
        ("top.yaml", "camera.top.calibration"),
        ("logs/dvl.csv", "logs.files"),
        ("logs", "logs.files"),
    ],
)
def test_a_fifo_is_refused_before_anything_waits_for_it(package, name, key):
    path = package / name
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    os.mkfifo(path)
    assert f"{key} names a FIFO, not a file: {path.name}" in refusal(package)
    assert f"{key} names a FIFO" in refusal(package, allow_outside=True)


def test_a_device_is_refused_outside_or_not(package):
    (package / "hull.stl").unlink()
    (package / "hull.stl").symlink_to("/dev/zero")
    assert "hull.mesh names a device" in refusal(package, allow_outside=True)


def test_what_is_missing_is_left_to_its_reader(package):
    for name in ("hull.stl", "top.yaml"):
        (package / name).unlink()
    shutil.rmtree(package / "logs")
    check_files(load_config(package))


@pytest.mark.parametrize("name", ["x" * 900, "a/" * 400])
def test_so_is_a_name_that_no_file_can_have(package, name):
    change(package, '"hull.stl"', f'"{name}"')
    check_files(load_config(package))


def test_a_loop_of_links_is_left_to_its_reader(package):
    (package / "hull.stl").unlink()
    (package / "hull.stl").symlink_to("hull.stl")
    assert lies_inside(package / "hull.stl", package) in (True, False)
    check_files(load_config(package))


def test_a_bare_log_is_held_to_its_folder_as_well(package):
    check_log(package / "logs", package)
    (package / "logs" / "camera_top.csv").write_text("t,file\n0,../../other/secret.png\n")
    with pytest.raises(InputError, match="a table of logs names a file outside"):
        check_log(package / "logs", package / "logs")
    check_log(package / "logs", package, allow_outside=True)


def test_the_files_of_a_log_are_those_that_are_read(package):
    assert log_files(package, "logs") == [
        Path("logs/dvl.csv"),
        Path("logs/camera_top.csv"),
        Path("logs/a.png"),
    ]
    assert log_files(package, "hull.stl") == [Path("hull.stl")]
