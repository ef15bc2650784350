"""One of several objects is gripped, lifted over another and put down."""

import numpy as np
import pytest
from driven import driven

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.grasped_box import HOLDS, LOST
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.motion.analytic import AnalyticMotion, step, wave
from mmt_drake.systems.grip_script import GripScript
from mmt_drake.systems.objects_on_table import ObjectsOnTable
from mmt_drake.systems.on_table import Hang, OnTable
from mmt_drake.systems.scripted_operator import ScriptedOperator

MODEL = FlexibleBoxModel(
    BoxParameters(m=0.3, k1=0.0, k2=500.0, b1=0.0, b2=30.0),
    NormalContact(k=2000.0, b=60.0),
    Friction(Fs=0.2, Fd=0.2, v_d=0.005),
)
# Down, lifted by 60 mm, swung, carried 200 mm along x, put down, up.
OVER = AnalyticMotion(
    (0.0, 0.0, 0.01),
    steps=[
        *(step(2, 0.2, 0.6, -0.013), step(2, 1.0, 1.8, 0.063), step(0, 2.7, 3.8, 0.2)),
        *(step(2, 4.2, 5.0, -0.063), step(2, 5.6, 6.0, 0.013), step(0, 6.2, 7.0, -0.2)),
    ],
    waves=[wave(0, 1.7, 2.9, 0.004, 1.5)],
    cycle=7.5,
)
NAMES = ("force", "held", "touched", "places", "measurement")


def carried(things, seconds=6.1, grip=8.0, **options):
    """What `OVER` makes of objects, the first of which is gripped from 0.8 to 5.4 s."""
    inputs = {"motion": ScriptedOperator(OVER), "grip": GripScript(0.8, 5.4, grip, 7.5)}
    return driven(ObjectsOnTable(things, **options), NAMES, seconds, **inputs)[0]


def thing(x=0.0, top=0.0, hang=None, model=MODEL):
    return OnTable(model, (x, 0.0), (0.06, 0.06, 0.05), False, top, hang)


def test_it_is_lifted_over_another_which_stays_and_put_down_beyond_it():
    seen = carried([thing(hang=Hang(0.03)), thing(0.1, top=0.02)])
    high = seen["held"][:, 3] > 1e-4
    assert seen["held"][high, 3].max() == pytest.approx(0.06, abs=0.003)
    assert seen["force"][2000, 2] == pytest.approx(-0.3 * 9.81, rel=0.02)
    assert seen["places"][-1, 0] == pytest.approx(0.2, abs=0.01)
    assert np.ptp(seen["places"][:, 2]) == 0.0
    over = high & (np.abs(seen["places"][:, 0] - 0.1) < 0.06)
    assert (
        over.any() and seen["held"][over, 3].min() > 0.02
    )  # above the other's top, which is 20 mm higher than its own
    assert set(np.unique(seen["touched"])) == {0.0, 1.0} and not seen["touched"][-50:].any()


def test_others_on_the_table_change_no_bit_of_what_is_carried():
    alone = carried([OnTable(MODEL, hang=Hang(0.03))])
    among = carried([thing(hang=Hang(0.03)), thing(0.4)])
    assert np.count_nonzero(alone["held"][:, 0] == HOLDS) > 4000
    for name in ("force", "held", "measurement"):
        np.testing.assert_array_equal(alone[name], among[name])


def test_the_other_simulation_carries_it_likewise():
    own, other = (carried([thing(hang=Hang(0.03)), thing(0.1)], laws=laws) for laws in ("own", "foreign"))
    air = (own["held"][:, 3] > 1e-3) & (other["held"][:, 3] > 1e-3)
    assert np.count_nonzero(air) > 3000
    assert np.linalg.norm((own["force"] - other["force"])[air]) < 0.02 * np.linalg.norm(own["force"][air])
    assert other["places"][-1, 0] == pytest.approx(0.2, abs=0.01)
    assert np.ptp(other["places"][:, 2]) < 1e-6
    assert set(np.unique(other["touched"])) == {0.0, 1.0}


def test_what_has_slipped_out_is_felt_no_more_and_an_opened_grip_has_forgotten_it():
    seen = carried([thing(hang=Hang(0.03, mu=0.35)), thing(0.1)], grip=8.0)
    lost = int(np.argmax(seen["held"][:, 0] == LOST))
    assert lost > 1000 and seen["held"][lost + 400, 3] == 0.0
    assert not seen["force"][lost + 400 : 4000].any()
    assert seen["held"][5350, 0] == LOST and not seen["held"][5800].any()


def test_no_grip_takes_what_has_effects_and_none_may_ask_for_that():
    stiffens = LIBRARY["nonlinear_stiffness"].apply(MODEL, {"k3": 1e5})
    seen = carried([thing(model=stiffens), thing(0.4, hang=Hang(0.03))], seconds=2.2)
    assert not seen["held"].any() and not seen["force"][2000:].any()
    with pytest.raises(BadInput, match="effects"):
        ObjectsOnTable([thing(model=stiffens, hang=Hang(0.03))])
    with pytest.raises(BadInput, match="effects"):
        ObjectsOnTable([thing(model=stiffens)], laws="foreign")
