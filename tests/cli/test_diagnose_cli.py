"""`diagnose`: files in, the contract's files out; bad input in one line."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program

from mmt_drake.effects import LIBRARY
from mmt_drake.recording import load, save

#: What a force that grows faster than its spring may be taken for.
RIVALS = {"nonlinear_stiffness", "contact_gap", "force_saturation", "force_bias"}
OWN = Path(__file__).parents[1] / "effects" / "own_effect.py"
#: `mmt-drake`, which says in a pipe too what it tries, and how many seconds it has worked.
SAYING = """import contextlib, sys, time
from mmt_drake.cli import diagnose, main
class Saying:
    def __call__(self, what): print(what, time.process_time(), flush=True)
    tell = print
diagnose.working = lambda *_: contextlib.nullcontext(Saying())
sys.exit(main.main())"""


def test_ctrl_c_in_the_midst_of_the_fits_ends_it_within_a_second_with_what_is_known(folder: Path, tmp_path: Path):
    command = ["diagnose", folder / "contact.csv", "--model", folder / "model.yaml", "--out", tmp_path / "out"]
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", SAYING, *command], **pipes, text=True, preexec_fn=heard) as running:
        worked = float(next(line for line in running.stdout if "coulomb_friction" in line).split()[-1])
        running.send_signal(signal.SIGINT)
        _, status, used = os.wait4(running.pid, 0)
        running.returncode = os.waitstatus_to_exitcode(status)
        said = running.stderr.read()
        assert running.returncode == 130 and said.startswith("mmt-drake: interrupted; so far "), said
        assert " with nothing" in said and said.count("\n") == 1
    assert used.ru_utime + used.ru_stime - worked < 0.5  # [s] of work, however busy the machine is
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["interrupted.json"]
    known = json.loads((tmp_path / "out" / "interrupted.json").read_text())
    errors = [*known["error_over_noise"].values()]
    assert "nothing" in known["error_over_noise"] and errors == sorted(errors)
    assert known["command"].startswith("mmt-drake diagnose ")


def test_a_law_of_the_user_s_own_is_named_by_the_name_it_has(tmp_path: Path, program: Program):
    whole = dict(LIBRARY)
    for name in whole.keys() - RIVALS:
        del LIBRARY[name]
    (tmp_path / "own.py").write_text(OWN.read_text())
    (tmp_path / "motion.csv").write_text("time,position,force\n" + "".join(map(pressed, np.arange(4000) * 2e-3)))
    (tmp_path / "nominal.yaml").write_text("structure: kelvin_voigt\nparameters: {k: 300, b: 5}\n")
    known = "effects: [{name: quintic_stiffness, parameters: {k5: 2.0e10}}]\n"
    (tmp_path / "true.yaml").write_text((tmp_path / "nominal.yaml").read_text() + known)
    own = ("--effects", tmp_path / "own.py")
    try:
        made = (
            "--model",
            tmp_path / "true.yaml",
            "--operator",
            tmp_path / "motion.csv",
            "--out",
            tmp_path / "made.csv",
        )
        assert program("simulate", *made, *own).status == 0
        measured = load(tmp_path / "made.csv")
        noisy = measured["force"] + 0.01 * np.random.default_rng(1).standard_normal(len(measured))
        save(replace(measured, columns={**measured.columns, "force": noisy}), tmp_path / "noisy.csv")
        out = tmp_path / "out"
        told = program("diagnose", tmp_path / "noisy.csv", "--model", tmp_path / "nominal.yaml", "--out", out, *own)
    finally:  # in its own order, which candidates are told in
        LIBRARY.clear()
        LIBRARY.update(whole)
    assert told.status == 0, told.err
    document = json.loads((out / "diagnosis.json").read_text())
    assert document["verdict"] == "missing_physics", document["summary"]
    (effect,) = document["effects"]
    assert (effect["name"], effect["block"]) == ("quintic_stiffness", "contact")
    assert effect["parameters"]["k5"]["value"] == pytest.approx(2.0e10, rel=0.05)
    assert "quintic stiffness" in told.out and "quintic_stiffness" in (out / "augmented_model.yaml").read_text()


def pressed(t: float) -> str:
    """A row of a recording: a probe that presses and pulls by up to a centimetre, more and less."""
    position = 0.006 * np.sin(2.3 * t) * (1.0 + 0.5 * np.sin(0.7 * t)) + 0.001 * np.sin(11.0 * t)
    return f"{t:.17g},{position:.17g},0\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("missing.csv", "--model", "model.yaml", "--out", "out2"), "missing.csv"),
        (("contact.csv", "--model", "missing.yaml", "--out", "out2"), "missing.yaml"),
        (("contact.csv", "--model", "tissue.yaml", "--out", "out2"), "structure"),
        (("contact.csv", "--model", "model.yaml", "--out", "contact.csv"), "contact.csv"),
        (("contact.csv", "--model", "model.yaml", "--out", "out2", "--jobs", "0"), "whole number"),
        (("contact.csv", "--model", "model.yaml", "--out", "out2", "--time-budget", "soon"), "seconds above 0"),
        (("contact.csv", "--model", "model.yaml", "--out", "out2", "--effects", "none.py"), "none.py"),
    ],
)
def test_bad_input_ends_with_one_line(
    arguments: tuple[str, ...], told: str, folder: Path, program: Program, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(folder)
    (folder / "tissue.yaml").write_text("structure: kelvin_voigt\nparameters: {k: 300.0, b: 20.0}\n")
    outcome = program("diagnose", *arguments)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1 and told in outcome.err
    assert not (folder / "out2").exists()
