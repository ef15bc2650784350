"""`setup1-learning`: what a learner costs, whether it repeats, and what nobody may feel of it."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.bench.pacing import paced
from mmt_drake.diagrams.proof.bench.repeatability import bytes_apart
from mmt_drake.diagrams.proof.experiments.learning import LAWS
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.learning.answer import LookResult
from mmt_drake.learning.beside import Looks, Question
from mmt_drake.learning.law_learner import LawLearner
from mmt_drake.model.message_layout import MESSAGE_NUMBER
from mmt_drake.model_message import UNKNOWN_THETA, ToldEffect
from mmt_drake.realtime import Pace
from mmt_drake.recording import AXES, load

_SCENARIO = "setup1-learning"
_TURNS, _TURN_S, _RUN_S, _PRESSED_S = 4, 10.0, 50.0, 30.0
_TWICE, _GIVEN_J = 2.0, 1e-5
_FAR = ["to_telerobot.delay=2.0", "to_operator.delay=2.0", "to_telerobot.loss=0.1", "to_operator.loss=0.1"]
_LOOP = "from mmt_drake.own_process import give_way; give_way(idle=True)\nwhile True: pass"
_NONE = ["environment.object.effects=[]"]


class LawsInTurn(Looks):
    """Names passive laws at random, none now and then: they come and go whatever the object is."""

    def __init__(self) -> None:
        self._random = np.random.default_rng(0)

    def close(self) -> None:
        """Nothing was begun."""

    def ask(self, question: Question) -> None:
        """Nothing is to be looked for."""

    def is_answered(self, question: Question) -> bool:
        """At once."""
        return True

    def answer(self, question: Question, *, here: bool) -> LookResult:
        """Some law of `LAWS`, or none."""
        names = self._random.permutation(list(LAWS)).tolist()[: min(self._random.integers(4), 1)]
        laws = tuple(ToldEffect(name, dict(LAWS[name])) for name in names)
        return LookResult("missing_physics" if laws else "parameters", laws, UNKNOWN_THETA)


def measurements(minutes: float = 1.0) -> Iterator[Measurement]:
    """Every figure.

    Args:
        minutes: for which an object without a law is felt, and nothing is to be told.
    """
    yield from _pacing()
    yield from _runs()
    yield _energy()
    station = build_station(load_scenario(_SCENARIO, _NONE))
    context = station.simulate(60.0 * minutes).get_context()
    learner = _learner(station)
    told = learner.GetOutputPort("model").Eval(learner.GetMyContextFromRoot(context))[MESSAGE_NUMBER]
    yield Measurement(f"messages told in {minutes:g} min of an object without a law", float(told), "", 0.0)


def _learner(station: Station) -> LawLearner:
    found = station.diagram.GetSubsystemByName("learner")
    assert isinstance(found, LawLearner)
    return found


def _pacing() -> Iterator[Measurement]:
    """Lateness by the wall clock without the learner and with it, in turns; it looks from the third second on.

    Beside them a loop in the learner's place, of its priority, that computes nothing: what any work costs the clock.
    """
    none, looking = ["learner=null"], ["learner.window=3.0"]
    loops: dict[str, Callable[[], Pace]] = {
        "without its learner": lambda: paced(_SCENARIO, _TURN_S, none),
        "beside an idle loop": lambda: _beside_a_loop(lambda: paced(_SCENARIO, _TURN_S, none)),
        "with its learner": lambda: paced(_SCENARIO, _TURN_S, looking),
    }
    rounds = [{name: loop() for name, loop in loops.items()} for _ in range(_TURNS)]
    p99 = {name: float(np.quantile(np.concatenate([r[name].late_s for r in rounds]), 0.99)) for name in loops}
    for name, value in p99.items():
        yield Measurement(f"{_SCENARIO} {name}: lateness of a tick, 99th percentile", 1e6 * value, "us")
    without, idle, learning = p99.values()
    yield Measurement("99th percentile with a learner over that without", learning / without, "x", _TWICE)
    yield Measurement("99th percentile with a learner over that beside an idle loop", learning / idle, "x")


def _beside_a_loop(run: Callable[[], Pace]) -> Pace:
    """A paced run beside a process that does nothing without end."""
    with subprocess.Popen([sys.executable, "-c", _LOOP]) as loop:
        try:
            return run()
        finally:
            loop.kill()


def _runs() -> Iterator[Measurement]:
    """Two whole runs, looks waited for: how fast, and whether they are the same."""
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / name for name in ("first.mcap", "second.mcap")]
        stations = [build_station(load_scenario(_SCENARIO), record=file) for file in files]
        begun = time.perf_counter()
        stations[0].simulate(_RUN_S)
        took = time.perf_counter() - begun
        stations[1].simulate(_RUN_S)
        apart = bytes_apart(*files)
    yield Measurement(
        f"{_SCENARIO}, its look waited for: simulated time over wall clock", _RUN_S / took, "x", 1.0, True
    )
    yield Measurement(f"{_SCENARIO} run twice: bytes of the recordings that differ", apart, "bytes", 0.0)


def _energy() -> Measurement:
    """Energy that the hand got out beyond what it had put in, of forces held from tick to tick."""
    changes = [*_FAR, "learner.window=3.0", "learner.delay=0.1", "learner.doubt=1.0"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        station = build_station(load_scenario(_SCENARIO, changes), record=file)
        _learner(station).answered_by(LawsInTurn())
        station.simulate(_PRESSED_S)
        recording = load(file)
    columns = ("rendered_force", "master_position")
    force, hand = (np.column_stack([recording[f"{name}_{axis}"] for axis in AXES]) for name in columns)
    put_in = np.cumsum(-(force[:-1] * np.diff(hand, axis=0)).sum(axis=1))
    told = int(recording["model_number"].max())
    name = f"energy given that was not put in, 2 s of delay, 10 % loss, {told} messages of laws while pressing"
    return Measurement(name, max(0.0, -float(put_in.min())), "J", _GIVEN_J)
