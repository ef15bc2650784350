"""What was known when Ctrl-C ended long work is on disk, and the last line says where."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program

from mmt_drake.cli.interrupted import known_kept
from mmt_drake.diagnosis import first_model
from mmt_drake.errors import Interrupted


@dataclass(frozen=True)
class Result:
    name: str
    errors: np.ndarray
    worst: float
    where: Path
    reached: bool | None


def test_results_that_were_done_are_on_disk_and_the_line_names_the_file(tmp_path: Path) -> None:
    result = Result("first", np.array([1.0, np.inf]), np.float64(2.5), Path("run.mcap"), None)
    kept = known_kept(tmp_path / "out", "mmt-drake experiment objects")
    with pytest.raises(KeyboardInterrupt, match=r"1 of 3 done; written: .*interrupted\.json"), kept:
        raise Interrupted("1 of 3 done", {"of": 3, "results": [result]})
    known = {"name": "first", "errors": [1.0, None], "worst": 2.5, "where": "run.mcap", "reached": None}
    written = json.loads((tmp_path / "out" / "interrupted.json").read_text())
    assert written == {"command": "mmt-drake experiment objects", "of": 3, "results": [known]}


def test_nothing_known_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(Interrupted), known_kept(tmp_path, "mmt-drake trial"):
        raise Interrupted("")
    assert not [*tmp_path.iterdir()]


def test_a_fit_leaves_it_beside_the_model_it_was_to_write(
    tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ended(*_: object, **__: object) -> None:
        raise Interrupted("so far k 8, not fitted to the end", {"unfinished_numbers": {"k": 8.0}})

    monkeypatch.setattr(first_model, "fit", ended)
    (tmp_path / "pull.csv").write_text(
        "time,position,force\n" + "".join(f"{i / 100},{i % 9 / 1e3},{i % 9}\n" for i in range(200))
    )
    run = program("fit", tmp_path / "pull.csv", "--out", tmp_path / "model.yaml")
    assert run.status == 130
    assert "interrupted; so far k 8" in run.err
    assert json.loads((tmp_path / "model.interrupted.json").read_text())["unfinished_numbers"] == {"k": 8.0}
    assert not (tmp_path / "model.yaml").exists()


def test_work_that_ends_well_removes_what_an_interrupted_one_left(tmp_path: Path) -> None:
    (tmp_path / "interrupted.json").write_text("{}")
    with known_kept(tmp_path, "mmt-drake trial"):
        pass
    assert not [*tmp_path.iterdir()]
