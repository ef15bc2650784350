"""Recordings that are none, damaged or out of bounds: how to make each, and what must be said of it."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from cli_samples import MODEL, TIME, WAVE, Columns, changed, csv_text, good, text, with_cell, write, write_bag

Make = Callable[[Path], list[object]]


def cut(path: Path, keep: float) -> Path:
    """The beginning of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: round(keep * len(data))])
    return path


def flipped(path: Path, at: float) -> Path:
    """A file with one byte changed."""
    data = bytearray(path.read_bytes())
    data[round(at * len(data))] ^= 0xFF
    path.write_bytes(data)
    return path


# --- Recordings. Each goes in turn through one of the commands that read one.

TABLES: dict[str, tuple[Columns, str]] = {
    "a NaN": (with_cell("position_y", 7, np.nan), "row 7, column 'position_y': found nan"),
    "an infinity": (with_cell("position_x", 50, -np.inf), "row 50, column 'position_x': found -inf"),
    "time goes back": (with_cell("time", 20, 0.1), "row 20, column 'time': found time going back"),
    "time stands": (with_cell("time", 20, 0.18), "row 20, column 'time': found the same time again"),
    "time in ms": (changed(time=1e3 * TIME), "is this ms, us or ns?"),
    "positions in mm": (changed(position_y=300.0 * WAVE), "expected at most 5 m, is it in mm?"),
    "forces in mN": (changed(force_z=5000.0 + WAVE), "expected at most 1000 N, is it in mN?"),
    "velocities in mm/s": (
        changed(**{f"velocity_{a}": 1e3 * np.gradient(good()[f"position_{a}"], TIME) for a in "xyz"}),
        "column 'velocity_x': found",
    ),
    "a position missing": (changed(position_z=None), "expected also position_z"),
    "a column misspelt": (changed(force_zz=WAVE), "did you mean 'force_z'"),
    "a flag of one half": (changed(in_contact=0.5 + 0.0 * WAVE), "row 1, column 'in_contact': found 0.5"),
    "two samples": ({name: values[:2] for name, values in good().items()}, "found 2 samples"),
}


# Nothing that a topic could say: names of columns, flags (they are Bool), times that the writer itself refuses.
NOT_IN_MCAP = ("time goes back", "time stands", "a position missing", "a column misspelt", "a flag of one half")


def reading(source: Path, command: str) -> list[object]:
    """A command that reads a recording and would write `out/made.csv`."""
    target = source.parent / "out" / "made.csv"
    if command == "convert":
        return ["convert", source, target]
    if command == "run":
        return ["run", "setup1", "--seconds", "1", "--operator", source, "--record", target]
    model = text(source.parent / "model.yaml", MODEL)
    return ["simulate", "--model", model, "--operator", source, "--out", target]


COMMANDS = ("convert", "run", "simulate")


def table_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    number = 0
    for ending in (".csv", ".npz", ".mcap"):
        for what, (columns, told) in TABLES.items():
            if ending == ".mcap" and what in NOT_IN_MCAP:
                continue
            command = COMMANDS[number % len(COMMANDS)]
            number += 1

            yield f"{command}: {what} in {ending}", _written(f"in{ending}", columns, command), (f"in{ending}", told)


def _written(name: str, columns: Columns, command: str) -> Make:
    return lambda folder: reading(write(folder / name, columns), command)


def file_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    def case(what: str, prepare: Callable[[Path], Path], command: str, *told: str) -> tuple[str, Make, tuple[str, ...]]:
        return what, lambda folder: reading(prepare(folder), command), told

    table = csv_text(good())
    lines = table.splitlines()
    word = lines[4].replace(lines[4].split(",")[3], "soft", 1)
    yield case("no such file", lambda f: f / "in.csv", "run", "in.csv: found no such file")
    yield case("no such builtin", lambda f: Path("builtin:foot"), "run", "builtin:foot")
    yield case("empty csv", lambda f: text(f / "in.csv", ""), "run", "in.csv: found an empty file")
    yield case("empty mcap", lambda f: text(f / "in.mcap", ""), "simulate", "in.mcap: found an empty file")
    yield case("empty npz", lambda f: text(f / "in.npz", ""), "convert", "in.npz: found an empty file")
    yield case("empty bag", lambda f: text(f / "in.bag", ""), "convert", "in.bag: found an empty file")
    yield case("header alone", lambda f: text(f / "in.csv", lines[0]), "simulate", "found a header and no rows")
    yield case(
        "a word", lambda f: text(f / "in.csv", "\n".join([*lines[:4], word])), "run", "row 4 (line 5)", "found 'soft'"
    )
    yield case(
        "a row cut short",
        lambda f: text(f / "in.csv", "\n".join([*lines[:9], lines[9].rpartition(",")[0]])),
        "convert",
        "row 9 (line 10): found 6 cells, expected 7",
    )
    yield case("semicolons", lambda f: text(f / "in.csv", table.replace(",", ";")), "run", "header", "expected commas")
    yield case("binary csv", lambda f: text(f / "in.csv", b"time,\xff\xfe"), "simulate", "bytes that are no text at 5")
    yield case("another ending", lambda f: text(f / "in.txt", table), "run", "found ending '.txt'")
    yield case("a folder", lambda f: f, "convert", "found a folder without metadata.yaml")
    yield case("truncated npz", lambda f: cut(write(f / "in.npz", good()), 0.5), "run", "in.npz: found", "complete NPZ")
    yield case("damaged npz", lambda f: flipped(write(f / "in.npz", good()), 0.1), "convert", "in.npz", "be read")
    yield case("pickled npz", lambda f: _pickled(f / "in.npz"), "simulate", "in.npz: time: found type object")
    yield case("an unknown set", lambda f: write(f / "in.npz", {"t": TIME, "y": WAVE}), "run", "found arrays t, y")
    yield case(
        "mcap cut in its first chunk",
        lambda f: cut(write(f / "in.mcap", good()), 0.5),
        "run",
        "in.mcap: found no message",
    )
    yield case("damaged mcap", lambda f: flipped(write(f / "in.mcap", good()), 0.4), "convert", "in.mcap", "found")
    yield case(
        "mcap with a damaged name",
        lambda f: text(
            f / "in.mcap", write(f / "in.mcap", good()).read_bytes().replace(b"/telerobot", b"/\xff\xfeerobot")
        ),
        "simulate",
        "in.mcap: found a file that cannot be read",
    )
    yield case("npz of another compression", lambda f: _packed(f / "in.npz"), "run", "in.npz: found", "cannot be read")
    yield case("csv called mcap", lambda f: text(f / "in.mcap", table), "run", "found another beginning")
    yield case("truncated bag", lambda f: cut(write(f / "in.bag", good()), 0.5), "simulate", "in.bag", "cannot be read")
    yield case("bag of NaN", lambda f: write(f / "in.bag", with_cell("position_x", 3, np.nan)), "run", "row 3", "nan")
    yield case(
        "wrong topics", lambda f: write_bag(f / "in.bag", good(), "/arm/pose"), "run", "in.bag: found no message on any"
    )
    yield case(
        "a topic of another type",
        lambda f: write_bag(f / "in.bag", good(), kind="Pose2D"),
        "run",
        "/telerobot/pose: found geometry_msgs/msg/Pose2D",
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
