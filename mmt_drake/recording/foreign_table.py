"""What the columns of a file of one's own may be, by name and unit: a guess, to be offered, never taken by itself."""

import re
from collections.abc import Sequence

from mmt_drake.recording.column_map import offered
from mmt_drake.recording.signals import AXES
from mmt_drake.recording.units import in_si, split

_WORDS = {
    "time": "time t timestamp zeit clock seconds sec ms",
    "position": "position pos x p displacement disp stroke travel depth indentation extension weg",
    "force": "force f load kraft reaction",
    "velocity": "velocity vel v speed",
    "input": "input u command cmd voltage current torque tau duty effort i motor",
    "output": "output y angle q phi encoder joint",
}
_SI = {"time": "s", "position": "m", "force": "N", "velocity": "m/s"}
"""The only column in such a unit is taken for one if none has its name."""


def guessed(headers: Sequence[str]) -> dict[str, str]:
    """Column of a recording -> header that may be it; empty where nothing is known."""
    left = list(headers)
    found: dict[str, str] = {}

    def take(name: str, word: str, axis: str = "") -> None:
        fitting = [header for header in left if _fits(header, word, axis)]
        measured = [header for header in left if _measures(header, word, axis)]
        if fitting or len(measured) == 1:
            found[name] = min(fitting or measured, key=lambda header: len(_plain(header)))
            left.remove(found[name])

    take("time", "time")
    for word in ("position", "force", "velocity"):
        for axis in AXES:
            take(f"{word}_{axis}", word, axis)
    if set(found) >= {f"{word}_{axis}" for word in ("position", "force") for axis in AXES}:
        return found
    if {"position_y", "position_z"} <= set(found):
        return found  # three axes of motion, no force
    left = [header for header in headers if header != found.get("time")]
    found = {name: header for name, header in found.items() if name == "time"}
    if any(_fits(header, "force", "") for header in left) or not any(_fits(header, "input", "") for header in left):
        take("force", "force")
    if "force" in found:
        for name in ("velocity", "position"):
            take(name, name)
        if "position" not in found:
            take("position", "output")
        return found
    take("input", "input")
    for word in ("output", "position"):
        if "output" not in found:
            take("output", word)
    return found


def entry(name: str, header: str) -> str:
    """The entry of a mapping that says of a header what it is, with the unit that the header tells."""
    unit = offered(name, split(header)[1])
    return header + (f":{unit}" if unit else "")


def hint(headers: Sequence[str], file: str) -> str:
    """What to do about a file whose columns have other names, to be added to what was expected."""
    options = " ".join(f"--map '{name}={entry(name, header)}'" for name, header in guessed(headers).items())
    return f"; {options or '--map time=COLUMN:UNIT ...'} says what they are, or `mmt-drake init {file}` looks"


def _plain(header: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", split(header)[0].lower()).strip("_")


def _fits(header: str, word: str, axis: str) -> bool:
    """Whether a header has one of the names of a word, along an axis if one is asked for."""
    plain, words = _plain(header), _WORDS[word].split()
    if not axis:
        return plain in words or any(part in words for part in plain.split("_") if len(part) > 1)
    if word == "position" and plain == axis:
        return True
    base = plain.removesuffix(axis).rstrip("_")
    return plain.endswith(axis) and base != plain and any(part in words for part in base.split("_"))


def _measures(header: str, word: str, axis: str) -> bool:
    """Whether a header tells the unit of a word, and the axis if one is asked for."""
    unit = split(header)[1]
    fits = unit is not None and word in _SI and (in_si(unit) or ("",))[0] == _SI[word]
    return fits and (not axis or _plain(header).split("_")[-1] == axis)
