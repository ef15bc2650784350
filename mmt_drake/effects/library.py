"""The library itself, and how a user's own effect gets into it."""

import re
from collections.abc import Iterable
from pathlib import Path

from mmt_drake.effects.effect import Effect
from mmt_drake.errors import BadInput, one_line
from mmt_drake.own_code import read_code

LIBRARY: dict[str, Effect] = {}
"""Name -> effect, in the order in which they were registered."""

SOURCES: dict[str, Path] = {}
"""Name -> the Python file that it came from; of a person's own effects alone."""


def register(effect: Effect) -> Effect:
    """Put an effect into the library.

    Raises:
        BadInput: it is no `Effect`, its name is none, or another effect has that name.
    """
    if not isinstance(effect, Effect):
        raise BadInput("effects", found=f"{type(effect).__name__} to register", expected="an Effect")
    if not effect.name.isidentifier():
        raise BadInput("effects", found=f"the name {effect.name!r}", expected="letters, digits and underscores")
    if LIBRARY.get(effect.name, effect) is not effect:
        raise BadInput("effects", found=f"a second effect called {effect.name}", expected="names that differ")
    LIBRARY[effect.name] = effect
    return effect


def own_files(names: Iterable[str]) -> list[Path]:
    """The files that those of these effects come from which are a person's own."""
    return sorted({SOURCES[name] for name in names if name in SOURCES})


_PREAMBLE = "Failed in nopython mode"
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LINE = re.compile(r"line (\d+)|\.py \((\d+)\)")
"""In a message of numba's: what comes before what is wrong, codes of a terminal, and where it is."""


def _compile(effect: Effect, path: str | Path) -> None:
    """Compile the law of an effect, which else would be when a fit first needs it.

    Raises:
        BadInput: numba cannot.
    """
    try:
        _ = effect.law and effect.law.address
    except Exception as error:  # numba's own, and whatever else its passes raise for code that they do not know
        text = _COLOUR.sub("", str(error))
        said = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith(_PREAMBLE)]
        line = _LINE.search(text)
        at = f"law of {effect.name}" + (f", line {line[1] or line[2]}" if line else "")
        found = f"{type(error).__name__}: {said[0] if said else one_line(error)}"
        raise BadInput(path, at=at, found=found, expected="what numba compiles, four numbers returned") from error


def register_file(path: str | Path) -> None:
    """Register the effects of a Python file: its `EFFECT`, or those for which it calls `register`.

    A file is read once in a process, however often it is named.

    Raises:
        BadInput: there is no such file, it cannot be run, it registers nothing, or what it registers is refused.
    """
    file = Path(path).resolve()
    if file in SOURCES.values():
        return
    before = dict(LIBRARY)
    expected = "a Python file that defines EFFECT"
    try:
        loaded = read_code(path, expected)
        if hasattr(loaded, "EFFECT"):
            register(loaded.EFFECT)
        new = LIBRARY.keys() - before.keys()
        for name in new:
            _compile(LIBRARY[name], path)
    except BaseException as error:
        LIBRARY.clear()
        LIBRARY.update(before)
        if isinstance(error, BadInput) and error.source != path:
            raise BadInput(path, found=str(error), expected="an effect that can be registered") from None
        raise
    if not new:
        raise BadInput(path, found="no effect registered", expected="EFFECT = Effect(...), or calls of register")
    SOURCES.update(dict.fromkeys(new, file))
