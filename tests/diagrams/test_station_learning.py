"""A station with a learner: who is connected to whom, what is refused, and what is felt in the end."""

import json
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.analysis.learned import learned
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.learning import law_learner
from mmt_drake.learning.answer import LookResult
from mmt_drake.learning.beside import Looks, Question
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model_message import UNKNOWN_THETA, ToldEffect
from mmt_drake.recording import load

CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
PRESSED = ToldEffect("normal_nonlinear_stiffness", {"k3": 2e7})


class Naming(Looks):
    """Names the law that the object has."""

    def __init__(self, law: ToldEffect) -> None:
        self.law, self.closed = law, False

    def close(self) -> None:
        self.closed = True

    def ask(self, question: Question) -> None:
        """Nothing is to be looked for."""

    def answer(self, question: Question, *, here: bool) -> LookResult | None:
        return LookResult("missing_physics", (self.law,), UNKNOWN_THETA)


def test_a_message_crosses_the_network_where_there_is_a_learner_and_nowhere_else() -> None:
    assert returned(load_scenario("setup1-learning"))["model"] == MESSAGE_SIZE
    assert "model" not in returned(load_scenario("setup1-free-running"))


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ("estimator=!RlsOptions {}", "estimator: found !RlsOptions"),
        ("renderer=!DirectForce {}", "renderer: found !DirectForce"),
        ("environment.surface=!Plane {tilt: 10}", "learner: found a learner, expected null"),
    ],
)
def test_a_learner_whose_news_nobody_could_take_up_is_refused(change: str, what: str) -> None:
    with pytest.raises(BadInput, match=what):
        load_scenario("setup1-learning", [change, "switching=telerobot"])


@pytest.mark.parametrize(("law", "where"), [(CUBIC, "surface"), (PRESSED, "normal")])
def test_a_law_that_is_told_is_felt_and_recorded(
    law: ToldEffect, where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Naming] = []

    def make(idle: bool) -> Naming:
        made.append(Naming(law))
        return made[-1]

    monkeypatch.setattr(law_learner, "Looks", make)
    changes = ["learner.window=3.0", "learner.delay=0.5", "to_telerobot.delay=0.1", "to_operator.delay=0.1"]
    changes += [f"environment.object.effects={json.dumps([{'name': law.name, 'parameters': law.parameters}])}"]
    station = build_station(load_scenario("setup1-learning", changes), record=tmp_path / "run.mcap")
    station.simulate(8.0)
    assert made[0].closed
    recording = load(tmp_path / "run.mcap")
    found = learned(recording)
    assert found is not None and [told.effects for told in found.told] == [(law,)]
    before, after = (getattr(off, where) for off in (found.before, found.told[0].error))
    assert before > 0.02 and after < 0.25 * before
    assert (recording["renderer_status"] < 7.0).all(), "no packet between two messages is taken for one"
    assert np.unique(recording["learner_status"]).tolist() == [0.0, 1.0, 2.0]
