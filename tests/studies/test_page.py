# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page of the sources shows what every study came to."""

from __future__ import annotations

from pathlib import Path

from hullrecon.studies.page.page import render_page
from hullrecon.studies.registry import STUDIES
from hullrecon.studies.results import KeptFigure, KeptStudy
from hullrecon.studies.study import ComparedValue


def test_the_numbers_of_every_study_are_on_the_page_once(tmp_path: Path) -> None:
    kept = {
        study.id: KeptStudy(
            id=study.id,
            source=study.source,
            shows=study.shows,
            needs_dive=study.needs_dive,
            seconds=1.0,
            figures=(KeptFigure(name="drawn", caption="a picture"),),
            compared=(ComparedValue(what=f"found by {study.id}.", unit="", printed=1.0, ours=1.0),),
            heads=("table",),
            rows=((f"row of {study.id}.",),),
        )
        for study in STUDIES
    }
    page = render_page(kept, tmp_path)
    for study in STUDIES:
        assert page.count(f"found by {study.id}.") == 1, study.id
        assert page.count(f"row of {study.id}.") == 1, study.id
