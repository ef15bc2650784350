"""One case for every system of mmt_drake, and for every variant of one; the contract test runs them all."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import contract
import numpy as np
from gantry import gantry
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import System

from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.chain import ChainJoint, chain
from mmt_drake.arms.joint_effects import JointEffects
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.cloud import plane
from mmt_drake.cloud.proxy import NO_CLOUD
from mmt_drake.effects import LIBRARY
from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.foreign.options import ForeignSensors
from mmt_drake.learning.law_learner import LawLearner
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.network.config import ChannelConfig
from mmt_drake.rendering import impedance
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.updates import Blended, EnergyPermitting
from mmt_drake.surfaces import Sphere
from mmt_drake.systems.carried_reflection import CarriedReflection
from mmt_drake.systems.cartesian_impedance import CartesianImpedance
from mmt_drake.systems.compliant_tip import CompliantTipSystem, TipSettings
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.direct_force import DirectForceRenderer
from mmt_drake.systems.driven_body import DrivenBody
from mmt_drake.systems.flexible_box import FlexibleBox, SensorNoise
from mmt_drake.systems.foreign_box import ForeignBoxSystem
from mmt_drake.systems.fused_reflection import FusedRenderer
from mmt_drake.systems.grip_script import GripScript
from mmt_drake.systems.high_band_estimator import HighBandEstimator
from mmt_drake.systems.impedance_reflection import ImpedanceRenderer
from mmt_drake.systems.interactive_operator import SLIDERS, InteractiveOperator
from mmt_drake.systems.kelvin_voigt import KelvinVoigtContact
from mmt_drake.systems.live_view import LiveView
from mmt_drake.systems.load_estimator import LoadEstimator
from mmt_drake.systems.local_frame import LocalFrame
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.object_memory import ObjectMemory
from mmt_drake.systems.objects_on_table import ObjectsOnTable
from mmt_drake.systems.on_table import Hang, OnTable
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.passivity_controlled_force import PassivityControlledForce
from mmt_drake.systems.passivity_controlled_motion import PassivityControlledMotion
from mmt_drake.systems.probe_compensation import ProbeCompensation
from mmt_drake.systems.proxy_spring import ProxySpringRenderer
from mmt_drake.systems.recorder import McapRecorder
from mmt_drake.systems.rls_estimator import RlsEstimator
from mmt_drake.systems.scene_tracker import SceneTracker
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.surface_contact import SurfaceContactSystem
from mmt_drake.systems.surface_contact_detector import SurfaceContactDetector
from mmt_drake.systems.touched_object import TouchedObject
from mmt_drake.systems.touched_surface import TouchedSurface
from mmt_drake.systems.yielding_hand import YieldingHand
from mmt_drake.viewer.viewer import Viewer


def joint_effects(folder: Path) -> System:
    """Friction and a ripple on the joints of a small chain.

    No bristles: the simulator integrates them, and its last step, which sets the next one, is in no context.
    """
    plant = chain([ChainJoint(axis=(0.0, 1.0, 0.0)), ChainJoint((0.3, 0.0, 0.0), axis=(0.0, 1.0, 0.0))])
    plant.Finalize()
    effects = (
        JointEffect("coulomb_friction", "joint_1", {"Fc": 0.3}),
        JointEffect("load_dependent_friction", "joint_1", {"mu": 0.1}),
        JointEffect("torque_ripple", "joint_1", {"amplitude": 0.2, "period": 0.3, "phase": 0.1}),
        JointEffect("viscous_friction", "joint_2", {"b": 0.2}),
    )
    arm = ArmPlant(plant, ("joint_1", "joint_2"), ("link_1", "link_2"))
    return JointEffects(arm, ArmModel(robot=folder / "none.urdf", effects=effects))


@dataclass(frozen=True)
class Case:
    """One system, or one variant of it.

    Attributes:
        make: a fresh instance; gets a folder for what it writes.
        drakes_own: a part of Drake's that stands in for one of ours; its documentation is Drake's.
        any_size: ports whose size or type the caller chooses, so the docstring cannot tell it.
        computed_together: pairs (input, output) that are declared as feedthrough although that output does not follow
            that input, because it is a slice of what is computed for the others.
        still: outputs that keep their value during the run.
        writes_files: an I/O system, which holds a file in `self` and runs once.
        every: at each how many ticks it is seen what follows what.
    """

    make: Callable[[Path], System]
    drakes_own: bool = False
    any_size: frozenset[str] = frozenset()
    computed_together: frozenset[tuple[str, str]] = frozenset()
    still: frozenset[str] = frozenset()
    writes_files: bool = False
    every: int = 5


ROUGH = ChannelConfig(delay=0.03, jitter=0.01, loss=0.1, duplication=0.1, reordering=0.1, seed=3)
AT_ONCE = ChannelConfig(jitter=0.004, loss=0.3, seed=4)  # some packets take no time
PLAYED_OUT = ChannelConfig(delay=0.02, jitter=0.005, loss=0.1, playout=0.04, seed=5)


def channel(config: ChannelConfig, size: int = 6, **options: Any) -> Case:
    return Case(
        lambda folder: network_channel(config, size, contract.PERIOD, **options),
        drakes_own=config.is_constant and not options,
        any_size=frozenset({"sent", "received"}),
    )


def cloud_channel(config: ChannelConfig) -> Case:
    return Case(
        lambda folder: network_channel(config, AbstractValue.Make(NO_CLOUD), 1 / 50),
        drakes_own=config.is_constant,
        any_size=frozenset({"sent", "received"}),
    )


def flexible_box(**options: Any) -> FlexibleBox:
    return FlexibleBox(
        FlexibleBoxModel(),
        noise=SensorNoise(force=0.02, position=1e-5, velocity=1e-4, seed=6),
        surface=plane(1000, (0.12, 0.12)),
        cloud_noise=1e-4,
        **options,
    )


def graspable(laws: Literal["own", "foreign"]) -> ObjectsOnTable:
    """One without end, in a grip."""
    model = FlexibleBoxModel(BoxParameters(m=0.1, b1=0.0), NormalContact(k=2000.0), Friction.coulomb(0.2))
    noise = SensorNoise(force=0.02, position=1e-5, velocity=1e-4, seed=6)
    thing = OnTable(model, hang=Hang(), surface=plane(1000, (0.12, 0.12)))
    return ObjectsOnTable([thing], laws=laws, noise=noise, cloud_noise=1e-4)


def foreign_box(**sensors: Any) -> ForeignBoxSystem:
    return ForeignBoxSystem(
        Numbers(Fs=0.3, Fd=0.2),
        ForeignSensors(**sensors),
        noise=SensorNoise(force=0.02, position=1e-5, velocity=1e-4, seed=6),
        surface=plane(1000, (0.12, 0.12)),
        cloud_noise=1e-4,
    )


def objects_on_table() -> ObjectsOnTable:
    """Three, of which the first is under the probe and pushed into the second."""
    size, model = (0.06, 0.06, 0.05), FlexibleBoxModel()
    things = [OnTable(model, at, size, at[0] > 0.0, 0.0) for at in ((0.0, 0.0), (0.061, 0.0), (0.2, 0.0))]
    noise = SensorNoise(force=0.02, position=1e-5, velocity=1e-4, seed=6)
    return ObjectsOnTable(things, noise=noise, spacing=0.004, cloud_noise=1e-4)


def with_effects(model: Any) -> Any:
    """The model with friction that depends on the load, and a branch that remembers."""
    for name, values in (
        ("load_dependent_friction", {"mu": 0.2}),
        ("viscoelastic_relaxation", {"k_maxwell": 50, "tau": 0.1}),
    ):
        model = LIBRARY[name].apply(model, values)
    return model


def cartesian_impedance() -> CartesianImpedance:
    plant, tip = gantry()
    return CartesianImpedance(plant, tip, RigidTransform(np.array([0.1, 0.2, 0.3])), np.zeros(3))


@cache
def viewer() -> Viewer:
    return Viewer("")


def interactive_operator() -> InteractiveOperator:
    operator = InteractiveOperator(viewer())
    for name, *_, first in SLIDERS:
        viewer().values[name] = first + 0.01
    return operator


def recorded_operator() -> ScriptedOperator:
    time = np.linspace(0.0, 0.35, 50)
    samples = np.array([contract.motion(t) for t in time])
    return ScriptedOperator(SampledMotion(time, samples[:, :3], samples[:, 3:]))


# A status that tells of what is not finite does not follow what is.
ALWAYS_FINITE = frozenset({(name, "status") for name in ("motion", "remote_force", "remote_energy")})
# A renderer's outputs are parts of one vector; what becomes of theta is decided by theta and its flag.
STATUS_ALONE = frozenset((port, "status") for port in ("motion", "theta", "in_contact", "held_body"))
#: Only `EnergyPermitting` asks how sure theta is.
SURE = frozenset(("model_status", port) for port in (*impedance.PORT_SIZES, "readout"))
#: Which way the surface lies says nothing of theta.
LIES = frozenset({("facet", "status")})
#: A message that is changed by a little is refused, and the last good one stays.
TOLD = frozenset(("model", port) for port in ("force", "update_jump", "stored_energy"))
#: Another object matters where none is held, from the next touch on.
MET = frozenset(("thing", port) for port in impedance.PORT_SIZES)
#: A hand apart from the motion matters to these where it is not finite.
UNLESS_BAD = frozenset(("hand", port) for port in (*impedance.PORT_SIZES, "readout"))

#: A grip that holds and does not slip is felt no more for being stronger.
GRIPPED = frozenset(("grip", port) for port in ("body", "in_contact", "touched", "places", "bodies"))
#: In the run nothing is carried for so long that the numbers change.
UNTOLD = frozenset(
    (port, out) for port in ("measurement", "held", "grip", "in_contact", "theta") for out in ("deviation", "status")
) | {("in_contact", "carried"), ("theta", "carried"), ("theta", "in_contact"), ("grip", "in_contact")}
#: Nor is anything lifted: what is felt is the force on the table.
ON_THE_TABLE = frozenset(
    (port, "carries") for port in ("motion", "force", "grip", "in_contact", "theta", "carried")
) | frozenset({("in_contact", "force"), ("theta", "force"), ("in_contact", "readout")})

STILL_ON_THE_TABLE = frozenset({"deviation", "status"})  # nothing is carried for long enough to be told

CASES: dict[str, Case] = {
    "InteractiveOperator": Case(lambda folder: interactive_operator()),
    "ScriptedOperator-recorded": Case(lambda folder: recorded_operator()),
    "ScriptedOperator": Case(lambda folder: ScriptedOperator(scripted_motion("strokes"))),
    "FlexibleBox": Case(lambda folder: flexible_box()),
    "FlexibleBox-told-contact": Case(
        lambda folder: flexible_box(told_contact=True),
        computed_together=frozenset({("motion", "in_contact"), ("contact", "body")}),
    ),
    "FlexibleBox-on-a-ball": Case(lambda folder: flexible_box(shape=Sphere(fixed_to="body", mu=0.3))),
    "ObjectsOnTable-in-a-grip": Case(
        lambda folder: graspable("own"), computed_together=GRIPPED, any_size=frozenset({"bodies"})
    ),
    "ObjectsOnTable-foreign": Case(
        lambda folder: graspable("foreign"),
        computed_together=GRIPPED | {("grip", "force"), ("grip", "measurement")},
        any_size=frozenset({"bodies"}),
    ),
    "GripScript": Case(lambda folder: GripScript(closes=0.1, opens=0.4)),
    "LoadEstimator": Case(lambda folder: LoadEstimator(), computed_together=UNTOLD, still=STILL_ON_THE_TABLE),
    "CarriedReflection": Case(
        lambda folder: CarriedReflection(updates=EnergyPermitting()),
        computed_together=ON_THE_TABLE,
        still=frozenset({"carries"}),
    ),
    "ObjectsOnTable": Case(
        lambda folder: objects_on_table(),
        any_size=frozenset({"bodies"}),
        computed_together=frozenset({("motion", "held")}),
        still=frozenset({"held"}),
    ),
    "SceneTracker": Case(lambda folder: SceneTracker(-0.05, offset=0.5e-3)),
    "SceneTracker-with-a-grip": Case(lambda folder: SceneTracker(-0.05, offset=0.5e-3, grips=True)),
    "TouchedObject-with-a-grip": Case(
        lambda folder: TouchedObject(lost=2.0),
        computed_together=frozenset((i, o) for i in ("position", "grip", "has") for o in ("facet", "thing", "height"))
        | frozenset((i, o) for i in ("grip", "has") for o in ("in_contact", "clearance"))
        | {("has", "readout")},
        still=frozenset({"thing", "height"}),
    ),
    "CarriedReflection-of-several": Case(
        lambda folder: CarriedReflection(updates=EnergyPermitting(), seen=True),
        computed_together=ON_THE_TABLE
        | frozenset((i, o) for i in ("facet", "height", "thing") for o in ("force", "carries", "readout"))
        - {("thing", "readout")},
        still=frozenset({"carries"}),
    ),
    "TouchedObject": Case(
        # Over one object, whose top is told once in a while.
        lambda folder: TouchedObject(),
        computed_together=frozenset({("position", "facet"), ("position", "thing"), ("position", "height")}),
        still=frozenset({"thing", "height"}),
    ),
    "ObjectMemory": Case(
        # What is stable is kept, and so is all that goes with it; a size matters to a guess alone.
        lambda folder: ObjectMemory(),
        computed_together=frozenset(
            {
                *(("model_status", port) for port in ("theta", "stable", "remembered")),
                *(("theta", port) for port in ("stable", "model_status", "remembered")),
                *((port, "stable") for port in ("thing", "scene", "told_thing", "stable")),
                *((port, "remembered") for port in ("told_thing", "stable")),
            }
        ),
        still=frozenset({"stable"}),
    ),
    "ForeignBoxSystem": Case(lambda folder: foreign_box()),
    "ForeignBoxSystem-sensors": Case(
        lambda folder: foreign_box(
            corner=40.0, delay=0.0025, force_resolution=1e-3, position_resolution=1e-5, velocity_window=0.01
        )
    ),
    "DrivenBody": Case(lambda folder: DrivenBody(with_effects(DrivenBodyModel(m=0.5, b=2.0, k=30.0, Fc=0.1)))),
    "SurfaceContactSystem": Case(lambda folder: SurfaceContactSystem(SurfaceContact(k=300.0, b=20.0, mu=0.3))),
    "KelvinVoigtContact": Case(lambda folder: KelvinVoigtContact(with_effects(KelvinVoigt(k=300.0, b=20.0)))),
    "YieldingHand": Case(lambda folder: YieldingHand()),
    "ImpedanceRenderer": Case(
        lambda folder: ImpedanceRenderer(),
        computed_together=STATUS_ALONE | UNLESS_BAD | SURE | LIES | TOLD | MET,
        still=frozenset({"status"}),
    ),
    "ImpedanceRenderer-blended": Case(
        lambda folder: ImpedanceRenderer(updates=Blended()),
        computed_together=STATUS_ALONE | UNLESS_BAD | SURE | LIES | TOLD | MET,
        still=frozenset({"status"}),
    ),
    "ImpedanceRenderer-energy": Case(
        lambda folder: ImpedanceRenderer(updates=EnergyPermitting()),
        computed_together=frozenset({("held_body", "status"), ("model_status", "status"), ("motion", "status")})
        | LIES
        | TOLD
        | MET,
        every=3,  # a report leads a body for a tick now and then, as far as its energy permits
    ),
    "FusedRenderer": Case(
        lambda folder: FusedRenderer(),
        computed_together=STATUS_ALONE
        | SURE
        | {("high_band", port) for port in ("status", "update_jump", "stored_energy")},
        still=frozenset({"status"}),
    ),
    "HighBandEstimator": Case(lambda folder: HighBandEstimator()),
    "HighBandEstimator-spring": Case(lambda folder: HighBandEstimator(HighBand(damper=False))),
    "DirectForceRenderer": Case(
        lambda folder: DirectForceRenderer(),
        computed_together=frozenset({("remote_force", "status")}),
        still=frozenset({"status"}),
    ),
    "PassivityControlledForce": Case(
        lambda folder: PassivityControlledForce(), computed_together=ALWAYS_FINITE, still=frozenset({"status"})
    ),
    "PassivityControlledMotion": Case(lambda folder: PassivityControlledMotion()),
    "ProxySpringRenderer": Case(lambda folder: ProxySpringRenderer(), still=frozenset({"status"})),
    "LocalFrame": Case(lambda folder: LocalFrame()),
    "TouchedSurface": Case(lambda folder: TouchedSurface()),
    "ContactDetector": Case(lambda folder: ContactDetector()),
    "SurfaceContactDetector": Case(
        lambda folder: SurfaceContactDetector(), computed_together=frozenset({("position", "proxy_state")})
    ),
    "NetworkChannel-wire": channel(ChannelConfig()),
    "NetworkChannel-delay": channel(ChannelConfig(delay=0.1)),
    "NetworkChannel-rough": channel(ROUGH),
    "NetworkChannel-at-once": channel(AT_ONCE),
    "NetworkChannel-playout": channel(PLAYED_OUT, interpolation="motion"),
    "AbstractNetworkChannel-wire": cloud_channel(ChannelConfig()),
    "AbstractNetworkChannel-delay": cloud_channel(ChannelConfig(delay=0.1)),
    "AbstractNetworkChannel-rough": cloud_channel(ROUGH),
    "AbstractNetworkChannel-at-once": cloud_channel(ChannelConfig(jitter=0.05, seed=4)),
    "McapRecorder": Case(
        lambda folder: McapRecorder(folder / "run.mcap", [("force", 3), ("in_contact", 1)]),
        any_size=frozenset({"signals"}),
        writes_files=True,
    ),
    "LiveView": Case(lambda folder: LiveView(viewer()), writes_files=True),
    "RlsEstimator": Case(lambda folder: RlsEstimator(), still=frozenset({"stable"})),
    "ProbeCompensation": Case(
        # In free space for 70 ms at a time.
        lambda folder: ProbeCompensation(ProbeOptions(0.15, (0.0, 0.0, -1.5), clear=0.01, window=0.005))
    ),
    "CompliantTipSystem": Case(lambda folder: CompliantTipSystem(TipSettings(), np.array([0.0, 0.0, 0.005]))),
    "CartesianImpedance": Case(lambda folder: cartesian_impedance(), any_size=frozenset({"state", "torque"})),
    "OutputErrorEstimator": Case(lambda folder: OutputErrorEstimator(), still=frozenset({"stable", "model_status"})),
    "JointEffects": Case(joint_effects, any_size=frozenset({"state", "torque", "force"})),
    "LawLearner": Case(lambda folder: LawLearner(), still=frozenset({"model", "status"})),
}
