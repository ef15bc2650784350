"""YAML into dataclasses, strictly: every error names the file, the key, what was found, what was expected.

Drake's `yaml_load_typed` has the same idea and the same notation for alternatives (a tag that names the
type); it cannot fill frozen dataclasses, runs no validation and does not say where in a file a value stands.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml

from mmt_drake.errors import BadInput

T = TypeVar("T")

_TAG = "!"  # key under which a mapping keeps its tag


class _Loader(yaml.SafeLoader):
    """Safe YAML that keeps the tag of a mapping and refuses a key given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for i, key in enumerate(keys):
            if key in keys[:i]:
                raise yaml.constructor.ConstructorError(
                    problem=f"the key {key!r} twice", problem_mark=node.value[i][0].start_mark
                )
        return super().construct_mapping(node, deep)


def _tagged(loader: _Loader, suffix: str, node: yaml.Node) -> dict[str, Any]:
    if isinstance(node, yaml.ScalarNode) and node.value == "":
        return {_TAG: suffix}
    if not isinstance(node, yaml.MappingNode):
        raise yaml.constructor.ConstructorError(
            problem=f"the tag !{suffix} before something else than a mapping", problem_mark=node.start_mark
        )
    return {_TAG: suffix, **loader.construct_mapping(node, deep=True)}


_Loader.add_multi_constructor("!", _tagged)
# YAML 1.1 takes 1e-3 for text; engineers do not.
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def read_text(path: str | Path, what: str) -> str:
    """The text of a file.

    Raises:
        BadInput: it cannot be read, or is no UTF-8.
    """
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise BadInput(path, found=error.strerror or type(error).__name__, expected=what) from None
    except UnicodeDecodeError:
        raise BadInput(path, found="bytes that are no UTF-8 text", expected=what) from None


def parse(text: str, source: str) -> Any:
    """Plain data from YAML text; a tagged mapping keeps its tag.

    Raises:
        BadInput: it is no YAML, or gives a key twice.
    """
    try:
        return yaml.load(text, Loader=_Loader)  # the loader is a safe one
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        at = f"line {mark.line + 1}, column {mark.column + 1}" if mark else None
        raise BadInput(source, at=at, found=getattr(error, "problem", None) or "no YAML", expected="YAML") from None


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
            raise BadInput("--set", at=key, found=f"{'.'.join(parts[: i + 1])} = {below!r}", expected="a mapping there")
        data = below
    data[parts[-1]] = value


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
    if schema is int:
        if isinstance(data, bool) or not isinstance(data, int):
            raise _bad(source, at, data, "a whole number")
        return data
    if schema in (bool, str):
        if not isinstance(data, schema):
            raise _bad(source, at, data, "true or false" if schema is bool else "text")
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
    try:
        return schema(**values)
    except BadInput as error:
        # A class that checks itself does not know where its values come from.
        place = _join(at, str(error.at)) if error.at is not None else at
        raise BadInput(source, at=place or None, found=error.found, expected=error.expected) from None


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


def known_keys(data: Mapping[Any, Any], allowed: typing.Sequence[str], source: str, at: str) -> None:
    """Refuse keys that are not allowed, with the nearest one that is.

    Raises:
        BadInput: there is such a key.
    """
    for key in data:
        if key not in allowed:
            near = difflib.get_close_matches(str(key), allowed, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise BadInput(source, at=at or None, found=f"the key {key!r}{hint}", expected=f"{', '.join(allowed)}")


def _join(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key


def _bad(source: str, at: str, found: object, expected: str, *, quote: bool = True) -> BadInput:
    shown = repr(found) if quote else found
    return BadInput(source, at=at or None, found=shown, expected=expected)
