"""Dataclasses of a diagnosis into plain JSON data and back, strictly."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Mapping
from typing import Any, TypeVar

from mmt_drake.errors import BadInput
from mmt_drake.typed_yaml import fill, known_keys

T = TypeVar("T")


def plain(value: object, source: str, at: str = "") -> Any:
    """What `json.dump` takes: dataclasses and mappings as dictionaries in their order, tuples as lists.

    Raises:
        BadInput: a number is not finite, or a value is of a kind that JSON does not have.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = (field.name for field in dataclasses.fields(value))
        return {name: plain(getattr(value, name), source, _below(at, name)) for name in names}
    if isinstance(value, Mapping):
        return {str(key): plain(item, source, _below(at, str(key))) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item, source, f"{at}[{i}]") for i, item in enumerate(value)]
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, int | float) and math.isfinite(value):
        return int(value) if isinstance(value, int) else float(value)  # numpy's float64 is a float
    raise BadInput(source, at=at or None, found=repr(value), expected="a finite number, text, a flag or null")


def read(schema: type[T], data: object, source: str, at: str = "") -> T:
    """A value of the type `schema` from parsed JSON: the inverse of `plain`.

    Understands dataclasses, mappings with text keys, tuples, unions told apart by the kind of the data, and whatever
    `typed_yaml.fill` reads. Fields with a default may be missing, any other may not.

    Raises:
        BadInput: a key is missing or unknown, a value is of the wrong kind or not finite, or a dataclass refuses it.
    """
    result: T = _read(schema, data, source, at)
    return result


def _read(schema: Any, data: object, source: str, at: str) -> Any:
    origin, arguments = typing.get_origin(schema), typing.get_args(schema)
    if origin in (typing.Union, types.UnionType):
        if data is None and type(None) in arguments:
            return None
        return _read(_member(arguments, data), data, source, at)
    if dataclasses.is_dataclass(schema):
        return _read_fields(schema, _mapping(data, source, at), source, at)
    if origin is Mapping:
        items = _mapping(data, source, at).items()
        return {key: _read(arguments[1], value, source, _below(at, key)) for key, value in items}
    if origin is tuple and isinstance(data, list):
        if arguments[-1] is not Ellipsis and len(data) != len(arguments):
            raise BadInput(source, at=at, found=f"{len(data)} values", expected=f"{len(arguments)}")
        kinds = (arguments[0],) * len(data) if arguments[-1] is Ellipsis else arguments
        pairs = zip(kinds, data, strict=True)
        return tuple(_read(kind, item, source, f"{at}[{i}]") for i, (kind, item) in enumerate(pairs))
    return fill(schema, data, source, at)


def _member(kinds: tuple[Any, ...], data: object) -> Any:
    """The member of a union that data of this kind belongs to; the first one, which will refuse it, if there is none.

    No union here has two members of one kind.
    """
    known = [kind for kind in kinds if kind is not type(None)]
    wanted = {list: tuple, dict: Mapping, int: float}.get(type(data), type(data))
    for kind in known:
        if wanted in (kind, typing.get_origin(kind)) or (wanted is Mapping and dataclasses.is_dataclass(kind)):
            return kind
    return known[0]


def _read_fields(schema: Any, data: Mapping[str, object], source: str, at: str) -> Any:
    fields = dataclasses.fields(schema)
    known_keys(data, [field.name for field in fields], source, at)
    for field in fields:
        optional = field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING
        if field.name not in data and not optional:
            raise BadInput(source, at=at or None, found=f"no key {field.name!r}", expected="one")
    hints = typing.get_type_hints(schema)
    values = {key: _read(hints[key], value, source, _below(at, key)) for key, value in data.items()}
    try:
        return schema(**values)
    except BadInput as error:  # a class that checks itself does not know where its values come from
        place = at if error.at is None else _below(at, str(error.at))
        raise BadInput(source, at=place or None, found=error.found, expected=error.expected) from None


def _mapping(data: object, source: str, at: str) -> Mapping[str, object]:
    if not isinstance(data, dict):
        raise BadInput(source, at=at or None, found=repr(data), expected="an object")
    return data


def _below(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key
