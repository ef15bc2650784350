"""The engine table: the renderer against H(s), and that every engine is asked the same and judged right."""

import cmath
import dataclasses
import json
import math

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.engines import EnginesResult, engines_table, findings, report_of, run_engines
from mmt_drake.diagrams.proof.experiments.engines.method import (
    OURS,
    STEP,
    Method,
    Probe,
    Setting,
    Trace,
    engine_package,
    missing,
)
from mmt_drake.diagrams.proof.experiments.engines.mujoco_methods import MOCAP
from mmt_drake.diagrams.proof.experiments.engines.run import METHODS, measure
from mmt_drake.diagrams.proof.experiments.engines.tables import TABLES, points, printed_errors
from mmt_drake.errors import MissingDependency
from mmt_drake.model.linear import state_space, transfer_function

POINTS = {(point.table, point.omega): point for point in points()}
BY_NAME = {(method.engine, method.name): method for method in METHODS}
COMPILED, FROM_PYTHON = RENDERER = tuple(method for method in METHODS if method.engine == OURS)
INSTALLED = [method for method in METHODS if method.package is None or missing(method.package) is None]
INPUTS = ("inside_step", "sampled")


def answering(ratio: complex) -> Method:
    """An engine whose answer is the exact one times a number, on a constant that is none of it."""

    def run(setting: Setting) -> Trace:
        s = 1j * setting.probe.omega
        exact = complex(transfer_function(setting.parameters, s))
        return Trace(np.imag(ratio * exact * np.exp(s * setting.probe.times)) + 3.0, 1.0)

    return Method("drake", "pretends", run)


@pytest.fixture(scope="module")
def ours() -> EnginesResult:
    return run_engines(RENDERER)


@pytest.mark.parametrize("input_", INPUTS)
def test_the_renderer_follows_the_exact_transfer_function_to_1e_5_on_both_tables(ours, input_):
    errors = [cell.error for cell in ours.cells if cell.input == input_]
    assert len(errors) == 2 * 6
    assert max(errors) < {"inside_step": 1e-9, "sampled": 1e-5}[input_]


@pytest.mark.parametrize(("tick", "times"), [(COMPILED, 5.0), (FROM_PYTHON, 8.0)], ids=["natively", "from Python"])
def test_a_tick_of_the_renderer_is_of_the_order_of_the_cheapest_step_of_an_engine_stepped_alike(tick, times):
    point = POINTS["B", 24.3]
    alike = [method for method in INSTALLED if method.from_python == tick.from_python]
    turns = [{method: measure(method, point, "inside_step").us_per_step for method in alike} for _ in range(3)]
    cost = {method: min(turn[method] for turn in turns) for method in alike}
    assert cost.pop(tick) < times * min(cost.values())


def test_costs_are_compared_among_engines_that_are_stepped_alike():
    def costing(us: float, **of: object) -> Method:
        return dataclasses.replace(
            answering(1.0), run=lambda setting: Trace(np.zeros(setting.probe.steps + 1), us), **of
        )

    native, slow = costing(2.0, name="native"), costing(9.0, name="slow")
    python, own = costing(1.0, name="python", from_python=True), costing(1.5, engine=OURS)
    result = run_engines([own, native, slow, python], at=[POINTS["A", 1.0]])
    *_, cost = result.reached_by(result.summaries()[0])
    assert (cost.target.to_reach, cost.reached) == (2.0, True)
    own_from_python = run_engines([dataclasses.replace(own, from_python=True), native, python], at=[POINTS["A", 1.0]])
    *_, cost = own_from_python.reached_by(own_from_python.summaries()[0])
    assert (cost.target.to_reach, cost.reached) == (1.0, False)


@pytest.mark.parametrize(
    "method",
    [method for method in INSTALLED if method.name != MOCAP],
    ids=lambda method: f"{method.engine}, {method.name}",
)
def test_every_engine_simulates_the_object_that_it_is_asked_for(method):
    for point, input_ in ((POINTS["A", 4.32], "inside_step"), (POINTS["B", 10.3], "sampled")):
        assert measure(method, point, input_).error < 0.05


@pytest.mark.skipif(missing("mujoco") is not None, reason="the extra `engines`")
@pytest.mark.parametrize("point", points(), ids=lambda point: f"{point.table}, {point.omega}")
def test_a_body_that_is_moved_by_its_position_loses_its_velocity_in_a_physics_engine(point):
    # The contact damper then holds the body to the world, and the probe feels b2 v_m of it.
    p, s = point.parameters, 1j * point.omega
    body = p.k2 / (p.m * s * s + (p.b1 + p.b2) * s + p.k1 + p.k2)
    cell = measure(BY_NAME["mujoco", MOCAP], point, "inside_step")
    assert cell.response == pytest.approx(p.k2 * (1.0 - body) - p.b2 * s * body, rel=0.01)


@pytest.mark.parametrize("scheme", ["explicit_euler", "implicit_euler"])
def test_eulers_methods_answer_as_their_difference_equations_say(scheme):
    point = POINTS["B", 6.27]
    A, B, C, D = state_space(point.parameters)
    s = 1j * point.omega
    u = np.array([1.0, s])
    if scheme == "explicit_euler":  # q(k + 1) = q(k) + h (A q(k) + B u(k))
        h = STEP
        q = np.linalg.solve((np.exp(s * h) - 1.0) * np.eye(2) - h * A, h * B @ u)
    else:  # q(k + 1) = q(k) + h (A q(k + 1) + B u(k + 1)), and Drake makes two of half the length
        h = 0.5 * STEP
        q = np.linalg.solve((1.0 - np.exp(-s * h)) * np.eye(2) - h * A, h * B @ u)
    cell = measure(BY_NAME["drake", scheme], point, "inside_step")
    settled = math.exp(-8.0 * 0.6) * cell.error  # of the engine's own error so much has not died away yet
    assert abs(cell.response - (C @ q + D @ u).item()) < settled * abs(point.exact)


@pytest.mark.parametrize("ratio", [1.0, 1.02 * cmath.exp(0.05j), 0.7 * cmath.exp(-0.3j)])
def test_amplitude_and_phase_are_read_off_a_force_with_an_offset(ratio):
    cell = measure(answering(ratio), POINTS["A", 1.0], "sampled")
    assert cell.relative_error == pytest.approx(abs(abs(ratio) - 1.0), abs=1e-9)
    assert cell.phase_error_deg == pytest.approx(math.degrees(cmath.phase(ratio)), abs=1e-7)
    assert cell.error == pytest.approx(abs(ratio - 1.0), abs=1e-9)


@pytest.mark.parametrize("point", points(), ids=lambda point: f"{point.table}, {point.omega}")
def test_the_body_starts_in_the_steady_state_of_the_equation_of_motion(point):
    setting = Setting(point.parameters, Probe(point.omega, 1, "inside_step"))
    A, B, C, D = state_space(point.parameters)
    s = 1j * point.omega
    amplitude = np.linalg.solve(s * np.eye(2) - A, B @ [1.0, s])
    assert setting.body_at_start() == pytest.approx(tuple(amplitude.imag))
    assert (C @ amplitude + D @ [1.0, s]).item() == pytest.approx(point.exact)
    body = np.imag(np.outer(amplitude, np.exp(s * setting.probe.times)))
    assert setting.force(*body) == pytest.approx(np.imag(point.exact * np.exp(s * setting.probe.times)))


def test_sampled_poses_are_differentiated_causally_and_as_well_as_their_order_says():
    probe = Probe(24.3, 2000, "sampled", lead=10)
    _, exact = dataclasses.replace(probe, input="inside_step").at_samples()
    _, velocity = probe.at_samples()
    expected = (probe.omega * STEP) ** 3 / 4.0
    assert np.max(np.abs(velocity - exact)) / probe.omega == pytest.approx(expected, rel=0.01)
    _, shorter = dataclasses.replace(probe, steps=1000).at_samples()
    assert np.array_equal(shorter, velocity[: len(shorter)])  # later samples are none of its business


@pytest.mark.parametrize("input_", INPUTS)
def test_the_middle_of_a_step_lies_on_the_sine(input_):
    probe = Probe(24.3, 500, input_)
    middle = probe.times[:-1] + 0.5 * STEP
    x, v = probe.at_middles()
    assert x == pytest.approx(np.sin(probe.omega * middle), abs=1e-7)
    assert v == pytest.approx(probe.omega * np.cos(probe.omega * middle), abs=1e-4)


def test_the_exact_amplitudes_are_the_published_ones():
    assert abs(POINTS["A", 1.0].exact) == pytest.approx(4.763, abs=5e-4)
    assert abs(POINTS["A", 4.32].exact) == pytest.approx(12.0606, abs=5e-5)


def test_the_theses_own_errors_are_those_that_it_tells():
    # Against the column that the thesis expects.
    raisim, *others = (printed_errors(name) for name in ("raisim", "ode", "bullet", "simbody", "dart"))
    assert raisim == pytest.approx((0.005, 0.045), abs=5e-4)
    least, most = zip(*others, strict=True)
    assert (min(least), max(most)) == pytest.approx((0.016, 1.23), abs=5e-3)


def test_with_b1_and_b2_exchanged_table_b_fits_what_the_thesis_expects_at_three_of_four_points():
    table = TABLES[1].exchanged()
    off = [abs(abs(point.exact) / point.expected - 1.0) for point in table.points()]
    assert sum(error < 0.005 for error in off) == 3


def test_an_engine_that_is_not_installed_is_left_out_and_one_line_says_how_to_get_it():
    absent = dataclasses.replace(answering(1.0), engine="bullet", package="no_such_engine")
    result = run_engines([COMPILED, absent], at=[POINTS["A", 1.0]])
    assert {cell.method.engine for cell in result.cells} == {OURS}
    assert result.left_out.keys() == {"bullet"}
    assert any("Bullet was left out: no_such_engine not found" in line for line in findings(result))
    with pytest.raises(MissingDependency, match=r"^engines: no_such_engine not found; .*\[engines\]") as caught:
        engine_package("no_such_engine")
    assert "\n" not in str(caught.value)


def test_the_document_has_what_the_contract_says(ours):
    document = json.loads(json.dumps(report_of(ours).document, allow_nan=False))
    assert document["experiment"] == "engines" and document["step_s"] == 0.001
    keys = {"engine", "input", "table", "omega", "amplitude", "exact", "relative_error", "phase_error_deg"}
    assert all(keys | {"us_per_step", "thesis"} <= set(cell) for cell in document["cells"])
    cell = next(cell for cell in document["cells"] if cell["omega"] == 4.32)
    assert (cell["table"], cell["thesis"]) == ("A", 4.2)
    told = {each["figure"]: each for each in document["figures_to_reach"]}
    exact = told["off the exact H(s)"]
    assert (exact["thesis_says"], exact["to_reach"], exact["verdict"]) == ("0.54 to 4.5 (Raisim)", 1e-5, "reached")
    assert told["a step"]["to_reach"] is None  # there is none to be cheaper than
    printed = {table["table"]: table["printed"] for table in document["thesis"]}
    assert printed["B"] == {"raisim": [0.7, 108.85, 31.79, 21.27]} and printed["A"]["bullet"] == [1.43, 1.15]


def test_the_page_shows_every_engine_and_the_theses_figures(ours, tmp_path):
    drake = run_engines([BY_NAME["drake", "runge_kutta3"]])
    both = EnginesResult(ours.cells + drake.cells, {})
    page = report_of(both).write(tmp_path).read_text()
    assert (tmp_path / "engines.png").is_file()
    for text in ("the renderer", "runge_kutta3", "31.79", "1.43"):
        assert text in page
    rows = engines_table(both).rows
    assert [(row[0], row[2]) for row in rows] == [
        ("the renderer", "natively"),
        ("the renderer", "from Python"),
        ("Drake", "natively"),
    ]
    assert list(rows[0][-3:-1]) == ["0.54 to 4.5 (Raisim)", "0.001"]
    assert rows[0][-1].startswith("reached; sampled: reached; cost (to reach: ")
    assert rows[1][-1] == "reached; sampled: reached"  # Drake is not stepped from Python
    assert rows[2][-3] is None and rows[2][-1] == "reached; sampled: reached"
    wrong = EnginesResult(run_engines([answering(1.001)]).cells, {})
    assert engines_table(wrong).rows[0][-1] == "missed; sampled: missed"
    assert any("reached" in line for line in findings(both))
