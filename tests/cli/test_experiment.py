"""`mmt-drake experiment`: glue between the arguments, the experiments and the terminal."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import mmt_drake.diagrams.proof.experiments.ablation.report as ablation
import mmt_drake.diagrams.proof.experiments.engines.report as engines
import mmt_drake.diagrams.proof.experiments.thesis as three
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.experiments import MODULES
from mmt_drake.diagrams.proof.experiments.comparison import Comparison
from mmt_drake.diagrams.proof.experiments.engines import own
from mmt_drake.diagrams.proof.experiments.report import EXPERIMENTS
from mmt_drake.diagrams.proof.studies import Asked


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Experiment 3 with two of the ways of solving eq. 30."""
    chosen = (three.MAIN, "thesis_rls_without_c")
    made, asked = three.thesis_cases(3, seconds=7.0), Asked(tmp_path_factory.mktemp("three"), seconds=7.0)
    fewer = replace(EXPERIMENTS[3], cases=lambda _: {name: made[name] for name in chosen})
    cases = fewer.run(asked)
    return SimpleNamespace(cases=cases, report=fewer.report(asked, cases))


@pytest.fixture
def asked(result, monkeypatch):
    """What the command asks for; the answer is a result computed once."""
    told = SimpleNamespace()

    def run(experiment, asked, progress):
        told.asked, told.number = asked, experiment.name
        progress(len(result.cases))

    monkeypatch.setattr(Comparison, "run", run)
    monkeypatch.setattr(Comparison, "report", lambda *_: result.report)
    return told


@pytest.mark.parametrize("name", [name for name in MODULES if not name.isdigit()])
def test_help_says_what_each_experiment_is(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["experiment", "--help"]) == 0
    assert f"\n{name}: " in capsys.readouterr().out


@pytest.mark.parametrize("experiment", [3, "network"])
def test_json_is_one_document_and_nothing_else(asked, result, tmp_path, capsys, experiment):
    options = ["--json", "--out", str(tmp_path), "--seconds", "7", "--seed", "5"]
    assert main(["experiment", str(experiment), *options]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out) == json.loads(json.dumps(result.report.document))
    assert captured.err == ""
    assert (asked.number, asked.asked.seconds, asked.asked.seed, asked.asked.operator) == (experiment, 7.0, 5, None)


def test_the_table_tells_every_case_its_errors_and_where_the_page_is(asked, result, tmp_path, capsys):
    assert main(["experiment", "3", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    for case in result.cases.values():
        row = next(line for line in told.splitlines() if line.startswith(f"{case.name} "))
        errors = [*case.metrics.rendered_error.tangential.values(), case.settled.rendered_error.tangential["all"]]
        assert [float(cell) for cell in row.split()[1:6]] == pytest.approx(
            [100.0 * ratio for ratio in errors], rel=1e-3
        )
    assert "truth" in told and f"page: {tmp_path / 'index.html'}" in told
    assert (tmp_path / "figure_14.png").is_file() and (tmp_path / "figure_35.png").is_file()


def test_without_out_everything_goes_to_a_folder_of_its_own(asked, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["experiment", "3", "--json"]) == 0
    assert str(asked.asked.out) == "out/experiment3"
    assert (tmp_path / "out" / "experiment3" / "index.html").is_file()


def test_engines_tells_what_each_engine_is_off_and_costs_as_text_and_as_one_document(tmp_path, monkeypatch, capsys):
    ours = engines.run_engines(own.METHODS)
    monkeypatch.setattr(engines, "run_engines", lambda progress: ours)
    assert main(["experiment", "engines", "--json", "--out", str(tmp_path)]) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert document["experiment"] == "engines" and len(document["cells"]) == 24
    assert captured.err == "" and (tmp_path / "index.html").is_file() and (tmp_path / "engines.png").is_file()
    assert main(["experiment", "engines", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "the renderer" in told and "(to reach: 1e-05, reached)" in told and f"page: {tmp_path}" in told
    assert "31.79" in told  # what the thesis prints stands beside it


def test_ablation_tells_every_cause(tmp_path, monkeypatch, capsys):
    one_cause = ablation.ablation(ablation.CAUSES[:1])
    monkeypatch.setitem(ablation.STUDIES, "ablation", one_cause.study)
    monkeypatch.setattr("mmt_drake.cli.experiment.processors", lambda: 1)
    assert main(["experiment", "ablation", "--seconds", "9", "--seed", "2", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert any(line.startswith("nothing ") for line in told.splitlines()) and "Figure 35:" in told
    assert (tmp_path / "ablation.png").is_file() and len(list(tmp_path.glob("*.mcap"))) == 3


def test_objects_tells_the_worst_and_what_was_found_of_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("mmt_drake.cli.experiment.processors", lambda: 1)
    monkeypatch.setattr("mmt_drake.diagrams.proof.experiments.objects.SECONDS", 9.0)
    assert main(["experiment", "objects", "--count", "1", "--out", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "1 objects, the normal axis of the same material" in told and f"page: {tmp_path}" in told
    rows = [line.split() for line in told.splitlines()]
    (true,) = [row for row in rows if "true" in row]
    (found,) = [row for row in rows if "found" in row]
    np.testing.assert_allclose(np.array(found[-6:], float), np.array(true[-6:], float), rtol=0.05)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["4"], "invalid choice: '4'"),
        (["2", "--operator", "hand.csv"], "experiment 2: found --operator"),
        (["estimators", "--operator", "hand.csv"], "experiment estimators: found --operator, expected no option but"),
        (["bands", "--operator", "hand.csv"], "experiment bands: found --operator"),
        (["engines", "--count", "3", "--estimator", "rls"], "experiment engines: found --count, --estimator"),
        (["1", "--anisotropic"], "experiment 1: found --anisotropic, expected no option but --operator, --seconds"),
        (["peers", "--count", "3"], "experiment peers: found --count"),
        (["objects", "--seconds", "5"], "experiment objects: found --seconds"),
        (["objects", "--count", "0"], "experiment objects: found --count 0"),
        (["adequacy", "--count", "0"], "experiment adequacy: found --count 0"),
        (["passivity", "--count", "0"], "experiment passivity: found --count 0"),
        (["engines", "--seed", "0"], "experiment engines: found --seed"),
        (["engines", "--seconds", "5"], "experiment engines: found --seconds, expected no option but --out and --json"),
        ([], "required"),
        (["1", "--seconds", "0"], "seconds"),
        (["1", "--seed", "-1"], "seed"),
        (["1", "--operator", "missing.csv", "--out", "made_for_nothing"], "missing.csv"),
    ],
)
def test_bad_input_is_one_line_and_exit_status_2(arguments, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["experiment", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert told in captured.err and len(captured.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_an_error_in_another_process_is_the_same_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("mmt_drake.cli.experiment.processors", lambda: 2)
    assert main(["experiment", "3", "--seconds", "2", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "in_contact: found" in line and "expected more than the 5 s after which errors count" in line
    assert list(tmp_path.iterdir()) == []
