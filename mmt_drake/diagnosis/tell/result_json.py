"""Dataclasses of a diagnosis as plain JSON data."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from mmt_drake.errors import BadInput


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


def _below(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key
