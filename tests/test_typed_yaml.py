"""YAML into dataclasses."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.typed_yaml import fill, override, parse


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
        ("cuont: 3", "thing.yaml: found the key 'cuont' (did you mean count?)"),
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
