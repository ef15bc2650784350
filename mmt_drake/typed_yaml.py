"""YAML into dataclasses, strictly: every error names the file, the key, what was found, what was expected.

Drake's `yaml_load_typed` has the same idea and the same notation for alternatives (a tag that names the
type); it cannot fill frozen dataclasses, runs no validation and does not say where in a file a value stands.
"""

import dataclasses
import math
import re
import reprlib
import types
import typing
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import yaml

from mmt_drake.errors import BadInput, located, suggest

T = TypeVar("T")

_TAG = "!"  # key under which a mapping keeps its tag
_MOST_BYTES = 1 << 18  # of a file; what the project writes is a few thousand long
_MOST_NODES = 20_000  # of a document, where each alias counts as what it stands for
_DEEPEST = 50  # mappings and lists within each other
_LONGEST = 250  # characters of a whole number, which then still is a float, and of a message

_shown = reprlib.Repr()  # a value in a message: it may be as large as a file
_shown.maxstring = _shown.maxother = _shown.maxlong = 120


class _Loader(yaml.BaseLoader):
    """The core schema of YAML 1.2, and tags of mappings, which are kept; within bounds, and no key twice."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._nodes = self._depth = 0
        self._sizes: dict[str, int] = {}

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = cast(Any, self).peek_event()  # PyYAML says no type of it
        before = self._nodes
        anchor = getattr(event, "anchor", None)
        if isinstance(event, yaml.AliasEvent) and anchor in self.anchors:
            if anchor not in self._sizes:
                raise _no_yaml(f"the alias *{anchor} within what it stands for", event)
            self._nodes += self._sizes[anchor]
        self._nodes, self._depth = self._nodes + 1, self._depth + 1
        if self._nodes > _MOST_NODES:
            raise _no_yaml(f"more than {_MOST_NODES} values", event)
        if self._depth > _DEEPEST:
            raise _no_yaml(f"more than {_DEEPEST} mappings and lists within each other", event)
        node = super().compose_node(parent, index)
        if anchor is not None:
            self._sizes[anchor] = self._nodes - before
        self._depth -= 1
        return node

    def construct_mapping(self, node: Any, deep: bool = True) -> dict[Any, Any]:
        if not isinstance(node, yaml.MappingNode):
            raise _no_yaml("!!map before something else than a mapping", node)
        keys = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode) or key_node.value == _TAG:
                raise _no_yaml("a key that is no name", key_node)
            key = self.construct_object(key_node)
            if isinstance(key, dict):  # a tag with nothing after it
                raise _no_yaml("a key that is no name", key_node)
            if key in keys:
                raise _no_yaml(f"the key {_shown.repr(key)} twice", key_node)
            keys.add(key)
        return super().construct_mapping(node, deep=True)


def _no_yaml(problem: str, where: Any) -> yaml.constructor.ConstructorError:
    """The error at a node or an event."""
    return yaml.constructor.ConstructorError(problem=problem, problem_mark=where.start_mark)


def _tagged(loader: _Loader, suffix: str, node: yaml.Node) -> dict[str, Any]:
    if isinstance(node, yaml.ScalarNode) and node.value == "":
        return {_TAG: suffix}
    if not isinstance(node, yaml.MappingNode):
        raise _no_yaml(f"the tag {_shown.repr('!' + suffix)} before something else than a mapping", node)
    return {_TAG: suffix, **loader.construct_mapping(node)}


def _unknown(_: _Loader, node: yaml.Node) -> None:
    raise _no_yaml(f"the tag {_shown.repr(node.tag)}", node)


def _whole(text: str) -> int:
    if len(text) > _LONGEST:
        raise ValueError(f"a whole number of {len(text)} characters")
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))


def _text(text: str) -> str:
    if not text.isprintable():  # nor would it be a line, a name of a file, or safe on a terminal
        raise ValueError(f"{_shown.repr(text)}, which cannot be printed")
    return text


# Chapter 10.3 of YAML 1.2.2. Whatever else YAML 1.1 takes for a number, a date or a truth is text: 1:30, 1_000, yes.
_SCALARS: dict[str, tuple[str, Callable[[str], Any]]] = {
    "null": (r"null|Null|NULL|~|", lambda _: None),
    "bool": (r"true|True|TRUE|false|False|FALSE", lambda text: text.lower() == "true"),
    "int": (r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", _whole),
    "float": (
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        lambda text: float(re.sub(r"\.(?=[inIN])", "", text)),
    ),
    "str": (r"(?s:.*)", _text),
}


def _scalar(kind: str) -> Callable[[_Loader, yaml.Node], Any]:
    pattern, read = re.compile(rf"(?:{_SCALARS[kind][0]})\Z"), _SCALARS[kind][1]

    def construct(loader: _Loader, node: Any) -> Any:
        text = loader.construct_scalar(node)
        try:
            if pattern.match(text):  # always, unless the tag is written out: !!float abc
                return read(text)
        except ValueError as error:
            raise _no_yaml(str(error), node) from None
        raise _no_yaml(f"!!{kind} before {_shown.repr(text)}", node)

    return construct


for _kind, (_pattern, _) in _SCALARS.items():
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _scalar(_kind))
    if _kind != "str":
        _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_kind}", re.compile(rf"(?:{_pattern})\Z"), None)
_Loader.add_constructor("tag:yaml.org,2002:seq", partial(_Loader.construct_sequence, deep=True))
_Loader.add_constructor("tag:yaml.org,2002:map", _Loader.construct_mapping)
_Loader.add_constructor(None, _unknown)
_Loader.add_multi_constructor("!", _tagged)


def read_text(path: str | Path, what: str) -> str:
    """The text of a file.

    Args:
        path: of the file.
        what: it should be.

    Raises:
        BadInput: it cannot be read, is too long, or is no UTF-8.
    """
    try:
        with Path(path).open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise BadInput(path, found=f"more than {_MOST_BYTES} bytes", expected=what)
        return content.decode("utf-8")
    except OSError as error:
        raise BadInput(path, found=(error.strerror or type(error).__name__).lower(), expected=what) from None
    except UnicodeDecodeError:
        raise BadInput(path, found="bytes that are no UTF-8 text", expected=what) from None


def parse(text: str, source: str) -> Any:
    """Plain data from YAML 1.2 text (core schema); a tagged mapping keeps its tag.

    Raises:
        BadInput: it is no YAML, gives a key twice, or is beyond what can be meant: nested 50 deep, or 20 000 values.
    """
    try:
        return yaml.load(text, Loader=_Loader)  # makes plain data alone
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        at = f"line {mark.line + 1}, column {mark.column + 1}" if mark else None
        problem = getattr(error, "problem", None) or str(error).partition("\n")[0]  # of a character that no text has
        problem = problem.removeprefix("but ").removeprefix("found ")
        expected = "each key once" if problem.endswith("twice") else "YAML"
        raise BadInput(source, at=at, found=problem[:_LONGEST], expected=expected) from None
    except (ValueError, OverflowError):  # of `chr`
        raise BadInput(source, found="an escape for a character that Unicode does not have", expected="YAML") from None


def fill(schema: type[T], data: object, source: str, at: str = "") -> T:
    """A value of the type `schema` from plain data.

    Understands dataclasses (whose missing fields keep their defaults, as those whose metadata has `in_files: False`
    always do), float, int, bool, str, tuples, lists,
    dictionaries with text keys, Literal, Optional, and unions of dataclasses told apart by a tag with the
    class's name (the first one needs none).

    Raises:
        BadInput: an unknown key or tag, a value of the wrong kind or not finite, and what the dataclasses
            themselves refuse.
    """
    result: T = _convert(schema, data, source, at)
    return result


def override(data: dict[str, Any], assignment: str) -> None:
    """Apply `key.sub=value` to plain data in place; the value is YAML.

    Raises:
        BadInput: no `=`, no YAML, or a key below something that has none.
    """
    key, equals, text = assignment.partition("=")
    parts = key.split(".")
    if not equals or not all(parts):
        raise BadInput("--set", found=assignment, expected="key=value or key.sub=value")
    value = parse(text, f"--set {key}")
    for i, part in enumerate(parts[:-1]):
        below = data.setdefault(part, {})
        if below is None:
            below = data[part] = {}
        if not isinstance(below, dict):
            raise BadInput(
                "--set", at=key, found=f"{'.'.join(parts[: i + 1])} = {_shown.repr(below)}", expected="a mapping there"
            )
        data = below
    data[parts[-1]] = value


_PLAIN = {int: "a whole number", bool: "true or false", str: "text"}


def _convert(schema: Any, data: object, source: str, at: str) -> Any:
    origin, arguments = typing.get_origin(schema), typing.get_args(schema)
    if origin in (typing.Union, types.UnionType):
        return _union(arguments, data, source, at)
    if dataclasses.is_dataclass(schema):
        return _dataclass(schema, data, source, at)
    if origin is typing.Literal:
        if data not in arguments:
            raise _bad(source, at, data, f"one of {', '.join(map(str, arguments))}")
        return data
    if origin in (tuple, list):
        return _sequence(origin, arguments, data, source, at)
    if origin is dict:
        if not isinstance(data, dict) or not all(isinstance(key, str) for key in data):
            raise _bad(source, at, data, "a mapping")
        return {key: _convert(arguments[1], value, source, _join(at, key)) for key, value in data.items()}
    if schema is float:
        if isinstance(data, bool) or not isinstance(data, int | float):
            raise _bad(source, at, data, "a finite number")
        try:
            number = float(data)
        except OverflowError:
            raise _bad(source, at, "a whole number of hundreds of digits", "a finite number", quote=False) from None
        if not math.isfinite(number):
            raise _bad(source, at, data, "a finite number")
        return number
    if schema in _PLAIN:
        if type(data) is not schema:
            raise _bad(source, at, data, _PLAIN[schema])
        return data
    raise TypeError(f"no rule to read {schema} from YAML")


def _union(arguments: tuple[Any, ...], data: object, source: str, at: str) -> Any:
    if data is None and type(None) in arguments:
        return None
    kinds: list[type] = [kind for kind in arguments if kind is not type(None)]
    classes = {kind.__name__: kind for kind in kinds if dataclasses.is_dataclass(kind)}
    if len(kinds) == 1:
        return _convert(kinds[0], data, source, at)
    if len(classes) == len(kinds) and isinstance(data, dict):
        tag = data.get(_TAG, next(iter(classes)))
        if tag not in classes:
            raise _bad(source, at, f"!{tag}", f"one of {', '.join('!' + name for name in classes)}", quote=False)
        return _convert(classes[tag], data, source, at)
    for kind in kinds:
        if kind in (int, str, bool, float) and type(data) is kind:
            return _convert(kind, data, source, at)
    if float in kinds and type(data) is int:
        return _convert(float, data, source, at)
    names = (f"!{kind.__name__} {{...}}" if kind.__name__ in classes else kind.__name__ for kind in kinds)
    raise _bad(source, at, data, " or ".join(names))


def _dataclass(schema: Any, data: object, source: str, at: str) -> Any:
    if data is None:
        data = {}
    if not isinstance(data, dict):
        raise _bad(source, at, data, "a mapping")
    tag = data.get(_TAG, schema.__name__)
    if tag != schema.__name__:
        raise _bad(source, at, f"!{tag}", f"!{schema.__name__}", quote=False)
    hints = typing.get_type_hints(schema)
    names = [f.name for f in dataclasses.fields(schema) if f.init and f.metadata.get("in_files", True)]
    known_keys({key: value for key, value in data.items() if key != _TAG}, names, source, at)
    values = {key: _convert(hints[key], value, source, _join(at, key)) for key, value in data.items() if key != _TAG}
    with located(source, at):
        return schema(**values)


def _sequence(origin: Any, arguments: tuple[Any, ...], data: object, source: str, at: str) -> Any:
    if not isinstance(data, list):
        raise _bad(source, at, data, "a list")
    if origin is tuple and Ellipsis not in arguments:
        if len(data) != len(arguments):
            raise _bad(source, at, data, f"a list of {len(arguments)}")
        kinds = arguments
    else:
        kinds = (arguments[0],) * len(data)
    return origin(_convert(k, v, source, f"{at}[{i}]") for i, (k, v) in enumerate(zip(kinds, data, strict=True)))


def mapping(data: object, source: str, at: str) -> Mapping[str, Any]:
    """A mapping of names to values.

    Raises:
        BadInput: it is something else.
    """
    if not isinstance(data, dict) or not all(isinstance(key, str) for key in data):
        raise BadInput(source, at=at, found=type(data).__name__, expected="a mapping of names to values")
    return data


def known_keys(data: Mapping[Any, Any], allowed: typing.Sequence[str], source: str, at: str) -> None:
    """Refuse keys that are not allowed, with the nearest one that is.

    Raises:
        BadInput: there is such a key.
    """
    for key in data:
        if key not in allowed:
            raise BadInput(
                source,
                at=at or None,
                found=f"the key {_shown.repr(key)}{suggest(str(key), allowed)}",
                expected=f"{', '.join(allowed)}",
            )


def _join(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key


def _bad(source: str, at: str, found: object, expected: str, *, quote: bool = True) -> BadInput:
    shown = _shown.repr(found) if quote else found
    return BadInput(source, at=at or None, found=shown, expected=expected)
