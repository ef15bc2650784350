"""Results as data of Python's own types, which files have words for."""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def plain(data: Any, *, finite: bool = False) -> Any:
    """Data with dataclasses and mappings as dicts, arrays, tuples and sets as lists, scalars of numpy as Python's.

    Args:
        data: to any depth. What else it holds is left as it is.
        finite: for JSON: None in the place of a number that is not finite, and what has no word is what it is called.
    """
    if isinstance(data, np.ndarray | np.generic):
        data = data.tolist()
    if is_dataclass(data):
        data = {field.name: getattr(data, field.name) for field in fields(data)}
    if isinstance(data, Mapping):
        return {str(key): plain(value, finite=finite) for key, value in data.items()}
    if isinstance(data, list | tuple | set | frozenset):
        return [plain(value, finite=finite) for value in data]
    if not finite or data is None or isinstance(data, str | int):
        return data
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    return str(data)
