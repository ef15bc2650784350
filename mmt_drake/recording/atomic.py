"""Files that are either whole or not there."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
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
        with writing(target):
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
def writing(target: str | Path) -> Iterator[None]:
    """Turn an error of the operating system while writing into one line about ``target``.

    Raises:
        BadInput: an OSError came up.
    """
    try:
        yield
    except OSError as error:
        raise BadInput(target, found=error.strerror or error, expected="a place to write to") from error


def part_of(target: Path) -> Path:
    """The file in which a recording grows until it is whole: ``out.part.mcap`` beside ``out.mcap``."""
    return target.with_stem(f"{target.stem}.part")


def begin_part(target: Path) -> int:
    """Open the ``part_of`` a file, empty and locked, for its one writer; gives the descriptor, which holds the lock.

    What a run that was killed has left there is kept as ``out.part1.mcap``, ``out.part2.mcap`` and so on.

    Raises:
        BadInput: another writer has the lock.
        OSError: the operating system refuses.
    """
    part = part_of(target)
    while True:
        with ExitStack() as unlocked:
            file = os.open(part, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
            unlocked.callback(os.close, file)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise BadInput(target, found="another run that is recording to it", expected="one at a time") from error
            if is_at(file_id(file), part):  # or its writer has just given it its name
                if os.fstat(file).st_size == 0:
                    unlocked.pop_all()
                    return file
                names = (part.with_stem(f"{part.stem}{number}") for number in count(1))
                os.rename(part, next(name for name in names if not name.exists()))


def file_id(file: int | Path) -> tuple[int, int]:
    """Device and inode of a file, which it keeps whatever it is called."""
    status = os.stat(file)
    return status.st_dev, status.st_ino


def is_at(identity: tuple[int, int], path: Path) -> bool:
    """True if it is this very file that stands there."""
    try:
        return file_id(path) == identity
    except OSError:
        return False
