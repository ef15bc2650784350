"""The experiment on energy: what it counts, and that no adversary gets any out of the shipped renderers."""

from pathlib import Path

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.passivity import (
    AS_SHIPPED,
    CASES,
    POLICIES,
    SIGNALS,
    STEP,
    EnergyRun,
    passivity_table,
    played,
)
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.stations.shipped import shipped as all_shipped
from mmt_drake.rendering.updates import AtOnce, renderer_rules
from mmt_drake.told_laws import NO_LAWS


def test_a_spring_whose_force_is_held_gives_half_its_stiffness_times_the_steps_squared() -> None:
    depth = 0.004 * np.sin(np.linspace(0.0, np.pi, 201)) ** 2
    path = np.zeros((201, 3))
    path[:, 2] = -depth - 1e-9  # in contact throughout
    theta = np.tile([1.0, 0.0, 500.0, 60.0, 0.0, 0.0, 800.0, 0.0, 0.0, 0.0], (201, 1))
    one, none = np.ones(201), np.zeros((201, 3))
    rules = renderer_rules(AtOnce(), STEP, 1)
    held, sure = np.zeros((201, 6)), np.zeros(201)
    nothing = NO_LAWS[np.newaxis], np.zeros(201)
    given, jump = played(path, theta, theta, one, one, held, 0, one, none, 0.0, rules, sure, False, None, *nothing)
    assert -given == pytest.approx(400.0 * np.sum(np.diff(depth) ** 2), rel=1e-3)
    assert jump < 1e-5


def test_no_adversary_gets_energy_out_of_what_is_shipped_and_other_policies_give_it() -> None:
    runs = CASES.run(Asked(Path(), count=120))
    shipped = [run for run in runs if run.policy == AS_SHIPPED]
    assert {run.signal for run in shipped} == set(SIGNALS)
    assert {run.scenario for run in shipped} == set(all_shipped())
    report = CASES.report(runs)
    counted = {figure.case: figure.value for figure in report.reached if figure.target.unit == "runs"}
    assert counted[AS_SHIPPED] == 0.0 and all(counted[name] > 0.0 for name in POLICIES if name != AS_SHIPPED)
    assert 0.0 < max(run.jump for run in shipped if run.scenario != "setup1-learning") < 0.051  # 50 N/s
    assert max(run.jump for run in shipped) < 0.1  # a place that is told may bend a law further (docs/learning.md)


def test_runs_are_counted_by_policy_and_by_what_becomes_of_the_velocity() -> None:
    runs = tuple(
        EnergyRun(i, policy, "setup1", signal, 1e-3 if policy == "at once" and signal == "dead" else 1e-6, 0.05)
        for policy in POLICIES
        for i, signal in enumerate(SIGNALS)
    )
    rows = {row[0]: row[1:] for row in passivity_table(runs).rows}
    assert rows["at once"] == ["0 of 1", "1 of 1", "0 of 1", "0 of 1"] and rows[AS_SHIPPED] == ["0 of 1"] * 4
    assert [figure.value for figure in CASES.report(runs).reached] == [0.0, 0.05, 1.0, 0.0, 0.0]
