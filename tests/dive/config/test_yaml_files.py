# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import time

import pytest

from hullrecon.dive.config.yaml_files import ROOM, parse_yaml


def doubling(levels: int) -> str:
    """A kilobyte of aliases that stand for 9 ** levels values."""
    lines = ["a0: &a0 [x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]" for k in range(1, levels)]
    return "\n".join(lines)


def test_plain_yaml_is_read():
    assert parse_yaml("a: 1\nb: [1, 2.5, x]\nc: {d: true}\n") == {
        "a": 1,
        "b": [1, 2.5, "x"],
        "c": {"d": True},
    }
    assert parse_yaml("") is None


def test_the_head_that_opencv_writes_is_left_out():
    assert parse_yaml("%YAML:1.0\n---\na: 1\n") == {"a": 1}


def test_the_end_that_ros_topic_echo_writes_is_left_out():
    assert parse_yaml("a: 1\n---\n") == {"a": 1}
    assert parse_yaml("a: 1\n---\n---") == {"a": 1}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\n---\na: 2\n", "found another document, in line 2"),
        ("a: 1\na: 2\n", 'found duplicate key "a".*, in line 2'),
        ("a:\n\tb: 1\n", "cannot start any token, in line 2"),
    ],
)
def test_what_is_no_yaml_is_told_with_its_line(text, words):
    with pytest.raises(ValueError, match=words):
        parse_yaml(text)


def test_aliases_as_programs_write_them_are_read():
    assert parse_yaml("a: &id001 [1, 2]\nb: *id001\n") == {"a": [1, 2], "b": [1, 2]}
    assert parse_yaml("a: &a {x: 1}\nb:\n  <<: *a\n  y: 2\n") == {
        "a": {"x": 1},
        "b": {"x": 1, "y": 2},
    }


def test_aliases_that_expand_beyond_the_file_are_refused():
    with pytest.raises(ValueError, match="aliases stand for more"):
        parse_yaml(doubling(9))


def test_merged_tables_are_counted_as_well():
    lines = ["a0: &a0 {x: 1}"]
    lines += [
        f"a{k}: &a{k}\n  <<: [{', '.join([f'*a{k - 1}'] * 9)}]\n  k{k}: 1" for k in range(1, 12)
    ]
    with pytest.raises(ValueError, match="aliases stand for more"):
        parse_yaml("\n".join(lines))


def test_a_long_file_without_aliases_is_read():
    count = ROOM + 100
    assert parse_yaml(f"[{','.join(['1'] * count)}]") == [1] * count


def test_an_alias_of_what_it_lies_in_is_refused():
    with pytest.raises(ValueError, match="what it lies in"):
        parse_yaml("&a [*a]")


@pytest.mark.parametrize("text", ["[" * 900, "{" * 900, "- " * 3000])
def test_nesting_that_python_gives_up_on_is_refused(text):
    with pytest.raises(ValueError, match="nested too deeply"):
        parse_yaml(text)


@pytest.mark.parametrize(
    "text",
    [
        "x: " + "1" * 10_000,
        "? {a: [1]}\n: 2",
        "!!python/object/apply:os.system [ls]",
        "a: !!timestamp 1",
        "a: [",
        "\0",
        "%TAG ! x",
        "<<: 1",
    ],
)
def test_parser_failure_becomes_a_one_line_value_error(text):
    with pytest.raises(ValueError, match=r".") as caught:
        parse_yaml(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["{a: " * 20_000 + "}" * 20_000, "a: " + "[" * 101, "b:\n  " + "- {" * 20_000]
)
def test_brackets_in_brackets_are_refused_before_they_are_parsed(text):
    begun = time.process_time()
    with pytest.raises(ValueError, match="nested too deeply"):
        parse_yaml(text)
    assert time.process_time() - begun < 1


@pytest.mark.parametrize("text", ["[" + "1," * 100_000 + "1]", "- 1\n" * 100_000])
def test_more_values_than_can_be_parsed_in_seconds_are_refused(text):
    with pytest.raises(ValueError, match="more than 20000 lines and values"):
        parse_yaml(text)


def test_a_hundred_brackets_side_by_side_are_no_nesting():
    assert parse_yaml("[" + "[1]," * 500 + "[1]]") == [[1]] * 501
