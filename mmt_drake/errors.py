"""Errors that a user can act on, each in one line."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from numbers import Real
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

_LONGEST = 4000  # characters of a message


class MmtError(Exception):
    """Base of every error this package raises on purpose."""


class BadInput(MmtError, ValueError):
    """Something handed in from outside breaks its contract.

    The message is one line: what was read, where in it, what was found, what was
    expected. The command line prints it and exits with status 2.

    Args:
        source: the file, option or object that was read.
        found: what stands there.
        expected: what should stand there.
        at: the row, key, topic or column within the source, if there is one.
    """

    def __init__(self, source: object, *, found: object, expected: object, at: object = None):
        self.source, self.found, self.expected, self.at = source, found, expected, at
        where = f"{source}" if at is None else f"{source}: {at}"
        line = printable(" ".join(f"{where}: found {found}, expected {expected}".split()))
        if len(line) > _LONGEST:
            line = f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 2 :]}"
        super().__init__(line)

    def of(self, source: object) -> BadInput:
        """The same, told of something else: what a person knows it by."""
        return BadInput(source, found=self.found, expected=self.expected, at=self.at)

    def __reduce__(self) -> tuple[Callable[..., BadInput], tuple[object, ...]]:
        """Errors travel between processes."""
        return partial(BadInput, found=self.found, expected=self.expected, at=self.at), (self.source,)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in the midst of long work; its text is what was known by then.

    Args:
        said: that text.
        known: the same as plain values, dataclasses and arrays; none: nothing was known.
    """

    def __init__(self, said: str, known: Mapping[str, object] | None = None) -> None:
        super().__init__(said)
        self.known = dict(known or {})


def some(names: Iterable[str], most: int = 12) -> str:
    """Names for a message, the first ones of many."""
    every = list(names)
    return ", ".join(every[:most]) + (f" and {len(every) - most} more" if len(every) > most else "")


def suggest(name: str, known: Iterable[str]) -> str:
    """`` (did you mean ...?)`` for a name close to a known one, else an empty string."""
    close = difflib.get_close_matches(name[:80], list(known), n=1, cutoff=0.65)
    return f" (did you mean {close[0]!r}?)" if close else ""


def printable(text: str) -> str:
    """Text as a terminal may have it: what is no character to be seen, but for line ends and tabs, as its escape.

    Names of files, columns and topics may hold codes that move a terminal's cursor, or make it answer.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text)


def one_line(error: BaseException) -> str:
    """The text of another library's error, in one line."""
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def readable(source: object, what: str, expected: str, passing: type[OSError] = OSError) -> Iterator[None]:
    """Tell in one line what another library makes of a damaged file, whatever that is.

    Args:
        source: the file.
        what: it seemed to be.
        expected: instead.
        passing: errors of the operating system that are left as they are, like `BadInput` and a lack of memory.

    Raises:
        BadInput: any other error.
    """
    try:
        yield
    except (BadInput, passing, MemoryError):
        raise
    except Exception as error:
        found = f"{what} that cannot be read ({one_line(error)})"
        raise BadInput(source, found=found, expected=expected) from error


@contextmanager
def located(source: object, at: str = "") -> Iterator[None]:
    """Say where it stands what is refused by something that does not know where its values come from.

    Args:
        source: that was read.
        at: the place in it; what the refusal names is below that.

    Raises:
        BadInput: what was refused, there.
    """
    try:
        yield
    except BadInput as error:
        where = ".".join(str(part) for part in (at or None, error.at) if part is not None)
        raise BadInput(source, at=where or None, found=error.found, expected=error.expected) from None


def check_number(source: str, name: str, value: float, *, least: float, open_interval: bool = False) -> None:
    """Refuse a parameter that is not finite or too small.

    Args:
        source: what the parameter belongs to.
        name: of the parameter.
        value: that was given.
        least: smallest value allowed.
        open_interval: `least` itself is not allowed.

    Raises:
        BadInput: the value is refused.
    """
    is_number = isinstance(value, Real) and math.isfinite(value)
    if not is_number or value < least or (open_interval and value == least):
        sign = ">" if open_interval else ">="
        found = value if isinstance(value, Real) else repr(value)
        raise BadInput(source, at=name, found=found, expected=f"a finite number {sign} {least:g}")


def check_kind(source: str, name: str, value: object, kind: type, expected: str) -> None:
    """Refuse an argument of another class.

    Raises:
        BadInput: it is refused.
    """
    if not isinstance(value, kind):
        raise BadInput(source, at=name, found=f"{type(value).__name__} ({value!r:.80})", expected=expected)


def attempt(work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T | None:
    """What some work gives; None where it ends in an `MmtError`, as where a simulation diverges."""
    try:
        return work(*args, **kwargs)
    except MmtError:
        return None


class MissingDependency(MmtError):
    """An optional package, SDK or folder is not here; the message says how to get it."""
