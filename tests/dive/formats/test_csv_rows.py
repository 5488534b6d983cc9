# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import csv
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.formats.csv_rows import LONGEST_LINE, read_rows
from hullrecon.errors import InputError

QUICK = settings(
    max_examples=50,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
CELLS = st.text(st.characters(codec="utf-8", exclude_characters='\r\n\0"'), max_size=8).map(
    str.strip
)


def rows(tmp_path: Path, text: str | bytes, needed=("a",)):
    path = tmp_path / "x.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return list(read_rows(path, needed))


@QUICK
@given(
    st.lists(st.lists(CELLS, min_size=2, max_size=2), max_size=5), st.sampled_from(["\n", "\r\n"])
)
def test_rows_written_by_csv_module_are_read_with_line_numbers(tmp_path, table, end):
    path = tmp_path / "x.csv"
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator=end).writerows([["a", "b"], *table])
    assert list(read_rows(path, ("a", "b"))) == [
        (n, dict(zip("ab", row, strict=True))) for n, row in enumerate(table, 2)
    ]


def test_blank_lines_are_passed_over_and_counted_as_lines(tmp_path):
    assert rows(tmp_path, "a\n1\n\n\n2\n") == [(2, {"a": "1"}), (5, {"a": "2"})]


def test_missing_cells_are_empty_and_extra_cells_are_dropped(tmp_path):
    assert rows(tmp_path, "a,b\n1\n1,2,3\n") == [
        (2, {"a": "1", "b": ""}),
        (3, {"a": "1", "b": "2"}),
    ]


def test_a_last_line_that_is_short_and_has_no_end_is_cut(tmp_path):
    assert rows(tmp_path, "a,b\n1,2\n1") == [(2, {"a": "1", "b": "2"}), (3, None)]
    assert rows(tmp_path, "a,b\n1,2\n1,3") == [(2, {"a": "1", "b": "2"}), (3, {"a": "1", "b": "3"})]


@pytest.mark.parametrize("length", [LONGEST_LINE - 1, LONGEST_LINE, 3 * LONGEST_LINE])
def test_a_line_that_is_too_long_costs_itself(tmp_path, length):
    found = rows(tmp_path, "a\n1\n" + "x" * length + "\n2\n")
    assert found[0] == (2, {"a": "1"})
    assert found[-1] == (4, {"a": "2"})
    assert (found[1][1] is None) == (length >= LONGEST_LINE)


def test_a_header_of_a_thousand_columns_is_refused(tmp_path):
    """Each of a million short lines would become a row of so many cells."""
    with pytest.raises(InputError, match="has 1000 columns"):
        rows(tmp_path, "a" + ",b" * 999 + "\n" + "1\n" * 10)
    assert rows(tmp_path, "a,b\n1,2\n")


def test_a_missing_column_is_named(tmp_path):
    with pytest.raises(InputError, match=r"x\.csv has no column c"):
        rows(tmp_path, "a,b\n", ("a", "c"))
    for separator in ",;\t":
        assert rows(tmp_path, f"a{separator}c\n1{separator}2\n", ("a", "c"))


@QUICK
@given(st.binary(max_size=300))
def test_any_bytes_are_rows_or_bad_lines(tmp_path, tail):
    found = rows(tmp_path, b"a,b\n1,2\n" + tail)
    assert found[0] == (2, {"a": "1", "b": "2"})
    assert all(row is None or set(row) == {"a", "b"} for _, row in found)


TABLE = "t,vx,name\n1.5,-0.25,a\n2.5,0.5,b\n"
READ = [{"t": "1.5", "vx": "-0.25", "name": "a"}, {"t": "2.5", "vx": "0.5", "name": "b"}]


@pytest.mark.parametrize(
    "text",
    [
        TABLE.replace(",", ";"),
        TABLE.replace(",", "\t"),
        TABLE.replace(",", ";").replace(".", ","),
        TABLE.replace(",", "\t").encode("utf-16"),
        TABLE.replace("t,vx,name", "T , Vx , NAME "),
        "# DVL-Logger 2.1\nvessel, x\n\n" + TABLE,
    ],
    ids=["semicolons", "tabs", "decimal commas", "UTF-16", "capitals", "preamble"],
)
def test_tables_of_spreadsheets_and_loggers_are_read(tmp_path, text):
    assert [row for _, row in rows(tmp_path, text, ("t", "vx"))] == READ


def test_a_second_header_in_another_order_holds_for_the_rows_below_it(tmp_path):
    """A logger that was started anew, with other settings, appends to its file."""
    appended = TABLE + "name,vx,t\nb,0.5,2.5\n"
    (_, row) = rows(tmp_path, appended, ("t", "vx"))[-1]
    assert row == {"t": "2.5", "vx": "0.5", "name": "b"}


def test_a_comma_in_a_text_is_no_decimal_point(tmp_path):
    ((_, row),) = rows(tmp_path, "t;file\n1,5;img 0,1.jpg\n", ("t", "file"))
    assert row == {"t": "1.5", "file": "img 0,1.jpg"}


def test_a_table_without_header_is_shown_by_its_first_line(tmp_path):
    with pytest.raises(InputError, match=r"no column t, vx: it begins with '1\.5,-0\.25,a'"):
        rows(tmp_path, TABLE.partition("\n")[2], ("t", "vx"))


def test_a_column_that_is_there_twice_is_refused(tmp_path):
    with pytest.raises(InputError, match="has the column vy 2 times"):
        rows(tmp_path, "t,vx,vy,vy,vz\n1,2,3,4,5\n", ("t", "vx", "vy", "vz"))
    assert rows(tmp_path, "t,vx,vy,other,vz\n1,2,3,4,5\n", ("t", "vx", "vy", "vz"))
