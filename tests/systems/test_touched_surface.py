"""A surface that touches correct: by how much, when, what it does meanwhile, and what it does not believe."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator

from mmt_drake.cloud import plane
from mmt_drake.cloud.touch import TouchSettings
from mmt_drake.errors import BadInput
from mmt_drake.systems.touched_surface import TouchedSurface

STEP = 1e-3
SEEN = plane(10_000, (0.1, 0.1))


class Tip:
    """A tip that taps every second on a surface, whose force is that of a spring and a damper."""

    def __init__(self, height, *, settings=None, noise=0.02, offset=0.0, late=None, force_late=0, start=0.0):
        self.system = TouchedSurface(settings, period=STEP)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.height, self.noise, self.offset, self.force_late, self.start = height, noise, offset, force_late, start
        self.drawn, self.tick, self.forces = np.random.default_rng(3), 0, []
        self.system.GetInputPort("point_cloud").FixValue(self.context, AbstractValue.Make(SEEN))
        if late is not None:
            self.system.GetInputPort("force_lateness").FixValue(self.context, np.array(late))

    def go_on(self, seconds):
        """The tip moves on; returns what was known at every tick."""
        told = []
        for _ in range(round(seconds / STEP)):
            w, t = 2.0 * np.pi, self.start + self.tick * STEP
            z, v = 0.006 + 0.01 * np.cos(w * t), -0.01 * w * np.sin(w * t)
            depth = self.height - z
            self.forces.append(500.0 * depth - 20.0 * v if depth > 0.0 else 0.0)
            force = np.array([0.0, 0.0, self.forces[-1 - min(self.force_late, self.tick)]])
            force += self.noise * self.drawn.normal(size=3) + self.offset
            raised, _ = self.raised
            self.system.GetInputPort("measurement").FixValue(self.context, [0.01, 0.0, z, 0.0, 0.0, v, *force])
            self.system.GetInputPort("clearance").FixValue(self.context, [z - raised])
            self.tick += 1
            self.simulator.AdvanceTo(self.tick * STEP)
            told.append(self.raised)
        return np.array(told)

    @property
    def raised(self):
        return np.array(self.system.GetOutputPort("surface_raised").Eval(self.context))

    @property
    def shown(self):
        return self.system.GetOutputPort("corrected").Eval(self.context).translation[2]


@pytest.mark.parametrize("height", [-0.0015, 0.0, 0.0002, 0.001])
def test_a_touch_outvotes_the_cloud(height):
    tip = Tip(height, offset=0.7)
    assert tip.raised.tolist() == [0.0, 1e-3]
    tip.go_on(1.0)
    known, deviation = tip.raised
    assert abs(known - height) < 6e-5  # a tick is 0.06 mm long there
    assert abs(known - height) < 3.0 * deviation < 2e-4
    assert tip.shown == known
    tip.system.GetInputPort("measurement").FixValue(tip.context, np.arange(1.0, 10.0))
    lowered = tip.system.GetOutputPort("lowered").Eval(tip.context)
    assert lowered.tolist() == [1.0, 2.0, 3.0 - known, *range(4, 10)]


def test_under_the_tip_the_surface_moves_slowly_and_at_once_when_it_is_off():
    told = Tip(0.001).go_on(1.0)[:, 0]
    steps = np.abs(np.diff(told))
    on = int(np.flatnonzero(steps)[0])
    assert steps[on : on + 100].max() == pytest.approx(1e-6)  # 1 mm/s
    assert np.count_nonzero(steps > 1.01e-6) <= 1


def test_more_touches_are_more_certain_and_one_elsewhere_is_less():
    certain = TouchSettings(wander=0.0, slope=0.1, lateness=0.0)
    tip = Tip(0.0005, settings=certain)
    deviations = [tip.go_on(1.0)[-1, 1] for _ in range(3)]
    assert deviations[0] > 1.2 * deviations[1] > 1.2**2 * deviations[2]
    assert certain.beside(deviations[2], 0.005) > 5e-4


def test_the_lateness_of_the_force_is_that_at_the_end_of_the_touch():
    tip = Tip(0.0002, late=[0.0, 0.0, 0.0, 0.0025, 0.0025, 0.005], force_late=4)
    tip.go_on(0.45)
    first, spread = tip.raised
    assert first < 0.0001
    assert spread > 1e-4  # it says that it does not know by how much the force is late
    tip.system.GetInputPort("force_lateness").FixValue(tip.context, [0.004, 0.0, 0.004, 1e-4, 1e-4, 1e-4])
    tip.go_on(0.55)
    assert tip.raised[0] == pytest.approx(0.0002, abs=6e-5)


def test_a_lateness_of_an_estimator_that_says_misfit_is_not_believed():
    wrong = [0.02, 0.0, 0.02, 1e-4, 1e-4, 1e-4]
    believed, doubted = Tip(0.0, late=wrong), Tip(0.0, late=wrong)
    doubted.system.GetInputPort("model_status").FixValue(doubted.context, [1.0])
    for tip in (believed, doubted):
        tip.go_on(1.0)
    assert believed.raised[0] > 6e-4
    assert doubted.raised[0] == 0.0 and doubted.raised[1] > 2e-4


def test_samples_that_are_not_finite_are_left_out():
    tip = Tip(0.0005)
    tip.go_on(0.1)
    before = tip.context.get_discrete_state_vector().CopyToVector()
    tip.system.GetInputPort("measurement").FixValue(tip.context, np.full(9, np.nan))
    tip.tick += 5
    tip.simulator.AdvanceTo(tip.tick * STEP)
    np.testing.assert_array_equal(tip.context.get_discrete_state_vector().CopyToVector(), before)
    tip.go_on(0.895)
    assert tip.raised[0] == pytest.approx(0.0005, abs=6e-5)


def test_without_a_surface_or_a_force_nothing_is_known():
    quiet = Tip(-0.1)
    quiet.go_on(1.2)
    assert quiet.raised.tolist() == [0.0, 1e-3]
    blind = Tip(0.001)
    blind.system.GetInputPort("point_cloud").FixValue(blind.context, AbstractValue.Make(SEEN.empty()))
    blind.go_on(1.2)
    assert blind.raised.tolist() == [0.0, 1e-3]


def test_a_touch_before_the_force_in_free_space_is_known_is_not_believed():
    tip = Tip(0.001, start=0.28)  # just above the surface
    tip.go_on(0.4)
    assert tip.raised.tolist() == [0.0, 1e-3]


@pytest.mark.parametrize(
    ("arguments", "refused"),
    [({"period": 0.0}, "period"), ({"period": 0.02}, "period: found 0.02 s"), ({"radius": -1.0}, "radius")],
)
def test_a_period_or_a_radius_that_tells_no_touch_is_refused(arguments: dict[str, float], refused: str) -> None:
    with pytest.raises(BadInput, match=refused):
        TouchedSurface(**arguments)
