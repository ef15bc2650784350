"""YAML into dataclasses."""

import math
from dataclasses import dataclass, field
from typing import Literal

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.typed_yaml import fill, override, parse, read_text


@dataclass(frozen=True)
class Round:
    radius: float = 1.0

    def __post_init__(self) -> None:
        if self.radius <= 0:
            raise BadInput("round", at="radius", found=self.radius, expected="above 0")


@dataclass(frozen=True)
class Flat:
    sides: tuple[float, float] = (1.0, 2.0)


@dataclass(frozen=True)
class Thing:
    shape: Round | Flat = Round()
    count: int = 3
    colour: Literal["red", "blue"] = "red"
    label: str | None = None
    tags: dict[str, float | str] = field(default_factory=dict)
    open: bool = False


def read(text):
    return fill(Thing, parse(text, "thing.yaml"), "thing.yaml")


def test_everything_has_a_default_and_can_be_said():
    assert read("") == Thing()
    text = "{shape: !Flat {sides: [3, 4e-1]}, count: 5, colour: blue, label: a, tags: {x: 1, y: b}, open: true}"
    assert read(text) == Thing(Flat((3.0, 0.4)), 5, "blue", "a", {"x": 1.0, "y": "b"}, True)


def test_the_first_alternative_needs_no_tag():
    assert read("shape: {radius: 2}") == Thing(Round(2.0))
    assert read("shape: !Flat") == Thing(Flat())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("cuont: 3", "thing.yaml: found the key 'cuont' (did you mean 'count'?)"),
        ("count: 1.5", "thing.yaml: count: found 1.5, expected a whole number"),
        ("count: true", "thing.yaml: count: found True"),
        ("shape: {radius: -1}", "thing.yaml: shape.radius: found -1.0, expected above 0"),
        ("shape: !Oval {}", "thing.yaml: shape: found !Oval, expected one of !Round, !Flat"),
        ("shape: Flat", "thing.yaml: shape: found 'Flat', expected !Round {...} or !Flat {...}"),
        ("shape: {radius: .inf}", "thing.yaml: shape.radius: found inf"),
        ("shape: !Flat {sides: [1]}", "thing.yaml: shape.sides: found [1], expected a list of 2"),
        ("colour: green", "thing.yaml: colour: found 'green', expected one of red, blue"),
        ("label: 4", "thing.yaml: label: found 4, expected text"),
        ("open: 1", "thing.yaml: open: found 1, expected true or false"),
        ("[1]", "thing.yaml: found [1], expected a mapping"),
        ("{count: 1, count: 2}", "thing.yaml: line 1, column 12: found the key 'count' twice"),
        ("{", "thing.yaml: line 1"),
    ],
)
def test_what_does_not_fit_is_named_with_its_place(text, message):
    with pytest.raises(BadInput) as error:
        read(text)
    assert str(error.value).startswith(message)


def test_override_reaches_into_the_tree_and_keeps_tags():
    data = parse("shape: !Flat {sides: [1, 1]}", "thing.yaml")
    override(data, "shape.sides=[5, 6]")
    override(data, "count=7")
    assert fill(Thing, data, "thing.yaml") == Thing(Flat((5.0, 6.0)), 7)


@pytest.mark.parametrize("assignment", ["count", "=3", "a..b=1", "count=[", "count.x=1"])
def test_a_broken_override_is_refused(assignment):
    data = {"count": 3}
    with pytest.raises(BadInput, match="--set"):
        override(data, assignment)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0500", 500),
        ("010", 10),
        ("0o17", 15),
        ("0x1F", 31),
        ("-3", -3),
        ("1e-3", 1e-3),
        ("+12e03", 12e3),
        (".5", 0.5),
        ("5.", 5.0),
        ("-.inf", -math.inf),
        ("!!float 3", 3.0),
        ("!!str 3", "3"),
        ("TRUE", True),
        ("~", None),
        ("1:30", "1:30"),
        ("190:20:30.15", "190:20:30.15"),
        ("1_000", "1_000"),
        ("0b11", "0b11"),
        ("-0x1F", "-0x1F"),
        ("0o8", "0o8"),
        ("1e", "1e"),
        ("yes", "yes"),
        ("off", "off"),
        ("2001-02-30", "2001-02-30"),
        ("2001-02-03 04:05:06", "2001-02-03 04:05:06"),
        ("=", "="),
        ("{<<: 1}", {"<<": 1}),
        ("[&a 1, *a]", [1, 1]),
    ],
)
def test_a_plain_word_is_what_the_core_schema_of_yaml_1_2_takes_it_for(text, value):
    found = parse(text, "thing.yaml")
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("!!float abc", "line 1, column 1: found !!float before 'abc'"),
        ("!!int 1:30", "line 1, column 1: found !!int before '1:30'"),
        ("9" * 4301, "line 1, column 1: found a whole number of 4301 characters"),
        ("a: " + "[" * 2000, "line 1, column 53: found more than 50 mappings and lists within each other"),
        ("{a: " * 2000, "found more than 50 mappings"),
        ("- 1\n" * 20_000, "line 20000, column 3: found more than 20000 values"),
        ("- &a0 1\n" + "".join(f"- &a{i + 1} [{f'*a{i}, ' * 10}]\n" for i in range(9)), "more than 20000 values"),
        ("&a [*a]", "line 1, column 5: found the alias *a within what it stands for"),
        ("*a", "line 1, column 1: found undefined alias 'a'"),
        ("!!map [1]", "line 1, column 1: found !!map before something else than a mapping"),
        ("!!seq 1", "line 1, column 1: found expected a sequence node"),
        ("!!int [1]", "line 1, column 1: found expected a scalar node"),
        ("!!set {a}", "found the tag 'tag:yaml.org,2002:set'"),
        ("!!python/object/apply:os.getcwd []", "found the tag"),
        ("!!binary aaaa", "found the tag"),
        ("{!Flat : 2}", "line 1, column 2: found a key that is no name"),
        ("{[1]: 2}", "line 1, column 2: found a key that is no name"),
        ('{"!": [1]}', "line 1, column 2: found a key that is no name"),
        ('"\\UFFFFFFFF"', "found an escape for a character that Unicode does not have"),
        ('a: "\\ud800"', "line 1, column 4: found '\\ud800', which cannot be printed"),
        ('a: "\\e[2J"', "line 1, column 4: found '\\x1b[2J', which cannot be printed"),
        ("!" + "a" * 5000 + " b", "found the tag '!aaa"),
        ("a: \0", "found unacceptable character #x0000: special characters are not allowed"),
        ("a: 1\n---\nb: 2", "line 2, column 1: found another document"),
    ],
)
def test_what_no_one_means_is_refused_in_one_short_line(text, message):
    with pytest.raises(BadInput) as error:
        parse(text, "thing.yaml")
    assert message in str(error.value) and len(str(error.value)) < 400


def test_a_value_in_a_message_is_cut_short():
    with pytest.raises(BadInput) as error:
        fill(Thing, {"count": ["a" * 10_000] * 100, "label": "b"}, "thing.yaml")
    assert len(str(error.value)) < 1000


def test_a_file_without_end_is_not_read_to_it(tmp_path):
    path = tmp_path / "long.yaml"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # sparse
    with pytest.raises(BadInput, match="more than 262144 bytes"):
        read_text(path, "YAML")
