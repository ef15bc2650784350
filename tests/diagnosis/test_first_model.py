"""A first model from a recording alone: the truth in its intervals, and nothing called determined that is not told."""

import math
from dataclasses import replace

import numpy as np
import pytest
from palpation_samples import STIFFNESS, palpation

from mmt_drake.diagnosis.first_model import FirstModel, _units, fit
from mmt_drake.diagnosis.fit.rough import rough_model
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagnosis.search.watch import Stage
from mmt_drake.diagnosis.tell.first import remarks
from mmt_drake.errors import BadInput, Interrupted
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.structure import Units
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed

TIME = np.arange(4000) * 2.5e-3
NOISE = 0.02


def pulled(k: float, b: float, F0: float, *, hertz: float = 1.0, k3: float = 0.0, seed: int = 0) -> Recording:
    """10 s of a spring and a damper moved by two sines, by their law itself."""
    rng = np.random.default_rng(seed)
    rates = 2.0 * math.pi * np.array([hertz, 0.31 * hertz])
    x = 5e-3 * np.sin(np.outer(TIME, rates)).sum(axis=1)
    v = 5e-3 * (rates * np.cos(np.outer(TIME, rates))).sum(axis=1)
    force = F0 - k * x - b * v - k3 * x**3 + NOISE * rng.standard_normal(len(TIME))
    return completed(TIME, {"position": x, "velocity": v, "force": force}, "pulled")


def driven(m: float, b: float, k: float) -> Recording:
    """5 s of a body on a spring whose position is given and whose input follows from its law."""
    rates = 2.0 * math.pi * np.array([0.4, 1.1])
    time = TIME[:2000]
    phase = np.outer(time, rates)
    x, v, a = (
        0.01 * part.sum(axis=1) for part in (1.0 - np.cos(phase), rates * np.sin(phase), rates**2 * np.cos(phase))
    )
    u = m * a + b * v + k * x
    noisy = x + 1e-5 * np.random.default_rng(1).standard_normal(len(x)) * (time > 0.0)
    return completed(time, {"input": u, "output": noisy}, "driven")


def fitted(*recordings: Recording, structure: str | None = None) -> FirstModel:
    with workers(1) as executor:
        return fit(recordings, structure, executor=executor)


def told(found: FirstModel) -> dict[str, str]:
    return {n.symbol: n.told for n in found.numbers}


def interrupted(after: str) -> Interrupted:
    """A fit of a spring and a damper that Ctrl-C ends at the first stage that tells this."""

    def listen(stage: Stage) -> None:
        if after in stage.now:
            raise KeyboardInterrupt

    with workers(1) as executor, pytest.raises(Interrupted) as caught:
        fit([pulled(k=8000.0, b=90.0, F0=-3.0)], executor=executor, on_stage=listen)
    return caught.value


def test_a_fit_that_is_interrupted_says_the_best_numbers_by_then() -> None:
    ended = interrupted("1 minima")
    assert ended.known["structure"] == "kelvin_voigt"
    assert ended.known["unfinished_numbers"]["k"] == pytest.approx(8000.0, rel=0.2)
    assert str(ended).startswith("so far k ")
    assert not interrupted("33 starts").known


def test_a_spring_and_a_damper_are_found_whatever_their_size() -> None:
    truth = {"k": 8000.0, "b": 90.0, "F0": -3.0}
    found = fitted(pulled(**truth))
    assert isinstance(found.model, KelvinVoigt) and found.explains and found.minima == 1
    for number in found.numbers:
        low, high = number.ci95
        assert low <= truth[number.symbol] <= high and low <= number.value <= high
        assert number.told == "determined" and high - low < 0.05 * abs(truth[number.symbol])
    assert found.heldout[0] == pytest.approx(found.noise[0], rel=0.2)


def test_two_recordings_tell_more_than_one() -> None:
    one, two = fitted(pulled(500.0, 20.0, 0.5)), fitted(pulled(500.0, 20.0, 0.5), pulled(500.0, 20.0, 0.5, seed=1))
    widths = [next(n.ci95[1] - n.ci95[0] for n in found.numbers if n.symbol == "b") for found in (one, two)]
    assert widths[1] < widths[0] and len(two.heldout) == 2


def test_damping_that_the_noise_hides_is_no_number_but_a_bound() -> None:
    found = fitted(pulled(500.0, 0.4, 0.5, hertz=0.05))  # b v is a twentieth of the noise
    assert told(found) == {"k": "determined", "b": "at most", "F0": "determined"}
    (damping,) = (n for n in found.numbers if n.symbol == "b")
    assert damping.value == 0.0 and damping.ci95[0] == 0.0 and damping.ci95[1] > 0.4
    assert any(remark == "May as well be 0, and is 0 in the model: b." for remark in remarks(found))


def test_what_the_structure_lacks_is_said_and_its_intervals_are_not_vouched_for() -> None:
    found = fitted(pulled(500.0, 20.0, 0.5, k3=2e7))
    assert not found.explains and "determined" not in told(found).values()
    assert any("the structure lacks physics" in remark for remark in remarks(found))


def test_a_driven_body_without_friction_is_given_none() -> None:
    truth = {"m": 2.0, "b": 6.0, "k": 40.0, "Fc": 0.0, "offset": 0.0}
    found = fitted(driven(2.0, 6.0, 40.0))
    assert isinstance(found.model, DrivenBodyModel) and found.explains
    for number in found.numbers:
        assert number.ci95[0] - 1e-6 <= truth[number.symbol] <= number.ci95[1] + 1e-6
    assert told(found)["Fc"] == "at most" and found.model.Fc == 0.0


@pytest.mark.parametrize(
    ("told", "expected", "remark"),
    [
        ({}, None, None),
        ({"output": "m", "input": "N"}, None, None),
        ({"output": "rad", "input": "A"}, Units("rad", "A"), None),
        ({"output": "rad", "input": "1"}, None, "The unit of input is '1', which has no name"),
        ({"output": "rad", "input": "rad/s"}, None, "The unit of input is 'rad/s', which has no name"),
        ({"output": "rad"}, None, "The unit of input is not told: "),
    ],
)
def test_units_that_no_model_can_name_are_remarked_on(
    told: dict[str, str], expected: Units | None, remark: str | None
) -> None:
    units, why = _units(replace(driven(2.0, 6.0, 40.0), own_units=told))
    assert units == expected
    assert why is None if remark is None else why is not None and why.startswith(remark)


def test_rough_numbers_are_those_of_least_squares() -> None:
    rough = rough_model(pulled(500.0, 20.0, 0.5))
    assert isinstance(rough, KelvinVoigt)
    assert (rough.k, rough.b, rough.F0) == pytest.approx((500.0, 20.0, 0.5), rel=0.02)


def test_of_a_tip_on_an_unknown_surface_the_stiffness_is_guessed_and_called_so() -> None:
    found = fit([palpation(radius=0.08, mu=0.3, seconds=10.0)], "surface_contact")
    assert isinstance(found.model, SurfaceContact) and found.model.k == pytest.approx(STIFFNESS, rel=0.1)
    assert {n.symbol: n.told for n in found.numbers} == {"k": "cannot be told", "b": "cannot be told"}
    assert remarks(found)[0].startswith("The shape of the surface is not known, so these are guesses")


def test_forces_on_the_object_are_refused_and_the_option_is_named() -> None:
    recording = pulled(500.0, 20.0, 0.5)
    turned = replace(recording, columns={**recording.columns, "force": -recording["force"]})
    found = fitted(turned)
    assert found.reason is not None and "change their sign (--map force=-COLUMN)" in found.reason
    assert not found.numbers


def test_what_stands_still_tells_nothing() -> None:
    recording = pulled(500.0, 20.0, 0.5)
    still = {"position": np.zeros(len(TIME)), "force": recording["force"]}
    assert "Nothing moves" in (fitted(completed(TIME, still, "still")).reason or "")


def test_an_input_that_never_changes_is_refused() -> None:
    falling = {"input": np.zeros(len(TIME)), "output": -4.9 * TIME**2}
    with pytest.raises(BadInput, match="column 'input': found an input of 0 throughout, expected one that varies"):
        fitted(completed(TIME, falling, "falling"))


@pytest.mark.parametrize(
    ("structure", "message"),
    [
        ("springs", "--structure: found 'springs', expected one of flexible_box, kelvin_voigt, driven_body, surface"),
        ("driven_body", "--structure: found driven_body for a single axis recording, expected flexible_box or kelvin"),
    ],
)
def test_a_structure_that_does_not_belong_is_refused(structure: str, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        fitted(pulled(500.0, 20.0, 0.5), structure=structure)


def test_recordings_of_two_kinds_are_refused() -> None:
    with pytest.raises(BadInput, match="driven: found a driven_body recording, expected single_axis"):
        fitted(pulled(500.0, 20.0, 0.5), driven(2.0, 6.0, 40.0))
