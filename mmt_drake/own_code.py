"""Python files of a person's own: effects, estimators, renderers."""

import hashlib
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from mmt_drake.errors import BadInput, MmtError, one_line
from mmt_drake.model.laws import load_file

_read: set[str] = set()


def read_code(path: str | Path, expected: str) -> ModuleType:
    """The module that a file makes; it is run once in a process, however often it is named.

    Args:
        path: of the file.
        expected: of it, for a person.

    Raises:
        BadInput: there is no such file, or it cannot be run.
    """
    file = Path(path).resolve()
    if not file.is_file():
        raise BadInput(path, found="no such file", expected=expected)
    name = f"mmt_drake_own_{hashlib.sha256(str(file).encode()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    _read.add(str(file))
    try:
        return load_file(name, str(file))
    except MmtError as error:
        raise BadInput(path, found=str(error), expected=expected) from None
    except (Exception, SystemExit) as error:
        raise BadInput(path, found=f"{type(error).__name__}: {error}", expected=expected) from error


@contextmanager
def own_code_named() -> Iterator[None]:
    """Names the line of a person's file in what that file raises.

    Raises:
        BadInput: an error, not of ours, that came out of a file of `read_code`.
    """
    try:
        yield
    except MmtError:
        raise
    except Exception as error:
        for frame in reversed(traceback.extract_tb(error.__traceback__)):
            if frame.filename in _read:
                found = f"{type(error).__name__}: {one_line(error)}"
                at = f"line {frame.lineno}, in {frame.name}"
                raise BadInput(frame.filename, at=at, found=found, expected="code that runs") from error
        raise
