# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""simulate as a user calls it: its help, what is said, where, and the exit code."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from hullrecon_cli.main import main

from hullrecon.synthetic.options import options

BARE = (
    "--legs",
    "1",
    "--leg-length-m",
    "0.8",
    "--structures",
    "1",
    "--marks",
    "0",
    "--barnacles",
    "0",
)
QUICK = (*BARE, "--cameras", "none", "--no-sonar")


def call(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = main([str(a) for a in arguments])
    return code, *capfd.readouterr()


def test_help_describes_every_option_with_bounds(
    capfd: pytest.CaptureFixture[str],
) -> None:
    code, out, _ = call(capfd, "simulate", "--help")
    text = re.sub(r"\s+", " ", out)
    assert code == 0
    assert "what is true goes to FOLDER/truth" in text
    for option in options():
        assert f"--{option.name.replace('_', '-')} " in text
        assert option.meta.description in text
        assert not option.meta.unit or f"{option.meta.description} ({option.meta.bounds()})" in text


def test_a_dive_is_written_and_counted(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    code, out, err = call(capfd, "simulate", tmp_path / "dive", *QUICK)
    assert code == 0
    assert (tmp_path / "dive" / "dive.toml").exists()
    assert re.fullmatch(r"wrote \S+dive: \d\.\d s, \d+ camera frames, 1 object to be found\n", out)
    assert err == ""


def test_json_is_one_document_with_the_counts(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    code, out, _ = call(capfd, "simulate", tmp_path / "dive", *QUICK, "--json")
    made = json.loads(out)
    assert code == 0
    assert made["package"] == str(tmp_path / "dive")
    assert made["objects"] == 1
    assert made["seconds"] == pytest.approx(0.8 / 0.3 + 2, abs=0.5)


def test_option_out_of_bounds_ends_with_code_2(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    code, out, err = call(capfd, "simulate", tmp_path / "dive", "--legs", "0")
    assert code == 2
    assert out == ""
    assert err == "error: legs is 0: choose 1 to 200\n"
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_something_in_it_is_one_line_and_code_six(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    code, _, err = call(capfd, "simulate", tmp_path, *QUICK)
    assert code == 6
    assert "not empty" in err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_interrupted_simulation_leaves_nothing(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr("hullrecon.synthetic.package.write_truth", interrupt)
        assert call(capfd, "simulate", tmp_path / "dive", *QUICK)[0] == 130
    assert list(tmp_path.iterdir()) == []
    assert call(capfd, "simulate", tmp_path / "dive", *QUICK)[0] == 0


def test_simulate_counts_images_on_standard_error(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hullrecon.artifacts import progress

    monkeypatch.setattr(
        progress, "choose_progress", lambda *, quiet=False: progress.LogLines(seconds=0.0)
    )
    options = (
        *BARE,
        "--structures",
        "0",
        "--views",
        "1",
        "--image-width",
        "160",
        "--image-height",
        "128",
        "--no-sonar",
    )
    code, out, err = call(capfd, "simulate", tmp_path / "dive", *options)
    counts = [int(n) for n in re.findall(r"^images written: (\d+) of \d+$", err, re.M)]
    assert code == 0
    assert counts == list(range(len(counts)))
    assert len(counts) >= 4
    assert f"of {len(counts)}\n" in err
    assert out.startswith("wrote ")
