"""Estimators and renderers of a person's own: in the loop, beside the shipped ones, and refused in one line."""

import re
from pathlib import Path

import numpy as np
import pytest

import mmt_drake as mmt
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.experiments.comparisons.estimators import ESTIMATORS, cost_us
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.stations.estimators import KINDS, OwnEstimator, estimator_name
from mmt_drake.diagrams.stations.own_parts import part_ports
from mmt_drake.diagrams.stations.renderers import OwnRenderer
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.model.parameters import THETA
from mmt_drake.recording import load

PAGE = Path(__file__).parents[2] / "docs" / "own_parts.md"
BLOCKS = {match[1]: match[2] for match in re.finditer(r"```python\n# (\w+\.py)\n(.*?)```", PAGE.read_text(), re.DOTALL)}
"""Files of the page -> what stands in them."""

BARE = """import mmt_drake as mmt
class Mine(mmt.LeafSystem):
    def __init__(self, period):
        super().__init__()
        self.DeclareVectorInputPort("measurement", 9)
        self.DeclareVectorOutputPort("theta", 10, lambda context, out: out.SetFromVector([1.0] * 10))
        self.DeclareVectorOutputPort("stable", 1, lambda context, out: out.SetFromVector([1.0]))
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files of the page in it, and in it this process."""
    monkeypatch.chdir(tmp_path)
    for name, text in BLOCKS.items():
        Path(name).write_text(text)
    return tmp_path


def test_the_estimator_of_the_page_is_as_long_as_it_says_and_finds_the_object_in_the_loop(here: Path) -> None:
    lines = [line for line in BLOCKS["my.py"].splitlines() if line and not line.startswith("import")]
    assert len(lines) == 10
    assert main(["run", "setup1", "--estimator", "my.py:MyEstimator", "--seconds", "4", "--record", "mine.mcap"]) == 0
    mine = load("mine.mcap")
    truth = mmt.load_scenario("setup1").environment.object.theta()
    found = dict(zip(THETA, (mine[f"theta_{name}"][-1] for name in THETA), strict=True))
    for name in ("k2", "b2", "normal_k", "normal_b"):
        assert found[name] == pytest.approx(dict(zip(THETA, truth, strict=True))[name], rel=1e-6), name
    settled = mine["in_contact"].astype(bool) & (mine.time > 2.0)
    error = mine["rendered_force_z"] - mine["force_z"]
    assert np.std(error[settled]) < 0.02 * np.std(mine["force_z"][settled])


def test_a_class_a_name_and_a_tag_build_the_same_station(here: Path) -> None:
    scenario, code = mmt.load_scenario("setup1"), "my.py:MyEstimator"
    tagged = mmt.load_scenario("setup1", [f"estimator=!OwnEstimator {{code: '{code}'}}"])
    handed = OwnEstimator(code)._class()
    ends = []
    for built, given in ((scenario, handed), (scenario, code), (tagged, None)):
        station = mmt.build_station(built, estimator=given)
        simulator = station.simulate(1.0)
        ends.append(station.diagram.GetOutputPort("theta").Eval(simulator.get_context()))
    assert ends[0][6] > 0.0
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_array_equal(ends[0], ends[2])


def test_a_renderer_of_one_s_own_is_given_what_it_has_ports_for(here: Path) -> None:
    own = OwnRenderer("soft.py:Soft")
    assert own.receives == ("theta", "stable", "in_contact") and not own.sees and own.name == "Soft"
    station = mmt.build_station(mmt.load_scenario("setup1"), renderer="soft.py:Soft", record="soft.mcap")
    station.simulate(3.0)
    soft = load("soft.mcap")
    on = (soft["detected_contact"] * soft["theta_stable"]).astype(bool)
    expected = np.where(on, -0.5 * soft["theta_normal_k"] * soft["master_position_z"], 0.0)
    assert on.sum() > 400
    np.testing.assert_allclose(soft["rendered_force_z"], expected, rtol=1e-9)


def test_a_renderer_of_the_remote_force_alone_sees_it_move_on_between_packets(here: Path) -> None:
    Path("direct.py").write_text(
        "import mmt_drake as mmt\n"
        "class Direct(mmt.LeafSystem):\n"
        "    def __init__(self, period):\n"
        "        super().__init__()\n"
        "        self.declare_inputs('remote_force')\n"
        "        self.declare_function('force', 3, lambda t, force: force)\n"
    )
    assert OwnRenderer("direct.py:Direct").between == "linear" and OwnRenderer("soft.py:Soft").between == "hold"
    scenario = mmt.load_scenario("setup1", ["renderer=!DirectForce", "to_operator.delay=0.05"])
    ends = []
    for renderer in (None, "direct.py:Direct"):
        station = mmt.build_station(scenario, renderer=renderer)
        ends.append(station.diagram.GetOutputPort("rendered_force").Eval(station.simulate(1.5).get_context()))
    assert np.linalg.norm(ends[0]) > 0.1
    np.testing.assert_array_equal(*ends)


def test_its_replay_is_what_it_does_in_the_loop(here: Path) -> None:
    own = OwnEstimator("my.py:MyEstimator")
    mmt.build_station(mmt.load_scenario("setup1"), estimator="my.py:MyEstimator", record="a.mcap").simulate(1.0)
    recorded = load("a.mcap")
    measurement = np.hstack([recorded.vector(name) for name in ("position", "velocity", "force")])
    trace = KINDS[OwnEstimator].replay(measurement, recorded["detected_contact"], own)
    # A state, which the recording has a tick later.
    theta = np.column_stack([recorded[f"theta_{name}"] for name in THETA])
    np.testing.assert_allclose(trace.theta[:-1], theta[1:], rtol=1e-9, atol=1e-12)
    assert np.isnan(trace.estimated_force).all()  # which it does not tell
    assert 0.0 < cost_us(own, recorded) < 1e4


def test_the_comparison_takes_it_beside_the_shipped_ones(here: Path) -> None:
    every = ESTIMATORS.scenarios(Asked(here, with_="my.py:MyEstimator"))
    assert {"strokes_thesis_rls", "strokes_output_error", "chirp_MyEstimator"} <= set(every)
    some = ESTIMATORS.scenarios(Asked(here, with_="my.py:MyEstimator", estimator="rls"))
    assert {estimator_name(case.estimator) for case in some.values()} == {"rls", "MyEstimator"}
    assert some["strokes_MyEstimator"].environment == some["strokes_thesis_rls"].environment


def test_what_a_port_may_be_is_read_off_the_station() -> None:
    inputs, outputs = part_ports("estimator")
    own = {"measurement": 9, "in_contact": 1, "reading": 3, "stamp": 1}
    assert inputs == {**own, "model": 44, "thing": 1, "scene": 72}
    assert (outputs["theta"], outputs["stable"], outputs["deviation"]) == (10, 1, 10)
    inputs, outputs = part_ports("renderer")
    assert inputs["point_cloud"] is None and inputs["remote_force"] == 3 and outputs["force"] == 3


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (None, "mine.py: found no such file, expected a Python file with a class Mine"),
        ("class Other: pass", "mine.py: found no Mine, expected a class Mine"),
        ("Mine = 3", "mine.py: found no Mine, expected a class Mine"),
        ("1 / 0", "mine.py: found ZeroDivisionError: division by zero, expected a Python file with a class Mine"),
        ("class Mine(:", "SyntaxError"),
        ("raise SystemExit(3)", "mine.py: found SystemExit: 3"),
        ("class Mine:\n def __init__(self): pass", "expected Mine(period=0.001) to be a Drake system"),
        ("class Mine:\n def __init__(self, period): 1 / 0", "line 2, in __init__: found ZeroDivisionError"),
        ("def Mine(period): return 3", "mine.py:Mine: found int, expected Mine(period=0.001) to be a Drake system"),
        (
            BARE.replace('"stable"', '"stabel"'),
            "mine.py:Mine: found no output port stable (1), expected theta (10), stable (1) among its outputs",
        ),
        (BARE.replace('"theta", 10', '"theta", 6'), "mine.py:Mine: found output port theta (6), expected theta (10)"),
        (BARE.replace('"measurement", 9', '"measurement", 6'), "input port measurement (6), expected measurement (9)"),
        (
            BARE.replace('"measurement"', '"mesurement"'),
            "found input port mesurement, which nothing feeds, expected no others than measurement (9), in_contact (1)",
        ),
        (BARE.replace("[1.0] * 10", "[1.0 / 0] * 10"), "line 6, in <lambda>: found ZeroDivisionError"),
        (BARE.replace("[1.0] * 10", "[1.0] * 9"), "line 6, in <lambda>: found"),
    ],
)
def test_what_cannot_stand_in_the_loop_is_refused_in_one_line(
    text: str | None, line: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if text is not None:
        Path("mine.py").write_text(text)
    status = main(["run", "setup1", "--seconds", "0.1", "--estimator", "mine.py:Mine", "--record", "out.mcap"])
    told = capsys.readouterr().err
    assert status == 2 and line in told and told.count("\n") == 1, told
    assert not list(here.glob("out*"))


@pytest.mark.parametrize("code", ["my.py", "my.txt:MyEstimator", ":MyEstimator", "my.py:My Estimator", "my.py:"])
def test_a_part_of_another_form_is_refused(code: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "setup1", "--renderer", code]) == 2
    told = capsys.readouterr().err
    assert f"setup1: renderer.code: found '{code}', expected FILE.py:CLASS" in told


def test_a_scenario_s_file_names_code_only_where_it_is_trusted(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("own.yaml").write_text("estimator: !OwnEstimator {code: my.py:MyEstimator}\n")
    assert main(["run", "own.yaml", "--seconds", "0.1"]) == 2
    assert "estimator.code: found 'my.py:MyEstimator', expected none in a file" in capsys.readouterr().err
    trusted = mmt.load_scenario("own.yaml", trust_library=True)
    assert trusted.estimator == OwnEstimator("my.py:MyEstimator")
    assert isinstance(mmt.load_scenario("own.yaml", ["estimator=!RlsOptions {}"]).estimator, RlsOptions)


def test_an_output_that_is_of_another_size_as_it_runs_is_told_with_its_port(here: Path) -> None:
    Path("short.py").write_text(
        "import mmt_drake as mmt\n"
        "class Short(mmt.LeafSystem):\n"
        "    def __init__(self, period):\n"
        "        super().__init__()\n"
        "        self.declare_inputs('motion')\n"
        "        self.declare_function('force', 3, lambda t, motion: (0.0, 0.0))\n"
    )
    with pytest.raises(BadInput, match=r"Short: force: found 2 numbers .*expected 3 numbers"):
        mmt.build_station(mmt.load_scenario("setup1"), renderer="short.py:Short", record="short.mcap").simulate(1.0)


NAN = """import mmt_drake as mmt
class Late(mmt.LeafSystem):
    def __init__(self, period):
        super().__init__()
        self.declare_inputs("motion")
        self.declare_function("force", 3, lambda t, motion: (0.0, 0.0, float("nan") if t > 1.0 else 0.0))
"""


def test_a_force_that_is_no_number_is_told_with_its_row_and_the_run_s_recording_is_kept(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("late.py").write_text(NAN)
    run = ["run", "setup1", "--renderer", "late.py:Late", "--seconds", "1.5"]
    told = "row 1002, column 'rendered_force_z': found nan, expected a finite number"
    assert main(run) == 0 and told in capsys.readouterr().out
    assert main([*run, "--record", "late.csv"]) == 2 and f"late.csv.mcap: {told}" in capsys.readouterr().err
    assert Path("late.csv.mcap").stat().st_size > 10_000 and not Path("late.csv").exists()
    for record, name in ((None, "setup1"), ("late.npz", "late.npz.mcap")):
        with pytest.raises(BadInput, match=f"^{name}: row 1002"):
            mmt.run("setup1", seconds=1.5, renderer="late.py:Late", record=record)
