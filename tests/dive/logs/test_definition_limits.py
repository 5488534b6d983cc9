# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import pytest

from hullrecon.dive.logs.messages import decode as decode_module
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.messages.definition_limits import check_idl, check_text, check_types
from hullrecon.dive.logs.messages.definitions import BUNDLED
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.readers.unpack import DamagedError

LINE = "=" * 80


def channel(
    definition: str, encoding: str = "ros1", form: str = "ros2msg", kind: str = "p/msg/T"
) -> Channel:
    return Channel("/t", kind, encoding, definition, form)


def types(**given: str) -> str:
    """A definition with further types behind it: T first, the others by name."""
    return (
        given.pop("T")
        + "\n"
        + "".join(f"{LINE}\nMSG: p/{name}\n{text}\n" for name, text in given.items())
    )


EMPTY_BOMB = (0xFFFFFFFF).to_bytes(4, "little")


@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
@pytest.mark.parametrize(
    ("definition", "why"),
    [
        (types(T="Foo[] foos", Foo=""), "a list of an empty type"),
        (
            types(T="Foo[1000000000] foos", Foo="uint8 a"),
            "read: it has an array of 1000000000 elements",
        ),
        (types(T="string[1000000000] names"), "an array of 1000000000 elements"),
        (types(T="uint8[999999999999] bytes"), "an array of 999999999999 elements"),
        (types(T="uint8[-1] bytes"), "an array of -1 elements"),
        (types(T="Foo[900] a\nFoo[900] b", Foo="uint8 a"), "arrays of 1800 messages"),
        (types(T="T again"), "contain each other without end|cannot be read"),
        (
            types(T="A0 a", **{f"A{i}": f"A{i + 1} a\nA{i + 1} b" for i in range(30)}, A30=""),
            "nested around nothing",
        ),
        (types(T="uint8 a", **{f"A{i}": "" for i in range(300)}), "301 types"),
        (types(T="\n".join(f"uint8 a{i}" for i in range(3000))), "3000 fields"),
        ("# " + "x" * 200_000, "characters"),
        (types(T=f"uint8 A={'9' * 10_000}"), "cannot be read"),
        ("\x00\x01\x02", "cannot be read"),
        (types(T="Missing a"), "cannot be read"),
    ],
)
def test_explosive_definitions_are_refused_in_a_short_line(encoding, definition, why):
    with pytest.raises(DamagedError, match=why) as caught:
        decode(channel(definition, encoding), EMPTY_BOMB * 4)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500


def test_failing_definition_is_tried_only_once(monkeypatch):
    tried = []
    monkeypatch.setattr(
        decode_module, "_from_definition", lambda channel: tried.append(channel) or 1 / 0
    )
    for _ in range(5):
        with pytest.raises(DamagedError, match="ZeroDivisionError"):
            decode(channel("uint8 once"), b"\x00")
    assert len(tried) == 1


@pytest.mark.parametrize(
    "expression",
    [
        "1 << 100000000000",
        "((1))",
        ")))((1))",
        "((((((((((((((((((((((((",
        "/* " * 10_000,
        '"' + "\\" * 9,
        "/*/",
        "sequence<" * 30,
    ],
)
def test_idl_that_computes_is_refused_before_it_is_parsed(expression):
    text = (
        f"module p {{ module msg {{ const long N = {expression}; struct T {{ uint8 a; }}; }}; }};"
    )
    with pytest.raises(DamagedError):
        check_idl(text)
    with pytest.raises(DamagedError, match="cannot be read"):
        decode(channel(text, "cdr", "ros2idl"), b"\x00\x01\x00\x00\x01")


def test_idl_as_ros_writes_it_passes():
    text = """module p { module msg {
      @verbatim (language="comment", text="a << b ((((((" "and more")
      struct T { @unit (value="m") double a; /* (((((( */ sequence<uint8, 4> b; // ((((((
      }; }; };"""
    check_idl(text)
    message = decode(
        channel(text, "cdr", "ros2idl"), b"\x00\x01\x00\x00" + bytes(8) + b"\x01\x00\x00\x00\x07"
    )
    assert message.b.tolist() == [7]


def test_bundled_definitions_stay_far_below_the_limits():
    for text in BUNDLED.values():
        check_text(text * 10)


def test_fixed_arrays_of_messages_and_numbers_decode():
    definition = types(
        T="Foo[3] foos\nfloat64[2] numbers\nstring[2] names\nFoo[0] none", Foo="uint8 a"
    )
    data = bytes([1, 2, 3]) + bytes(16) + b"\x01\x00\x00\x00a\x00\x00\x00\x00"
    message = decode(channel(definition), data)
    assert [foo.a for foo in message.foos] == [1, 2, 3]
    assert message.names == ["a", ""]


CODE = "__import__('os').system('touch code-has-run')"
PARTS = (
    "struct B { sequence<uint8, X> data; };",
    "struct B { string<X> data; };",
    "struct B { uint8 data[X]; };",
    "typedef uint8 T[X]; struct B { T data; };",
    "typedef sequence<uint8, X> T; struct B { T data; };",
)


@pytest.mark.parametrize("part", PARTS)
def test_a_constant_of_text_that_stands_for_a_bound_is_no_code(part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = f'module a {{ module msg {{ const string X = "{CODE}"; {part} }}; }};'
    channel = Channel(
        topic="/t", type="a/msg/B", encoding="cdr", definition=text, definition_format="ros2idl"
    )
    with pytest.raises(DamagedError, match="bound"):
        decode(channel, bytes(8))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "field", [(4, ((1, ("uint8", 0)), CODE)), (3, ((1, ("uint8", 0)), CODE)), (1, ("string", CODE))]
)
def test_a_bound_that_is_no_number_never_reaches_the_compiler(field):
    with pytest.raises(DamagedError, match="a bound that is no number"):
        check_types({"a/msg/B": ([], [("data", field)])}, "a/msg/B")
    check_types({"a/msg/B": ([], [("data", (4, ((1, ("uint8", 0)), None)))])}, "a/msg/B")
