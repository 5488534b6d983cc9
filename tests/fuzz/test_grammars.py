# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The small grammars by their rules: fragments of TOML, cells of CSVs, the name of a dive."""

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from benchmarks.fuzz.cases import BAD, Bench
from benchmarks.fuzz.formats import seeds
from benchmarks.fuzz.seed_files import TABLES
from hullrecon.dive.config.load import load_config
from hullrecon.errors import InputError, UsageError

QUICK = settings(
    max_examples=75,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,99}")

text = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)
quoted = text.map(
    lambda t: (
        '"' + "".join(c if c.isalnum() and c.isascii() else f"\\U{ord(c):08x}" for c in t) + '"'
    )
)
number = st.one_of(
    st.integers().map(str),
    st.floats().map(str),
    st.integers(min_value=0).map(hex),
    st.sampled_from(
        [
            "1_000",
            "0b101",
            "0o17",
            "1e400",
            "-0.0",
            "+nan",
            "9" * 500,
            "0x" + "f" * 5000,
            "1.",
            ".5",
            "1e",
        ]
    ),
)
moment = st.one_of(
    st.datetimes().map(lambda d: d.isoformat()),
    st.sampled_from(["07:32:00", "2026-13-40", "2026-05-04T09:30:00Z"]),
)
value = st.recursive(
    st.one_of(quoted, number, moment, st.sampled_from(["true", "false", "''", '"""a\nb"""', ""])),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4).map(lambda items: f"[{', '.join(items)}]"),
        st.dictionaries(st.sampled_from(["a", "x", '"b c"']), inner, max_size=3).map(
            lambda d: "{" + ", ".join(f"{k} = {v}" for k, v in d.items()) + "}"
        ),
    ),
    max_leaves=8,
)
KEYS = [
    "dive.name",
    "dive.vessel",
    "dive.date",
    "logs.files",
    "topics.dvl",
    "tray.joint",
    "tray.origin",
    "imu.frame",
    "pressure.density",
    "dvl.mount",
    "dvl.beams",
    "dvl.beam_angle_deg",
    "dvl.beam_azimuth_deg",
    "camera.top.calibration",
    "camera.top.time_offset",
    "camera.bottom.pose_in_top",
    "sonar.joint",
    "hull.mesh",
    "hull.units",
    "hull.pose_sigma",
    "hull.deviation_length",
    "x",
    "dive",
    "camera",
]


@QUICK
@given(pairs=st.dictionaries(st.sampled_from(KEYS), value, max_size=5))
@example(pairs={"dive": "{name = 1}"})
def test_toml_fragment_is_a_configuration_or_refused_in_a_line(
    tmp_path: Path, pairs: dict[str, str]
) -> None:
    lines = {"dive.name": '"x"', "logs.files": '["a"]', **pairs}
    (tmp_path / "dive.toml").write_text(
        "".join(f"{key} = {item}\n" for key, item in lines.items()), encoding="utf-8"
    )
    line = ""
    try:
        assert NAME.fullmatch(load_config(tmp_path).config.dive.name)
    except (UsageError, InputError) as error:
        line = str(error)
    assert len(line.splitlines()) <= 1
    assert len(line) < 700


@QUICK
@given(name=text)
@example(name="..")
@example(name="x\n")
@example(name="x" * 101)
@example(name="x" * 100)
def test_a_name_is_taken_if_it_is_a_plain_folder_of_its_own(tmp_path: Path, name: str) -> None:
    escaped = "".join(f"\\U{ord(c):08x}" for c in name)
    (tmp_path / "dive.toml").write_text(f'[dive]\nname = "{escaped}"\n[logs]\nfiles = ["a"]\n')
    if NAME.fullmatch(name):
        assert load_config(tmp_path).config.dive.name == name
        assert (tmp_path / name).resolve().parent == tmp_path.resolve()
    else:
        with pytest.raises(UsageError, match=r"dive\.name"):
            load_config(tmp_path)


cell = st.one_of(
    text,
    number,
    st.sampled_from(
        [
            "",
            " ",
            '"',
            '"a,b"',
            "'",
            "\\",
            "1;2",
            "../../x",
            "/dev/null",
            "p.npz",
            "a.png",
            "1e19",
            "-1e19",
            "0x1",
        ]
    ),
)


@settings(QUICK, max_examples=60)
@given(
    table=st.sampled_from(sorted(TABLES)),
    rows=st.lists(st.lists(cell, max_size=9), max_size=5),
    keeps_head=st.booleans(),
)
def test_any_cells_of_a_table_are_readings_or_named(
    bench: Bench, table: str, rows: list[list[str]], keeps_head: bool
) -> None:
    number = sorted_targets().index(f"logs/{table}.csv")
    whole = TABLES[table].splitlines()
    lines = [*(whole[:1] if keeps_head else []), *whole[1:2], *(",".join(row) for row in rows)]
    verdict = bench.judge("plain", number, "\n".join(lines).encode())
    assert verdict.kind not in BAD, verdict.text


def sorted_targets() -> list[str]:
    return [seed.target for seed in seeds()["plain"]]
