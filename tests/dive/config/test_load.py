# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
from pathlib import Path

import msgspec
import pytest

from hullrecon.dive.config.load import load_config
from hullrecon.errors import InputError, UsageError

PLAIN = '[dive]\nname = "x"\n[logs]\nfiles = ["logs"]\n'


class Features(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    clahe: float = 3.0


@pytest.fixture
def package(tmp_path: Path) -> Path:
    (tmp_path / "dive.toml").write_text(PLAIN)
    return tmp_path


def refusal(package: Path, *overrides: str) -> str:
    with pytest.raises(UsageError) as caught:
        load_config(package, {"features": Features}, overrides)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_smallest_file_gives_every_section_its_defaults(package):
    loaded = load_config(package, {"features": Features})
    assert loaded.config.pressure.density == 1025.0
    assert loaded.sections["hull"] is None
    assert loaded.sections["camera.top"] is None
    assert loaded.sections["features"] == Features()
    assert loaded.given == {"dive.name", "logs.files"}


def test_a_value_is_found_by_its_dotted_name(package):
    (package / "dive.toml").write_text(
        PLAIN + '[imu]\nframe = "enu"\n[camera.top]\ncalibration = "a.yaml"\ntime_offset = 2\n'
    )
    loaded = load_config(package, {"features": Features})
    assert loaded.value("imu.frame") == "enu"
    assert loaded.value("camera.top.time_offset") == 2.0
    assert loaded.value("camera.bottom.time_offset") is None
    assert loaded.value("hull.mesh") is None
    assert loaded.value("features.clahe") == 3.0


def test_a_dotted_name_that_no_section_has_is_a_key_error(package):
    with pytest.raises(KeyError, match=r"imu\.fram"):
        load_config(package).value("imu.fram")


def test_an_override_is_read_as_toml_and_a_bare_word_as_text(package):
    loaded = load_config(
        package,
        {"features": Features},
        ["features.clahe=4", "imu.frame=enu", "dvl.mount=[1,2,3,4,5,6]"],
    )
    assert loaded.value("features").clahe == 4.0
    assert loaded.value("imu").frame == "enu"
    assert loaded.value("dvl").mount == (1, 2, 3, 4, 5, 6)
    assert "imu.frame" in loaded.given


@pytest.mark.parametrize(
    ("override", "nearest"),
    [
        ("imu.fram=1", "imu.frame"),
        ("hull.frame=1", "hull.frame_spacing"),
        ("mount=1", "dvl.mount"),
        ("camera.tp=1", "camera.top"),
        ("camera.top.sigma=1", "camera.top.sigma_px"),
        ("features.clah=1", "features.clahe"),
        ("feature.clahe=1", "features"),
    ],
)
def test_an_unknown_key_names_the_nearest_known_one(package, override, nearest):
    more = () if not override.startswith("hull") else ('hull.mesh="a.stl"',)
    more += ('camera.top.calibration="a"',) if override.startswith("camera.top") else ()
    line = refusal(package, *more, override)
    key = override[:-2]
    if "feature." in override:
        key = override.partition("=")[0].removesuffix(".clahe")
    assert f"unknown key {key}" in line
    assert line.endswith(f"the nearest known key is {nearest}")
    assert "dive.toml" in line


@pytest.mark.parametrize(
    ("override", "key", "value"),
    [
        ("pressure.density=-3", "pressure.density", "-3"),
        ('pressure.density="salt"', "pressure.density", "'salt'"),
        ("dvl.mount=[1,2]", "dvl.mount", "[1, 2]"),
        ('dvl.mount=[1,2,3,4,5,"a"]', "dvl.mount[5]", "'a'"),
        ("imu.frame=up", "imu.frame", "'up'"),
        ("dive=2", "dive", "2"),
        ("features.clahe=true", "features.clahe", "True"),
        ("pressure.gravity=nan", "pressure.gravity", "nan"),
        ("dvl.beams=[[inf,0,0]]", "dvl.beams[0][0]", "inf"),
    ],
)
def test_a_wrong_value_names_its_key_and_shows_itself(package, override, key, value):
    assert f"{key} = {value}: expected" in refusal(package, override).replace(
        "Invalid enum value", "expected"
    )


def test_a_missing_key_is_named_with_its_section(package):
    assert "hull.mesh is missing" in refusal(package, 'hull.units="m"')


def test_beams_that_are_not_of_unit_length_are_refused(package):
    assert "dvl.beams" in refusal(package, "dvl.beams=[[1.0, 1.0, 0.0]]")


def test_a_lower_camera_without_an_upper_one_is_refused(package):
    assert "camera.bottom" in refusal(package, 'camera.bottom.calibration="a"')


@pytest.mark.parametrize("text", ["imu.frame", "=3", "a..b=1", "dive.name.x=1"])
def test_an_override_without_a_key_and_a_value_is_refused(package, text):
    assert "--set" in refusal(package, text)


def test_a_folder_without_a_dive_toml_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match=r"no dive\.toml"):
        load_config(tmp_path)
    with pytest.raises(InputError, match=r"no dive\.toml"):
        load_config(tmp_path / "absent")


@pytest.mark.parametrize("content", [b"[dive", b"\xff\xfe\x00", b"a = 1\na = 2\n"])
def test_a_file_that_is_not_toml_is_a_usage_error(tmp_path, content):
    (tmp_path / "dive.toml").write_bytes(content)
    with pytest.raises(UsageError, match=r"TOML|UTF-8"):
        load_config(tmp_path)


@pytest.mark.parametrize("name", ["..", ".", "a/b", "-x", "", "x\\n", "x" * 101, "$(shell)"])
def test_a_name_that_is_no_plain_folder_is_refused(package, name):
    with pytest.raises(UsageError, match=r"dive\.name"):
        load_config(package, {}, [f'dive.name="{name}"'])


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("topics={imu='/x', joints='/x'}", "topics.joints and topics.imu are both /x"),
        ("logs.files=[]", "logs.files"),
        ("logs.files=['a.mcap', './a.mcap']", "logs.files names a.mcap twice"),
        ("camera.top.time_offset=1e12", "time_offset"),
    ],
)
def test_what_contradicts_itself_is_refused(package, override, message):
    with pytest.raises(UsageError, match=message):
        load_config(package, {}, [override])


@pytest.mark.parametrize("text", ["x = " + "[" * 3000, "x = " + "1" * 10_000])
def test_values_that_the_parser_gives_up_on_are_no_fault_of_ours(tmp_path, text):
    (tmp_path / "dive.toml").write_text(text)
    with pytest.raises(UsageError, match="not valid TOML"):
        load_config(tmp_path)


HUGE = "0x" + "f" * 6000  # TOML's hexadecimal numbers have no end, and Python does not print them


@pytest.mark.parametrize("key", ["dive.name", "imu.sigma_roll_pitch_deg", "tray.origin", "logs"])
def test_unprintable_number_is_refused_in_a_short_line(package, key):
    (package / "dive.toml").write_text(f"{key} = {HUGE}\n")
    assert "a number of thousands of digits" in refusal(package)


@pytest.mark.parametrize(
    "text",
    [
        "a." * 900 + "a = 1",
        "[" + "a." * 900 + "a]",
        "'a'. \"b c\" ." * 140 + "a = 1",
        "x = {" + "a." * 900 + "a = 1}",
    ],
)
def test_key_of_hundreds_of_parts_is_refused_before_parsing(package, text):
    (package / "dive.toml").write_text(text)
    assert "a line with more than 100 dots" in refusal(package)


def test_values_that_lie_deep_in_each_other_are_refused(package):
    (package / "dive.toml").write_text(f"{PLAIN}\n[tray]\norigin = {'[' * 200}{']' * 200}")
    assert "nested too deeply" in refusal(package)
    (package / "dive.toml").write_text(PLAIN)
    assert "nested too deeply" in refusal(package, f"tray.origin={'[' * 100}{']' * 100}")


def test_a_key_of_thousands_of_letters_is_shown_by_its_start(package):
    (package / "dive.toml").write_text(f"{'x' * 5000} = 1\n{PLAIN}")
    line = refusal(package)
    assert "unknown key xxx" in line
    assert len(line) < 300


def test_a_choice_of_thousands_of_letters_is_shown_by_its_start(package):
    line = refusal(package, f"imu.frame={'x' * 5000}")
    assert line.startswith("imu.frame = 'xxx")
    assert len(line) < 400


@pytest.mark.parametrize(
    "key",
    [
        "dive.vessel",
        "topics.dvl",
        "tray.joint",
        "hull.mesh",
        "camera.top.calibration",
        "logs.files",
        "sonar.joint",
    ],
)
@pytest.mark.parametrize("text", ["a\\nb", "a\\u0000", "\\u001b[31m", "\\u2028", "\\u009b"])
def test_text_with_control_characters_or_line_breaks_is_refused(package, key, text):
    value = f'["{text}"]' if key == "logs.files" else f'"{text}"'
    line = refusal(package, f"{key}={value}")
    assert f"{key}" in line
    assert "expected text on one line, without control characters" in line
    assert line.isprintable()


@pytest.mark.parametrize(("value", "key"), [('""', "hull.mesh"), (f'"{"x" * 1001}"', "hull.mesh")])
def test_empty_or_very_long_file_name_is_refused(package, value, key):
    assert key in refusal(package, f"{key}={value}")


def test_fifo_or_endless_dive_toml_is_refused_in_one_line(tmp_path):
    os.mkfifo(tmp_path / "dive.toml")
    with pytest.raises(InputError, match=r"dive\.toml cannot be read: it is a FIFO, not a file"):
        load_config(tmp_path)
    (tmp_path / "dive.toml").unlink()
    (tmp_path / "dive.toml").symlink_to("/dev/zero")
    with pytest.raises(InputError, match="a device"):
        load_config(tmp_path)
    (tmp_path / "dive.toml").unlink()
    with (tmp_path / "dive.toml").open("wb") as stream:
        stream.truncate(1 << 30)
    with pytest.raises(InputError, match=r"more than 0\.25 MiB"):
        load_config(tmp_path)


@pytest.mark.parametrize(
    "name", [".", "..", ".hidden", "x\\n", "\\u0000", "x" * 101, "a b", "a/b", "\u00e9", "~", "-rf"]
)
def test_dive_name_that_leaves_its_folder_is_refused(package, name):
    assert "dive.name" in refusal(package, f'dive.name="{name}"')


def test_a_name_of_a_hundred_letters_is_taken(package):
    assert load_config(package, {}, [f'dive.name="{"x" * 100}"']).config.dive.name == "x" * 100


HULL = '[hull]\nmesh = "h.stl"\n'


def with_regions(package: Path, *regions: str) -> Path:
    (package / "dive.toml").write_text(
        PLAIN + HULL + "".join(f"[[hull.region]]\n{region}\n" for region in regions)
    )
    return package


def test_regions_of_the_hull_have_a_name_and_limits(package):
    with_regions(
        package,
        'name = "bow, port"\nalong = [30, 40.5]\ngirth = [0, 4]',
        'name = "keel"\ngirth = [-0.5, 0.5]',
    )
    bow, keel = load_config(package).config.hull.region
    assert (bow.name, bow.along, bow.girth) == ("bow, port", (30.0, 40.5), (0.0, 4.0))
    assert (keel.along, keel.girth) == (None, (-0.5, 0.5))


@pytest.mark.parametrize(
    ("regions", "words"),
    [
        (['name = "a"\nalong = [1, 2]', 'name = "a"\nalong = [2, 3]'], "hull.region names a twice"),
        (['name = "a"'], "hull.region a has no limits"),
        (['name = "a"\nalong = [2, 1]'], "hull.region a: along ends before it begins"),
        (['name = "a"\ngirth = [1, 1]'], "hull.region a: girth ends before it begins"),
        (['name = "a"\nalong = [1]'], "hull.region[0].along"),
        (['along = [1, 2]'], "hull.region[0].name is missing"),
        (['name = "a\\u001b[2J"\nalong = [1, 2]'], "hull.region[0].name"),
        (['name = ""\nalong = [1, 2]'], "hull.region[0].name"),
        (['name = "a"\nalong_m = [1, 2]'], "hull.region[0].along_m (dive.toml): the nearest known "
            "key is hull.region.along"),
        (['name = "a"\nalong = [1, nan]'], "hull.region[0].along[1] = nan"),
    ],
)  # fmt: skip
def test_region_that_is_empty_or_not_uniquely_named_is_refused(package, regions, words):
    with_regions(package, *regions)
    assert words in refusal(package)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("dvl.mount=[0, 0, 80, 0, 90, 0]", r"dvl.mount reaches 80 m.*is it in millimetres"),
        ("tray.origin=[450, 0, 100]", r"tray.origin reaches 450 m"),
        ("dvl.mount=[0, 0, 0.08, 0, 1.5708, 0]", r"angle of 1.5708, which is 90 degrees in rad"),
        ("imu.mount_deg=[3.1416, 0, 0]", r"imu.mount_deg has an angle of 3.1416"),
    ],
)
def test_mounts_in_millimetres_or_radians_are_refused(package, override, words):
    with pytest.raises(InputError, match=words):
        load_config(package, {}, [override])


def test_mounts_of_a_few_degrees_are_believed(package):
    assert load_config(package, {}, ["dvl.mount=[0, 0, 0.08, 3.1, 90, 1.5]"]).config.dvl.mount


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("pressure.density=1.025", "expected a number >= 900"),
        ("pressure.atmosphere=1013.25", "is it in hPa"),
        ('hull={mesh="a.stl", units="meters"}', 'expected "m" or "mm"'),
        ('imu.frame="NED"', 'expected "ned" or "enu"'),
        ('dive.date="4 May"', "expected a date and time such as"),
    ],
)
def test_values_of_another_unit_or_form_are_told_what_is_expected(package, override, words):
    assert words in refusal(package, override)


HEALED = {  # by what is printed to do: what is refused, and what that makes of it
    "a mono rig has camera.top only": (
        '[camera.bottom]\ncalibration = "a.yaml"',
        '[camera.top]\ncalibration = "a.yaml"',
    ),
    "name each log once": ('files = ["logs", "logs/"]', 'files = ["logs", "b.mcap"]'),
    "give each beam as x, y, z of length 1": (
        "[dvl]\nbeams = [[-1, 0, 1]]",
        "[dvl]\nbeams = [[-0.7071, 0, 0.7071]]",
    ),
    "give each sensor its own topic": (
        '[topics]\ndvl = "/a"\njoints = "/a"',
        '[topics]\ndvl = "/a"\njoints = "/b"',
    ),
    "give the baseline of the stereo calibration in camera.bottom.pose_in_top": (
        '[camera.top]\ncalibration = "a.yaml"\n[camera.bottom]\ncalibration = "b.yaml"\n'
        "pose_in_top = [0, 0, 0.1, 0, 0, 0]",
        '[camera.top]\ncalibration = "a.yaml"\n[camera.bottom]\ncalibration = "b.yaml"\n'
        "pose_in_top = [0, 0.1, 0, 0, 0, 0]",
    ),
    "give each region its own name": (
        HULL + '[[hull.region]]\nname = "a"\nalong = [1, 2]\n' * 2,
        "".join([HULL, *(f'[[hull.region]]\nname = "{name}"\nalong = [1, 2]\n' for name in "ab")]),
    ),
    "give along = [from, to], girth = [from, to] or both": (
        HULL + '[[hull.region]]\nname = "a"',
        HULL + '[[hull.region]]\nname = "a"\nalong = [1, 2]\ngirth = [0, 4]',
    ),
    "give the lower limit first": (
        HULL + '[[hull.region]]\nname = "a"\nalong = [2, 1]',
        HULL + '[[hull.region]]\nname = "a"\nalong = [1, 2]',
    ),
    "give it in Pa; 0 where": (
        "[pressure]\natmosphere = 1013.25",
        "[pressure]\natmosphere = 101325.0",
    ),
    "give both": (
        "[dvl]\nbeam_angle_deg = 30",
        "[dvl]\nbeam_angle_deg = 30\nbeam_azimuth_deg = [0, 90, 180, 270]",
    ),
    "leave one of them away": (
        "[dvl]\nbeams = [[0, 0, 1]]\nbeam_angle_deg = 30\nbeam_azimuth_deg = [0]",
        "[dvl]\nbeams = [[0, 0, 1]]",
    ),
    "give dvl.mount in metres": (
        "[dvl]\nmount = [0, 0, 80, 0, 90, 0]",
        "[dvl]\nmount = [0, 0, 0.08, 0, 90, 0]",
    ),
    "give roll, pitch, yaw of dvl.mount in degrees": (
        "[dvl]\nmount = [0, 0, 0.08, 0, 1.5708, 0]",
        "[dvl]\nmount = [0, 0, 0.08, 0, 90, 0]",
    ),
    "write paths with / between folders": (
        HULL.replace("h.stl", "cad\\hull.stl"),
        HULL.replace("h.stl", "cad/hull.stl"),
    ),
    "the nearest known key is imu.frame": ('[imu]\nfram = "ned"', '[imu]\nframe = "ned"'),
}


@pytest.mark.parametrize("remedy", HEALED)
def test_what_is_printed_to_do_about_dive_toml_heals(package, remedy):
    for text, heals in zip(HEALED[remedy], (False, True), strict=True):
        whole = PLAIN.replace('files = ["logs"]\n', "") if "files" in text else PLAIN
        (package / "dive.toml").write_text(whole + text + "\n")
        if heals:
            assert load_config(package).config.dive.name == "x"
            continue
        with pytest.raises((UsageError, InputError)) as caught:
            load_config(package)
        assert caught.value.remedy.startswith(remedy)


def test_a_folder_or_a_coding_that_is_corrected_is_read(package, tmp_path):
    with pytest.raises(InputError) as caught:
        load_config(tmp_path / "elsewhere")
    assert caught.value.remedy.startswith("give the folder that holds dive.toml")
    text = PLAIN.replace('name = "x"\n', 'name = "x"\nvessel = "B\u00e4r"\n')
    (package / "dive.toml").write_bytes(text.encode("latin-1"))
    with pytest.raises(UsageError) as caught:
        load_config(package)
    assert caught.value.remedy == "save it as UTF-8"
    (package / "dive.toml").write_bytes(text.encode())
    assert load_config(package).config.dive.vessel == "B\u00e4r"


@pytest.mark.parametrize(
    ("end", "coding"), [("\n", "utf-8-sig"), ("\r\n", "utf-8-sig"), ("\r\n", "utf-16")]
)
def test_a_file_of_a_windows_editor_is_read(package, end, coding):
    (package / "dive.toml").write_bytes(PLAIN.replace("\n", end).encode(coding))
    assert load_config(package).config.dive.name == "x"


def test_invalid_toml_is_shown_by_its_line(package):
    (package / "dive.toml").write_text(PLAIN + '[hull]\nmesh = "cad\\hull.stl"\n')
    with pytest.raises(UsageError, match=r'"cad\\hull\.stl"') as caught:
        load_config(package)
    assert caught.value.remedy == "write paths with / between folders"
