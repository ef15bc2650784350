"""The library itself, and how a user's own effect gets into it."""

import hashlib
from pathlib import Path

from mmt_drake.effects.effect import Effect
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.laws import load_file

#: name -> effect, in the order in which they were registered
LIBRARY: dict[str, Effect] = {}

_read: set[Path] = set()


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


def register_file(path: str | Path) -> None:
    """Register the effects of a Python file: its `EFFECT`, or those for which it calls `register`.

    A file is read once in a process, however often it is named.

    Raises:
        BadInput: there is no such file, it cannot be run, it registers nothing, or what it registers is refused.
    """
    file = Path(path).resolve()
    if file in _read:
        return
    if not file.is_file():
        raise BadInput(path, found="no such file", expected="a Python file that defines EFFECT")
    before = dict(LIBRARY)
    module = f"mmt_drake_effects_{hashlib.sha256(str(file).encode()).hexdigest()[:16]}"
    try:
        loaded = load_file(module, str(file))
        if hasattr(loaded, "EFFECT"):
            register(loaded.EFFECT)
    except BaseException as error:
        LIBRARY.clear()
        LIBRARY.update(before)
        if isinstance(error, MmtError):
            raise BadInput(path, found=str(error), expected="an effect that can be registered") from None
        if not isinstance(error, Exception):
            raise
        found = f"{type(error).__name__}: {error}"
        raise BadInput(path, found=found, expected="a Python file that defines EFFECT") from error
    if len(LIBRARY) == len(before):
        raise BadInput(path, found="no effect registered", expected="EFFECT = Effect(...), or calls of register")
    _read.add(file)
