"""Three objects that look the same, pushed at random by a hand that knows where they are, seen by the depth camera."""

from contextlib import closing

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, DiscreteValues, LeafSystem

from mmt_drake.diagrams.proof.experiments.scene import IdentityWatch
from mmt_drake.diagrams.stations.nets import Nets
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.model import scene_layout
from mmt_drake.numeric.arrays import Array

STEP, TOP, ABOVE, PRESSED = 1e-3, -0.01, 0.005, -0.014
REACH = np.array([0.16, 0.09])
ALIKE = [
    f"environment.things.{name}.{change}"
    for name, x in (("sponge", -0.07), ("brick", 0.0), ("roll", 0.07))
    for change in (
        f"at=[{x}, 0.0]", "size=[0.05, 0.05, 0.05]", "round=true", "centre=null", "colour=[0.5, 0.5, 0.5]",
        "object.effects=[]", "object.normal={k: 500.0, b: 12.0}",
        "object.parameters={m: 0.3, k1: 0.0, k2: 500.0, b1: 1.0, b2: 12.0, Fc: 0.6}",
    )
]  # fmt: skip


class Pusher(LeafSystem):
    """Comes down on one of them, pushes it towards another one most of the time, and goes up again."""

    def __init__(self, seed: int) -> None:
        super().__init__()
        self.random, self.phase, self.which = np.random.default_rng(seed), 3, 0
        self.begins, self.takes = 1.2, 0.1  # [s]: the camera has begun
        self.start = self.end = np.array([0.0, 0.0, ABOVE])
        self.DeclareVectorInputPort("places", 2 * scene_layout.MOST)
        state = self.DeclareDiscreteState([*self.start, 0.0, 0.0, 0.0])
        self.DeclareStateOutputPort("motion", state)
        self.DeclarePeriodicDiscreteUpdateEvent(STEP, 0.0, self._step)

    def _step(self, context: Context, values: DiscreteValues) -> None:
        t, now = context.get_time() + STEP, np.array(values.get_value()[:3])
        if t > self.begins + self.takes:
            self._next(now, self.get_input_port().Eval(context).reshape(-1, 2)[:3])
            self.start, self.begins = now, t
        s = np.clip((t - self.begins) / self.takes, 0.0, 1.0)
        after = self.start + (self.end - self.start) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        values.set_value(np.concatenate([after, (after - now) / STEP]))

    def _next(self, now: Array, places: Array) -> None:
        self.phase = (self.phase + 1) % 4
        if self.phase == 0:  # over one
            self.which = int(self.random.integers(3))
            self.end = np.array([*(places[self.which] + self.random.uniform(-0.01, 0.01, 2)), ABOVE])
            self.takes = max(0.3, float(np.hypot(*(self.end - now)[:2])) / 0.25)
        elif self.phase == 2:  # at up to 0.3 m/s
            other = (self.which + int(self.random.integers(1, 3))) % 3
            towards = np.arctan2(*(places[other] - places[self.which])[::-1]) + self.random.normal(0.0, 0.25)
            angle = towards if self.random.random() < 0.6 else self.random.uniform(0.0, 2.0 * np.pi)
            far = self.random.uniform(0.03, 0.14) * np.array([np.cos(angle), np.sin(angle)])
            self.end = np.array([*np.clip(now[:2] + far, -REACH, REACH), now[2]])
            speed = 0.3 * self.random.uniform(0.3, 1.0)
            self.takes = max(0.2, 1.9 * float(np.hypot(*(self.end - now)[:2])) / speed)
        else:
            self.end, self.takes = np.array([*now[:2], PRESSED if self.phase == 1 else ABOVE]), 0.25


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_objects_that_look_the_same_are_told_apart_while_they_are_pushed_into_each_other(seed: int) -> None:
    scenario = load_scenario("setup4", ["carrying=null", "operator_device.trigger=null", f"seed={seed}", *ALIKE])
    several = scenario.several
    assert several is not None
    watch, frame = IdentityWatch(3), 1.0 / several.cloud.rate
    with closing(Site(scenario)) as site:
        parts = {
            "operator": Pusher(seed),
            "environment": several.build(site),
            "camera": site.surface.camera,
            "scene": several.tracker(site),
        }
        builder = DiagramBuilder()
        for name, system in parts.items():
            builder.AddNamedSystem(name, system)
        motion = {port: "operator.motion[0:3]" for port in ("camera.probe", "scene.position")}
        reads = {
            "operator.places": "environment.places",
            "environment.motion": "operator.motion",
            "camera.bodies": "environment.bodies",
            "scene.point_cloud": "camera.point_cloud",
            **motion,
        }
        shown = {"scene": "scene.scene", "places": "environment.places"}
        Nets(parts).connect(builder, reads, shown)
        diagram = builder.Build()
        simulator = Simulator(diagram)
        for k in range(1, round(40.0 / frame)):
            simulator.AdvanceTo(k * frame)
            scene, places = (diagram.GetOutputPort(name).Eval(simulator.get_context()) for name in shown)
            if k * frame > 1.0:
                watch.look(scene_layout.rows(scene), places.reshape(-1, 2))
    assert watch.told.get("merged", 0) > 0.2 * watch.frames  # they do meet
    assert watch.kept >= 0.95 * watch.frames
