"""What is not finite never reaches the hand: a renderer holds its force, lets go, says so, and goes on by itself."""

from functools import cache

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.rendering.finite import HOLD_S, LET_GO_S
from mmt_drake.rendering.status import APPROACHING, NOT_FINITE, RENDERING
from mmt_drake.rendering.updates import Blended, EnergyPermitting
from mmt_drake.systems.direct_force import DirectForceRenderer
from mmt_drake.systems.fused_reflection import FusedRenderer
from mmt_drake.systems.impedance_reflection import ImpedanceRenderer
from mmt_drake.systems.passivity_controlled_force import PassivityControlledForce
from mmt_drake.systems.proxy_spring import ProxySpringRenderer

STEP = 1e-3
RENDERERS = {
    "impedance": ImpedanceRenderer,
    "blended": lambda: ImpedanceRenderer(updates=Blended()),
    "energy_permitting": lambda: ImpedanceRenderer(updates=EnergyPermitting()),
    "placed": lambda: ImpedanceRenderer(probe="placed"),
    "behind_an_arm": ImpedanceRenderer,
    "fused": FusedRenderer,
    "direct": DirectForceRenderer,
    "passivity": PassivityControlledForce,
    "proxy_spring": ProxySpringRenderer,
}
_MODEL = ("motion", "theta", "stable", "in_contact", "held_body")
VECTORS = {  # that each reads
    "behind_an_arm": (*_MODEL, "hand"),
    "fused": (*_MODEL, "high_band"),
    "direct": ("remote_force",),
    "passivity": ("motion", "remote_force", "remote_energy"),
    "proxy_spring": ("motion",),
}
STOPS_THEM = {  # what each cannot do without; theta is passed over, and a second model is left out
    "behind_an_arm": {"motion", "in_contact", "hand"},
    "direct": {"remote_force"},
    "passivity": {"motion", "remote_force", "remote_energy"},
}
GOOD, SPOILT, AGAIN = 60, 180, 500


def inputs(tick: int) -> dict[str, np.ndarray]:
    """A probe pressed 4 mm deep that strokes along y, and what the network brings."""
    t = STEP * tick
    y, rate = 0.01 * np.sin(20.0 * t), 0.2 * np.cos(20.0 * t)
    return {
        "motion": np.array([0.0, y, -0.004, 0.0, rate, 0.0]),
        "hand": np.array([0.0, y, -0.004, 0.0, rate, 0.0]),
        "theta": FlexibleBoxModel().theta(),
        "stable": np.ones(1),
        "in_contact": np.ones(1),
        "remote_force": np.array([0.0, -200.0 * y, 2.0]),
        "remote_energy": np.ones(3),
        "high_band": np.array([300.0, 5.0, 0.5]),
        "held_body": np.array([0.0, 0.0, t, 0.0, 0.0, t, t]),
    }


@cache
def rendered(renderer: str, spoilt: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Force (n, 3) and status (n,), with one number of one input not finite for a while."""
    system = RENDERERS[renderer]()
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    if renderer == "proxy_spring":
        system.GetInputPort("point_cloud").FixValue(context, AbstractValue.Make(Cloud.empty()))
    force, status = [], []
    for tick in range(GOOD + SPOILT + AGAIN):
        given = inputs(tick)
        if spoilt and GOOD <= tick < GOOD + SPOILT:
            given[spoilt][3 if spoilt == "hand" else 0] = np.nan if tick % 3 else -np.inf
        for name in VECTORS.get(renderer, _MODEL):
            system.GetInputPort(name).FixValue(context, given[name])
        force.append(system.GetOutputPort("force").Eval(context).copy())
        status.append(system.GetOutputPort("status").Eval(context)[0])
        simulator.AdvanceTo(STEP * (tick + 1))
    return np.array(force), np.array(status)


@pytest.mark.parametrize(
    ("renderer", "spoilt"), [(name, port) for name in RENDERERS for port in VECTORS.get(name, _MODEL)]
)
def test_an_input_that_is_not_finite_never_becomes_a_force_that_is_not(renderer, spoilt):
    if renderer == "proxy_spring":
        with pytest.raises(BadInput, match="finite"):  # the run ends with one line
            rendered(renderer, spoilt)
        return
    force, status = rendered(renderer, spoilt)
    assert np.isfinite(force).all() and np.isfinite(status).all()
    during = slice(GOOD, GOOD + SPOILT)
    if spoilt in STOPS_THEM.get(renderer, {"motion", "in_contact"}):
        assert set(status[during]) == {NOT_FINITE}
        held = force[GOOD : GOOD + round(HOLD_S / STEP) - 1]
        np.testing.assert_allclose(held, np.tile(force[GOOD - 1], (len(held), 1)), rtol=1e-9)
        assert np.linalg.norm(force[GOOD - 1]) > 1.0
        gone = GOOD + round((HOLD_S + LET_GO_S) / STEP) + 1
        np.testing.assert_allclose(force[gone : GOOD + SPOILT], 0.0, atol=1e-12)
    else:
        assert NOT_FINITE not in status
    assert status[-1] in (RENDERING, APPROACHING)
    np.testing.assert_allclose(force[-1], rendered(renderer)[0][-1], rtol=0.05, atol=0.05)  # it goes on by itself
