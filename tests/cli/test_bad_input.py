"""Whatever is wrong with what comes in: status 2, one line that says what and where, and nothing left behind."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from bad_recordings import Make, file_cases, table_cases
from cli_samples import MODEL, Program, listing, text, write
from table_samples import good

# --- Scenarios

CHANGES: dict[str, tuple[str, ...]] = {
    "no_equals": ("--set: found no_equals, expected key=value",),
    "=3": ("--set: found =3",),
    "seed.x=3": ("setup1: seed: found {'x': 3}, expected a whole number",),
    "operator.motion.name=chirp": ("--set: operator.motion.name: found operator.motion = 'strokes'",),
    "seed=[1": ("--set seed", "line 1"),
    "sede=3": ("setup1: found the key 'sede' (did you mean 'seed'?)",),
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
    "to_operator={jitter_law: poisson}": ("to_operator.jitter_law: found 'poisson'",),
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
    "detector.r1=-0.003": ("setup1: detector.r1: found -0.003",),
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
    yield "no such file", lambda folder: _run(folder, folder / "mine.yaml"), ("mine.yaml: found no such file",)


def _run(folder: Path, scenario: object) -> list[object]:
    return ["run", scenario, "--seconds", "1", "--record", folder / "out" / "made.mcap"]


# --- Model files

MODELS: dict[str, tuple[str, tuple[str, ...]]] = {
    "no YAML": ("structure: {", ("model.yaml: line",)),
    "a negative mass": (MODEL.replace("m: 1.0", "m: -1.0"), ("model.yaml: parameters.m: found -1.0",)),
    "a list of parameters": ("structure: flexible_box\nparameters: [1, 2]\n", ("model.yaml: parameters: found list",)),
    "an unknown effect": (MODEL + "effects: [{name: stiction}]\n", ("effects[0].name: found 'stiction'",)),
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
    "fly": ("invalid choice: 'fly'", "'run'", "mmt-drake --help"),
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
    "simulate --model nowhere.yaml --operator IN --out OUT/made.csv": ("nowhere.yaml: found no such file",),
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
