"""The program itself: help, version, exit status, pipes, Ctrl-C, a wheel without the checkout."""

import argparse
import ctypes
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from terminal import Terminal

import mmt_drake
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.cli.main import COMMANDS, main
from mmt_drake.cli.progress import progress
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput

PROGRAM = [sys.executable, "-m", "mmt_drake"]


def command(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Makes `mmt-drake effects` end with an error."""

    def fail(arguments: argparse.Namespace) -> int:
        raise error

    monkeypatch.setattr("mmt_drake.cli.effects.main", fail)


def test_help_lists_every_command_and_imports_nothing_slow() -> None:
    code = (
        "import sys; from mmt_drake.cli.main import main; main(['--help']); main(['run', '--help']);"
        "print(*{'numpy', 'pydrake', 'numba', 'rich'} & set(sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for name, (_, line) in COMMANDS.items():
        assert name in done.stdout and " ".join(line.split()[:3]) in done.stdout
    assert "examples:" in done.stdout and not done.stderr.strip()


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("mmt-drake di", {"diagnose"}),
        ("mmt-drake experiment la", {"late"}),
        ("mmt-drake run --har", {"--hardware"}),
        ("mmt-drake run setup1-e", {"setup1-everything"}),
    ],
)
def test_a_shell_completes_the_line(line: str, offered: set[str], tmp_path: Path) -> None:
    told = tmp_path / "offered"
    shell = {"_ARGCOMPLETE": "1", "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_SUPPRESS_SPACE": "1"}
    where = {"COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_STDOUT_FILENAME": str(told)}
    subprocess.run(PROGRAM, env=os.environ | shell | where, capture_output=True, check=True)
    assert set(told.read_text().split()) == offered


def test_alone_it_says_what_it_can_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    alone = capsys.readouterr()
    assert main(["--help"]) == 0
    assert alone == capsys.readouterr() and "examples:" in alone.out


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_has_help_with_an_example_of_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"usage: mmt-drake {name}" in out and f"  mmt-drake {name}" in out.partition("examples:")[2]


def test_an_error_is_one_line_and_debug_shows_where_it_came_from(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    error = BadInput("a.csv", at="row 3", found="nan", expected="a number")
    command(monkeypatch, error)
    assert main(["effects"]) == 2
    assert capsys.readouterr() == ("", "mmt-drake: a.csv: row 3: found nan, expected a number\n")
    for arguments in (["--debug", "effects"], ["effects", "--debug"]):
        with pytest.raises(BadInput) as caught:
            main(arguments)
        assert caught.value is error


def test_what_the_operating_system_refuses_is_told_with_the_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command(monkeypatch, OSError(28, "No space left on device", "page.html"))
    assert main(["effects"]) == 2
    assert "page.html: found No space left on device" in capsys.readouterr().err


def test_another_missing_module_is_no_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    command(monkeypatch, ModuleNotFoundError("No module named 'zstandard'", name="zstandard"))
    with pytest.raises(ModuleNotFoundError):
        main(["effects"])


def test_ctrl_c_ends_a_command_with_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    in_an_import = ImportError("initialization failed")  # Drake's, for one
    in_an_import.__cause__ = KeyboardInterrupt()
    for error in (KeyboardInterrupt(), in_an_import):
        command(monkeypatch, error)
        assert main(["effects"]) == 130
        assert capsys.readouterr().err == "mmt-drake: interrupted\n"


def test_ctrl_c_that_a_compiler_s_call_into_python_drops_ends_the_command_all_the_same(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compile_and_go_on(arguments: argparse.Namespace) -> int:
        ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()  # as LLVM's cache of objects does
        time.sleep(5.0)
        return 0

    monkeypatch.setattr("mmt_drake.cli.effects.main", compile_and_go_on)
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)  # who started the tests may ignore it
    try:
        assert main(["effects"]) == 130
    finally:
        signal.signal(signal.SIGINT, handler)
    assert capsys.readouterr().err == "mmt-drake: interrupted\n"


def test_a_reader_that_has_seen_enough_is_no_error() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([*PROGRAM, "effects"], stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert done.returncode == 141 and done.stderr == b""


@pytest.mark.parametrize(
    ("redirected", "status"), [(">&-", 0), (">&- 2>&-", 0), ("<&- >&-", 0), (">/dev/full", 2), ("| true", 141)]
)
@pytest.mark.parametrize("name", ["effects", "doctor"])
def test_a_stream_that_takes_nothing_ends_no_command_with_a_traceback(name: str, redirected: str, status: int) -> None:
    program = f"'{sys.executable}' -m mmt_drake {name}"
    done = subprocess.run(["bash", "-c", f"set -o pipefail; {program} {redirected}"], capture_output=True, check=False)
    assert done.returncode == status and done.stderr.count(b"\n") == (status == 2), done.stderr


def test_a_stream_without_all_characters_gets_their_escapes() -> None:
    settings = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run([*PROGRAM, "doctor"], env=settings, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and r"\u2013" in done.stdout and not done.stderr


def test_effects_as_json_is_the_library(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [entry["name"] for entry in listed] == list(dict.fromkeys([*LIBRARY, *ARM_EFFECTS]))
    friction = next(entry for entry in listed if entry["name"] == "static_friction")
    assert list(friction) == [
        "name",
        "block",
        "family",
        "elsewhere",
        "replaces",
        "equal_to",
        "equal_massless",
        "near_equal_to",
        "axis",
        "parameters",
        "equation",
        "source",
        "of_arms",
    ]
    assert {tuple(entry) for entry in listed} == {tuple(friction)}
    assert (friction["block"], friction["replaces"]) == ("friction", "Fc")
    assert friction["parameters"][2] == {"symbol": "v_d", "unit": "m/s", "bounds": [0.0, None]}


def test_an_effect_says_where_it_acts_in_a_structure_without_a_contact(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    assert "nonlinear_stiffness (contact; drive of a transmission)\n" in capsys.readouterr().out
    assert main(["effects", "--json"]) == 0
    stiffening = next(e for e in json.loads(capsys.readouterr().out) if e["name"] == "nonlinear_stiffness")
    assert stiffening["elsewhere"] == {"transmission": {"family": "drive_stiffness", "block": "drive"}}


def test_what_looks_alike_on_an_arm_is_published(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--json"]) == 0
    listed = {entry["name"]: entry["of_arms"] for entry in json.loads(capsys.readouterr().out)}
    assert listed["nonlinear_stiffness"] is None
    alike = {name: [other["name"] for other in own["near_equal_to"]] for name, own in listed.items() if own}
    assert alike["rotor_inertia"] == ["link_inertia"] and alike["torque_gain"] == ["scaled_inertias"]
    assert alike["payload"] == ["link_inertia"] and alike["time_delay"] == ["force_lag"]
    assert listed["coulomb_friction"] == {
        "place": "joint",
        "parameters": [{"symbol": "Fc", "unit": "N m"}],
        "near_equal_to": [],
    }


def test_effects_for_people_names_every_parameter_with_its_unit(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    out = capsys.readouterr().out
    for effect in LIBRARY.values():
        assert effect.name in out and effect.equation in out and effect.source in out
        assert all(f"{parameter.symbol} [{parameter.unit}]" in out for parameter in effect.parameters)


@pytest.mark.parametrize(("stream", "shown"), [(Terminal(), True), (io.StringIO(), False)])
def test_progress_is_shown_on_a_terminal_and_nowhere_else(
    stream: io.StringIO, shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", stream)
    with progress("setup1", 60.0, simulated=True) as update:
        update(12.0)
        time.sleep(0.15)
    assert ("12.0 of 60.0 s" in stream.getvalue()) is shown
    assert ("x real time" in stream.getvalue()) is shown


def test_the_module_runs_as_the_program(tmp_path: Path) -> None:
    done = subprocess.run([*PROGRAM, "--version"], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout == f"mmt-drake {mmt_drake.__version__}\n"
