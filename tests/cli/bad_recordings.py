"""Recordings that are none, damaged or out of bounds: how to make each, and what must be said of it."""

from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path

import numpy as np
from cli_samples import MODEL, text, write, write_bag
from table_samples import TIME, WAVE, Columns, changed, csv_text, good, with_cell

Make = Callable[[Path], list[object]]


def cut(path: Path, keep: float) -> Path:
    """The beginning of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: round(keep * len(data))])
    return path


def renamed(path: Path) -> Path:
    """A file whose topics are no text."""
    return text(path, path.read_bytes().replace(b"/telerobot", b"/\xff\xfeerobot"))


# What is wrong in each way is tested beside the reader; here, that it goes through each command from each form.
TABLES: dict[str, tuple[Columns, str]] = {
    "a NaN": (with_cell("position_y", 7, np.nan), "row 7, column 'position_y': found nan"),
    "positions in mm": (changed(position_y=300.0 * WAVE), "expected at most 5 m, is it in mm?"),
}


def reading(source: Path, command: str) -> list[object]:
    """A command that reads a recording and would write `out/made.csv`."""
    target = source.parent / "out" / "made.csv"
    if command == "convert":
        return ["convert", source, target]
    if command == "run":
        return ["run", "setup1", "--seconds", "1", "--operator", source, "--record", target]
    model = text(source.parent / "model.yaml", MODEL)
    return ["simulate", "--model", model, "--operator", source, "--out", target]


def table_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    for name, what, command in product(("in.csv", "in.npz", "in.mcap"), TABLES, ("convert", "run", "simulate")):
        columns, line = TABLES[what]
        yield f"{command}: {what} in {name}", _written(name, columns, command), (name, line)


def _written(name: str, columns: Columns, command: str) -> Make:
    return lambda folder: reading(write(folder / name, columns), command)


def file_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    def case(what: str, prepare: Callable[[Path], Path], command: str, *said: str) -> tuple[str, Make, tuple[str, ...]]:
        return what, lambda folder: reading(prepare(folder), command), said

    table = csv_text(good())
    yield case("no such file", lambda f: f / "in.csv", "run", "in.csv: found no such file")
    yield case("no such builtin", lambda f: Path("builtin:foot"), "run", "builtin:foot")
    yield case("empty bag", lambda f: text(f / "in.bag", ""), "convert", "in.bag: found an empty file")
    yield case("header alone", lambda f: text(f / "in.csv", table.partition("\n")[0]), "simulate", "header and no rows")
    yield case("pickled npz", lambda f: _pickled(f / "in.npz"), "simulate", "in.npz: time: found type object")
    yield case(
        "mcap with a damaged name",
        lambda f: renamed(write(f / "in.mcap", good())),
        "simulate",
        "in.mcap: found a file that cannot be read",
    )
    yield case("npz of another compression", lambda f: _packed(f / "in.npz"), "run", "in.npz: found", "cannot be read")
    yield case("truncated bag", lambda f: cut(write(f / "in.bag", good()), 0.5), "simulate", "in.bag", "cannot be read")
    yield case("bag of NaN", lambda f: write(f / "in.bag", with_cell("position_x", 3, np.nan)), "run", "row 3", "nan")
    yield case(
        "wrong topics", lambda f: write_bag(f / "in.bag", good(), "/arm/pose"), "run", "in.bag: found no message on any"
    )
    yield case(
        "several drops",
        lambda f: write(f / "in.npz", {"drop": np.repeat([1, 2], 25), "t_s": TIME, "h_m": WAVE, "v_mps": WAVE}),
        "run",
        "in.npz: found 2 recordings",
    )
    yield case(
        "a driven body",
        lambda f: write(f / "in.csv", {"time": TIME, "input": WAVE, "output": WAVE}),
        "run",
        "in.csv: found columns input, output",
    )
    yield case(
        "too short for lifts",
        lambda f: _high(f / "in.csv"),
        "run",
        "in.csv: found 0.488 s, expected 4.8 s or more for 1 lifts",
    )


class _Ends:
    """What ends the program of whoever unpickles it."""

    def __reduce__(self) -> tuple[object, ...]:
        return exec, ("raise SystemExit(9)",)


def _pickled(path: Path) -> Path:
    np.savez(path, time=np.array([_Ends(), None], dtype=object))
    return path


def _packed(path: Path) -> Path:
    """An archive whose table of contents names a compression that nobody has."""
    data = bytearray(write(path, good()).read_bytes())
    data[data.index(b"PK\x01\x02") + 10] = 77
    return text(path, bytes(data))


def _high(path: Path) -> Path:
    """Half a second far above the table: it would have to be placed, with lifts."""
    return write(path, changed(position_z=0.3 + 0.01 * WAVE))
