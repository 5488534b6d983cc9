# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What [report] of dive.toml puts on the page."""

from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image
from report_pages import page_context

from hullrecon.errors import InputError
from hullrecon.report.logo import read_logo
from hullrecon.report.options import ReportOptions
from hullrecon.report.render import render_page
from hullrecon.report.survey import Survey

ABOUT = ReportOptions(
    client="Harbour & Sons",
    operator="Deep <Eye>",
    equipment=("A50 DVL", "two cameras"),
    water="6 m visibility",
    conclusion="No repair\nis due.\n\nLook again in May.",
)


def page_of(survey: Survey, about: ReportOptions, logo: bytes | None = None) -> str:
    """The page without its scripts."""
    facts = replace(survey.facts, about=about, logo=logo)
    page = render_page(page_context(replace(survey, facts=facts), [], {}, {}))
    return re.sub(r"(?s)<(script|style)\b.*?</\1>", "", page)


def picture(path: Path, size: tuple[int, int] = (1000, 100)) -> Path:
    Image.new("RGBA", size, (20, 90, 160, 255)).save(path)
    return path


def test_blocks_are_shown_as_they_were_written(survey: Survey) -> None:
    page = page_of(survey, ABOUT)
    for text in ("Harbour &amp; Sons", "Deep &lt;Eye&gt;", "A50 DVL; two cameras", "6 m visibility",
                 "<p>No repair is due.</p>", "<p>Look again in May.</p>"):  # fmt: skip
        assert text in page, text


def test_blocks_that_nobody_wrote_are_absent(survey: Survey) -> None:
    page = page_of(survey, ReportOptions())
    for text in ("The inspection", "Conclusion", "Client", 'class="logo"'):
        assert text not in page, text
    assert "Operator of the vessel" not in page_of(survey, ABOUT)
    assert ReportOptions(client="  ").rows() == []
    assert ReportOptions(conclusion=" \n\n ").paragraphs() == []


def test_a_logo_is_shown_small_and_without_what_its_file_says(
    tmp_path: Path, survey: Survey
) -> None:
    path = tmp_path / "logo.png"
    noted = Image.new("RGB", (1000, 100), (20, 90, 160))
    exif = noted.getexif()
    exif[0x013B] = "somebody's name"
    noted.save(path, exif=exif)
    logo = read_logo(path)
    with Image.open(BytesIO(logo)) as shown:
        assert shown.size == (640, 64)
        assert not shown.getexif()
    assert b"somebody" not in logo
    assert 'alt="Logo of Deep &lt;Eye&gt;"' in page_of(survey, ABOUT, logo)


@pytest.mark.parametrize(
    ("name", "data"),
    [("logo.svg", b"<svg xmlns='x'><script/></svg>"), ("logo.png", b"\x89PNG\r\n\x1a\n")],
)
def test_a_logo_that_is_no_picture_is_refused_in_one_line(
    tmp_path: Path, name: str, data: bytes
) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=r"report\.logo cannot be used: logo") as caught:
        read_logo(tmp_path / name)
    assert len(str(caught.value).splitlines()) == 1
    assert read_logo(picture(tmp_path / "right.png"))


def test_a_logo_too_large_to_be_one_is_refused(tmp_path: Path) -> None:
    (tmp_path / "logo.png").write_bytes(bytes(4 * 2**20 + 1))
    with pytest.raises(InputError, match="more than 4 MiB"):
        read_logo(tmp_path / "logo.png")
    with pytest.raises(InputError, match="no PNG, JPEG or WebP that can be read"):
        read_logo(picture(tmp_path / "bomb.png", (20000, 2001)))
    with pytest.raises(InputError, match="No such file"):
        read_logo(tmp_path / "gone.png")
