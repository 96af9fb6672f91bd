"""Java's .properties files."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.datasets.java_properties import parse_properties
from circumspect.errors import InputError


@pytest.mark.parametrize(
    ("text", "properties"),
    [
        ("", {}),
        ("name#1=Bed", {"name#1": "Bed"}),
        ("a=1\nb:2\r\nc 3\rd\t= 4", {"a": "1", "b": "2", "c": "3", "d": "4"}),
        ("# comment\n! comment\n\n  \t\n  a  =  1  ", {"a": "1  "}),
        ("a = b = c", {"a": "b = c"}),
        ("a", {"a": ""}),
        ("=1", {"": "1"}),
        ("a=1\na=2", {"a": "2"}),
        ("a=one, \\\n   # two", {"a": "one, # two"}),
        ("a=1\\\\\nb=2", {"a": "1\\", "b": "2"}),
        ("a=cut\\", {"a": "cut"}),
        (r"a\ b\:c\=d=1", {"a b:c=d": "1"}),
        (r"a=\t\n\r\f\q\"", {"a": '\t\n\r\fq"'}),
        (r"a=\u00e9\u4e2d", {"a": "é中"}),
        (r"a=\ud83d\ude00", {"a": "😀"}),
        (r"a=\\u0041", {"a": r"\u0041"}),
        ("a=\xa9", {"a": "©"}),
    ],
)
def test_properties_as_java_reads_them(text, properties):
    assert parse_properties(text.encode("latin-1")) == properties


@pytest.mark.parametrize("escape", [r"\u", r"\u12", r"\u12g4", r"\uu123"])
def test_broken_escape_is_refused(escape):
    with pytest.raises(InputError, match="broken escape"):
        parse_properties(f"a={escape}".encode())


@given(
    st.dictionaries(
        st.text(st.characters(exclude_categories=["Cs"])),
        st.text(st.characters(exclude_categories=["Cs"])),
    )
)
def test_round_trip_of_escaped_text(properties):
    def escaped(text):
        units = text.encode("utf-16-be")
        return "".join(f"\\u{a:02x}{b:02x}" for a, b in zip(units[::2], units[1::2], strict=True))

    lines = "\n".join(f"{escaped(key)}={escaped(value)}" for key, value in properties.items())
    assert parse_properties(lines.encode()) == properties


@given(st.binary(max_size=200))
def test_any_bytes_give_text_or_a_known_error(data):
    try:
        properties = parse_properties(data)
    except InputError:
        return
    assert all(isinstance(text, str) for pair in properties.items() for text in pair)
