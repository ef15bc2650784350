"""An effect from a user's own file is as good as one of the library."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.cli.main import main
from mmt_drake.cli.trial import diagnose_case
from mmt_drake.effects import LIBRARY, SOURCES, register_file
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.beside import FitProcess
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.window import SAMPLE_SIZE
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model_files import model_data, save_model
from mmt_drake.model_message import ToldEffect

OWN = Path(__file__).with_name("own_effect.py").read_text()
PASSIVE = "law=quintic, passive=ALWAYS,"
MODEL = """structure: kelvin_voigt
parameters: {k: 100, b: 0}
effects: [{name: quintic_stiffness, parameters: {k5: 1e9}}]
"""


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(OWN)
    yield path
    forget()


def forget():
    LIBRARY.pop("quintic_stiffness", None)
    SOURCES.pop("quintic_stiffness", None)


def test_simulate_takes_it_and_the_listing_shows_it(own, tmp_path, capsys):
    (tmp_path / "model.yaml").write_text(MODEL)
    x = 0.01 * np.sin(np.arange(100) * 0.1)
    rows = np.column_stack([np.arange(100) * 1e-3, x, 0 * x])
    np.savetxt(tmp_path / "in.csv", rows, delimiter=",", header="time,position,force", comments="")
    told = ["--model", str(tmp_path / "model.yaml"), "--operator", str(tmp_path / "in.csv")]
    told += ["--out", str(tmp_path / "out.csv")]
    assert main(["simulate", *told]) == 2
    assert "effects[0].name: found 'quintic_stiffness'" in capsys.readouterr().err
    assert main(["simulate", *told, "--effects", str(own)]) == 0
    out = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    np.testing.assert_allclose(out["force"], -100 * x - 1e9 * x**5, atol=1e-9)
    capsys.readouterr()
    assert main(["effects", "--effects", str(own)]) == 0
    assert "\n  source: mine\n" in capsys.readouterr().out


def test_its_model_travels_to_a_process_that_has_not_read_the_file(own, tmp_path):
    register_file(own)
    register_file(own)  # a second time does nothing
    import pickle

    from mmt_drake.model.kelvin_voigt import KelvinVoigt

    model = LIBRARY["quintic_stiffness"].apply(KelvinVoigt(k=1.0), {"k5": 2.0})
    (tmp_path / "model.pickle").write_bytes(pickle.dumps(model))
    read = "import pickle, sys; m = pickle.load(open(sys.argv[1], 'rb'))\n"
    read += "m.kernel_vector(); print(m.additions.laws[0].values)"
    done = subprocess.run([sys.executable, "-c", read, tmp_path / "model.pickle"], capture_output=True, text=True)
    assert done.stdout.startswith("(2.0,)"), done.stderr


def test_the_process_of_an_estimator_s_fits_reads_the_file_too(own):
    own.write_text(f"from mmt_drake.effects.passivity import ALWAYS\n{OWN}".replace("law=quintic,", PASSIVE))
    register_file(own)
    fits = FitProcess(OutputErrorOptions(effects=(ToldEffect("quintic_stiffness", {"k5": 1e9}),)))
    assert fits.submit(np.zeros((0, SAMPLE_SIZE)), broken=False)
    assert fits.result() is not None


def test_a_case_of_a_trial_finds_it_and_its_model_names_the_file_which_it_does_not_run(own, tmp_path, capsys):
    random, t = np.random.default_rng(5), np.arange(0.0, 8.0, 2e-3)
    x, v = 0.01 * np.sin(5 * t), 0.05 * np.cos(5 * t)
    force = -100 * x - 2 * v - 5e9 * x**5 + 0.005 * random.standard_normal(len(t))
    np.savez(tmp_path / "recording.npz", time=t, position=x, force=force)
    (tmp_path / "model.yaml").write_text("structure: kelvin_voigt\nparameters: {k: 100, b: 2}\n")
    found = diagnose_case(tmp_path, time_budget=20.0, effects=[str(own)])
    assert [effect["name"] for effect in found["effects"]] == ["quintic_stiffness"]
    model, out = tmp_path / "augmented.yaml", tmp_path / "out.csv"
    save_model(model, model_data(KelvinVoigt(k=100.0, b=2.0), [("quintic_stiffness", {"k5": 5e9})]))
    forget()
    told = ["simulate", "--model", str(model), "--operator", str(tmp_path / "recording.npz"), "--out", str(out)]
    assert main(told) == 2
    assert (
        f"found 'quintic_stiffness', expected --effects {own}, where the model has it from" in capsys.readouterr().err
    )
    assert main([*told, "--effects", str(own)]) == 0
    made = np.genfromtxt(out, delimiter=",", names=True)
    np.testing.assert_allclose(made["force"], force, atol=0.03)
    model.write_text(model.read_text().replace(f"file: {own}", "file: 3"))
    assert main([*told, "--effects", str(own)]) == 2
    assert "effects[0].file: found 3, expected the name of a Python file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x = 1", "no effect registered"),
        ("def f(:", "SyntaxError"),
        ("import nothing_of_this_name", "ModuleNotFoundError"),
        ("raise SystemExit(1)", "SystemExit: 1"),
        ("EFFECT = 3", "int to register"),
        (OWN.replace("quintic_stiffness", "coulomb_friction"), "a second effect called coulomb_friction"),
        (OWN.replace("quintic_stiffness", "not a name"), "the name 'not a name'"),
        (OWN.replace('block="contact"', 'block="elsewhere"'), "block: found 'elsewhere'"),
        (OWN.replace("law=quintic,", ""), "a law and a change, or neither"),
        (OWN.replace("at.d**5", "at.x5"), ": found TypingError: Unknown attribute 'x5' of type At"),
        (
            OWN.replace("    return p[0]", "    import math\n    return p[0]"),
            ": found UnsupportedBytecodeError: Use of",
        ),
        (OWN.replace(", 0.0, 0.0, 0.0", ""), ": found TypingError: No conversion from float64 to UniTuple"),
    ],
)
def test_a_file_that_holds_no_effect_is_refused_in_one_line(tmp_path, text, line):
    path = tmp_path / "own.py"
    path.write_text(text)
    before = dict(LIBRARY)
    with pytest.raises(BadInput) as error:
        register_file(path)
    message = str(error.value)
    assert message.startswith(str(path)) and line in message and "\n" not in message
    assert before == LIBRARY


def test_a_missing_file_is_refused():
    with pytest.raises(BadInput, match=r"nowhere.py: found no such file"):
        register_file("nowhere.py")
