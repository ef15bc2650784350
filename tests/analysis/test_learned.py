"""What a recording says of laws that came to be told while the run went on."""

import numpy as np
import pytest

from mmt_drake.analysis.learned import SETTLES_S, ForceOff, learned, learner
from mmt_drake.errors import BadInput
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.model.message_layout import MESSAGE
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect
from mmt_drake.recording import Recording
from mmt_drake.recording.two_recordings import DELAY
from mmt_drake.rendering.status import APPROACHING, RENDERING

STEP, COUNT = 0.001, 12000
CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
TIME = np.arange(COUNT) * STEP


def recording(*messages: tuple[float, ModelMessage], delay: float = 0.0, off: float = 0.1) -> Recording:
    """A run whose rendered force is off by a share until the first message, and by a tenth of that from it on.

    Along the normal it is twice that.
    """
    model = np.zeros((COUNT, len(MESSAGE)))
    for since, message in messages:
        model[since <= TIME] = message.vector()
    plant = np.sin(3.0 * TIME)
    share = np.where((messages[0][0] if messages else np.inf) <= TIME, 0.1 * off, off)
    columns = {"in_contact": np.where((TIME > 1.0) & (TIME < 11.0), 1.0, 0.0)}
    columns |= {f"model_{name}": model[:, i] for i, name in enumerate(MESSAGE)}
    for axis in "xyz":
        columns[f"true_force_{axis}"] = columns[f"force_{axis}"] = plant
        ahead = round(delay / STEP)
        rendered = (1.0 + share * (2.0 if axis == "z" else 1.0)) * plant
        columns[f"rendered_force_{axis}"] = np.append(rendered[ahead:], np.full(ahead, rendered[-1]))
    return Recording(TIME, columns, made_by={DELAY: f"{delay:g}"})


@pytest.mark.parametrize("delay", [0.0, 0.4])
def test_the_error_before_and_after_a_law_is_told(delay: float) -> None:
    found = learned(recording((5.0, ModelMessage(UNKNOWN_THETA, (CUBIC,))), delay=delay))
    assert found is not None and len(found.told) == 1
    (told,) = found.told
    assert told.at == 5.0 and told.contact == pytest.approx(4.0, abs=0.002) and told.effects == (CUBIC,)
    assert found.before == pytest.approx((0.1, 0.2), rel=1e-6) and told.error == pytest.approx((0.01, 0.02), rel=1e-6)
    assert found.line() == (
        "told while it was felt: rendered force off by 10 % along the surface, 20 % along the normal, after "
        "0.5 s of contact; at 5.00 s "
        f"nonlinear stiffness (k3 = 3e+06 N/m^3) (rendered from {5.0 + delay:.2f} s on): 1 % along the surface, 2 % "
        "along the normal (each from 1 s after it is rendered)"
    )
    assert found.to_json()["before"] == pytest.approx(0.1) and found.to_json()["normal_before"] == pytest.approx(0.2)
    assert found.to_json()["told"][0]["effects"] == [{"name": "nonlinear_stiffness", "parameters": {"k3": 3e6}}]


@pytest.mark.parametrize("delay", [0.0, 0.4])
def test_the_error_after_a_law_counts_from_when_it_is_rendered(delay: float) -> None:
    run = recording((5.0, ModelMessage(UNKNOWN_THETA, (CUBIC,))), delay=delay)
    arrives, renders = 5.0 + delay, 7.0 + delay
    status = np.where((arrives <= TIME) & (renders > TIME), APPROACHING, RENDERING)
    rendered = {name: run[name].copy() for name in run.columns}
    for axis in "xyz":  # what is on its way is off by all of it
        rendered[f"rendered_force_{axis}"][status == APPROACHING] = 0.0
    found = learned(Recording(TIME, {**rendered, "renderer_status": status}, made_by=run.made_by))
    assert found is not None and found.told[0].at == 5.0
    assert found.told[0].rendered == pytest.approx(renders) and found.to_json()["told"][0]["rendered_s"] == renders
    assert found.told[0].error == pytest.approx((0.01, 0.02), rel=1e-6)
    never = {**rendered, "renderer_status": np.full(COUNT, APPROACHING)}
    missed = learned(Recording(TIME, never, made_by=run.made_by))
    assert missed is not None and missed.told[0].rendered is None and missed.told[0].error == ForceOff()


def test_what_the_force_sensor_adds_is_told_with_the_laws() -> None:
    message = ModelMessage(UNKNOWN_THETA, (CUBIC,), sensor=SensorError(gain=0.2))
    found = learned(recording((5.0, message)))
    assert found is not None and found.told[0].names == ("nonlinear_stiffness", "force_crosstalk")
    assert "and force crosstalk (gain = 0.2) (rendered from 5.00 s on): 1 % along" in found.line()
    assert found.to_json()["told"][0]["sensor"] == {"bias": 0.0, "rate": 0.0, "gain": 0.2, "tau": 0.0}


def test_a_law_that_leaves_is_told_too_and_a_message_without_contact_after_it_has_no_error() -> None:
    messages = (5.0, ModelMessage(UNKNOWN_THETA, (CUBIC,))), (11.5, ModelMessage(UNKNOWN_THETA, number=2))
    found = learned(recording(*messages))
    assert found is not None
    assert [told.effects for told in found.told] == [(CUBIC,), ()]
    assert found.told[1].error == ForceOff() and "at 11.50 s no law (rendered from 11.50 s on): unknown" in found.line()
    assert messages[1][0] - messages[0][0] > SETTLES_S


def test_a_law_that_is_known_from_the_start_has_nothing_before_it() -> None:
    found = learned(recording((0.0, ModelMessage(UNKNOWN_THETA, (CUBIC,)))))
    assert found is not None and found.line().startswith("told while it was felt: at 0.00 s nonlinear stiffness")


def test_a_learner_s_looks_are_counted_and_its_end_told() -> None:
    status = np.zeros(COUNT)
    status[2000:4000], status[6000:] = LearnerStatus.LOOKING, LearnerStatus.LOOKING
    found = learner(Recording(TIME, {"learner_status": status}))
    assert found is not None and found.to_json() == {"looks": 2, "at_end": "looking"}
    assert found.line() == "learner: looks at the contact 2; at the end it is looking"
    assert learner(Recording(TIME, {"position_x": TIME})) is None
    with pytest.raises(BadInput, match="learner_status: found 9 at the end, expected one of 0, 1, 2, 3, 4, 5"):
        learner(Recording(TIME, {"learner_status": np.full(COUNT, 9.0)}))


def test_a_run_in_which_nothing_was_told_says_nothing() -> None:
    assert learned(recording()) is None
    assert learned(Recording(TIME, {"position_x": TIME})) is None
