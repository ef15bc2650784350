"""What long work knew when Ctrl-C ended it, on disk."""

import json
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.errors import Interrupted

FILE = "interrupted.json"


@contextmanager
def known_kept(folder: Path, command: str) -> Iterator[None]:
    """Write what is known by then to `interrupted.json`, should Ctrl-C end the work; else there is no such file.

    Args:
        folder: of the results, made if need be.
        command: that was typed.

    Raises:
        KeyboardInterrupt: interrupted; its text says what is known, and names the file.
        BadInput: the file cannot be written.
    """
    # Imported where needed, so that help comes at once.
    from mmt_drake.analysis.plotting import write_whole

    path = folder / FILE
    try:
        yield
    except Interrupted as interrupt:
        if not interrupt.known:
            raise
        known = _plain({"command": command, **interrupt.known})
        text = json.dumps(known, indent=2, ensure_ascii=False, allow_nan=False)
        write_whole(path, f"{text}\n".encode())
        raise KeyboardInterrupt(f"{interrupt}; written: {path}") from None
    path.unlink(missing_ok=True)


def _plain(value: Any) -> Any:
    """As JSON has it: dataclasses as objects, arrays as lists, null for what is not finite, else what it is called."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(entry) for entry in value]
    return str(value)
