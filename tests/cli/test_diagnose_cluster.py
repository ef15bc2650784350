"""`--cluster`: the work spread over the workers of a dask cluster, and nothing found but what is found without."""

import gc
import json
import os
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from cli_samples import Program
from trial_samples import COULOMB, SPRING_MODEL, spring

import mmt_drake.diagnosis.diagnose
import mmt_drake.diagnosis.fit.workers
import mmt_drake.diagrams.proof.trial.run
from mmt_drake.cli.trial import diagnose_case
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagrams.proof.trial.cases import Case
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import MaterialSession
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model
from mmt_drake.recording import save

RECORDINGS = 2


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a scheduler with two workers, processes on this machine."""
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    folder = tmp_path_factory.mktemp("workers")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, local_directory=str(folder)
    ) as running:
        yield running.scheduler_address


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, checkout: Path) -> Path:
    """Recordings of one axis with friction that its model lacks, and an effect of the user's own."""
    folder = tmp_path_factory.mktemp("recordings")
    for seed in range(RECORDINGS):
        save(spring(COULOMB, seed=seed, seconds=4.0), folder / f"{seed}.npz")
    (folder / "model.yaml").write_text(SPRING_MODEL)
    shutil.copy(checkout / "tests/effects/own_effect.py", folder / "own.py")
    return folder


@pytest.fixture
def few_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library of half a dozen, to be quick."""
    some = ("coulomb_friction", "quadratic_drag", "nonlinear_stiffness", "hysteresis", "force_lag", "time_delay")
    monkeypatch.setattr(mmt_drake.diagnosis.diagnose, "LIBRARY", {name: LIBRARY[name] for name in some})


def without_times(value: Any) -> Any:
    """A document without what took how long."""
    if isinstance(value, dict):
        return {key: without_times(part) for key, part in value.items() if key != "seconds"}
    return [without_times(part) for part in value] if isinstance(value, list) else value


def test_several_recordings_are_diagnosed_the_same_to_the_last_digit(
    cluster: str, folder: Path, few_effects: None, program: Program
) -> None:
    documents, models = [], []
    for place in ([], ["--cluster", cluster]):
        out = folder / f"out{len(place)}"
        files = [folder / f"{seed}.npz" for seed in range(RECORDINGS)]
        told = program("diagnose", *files, "--model", folder / "model.yaml", "--out", out, *place)
        assert (told.status, told.err) == (0, "")
        documents.append(without_times(json.loads((out / "diagnosis.json").read_text())))
        models.append((out / "augmented_model.yaml").read_text())
    assert documents[0]["verdict"] == "missing_physics"
    assert [effect["name"] for effect in documents[0]["effects"]] == ["coulomb_friction"]
    assert len(documents[0]["recordings"]) == RECORDINGS
    assert documents[0] == documents[1] and models[0] == models[1]


def test_an_effect_of_the_user_s_own_is_known_to_the_workers(cluster: str, folder: Path, program: Program) -> None:
    out = folder / "own"
    arguments = ["diagnose", folder / "0.npz", "--model", folder / "model.yaml", "--out", out, "--cluster", cluster]
    try:
        told = program(*arguments, "--effects", folder / "own.py")
    finally:
        LIBRARY.pop("quintic_stiffness", None)
    assert (told.status, told.err) == (0, "")
    document = json.loads((out / "diagnosis.json").read_text())
    assert [effect["name"] for effect in document["effects"]] == ["coulomb_friction"]
    assert "quintic_stiffness" in {name for candidate in document["candidates"] for name in candidate["names"]}


def test_what_calls_share_is_on_each_worker_once_and_goes_when_it_goes_here(cluster: str) -> None:
    from distributed import Client

    problem = prepare([spring(seconds=4.0)], parse_model(yaml.safe_load(SPRING_MODEL))).problem
    assert problem is not None
    samples = problem.samples()
    with Client(cluster, set_as_default=False) as client, workers(cluster=cluster) as executor:
        pairs = [(problem, (problem, number)) for number in range(20)]
        shared, places, answers = set(), set(), []
        for same, place, answer in executor.map(
            lambda one, again: (one is again[0], (os.getpid(), id(one)), one.samples() + again[1]),
            *zip(*pairs, strict=True),
        ):
            shared.add(same)
            places.add(place)
            answers.append(answer)
        assert shared == {True} and answers == [samples + number for number in range(20)]
        assert len(places) == len({process for process, _ in places})
        assert sum(client.run(held).values()) > 0
        del problem, pairs, same, place, answer
        gc.collect()
        deadline = time.monotonic() + 20.0
        while sum(client.run(held).values()) > 0:
            assert time.monotonic() < deadline, "still on the workers"
            time.sleep(0.05)


def test_a_worker_that_goes_away_takes_nothing_with_it(cluster: str) -> None:
    from distributed import Client

    problem = prepare([spring(seconds=4.0)], parse_model(yaml.safe_load(SPRING_MODEL))).problem
    assert problem is not None
    problems = [replace(problem, coarse=float(number)) for number in range(1, 9)]
    expected = [one.coarse for one in problems]
    with Client(cluster, set_as_default=False) as client, workers(cluster=cluster) as executor:
        answers = executor.map(lambda one: (time.sleep(0.2), one.coarse)[1], problems)
        found = [next(answers)]
        process = next(iter(client.run(os.getpid).values()))
        os.kill(process, signal.SIGKILL)
        assert [*found, *answers] == expected
        assert list(executor.map(lambda one: one.coarse, problems)) == expected


def held(dask_worker: Any) -> int:
    """How much a worker keeps."""
    return len(dask_worker.data)


def cases() -> list[Case]:
    """Short sealed cases: friction concealed, and wrong values alone."""
    base = {"k": 500.0, "b": 20.0, "x0": 0.01, "F0": 0.0}
    right = {"structure": "kelvin_voigt", "parameters": {"k": 500.0, "b": 20.0, "x0": 0.01}}
    wrong = {"structure": "kelvin_voigt", "parameters": {"k": 420.0, "b": 23.0, "x0": 0.01}}
    friction = (Concealed("coulomb_friction", {"Fc": 0.5}),)
    return [
        Case("case-0001", "single", friction, base, right, MaterialSession(1), 0.5, 20.0),
        Case("case-0002", "parameters", (), base, wrong, MaterialSession(2)),
    ]


def test_cases_of_the_trial_are_diagnosed_as_they_are_here(
    cluster: str, tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mmt_drake.diagrams.proof.trial.run, "draw_trial", lambda *asked: cases())
    told = program("trial", "--json", "--out", tmp_path / "out", "--cluster", cluster)
    assert told.status == 0, told.err
    whole = json.loads(told.out)
    assert [case["verdict"] for case in whole["cases"]] == ["missing_physics", "parameters"]
    # Beside a free rest position an asymmetry of friction is nothing but an offset: dry friction is all that is sure.
    assert all(case["right_family"] for case in whole["cases"])
    for case in cases():
        folder = tmp_path / "out" / "cases" / case.name
        there = json.loads((folder / "diagnosis.json").read_text())
        here = json.loads(json.dumps(diagnose_case(folder)))
        assert without_times(here) == without_times(there)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere", "ftp://127.0.0.1:1"])
def test_a_scheduler_that_does_not_answer_is_bad_input(
    address: str, folder: Path, tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr(mmt_drake.diagnosis.fit.workers, "_PATIENCE_S", 0.3)
    model = folder / "model.yaml"
    told = program("diagnose", folder / "0.npz", "--model", model, "--out", tmp_path / "out", "--cluster", address)
    gc.collect()  # a client that never started, collected while the next one starts, would keep it waiting for ever
    assert (told.status, told.out) == (2, "")
    assert told.err.count("\n") == 1 and f"--cluster: found {address}" in told.err
    assert not (tmp_path / "out").exists()


def test_without_dask_the_extra_is_named(
    folder: Path, tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    model = folder / "model.yaml"
    told = program("diagnose", folder / "0.npz", "--model", model, "--out", tmp_path / "out", "--cluster", "tcp://a:1")
    assert (told.status, told.out) == (2, "")
    assert told.err.count("\n") == 1 and "mmt_drake[cluster]" in told.err
    assert not (tmp_path / "out").exists()
