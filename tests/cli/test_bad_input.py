"""Whatever is wrong with what comes in: status 2, one line that says what and where, and nothing left behind."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from cli_samples import (
    MODEL,
    TIME,
    WAVE,
    Columns,
    Program,
    changed,
    csv_text,
    good,
    listing,
    text,
    with_cell,
    write,
    write_bag,
)

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


# --- Scenarios

CHANGES: dict[str, tuple[str, ...]] = {
    "no_equals": ("--set: found no_equals, expected key=value",),
    "=3": ("--set: found =3",),
    "seed.x=3": ("setup1: seed: found {'x': 3}, expected a whole number",),
    "operator.motion.name=chirp": ("--set: operator.motion.name: found operator.motion = 'strokes'",),
    "seed=[1": ("--set seed", "line 1"),
    "sede=3": ("setup1: found the key 'sede' (did you mean seed?)",),
    "environment.object.parameters.m=-1": ("setup1: environment.object.parameters.m: found -1",),
    "environment.object.parameters.k2=-1": ("environment.object.parameters.k2: found -1",),
    "environment.object.friction.Fd=9": ("environment.object.friction.Fd: found 9",),
    "environment.noise.force=-0.1": ("environment.noise.force: found -0.1",),
    "environment.cloud.points=1000000000000": ("environment.cloud.points: found 1000000000000",),
    "environment.cloud.size=1e300": ("environment.cloud.size: found 1e+300, expected 0.001 to 10 m",),
    "environment.noise.seed=-1": ("environment.noise.seed: found -1",),
    "operator=!Recorded {placement: {rate: 1e300}}": ("operator.placement.rate: found 1e+300",),
    "operator=!Recorded {placement: {bandwidth: 1e-9}}": ("operator.placement.bandwidth: found 1e-09",),
    "estimator.cutoff_hz=1e-9": ("estimator.cutoff_hz: found 1e-09",),
    "environment.cloud=!Camera {}": ("environment.cloud: found !Camera", "!SimulatedDepthCamera, !DepthCamera"),
    "environment.cloud=!SimulatedDepthCamera {noise: -1}": ("environment.cloud.noise: found -1",),
    "environment.cloud=!SimulatedDepthCamera {latency: 0.1}": ("environment.cloud.latency: found 0.1",),
    "environment.cloud=!SimulatedDepthCamera {view: {tilt: 90}}": ("environment.cloud.view.tilt: found 90",),
    "environment.cloud=!DepthCamera {}": ("environment.cloud.extrinsics: found nothing", "calibrate"),
    "environment.cloud=!DepthCamera {extrinsics: a.yaml, serial: '1', recording: a.db3}": ("beside a serial number",),
    "environment.cloud=!DepthCamera {extrinsics: a.yaml}": ("environment.cloud: found !DepthCamera", "--hardware"),
    "environment.cloud.layout=hexagonal": ("environment.cloud.layout: found 'hexagonal'", "regular"),
    "to_telerobot.delay=soon": ("to_telerobot.delay: found 'soon', expected a finite number",),
    "to_telerobot.delay=.nan": ("to_telerobot.delay: found nan",),
    "to_telerobot.delay=-0.1": ("to_telerobot.delay: found -0.1",),
    "to_telerobot.delay=1e9": ("1000000000.0 s",),
    "to_operator.loss=2": ("to_operator.loss: found 2",),
    "to_operator.trace=nowhere.csv": ("nowhere.csv",),
    "to_operator={jitter_law: poisson}": ("to_operator.jitter_law: found poisson",),
    "step=0": ("step: found 0",),
    "step=1e-9": ("step: found 1e-09",),
    "duration=-5": ("duration: found -5",),
    "duration=long": ("duration: found 'long'",),
    "seed=1.5": ("seed: found 1.5, expected a whole number",),
    "seed=-1": ("seed: found -1",),
    "operator=!Omega7 {}": ("operator: found !Omega7, expected one of !Scripted, !Recorded, !Interactive",),
    "operator=!Interactive {}": ("operator: found !Interactive", "--meshcat"),
    "operator=!Recorded {file: nowhere.npz}": ("nowhere.npz: found no such file",),
    "operator.motion=wave": ("operator: found 'wave', expected one of strokes",),
    "operator.parameters={speed: fast}": ("speed",),
    "renderer=!Raisim {}": ("renderer: found !Raisim",),
    "renderer={substeps: -1}": ("substeps",),
    "estimator.equations=some": ("estimator.equations: found 'some'", "without_d"),
    "estimator.cutoff_hz=600": ("estimator.cutoff_hz: found 600",),
    "estimator.step=0.002": ("estimator.step: found 0.002",),
    "renderer=!FusedReflection {high_band: {crossover: 600}}": (
        "setup1: renderer.high_band.crossover: found 600",
        "500 Hz",
    ),
    "detector.r1=-0.003": ("setup1: detector.r1, r2, r3: found -0.003",),
    "clouds=all": ("clouds: found 'all'",),
}


SCENARIOS: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "no YAML": ("name: [a", ("mine.yaml: line 1",)),
    "a list": ("- a\n- b\n", ("mine.yaml: found list",)),
    "a key twice": ("seed: 1\nseed: 2\n", ("mine.yaml: line 2", "'seed' twice")),
    "no text": (b"\xff\xfe\x00", ("mine.yaml: found bytes that are no UTF-8",)),
    "an unknown key": ("robot: {}\n", ("mine.yaml: found the key 'robot'", "operator")),
    "an unknown type": ("operator: !Omega.7 {}\n", ("mine.yaml: operator: found !Omega.7",)),
    "a tag before a number": ("seed: !Seed 3\n", ("mine.yaml: line 1", "!Seed")),
}


def scenario_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    for change, told in CHANGES.items():
        yield f"--set {change}", lambda folder, change=change: [*_run(folder, "setup1"), "--set", change], told
    for what, (content, told) in SCENARIOS.items():
        yield what, lambda folder, content=content: _run(folder, text(folder / "mine.yaml", content)), told
    yield "no such scenario", lambda folder: _run(folder, "setup9"), ("found setup9", "setup1-delay")
    yield "no such file", lambda folder: _run(folder, folder / "mine.yaml"), ("mine.yaml: found No such file",)


def _run(folder: Path, scenario: object) -> list[object]:
    return ["run", scenario, "--seconds", "1", "--record", folder / "out" / "made.mcap"]


# --- Model files

MODELS: dict[str, tuple[str, tuple[str, ...]]] = {
    "empty": ("", ("model.yaml", "found NoneType")),
    "no YAML": ("structure: {", ("model.yaml: line",)),
    "another structure": (MODEL.replace("flexible_box", "soft_box"), ("model.yaml: structure: found 'soft_box'",)),
    "an unknown key": (MODEL + "normla: {k: 1.0}\n", ("model.yaml: found the key 'normla' (did you mean normal?)",)),
    "an unknown parameter": (MODEL.replace("k1:", "k3:"), ("model.yaml: parameters: found the key 'k3'",)),
    "a negative mass": (MODEL.replace("m: 1.0", "m: -1.0"), ("model.yaml: parameters.m: found -1.0",)),
    "a word for a number": (MODEL.replace("m: 1.0", "m: heavy"), ("model.yaml: parameters.m: found 'heavy'",)),
    "NaN": (MODEL.replace("m: 1.0", "m: .nan"), ("model.yaml: parameters.m: found nan",)),
    "no mass": (MODEL.replace("m: 1.0, ", ""), ("model.yaml: parameters", "expected m and k2")),
    "a list of parameters": ("structure: flexible_box\nparameters: [1, 2]\n", ("model.yaml: parameters: found list",)),
    "an unknown effect": (MODEL + "effects: [{name: stiction}]\n", ("effects[0].name: found 'stiction'",)),
    "half an effect": (
        MODEL + "effects: [{name: static_friction, parameters: {Fs: 1.0}}]\n",
        ("model.yaml: static_friction.parameters", "expected Fs, Fd, v_d"),
    ),
    "an effect out of bounds": (
        MODEL + "effects: [{name: coulomb_friction, parameters: {Fc: -1.0}}]\n",
        ("model.yaml: coulomb_friction.Fc: found -1,",),
    ),
    "effects as a word": (MODEL + "effects: many\n", ("model.yaml: effects: found str",)),
    "a model that does not fit": ("structure: kelvin_voigt\nparameters: {k: 1.0, b: 1.0}\n", ("in.csv: found",)),
}


def model_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    for what, (content, told) in MODELS.items():

        def make(folder: Path, content: str = content) -> list[object]:
            source, model = write(folder / "in.csv", good()), text(folder / "model.yaml", content)
            return ["simulate", "--model", model, "--operator", source, "--out", folder / "out" / "made.csv"]

        yield f"model: {what}", make, told


# --- The command line itself

LINES: dict[str, tuple[str, ...]] = {
    "": ("required: COMMAND", "mmt-drake --help"),
    "fly": ("invalid choice: 'fly'", "'run'"),
    "run": ("required: SCENARIO", "mmt-drake run --help"),
    "run setup1 --sec 3": ("unrecognized arguments: --sec",),
    "run setup1 --seconds abc": ("--seconds", "found 'abc', expected a number of seconds above 0"),
    "run setup1 --seconds 0": ("--seconds", "found '0'"),
    "run setup1 --seconds -3": ("--seconds", "found '-3'"),
    "run setup1 --seconds nan": ("--seconds", "found 'nan'"),
    "run setup1 --seconds inf": ("--seconds", "found 'inf'"),
    "run setup1 --seed -1": ("--seed", "found '-1', expected a whole number"),
    "run setup1 --seed 1.5": ("--seed", "found '1.5'"),
    "run setup1 --seed 99999999999999999999": ("seed: found 99999999999999999999, expected 0 to",),
    "run setup1 --hardware --operator IN": ("--operator: found --hardware",),
    "run setup1 --topic force=/ft": ("--topic: found no --operator",),
    "run setup1 --operator IN --topic force": ("--topic", "found 'force', expected name=/other"),
    "run setup1 --operator IN --topic force=/ft": ("in.csv: --topic force=/ft", "without topics"),
    "run setup1 --record OUT/made.txt": ("made.txt: found ending '.txt'", ".mcap"),
    "run setup1 --record OUT/made": ("made: found ending ''",),
    "run setup1 --record OUT/none/made.mcap": ("made.mcap: found no folder",),
    "run setup1 --record OUT/none/made.csv": ("made.csv: found no folder",),
    "run setup1 --record /proc/made.mcap": ("/proc/made.mcap: found", "expected a place to write to"),
    "convert IN": ("required: OUT",),
    "convert IN OUT": ("out: found ending ''",),
    "convert IN OUT/made.bag": ("made.bag: found ending '.bag'", ".mcap .csv .npz"),
    "convert IN OUT/none/made.csv": ("made.csv: found no folder",),
    "convert IN /proc/made.csv": ("/proc/made.csv: found",),
    "convert IN OUT/made.csv --topic /telerobot/wrench=/ft": ("--topic /telerobot/wrench=/ft",),
    "simulate --operator IN --out OUT/made.csv": ("required: --model",),
    "simulate --model nowhere.yaml --operator IN --out OUT/made.csv": ("nowhere.yaml: found No such file",),
    "simulate --model nowhere.yaml --operator IN --out OUT/made.xlsx": ("made.xlsx: found ending '.xlsx'",),
}


def line_cases() -> Iterator[tuple[str, Make, tuple[str, ...]]]:
    for line, told in LINES.items():

        def make(folder: Path, line: str = line) -> list[object]:
            source = str(write(folder / "in.csv", good()))
            out = str(folder / "out")
            return [word.replace("IN", source).replace("OUT", out) for word in line.split()]

        yield f"mmt-drake {line}", make, told


CASES = [*table_cases(), *file_cases(), *scenario_cases(), *model_cases(), *line_cases()]


@pytest.mark.parametrize(("make", "told"), [pytest.param(*rest, id=what) for what, *rest in CASES])
def test_is_refused_in_one_line_and_leaves_nothing(
    make: Make, told: tuple[str, ...], tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    arguments = make(tmp_path)
    before = listing(tmp_path)
    status, out, err = program(*arguments)
    assert (status, out) == (2, ""), err
    assert err.startswith("mmt-drake: ") and err.endswith("\n") and err.count("\n") == 1, err
    for words in told:
        assert words in err
    assert listing(tmp_path) == before


def test_from_the_shell_there_is_no_traceback_either(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mmt_drake", "convert", "nowhere.mcap", "made.csv"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "mmt-drake: nowhere.mcap: found no such file, expected a recording\n"
