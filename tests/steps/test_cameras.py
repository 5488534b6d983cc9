# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

from hullrecon.steps.cameras import cameras_file


def test_the_refined_cameras_go_before_the_calibration(tmp_path: Path) -> None:
    inputs = {"ingest": tmp_path / "ingest", "adjust": tmp_path / "adjust"}
    for folder in inputs.values():
        folder.mkdir()
    assert cameras_file(inputs) == tmp_path / "ingest" / "cameras.json"
    (tmp_path / "adjust" / "cameras.json").write_text("{}")
    assert cameras_file(inputs) == tmp_path / "adjust" / "cameras.json"
    assert cameras_file({"ingest": inputs["ingest"]}) == tmp_path / "ingest" / "cameras.json"
