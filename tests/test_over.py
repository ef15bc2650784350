"""Numbers of a model over what was recorded beside the motion: what they are, where, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.over import Course, Over, take_course
from mmt_drake.model_files import model_data, parse_model
from mmt_drake.over import in_recording, with_knots
from mmt_drake.recording import Recording, load, save
from mmt_drake.replay import replayed
from mmt_drake.simulation import simulate

TIME = np.arange(0.0, 3.0, 2e-3)
X, V = 0.01 * np.sin(5.0 * TIME), 0.05 * np.cos(5.0 * TIME)
CURRENT = 0.5 + 0.5 * np.sin(0.9 * TIME)
SPRING = {"structure": "kelvin_voigt", "parameters": {"k": 100.0, "b": 10.0}}
BODY = {"structure": "driven_body", "parameters": {"m": 1.0, "b": 4.0, "Fc": 0.6}}
CURVE = {"of": "current", "at": [0.0, 0.4, 1.0], "value": [2.0, 10.0, 16.0]}


def pressed(source="a.npz", constants=None, **columns):
    contact = {"position": X, "velocity": V, "force": 0.0 * X}
    return Recording(TIME, contact | columns, source, constants=constants or {})


def at(current):
    """The curve, by hand."""
    return np.where(current < 0.4, 2.0 + 20.0 * current, 6.0 + 10.0 * current)


def test_a_number_follows_a_column_that_changes_within_the_recording():
    model = parse_model(SPRING | {"over": {"b": CURVE}})
    recording = pressed(current=CURRENT)
    expected = -100.0 * X - at(CURRENT) * V
    assert replayed(model, recording)["force"] == pytest.approx(expected, abs=1e-12)
    assert simulate(model, recording)["force"] == pytest.approx(expected, abs=1e-12)


def test_so_does_a_number_of_an_effect_and_two_at_once():
    over = {"b": CURVE, "coulomb_friction.Fc": {"of": "tension", "at": [0, 10], "value": [0.0, 3.0]}}
    friction = {"effects": [{"name": "coulomb_friction", "parameters": {"Fc": 1.0}}]}
    tension = 12.0 * TIME / TIME[-1]  # beyond the last knot it is held
    found = replayed(parse_model(SPRING | {"over": over} | friction), pressed(current=CURRENT, tension=tension))
    expected = -100.0 * X - at(CURRENT) * V - np.minimum(0.3 * tension, 3.0) * np.sign(V)
    assert found["force"] == pytest.approx(expected, abs=1e-6)


def test_a_driven_body_with_a_number_on_its_way_is_that_of_another_integrator():
    model = parse_model(
        {"structure": "driven_body", "parameters": {"m": 2.0, "b": 1.0, "k": 30.0}, "over": {"b": CURVE, "k": CURVE}}
    )
    u = np.sin(3.0 * TIME)
    recording = Recording(TIME, {"input": u, "output": 0.0 * u, "current": CURRENT})

    def rates(t, y):
        c = at(0.5 + 0.5 * np.sin(0.9 * t))
        return [y[1], (np.sin(3.0 * t) - c * y[1] - c * y[0]) / 2.0]

    expected = solve_ivp(rates, (0.0, TIME[-1]), [0.0, 0.0], t_eval=TIME, max_step=0.01, rtol=1e-9, atol=1e-12).y[0]
    assert replayed(model, recording)["output"] == pytest.approx(expected, abs=2e-6)
    assert simulate(model, recording)["output"] == pytest.approx(replayed(model, recording)["output"], abs=1e-12)


def test_friction_that_comes_and_goes_with_a_column_holds_the_body_only_then():
    over = {"Fc": {"of": "current", "at": [0.0, 1.0], "value": [0.0, 5.0]}}
    model = parse_model({"structure": "driven_body", "parameters": {"m": 1.0, "b": 2.0, "Fc": 1.0}, "over": over})
    current = np.where((TIME > 1.0) & (TIME < 2.0), 1.0, 0.0)
    recording = Recording(TIME, {"input": np.ones(len(TIME)), "output": 0.0 * TIME, "current": current})
    rate = replayed(model, recording)["output_rate"]
    assert rate[TIME < 1.0] == pytest.approx((1.0 - np.exp(-2.0 * TIME[TIME < 1.0])) / 2.0, abs=1e-6)
    assert not rate[(TIME > 1.3) & (TIME < 2.0)].any()
    since = TIME[TIME > 2.01] - 2.0
    assert rate[TIME > 2.01] == pytest.approx((1.0 - np.exp(-2.0 * since)) / 2.0, abs=3e-3)


@pytest.mark.parametrize(
    ("recording", "level"),
    [
        (pressed(current=np.full(len(TIME), 0.7)), 13.0),
        (pressed(constants={"current": 0.2}), 6.0),
        (pressed(constants={"current_A": 0.0}), 2.0),
        (pressed(constants={"current_A": 7.0}), 16.0),
    ],
)
def test_what_stands_still_in_a_recording_gives_it_one_number(recording, level):
    model = in_recording(parse_model(SPRING | {"over": {"b": CURVE}}), recording)
    assert model == parse_model({"structure": "kelvin_voigt", "parameters": {"k": 100.0, "b": level}})


@pytest.mark.parametrize(("file", "level"), [("10mm1Hz0A", 2.0), ("10mm1Hz0x5A", 11.0), ("25mm0x5Hz1A", 16.0)])
def test_the_current_of_a_real_damper_is_a_constant_of_its_file(file, level, recordings):
    recording = load(recordings / "mr_damper" / f"{file}.npz")
    assert in_recording(parse_model(SPRING | {"over": {"b": CURVE}}), recording).b == pytest.approx(level)


def test_a_column_beside_the_motion_is_read_from_a_file_and_one_with_gaps_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    save(pressed(current=CURRENT), path)
    assert load(path)["current"] == pytest.approx(CURRENT)
    save(pressed(current=np.where(TIME > 1.0, np.nan, 0.0)), path)
    with pytest.raises(BadInput, match="row 502, column 'current': found nan, expected a finite number"):
        load(path)


def test_a_number_is_free_per_recording_by_its_name():
    own = {"of": "recording", "at": ["a.npz", "b.npz"], "value": [3.0, 5.0]}
    model = parse_model(SPRING | {"over": {"b": own}})
    assert in_recording(model, pressed("some/where/b.npz")).b == 5.0
    with pytest.raises(BadInput, match=r"c.npz: over.b: found no value for 'c.npz', expected one of a.npz, b.npz"):
        replayed(model, pressed("c.npz"))


def test_the_parameter_counts_as_the_mean_of_its_curve_where_nobody_asks_over_what():
    assert parse_model(SPRING | {"over": {"b": CURVE}}).b == pytest.approx(28.0 / 3.0)


def test_a_file_keeps_wishes_and_curves():
    over = {"k": "temperature", "b": CURVE, "hysteresis.alpha": "recording"}
    model = parse_model(SPRING | {"over": over})
    assert model_data(model)["over"] == over
    assert parse_model(model_data(model)) == model


def test_knots_are_the_values_that_recordings_have_or_quantiles_of_one_that_changes():
    model = parse_model(SPRING | {"over": {"b": "current"}})
    still = with_knots(model, [pressed(constants={"current_A": x}) for x in (1.0, 0.0, 0.5, 0.0)])
    assert still.over == (Over("b", "current", (0.0, 0.5, 1.0), (10.0, 10.0, 10.0)),)
    (curve,) = with_knots(model, [pressed(current=100.0 * TIME)]).over
    assert curve.at == pytest.approx((0.0, 100.0, 200.0, 300.0), abs=0.5) and set(curve.value) == {10.0}


def test_knots_that_are_known_stay_and_recordings_beyond_them_add_to_them():
    model = parse_model(SPRING | {"over": {"b": CURVE}})
    (curve,) = with_knots(model, [pressed(constants={"current": x}) for x in (0.2, 1.5)]).over
    assert (curve.at, curve.value) == ((0.0, 0.4, 1.0, 1.5), (2.0, 10.0, 16.0, 16.0))


def test_a_number_that_was_left_out_is_that_of_the_effects_that_stand_for_it():
    model = parse_model(SPRING | {"over": {"Fc": "current"}})
    found = {curve.number for curve in with_knots(model, [pressed(constants={"current": 1.0})]).over}
    assert {"coulomb_friction.Fc", "dahl_friction.Fc"} <= found
    assert not any(number.startswith("static_friction") for number in found)


def test_a_course_is_linear_between_its_times_and_held_beyond():
    p = np.zeros(3)
    course = Course((2, 0), np.array([1.0, 2.0, 4.0]), np.array([[0.0, 10.0, 20.0], [5.0, 5.0, 7.0]]), 1.0)
    vector = np.concatenate([p, course.numbers()])
    for t, expected in ((0.0, (5.0, 0.0)), (1.5, (5.0, 5.0)), (3.0, (6.0, 15.0)), (9.0, (7.0, 20.0))):
        take_course(vector, 3.0, t)
        assert (vector[0], vector[2]) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"mu": "current"}, "over: found 'mu', expected k, b, x0, F0, or effect.symbol"),
        (
            {"gravity_offset.angle": "current"},
            "over: found 'gravity_offset.angle', expected an effect of a kelvin_voigt",
        ),
        ({"static_friction.Fx": "current"}, "over: found 'static_friction.Fx', expected static_friction.Fs"),
        ({"b": 3}, "over.b: found 3, expected a column, 'recording', or of, at and value"),
        ({"b": {"of": "current", "at": [1, 0], "value": [1, 2]}}, "over.b.at: found .* expected numbers that increase"),
        ({"b": {"of": "current", "at": [0, 1], "value": [1]}}, "over.b: found 2 knots, 1 values"),
        ({"b": {"of": "current", "at": [0, 1], "value": [1, -2]}}, "over.b.value: b: found -2"),
        ({"b": {"of": "current", "at": [0, "x"], "value": [1, 2]}}, "over.b: at: found 'x', expected a number"),
        ({"b": {"by": "current"}}, "over.b: found the key 'by'"),
        (["b"], "over: found list, expected a mapping"),
    ],
)
def test_a_curve_that_is_none_is_refused_in_one_line(over, message):
    with pytest.raises(BadInput, match=message) as caught:
        parse_model(SPRING | {"over": over})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("over", "recordings", "message"),
    [
        ({"b": "current"}, [pressed()], "a.npz: over.b: found columns .* constants none, expected .*'current'"),
        (
            {"b": "current"},
            [pressed(current=np.where(TIME > 1.0, np.nan, 0.0))],
            "row 502, column 'current': found nan",
        ),
        ({"b": "recording"}, [pressed(), pressed()], "over.b: found two recordings called 'a.npz'"),
        ({"x0": "current"}, [pressed(constants={"current": 1.0})], "over.x0: found x0 = 0, left out"),
    ],
)
def test_what_was_not_recorded_is_refused_in_one_line(over, recordings, message):
    with pytest.raises(BadInput, match=message) as caught:
        with_knots(parse_model(SPRING | {"over": over}), recordings)
    assert "\n" not in str(caught.value)


TRANSMISSION = {"structure": "transmission", "parameters": {"ratio": 2.0}}
LOOP = {
    "structure": "driven_body",
    "parameters": {"m": 1.0, "Fc": 0.6},
    "controller": {"kind": "p", "gains": {"kp": 40.0}},
}


def curve(*values):
    return {"of": "current", "at": [0.0, 1.0], "value": list(values)}


@pytest.mark.parametrize(
    ("data", "over", "message"),
    [
        (BODY, {"m": curve(0.0, 1.0)}, r"a.yaml: over.m.value: found 0.0, expected"),
        (TRANSMISSION, {"ratio": curve(0.0, 1.0)}, r"a.yaml: over.ratio.value: found 0, expected a number other"),
        (TRANSMISSION, {"ratio": curve(-1.0, 1.0)}, r"a.yaml: over.ratio: found values with a mean of 0, expected"),
        (TRANSMISSION, {"m": curve(0.0, 1.0)}, r"a.yaml: over.m.value: found \[0.0, 1.0\], expected m = 0 throughout"),
        (TRANSMISSION, {"load": curve(-1.0, 1.0)}, "a.yaml: over.load.value: found .* expected load = 0 throughout"),
        (LOOP, {"Fc": "goal"}, "a.yaml: over.Fc: found 'goal' beside a controller"),
        (LOOP, {"Fc": curve(0.5, 1.0) | {"of": "input"}}, "a.yaml: over.Fc.of: found 'input' beside a controller"),
    ],
)
def test_a_curve_that_its_structure_cannot_follow_is_refused_in_one_line(data, over, message):
    with pytest.raises(BadInput, match=message) as caught:
        parse_model(data | {"over": over}, "a.yaml")
    assert "\n" not in str(caught.value)


def test_what_is_fitted_though_it_is_0_may_be_a_curve():
    recordings = [Recording(TIME, {"input": X, "output": X}, name) for name in "ab"]
    model = with_knots(parse_model(TRANSMISSION | {"over": {"offset": "recording"}}), recordings)
    free = {p.symbol: p.scale for p in Hypothesis(model, reach=0.5).free_parameters()}
    assert free == {"ratio": 2.0, "offset(recording=a)": 0.5, "offset(recording=b)": 0.5}


def test_a_curve_that_is_0_on_average_is_fitted():
    model = parse_model(SPRING | {"over": {"F0": curve(-3.0, 3.0)}})
    free = {p.symbol: p.scale for p in Hypothesis(model).free_parameters()}
    assert free["F0(current=0)"] == free["F0(current=1)"] == 3.0
    assert not Hypothesis(model).admits(LIBRARY["constant_force"])


def test_a_dead_band_before_a_closed_loop_may_close_and_open():
    effects = [{"name": "dead_band", "parameters": {"width": 0.2}}]
    data = LOOP | {"over": {"dead_band.width": curve(0.0, 0.4)}, "effects": effects}
    recording = Recording(TIME, {"input": X, "output": X, "current": CURRENT})
    now = in_recording(parse_model(data), recording).additions.course
    assert np.ptp(now.values, axis=1) == pytest.approx([0.4 * np.ptp(CURRENT)])


def test_a_flexible_box_takes_one_value_per_recording_and_says_so():
    curve = {"of": "recording", "at": ["a"], "value": [3.0]}
    model = parse_model({"structure": "flexible_box", "parameters": {"m": 1.0, "k2": 500.0}, "over": {"b2": curve}})
    assert in_recording(model, Recording(TIME, {}, "a")).parameters.b2 == 3.0
    model = parse_model({"structure": "flexible_box", "parameters": {"m": 1.0, "k2": 500.0}, "over": {"b2": CURVE}})
    with pytest.raises(BadInput, match=r"over.b2: found a current that changes within .* for a flexible_box"):
        in_recording(model, Recording(TIME, {"current": CURRENT}, "a"))
