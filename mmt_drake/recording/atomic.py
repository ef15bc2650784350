"""Files that are either whole or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mmt_drake.errors import BadInput


@contextmanager
def replacing(target: str | Path) -> Iterator[Path]:
    """Give a temporary path beside ``target`` to write to; rename it onto ``target`` at the end.

    Whatever goes wrong in between, ``target`` stays as it was and the temporary file goes.

    Raises:
        BadInput: the operating system refuses (full disk, no permission, no such folder).
    """
    target = Path(target)
    temporary = beside(target)
    try:
        with told(target):
            yield temporary
            os.replace(temporary, target)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def beside(target: Path) -> Path:
    """A name for a temporary file in the folder of ``target``, same ending, no other process's.

    Raises:
        BadInput: that folder is not there, or ``target`` is a folder itself.
    """
    if target.is_dir():
        raise BadInput(target, found="a folder", expected="a name for a file")
    if not target.parent.is_dir():
        raise BadInput(target, found=f"no folder {target.parent}", expected="an existing folder to write to")
    return target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")


@contextmanager
def told(target: str | Path) -> Iterator[None]:
    """Turn an error of the operating system while writing into one line about ``target``.

    Raises:
        BadInput: an OSError came up.
    """
    try:
        yield
    except OSError as error:
        raise BadInput(target, found=error.strerror or error, expected="a place to write to") from error


@contextmanager
def whole_or_none(recorded: Path, told_as: Path | None = None) -> Iterator[None]:
    """Leave no part of a recording behind when the run that makes it fails.

    Args:
        recorded: the file that a recorder writes to; a recorder keeps what it has, for those who have only that.
        told_as: the name in the message where that file could not be written; the file's folder by default.

    Raises:
        BadInput: as raised within; a full disk without the promise that its beginning is kept.
    """
    try:
        yield
    except BadInput as error:
        recorded.unlink(missing_ok=True)
        if str(error.source) != str(recorded) or not isinstance(error.__cause__, OSError):
            raise
        expected = "room for the recording; its beginning is removed"
        raise BadInput(told_as or recorded.parent, found=error.found, expected=expected) from error
