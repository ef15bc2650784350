"""Scenarios: shipped ones say what the thesis says, everything can be said, nonsense is refused."""

import dataclasses

import pytest

from mmt_drake.diagrams.stations.environment import ForeignBox
from mmt_drake.diagrams.stations.hands import Interactive, Recorded, Scripted
from mmt_drake.diagrams.stations.renderers import DirectForce, FusedReflection, ImpedanceReflection, ProxySpring
from mmt_drake.diagrams.stations.scenario import SCENARIOS, load_scenario, shipped
from mmt_drake.errors import BadInput
from mmt_drake.foreign.options import ForeignSensors
from mmt_drake.model.parameters import BoxParameters, Friction, NormalContact
from mmt_drake.model_files import with_effects
from mmt_drake.network.config import ChannelConfig
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.updates import RateLimited
from mmt_drake.typed_yaml import parse

EFFECTS = "environment.object.effects"


def test_the_shipped_scenarios_are_those_of_the_contract():
    assert {"setup1", "setup1-delay", "setup1-everything", "setup3"} <= set(shipped())


def test_setup_1_has_the_theses_parameters():
    for name in ("setup1", "setup1-delay"):
        model = load_scenario(name).environment.object
        assert model.parameters == BoxParameters(m=1, k1=0, k2=500, b1=60, b2=60)
        assert model.friction == Friction(0.1, 0.05, 0.005)
        assert model.normal == NormalContact(500, 60)


def test_delay_is_400_ms_each_way():
    scenario = load_scenario("setup1-delay")
    assert scenario.to_telerobot.delay == scenario.to_operator.delay == 0.4
    assert load_scenario("setup1").to_telerobot.is_constant and load_scenario("setup1").to_telerobot.delay == 0


def test_everything_that_can_be_said_is_said_in_setup1_everything():
    # But for what excludes something else there, and for what follows from the scenario's own step and cloud.
    unsaid = {"estimator.freeze_after", "estimator.step", "detector.period", "detector.surface_offset"}
    unsaid |= {"environment.cloud.file", "environment.cloud.voxel"}
    unsaid |= {"telerobot", "telerobot_device", "renderer.arm"}  # of set-up 3
    unsaid |= {"renderer.effects", "renderer.structure", "learner"}  # where the body carries the surface there are none
    unsaid |= {"carrying", "operator_device.trigger"}  # of set-up 1 with a grip
    unsaid |= {"environment.object.parameters.Fc"} | {f"{way}.trace" for way in ("to_telerobot", "to_operator")}
    unsaid |= {f"to_renderer.{field.name}" for field in dataclasses.fields(ChannelConfig)} - {"to_renderer.delay"}
    unsaid |= {f"to_operator.{name}" for name in ("reordering_delay", "rate_limit", "queue", "playout")}
    data = parse((SCENARIOS / "setup1-everything.yaml").read_text(), "setup1-everything")

    def left_out(value, said, path=""):
        for field in dataclasses.fields(value):
            if not field.metadata.get("in_files", True):
                continue
            if field.name not in said:
                yield path + field.name
            elif dataclasses.is_dataclass(getattr(value, field.name)):
                yield from left_out(getattr(value, field.name), said[field.name], f"{path}{field.name}.")

    assert set(left_out(load_scenario("setup1-everything"), data)) == unsaid


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ("operator=!Recorded {file: hand.csv}", Recorded("hand.csv")),
        ("operator=!Interactive {bandwidth: 3}", Interactive(3.0)),
        ("operator={motion: chirp, parameters: {duration: 30}}", Scripted("chirp", {"duration": 30})),
    ],
)
def test_set_can_exchange_a_part(change, kind):
    assert load_scenario("setup1", [change]).operator == kind


@pytest.mark.parametrize(
    ("change", "renderer"),
    [
        ("!ProxySpring {k: 300}", ProxySpring(300.0)),
        ("!DirectForce", DirectForce()),
        ("!DirectForce {passivity: {most_damping: 20}}", DirectForce(PassivityControl(most_damping=20.0))),
        ("{updates: !RateLimited {rate: 3}}", ImpedanceReflection(updates=RateLimited(3.0))),
        ("!FusedReflection {high_band: {damper: false}}", FusedReflection(high_band=HighBand(damper=False))),
    ],
)
def test_set_can_choose_another_renderer(change, renderer):
    assert load_scenario("setup1", [f"renderer={change}"]).renderer == renderer


def test_a_model_cannot_be_switched_where_none_is_rendered():
    with pytest.raises(BadInput, match=r"^setup1: switching: found operator, expected telerobot"):
        load_scenario("setup1", ["renderer=!DirectForce {}", "switching=operator"])


@pytest.mark.parametrize(
    ("changes", "at"),
    [
        (
            "environment.!=ForeignBox environment.object.parameters.k1=5",
            "environment.object.parameters: found k1 or b1 of a !ForeignBox, expected 0",
        ),
        ("environment.surface=!Sphere", "environment.surface"),
        ("learner={}", "learner: found a learner, expected null"),
        ("renderer=!DirectForce", "renderer"),
        ("carrying.opens=3.0", "carrying"),
        ("carrying.hang.centre=0.0", "centre"),
        ("carrying.grip=-1", "grip"),
    ],
)
def test_what_is_not_carried_is_refused(changes, at):
    with pytest.raises(BadInput, match=at):
        load_scenario("setup1-carrying", changes.split())


def test_of_several_objects_one_hangs_as_it_says_or_by_its_middle_and_none_with_effects():
    several = load_scenario("setup4").several
    grip = load_scenario("setup4").carrying.hang
    hangs = {name: thing.hang(grip) for name, thing in several.things.items()}
    assert (hangs["sponge"].centre, hangs["brick"].centre, hangs["roll"]) == (0.024, 0.03, None)
    assert all(thing.hang(None) is None for thing in several.things.values())
    with pytest.raises(BadInput, match=r"brick\.centre: found 2"):
        load_scenario("setup4", ["environment.things.brick.centre=2"])
    with pytest.raises(BadInput, match=r"things\.sponge\.object\.parameters\.b1: found 2"):
        load_scenario("setup4", ["environment.laws=foreign"])


@pytest.mark.parametrize("colour", ["[0.5, 255, 0]", "[-0.1, 0, 0]", "[0.5, .nan, 0]"])
def test_a_colour_that_is_none_is_refused(colour):
    with pytest.raises(BadInput, match=r"environment\.things\.roll\.colour(\[1\])?: found"):
        load_scenario("setup4", [f"environment.things.roll.colour={colour}"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("operator.motoin=x", "operator: found the key 'motoin' (did you mean 'motion'?)"),
        ("operator=!Omega {}", "operator: found !Omega, expected one of !Scripted, !Recorded, !Interactive"),
        ("environment.object.parameters.m=1e-9", "environment.object.parameters.m: found 1e-09 on springs of 500"),
        ("environment.object.parameters.m=-1", "environment.object.parameters.m: found -1.0"),
        ("to_telerobot.delay=soon", "to_telerobot.delay: found 'soon', expected a finite number"),
        ("to_telerobot.delay=.nan", "to_telerobot.delay: found nan"),
        ("to_telerobot.delay=-0.1", "to_telerobot.delay: found -0.1"),
        ("to_operator.loss=1.5", "to_operator.loss: found 1.5"),
        ("estimator.equations=without_g", "estimator.equations: found 'without_g'"),
        ("renderer.substeps=0.5", "renderer.substeps: found 0.5"),
        ("renderer={updates: !Sudden {}}", "renderer.updates: found !Sudden, expected one of !AtOnce, !RateLimited"),
        ("renderer={updates: !Blended {time: 0}}", "renderer.updates.time: found 0.0"),
        ("hand.mass=0", "hand.mass: found 0.0"),
        ("switching=nobody", "switching: found 'nobody', expected one of telerobot, operator"),
        ("detector.r1=0.02", "detector.r1, r2, r3"),
        ("environment.cloud.points=-5", "environment.cloud.points: found -5"),
        ("environment.cloud={file: a.ply, size: 0.2}", "environment.cloud.size: found 0.2, expected nothing beside"),
        ("environment.cloud.voxel=0.01", "environment.cloud.voxel: found 0.01"),
        (f"{EFFECTS}=coulomb_friction", f"{EFFECTS}: found str, expected a list"),
        (f"{EFFECTS}=[{{name: stiction}}]", f"{EFFECTS}[0].name: found 'stiction', expected one of viscous_friction"),
        (
            f"{EFFECTS}=[{{name: coulomb_friction, parameters: {{F_c: 0.4}}}}]",
            "environment.object.coulomb_friction.parameters: found parameters F_c, expected Fc",
        ),
        (
            f"{EFFECTS}=[{{name: coulomb_friction, parameters: {{Fc: -1}}}}]",
            "environment.object.coulomb_friction.Fc: found -1, expected a finite value from 0 to inf N",
        ),
        (f"{EFFECTS}=[{{name: time_delay, parameters: {{delay: 0.01}}}}]", f"{EFFECTS}: found time_delay, expected a"),
        ("environment.noise.force=-1", "environment.noise.force: found -1.0"),
        ("step=0", "step: found 0.0"),
        ("duration=-3", "duration: found -3.0"),
        ("seed=1.5", "seed: found 1.5"),
        ("estimator.step=0.002", "estimator.step: found 0.002, expected the scenario's step"),
        ("clouds=some", "clouds: found 'some', expected one of none, light, full"),
    ],
)
def test_nonsense_is_refused_with_its_place(change, message):
    with pytest.raises(BadInput) as error:
        load_scenario("setup1", [change])
    assert str(error.value).startswith(f"setup1: {message}")


def test_the_object_of_a_scenario_has_effects_as_a_model_file_has_them():
    said = "[{name: coulomb_friction, parameters: {Fc: 0.4}}, {name: force_bias, parameters: {bias: 0.3}}]"
    plain = load_scenario("setup1", ["environment.object.friction=null"]).environment.object
    found = load_scenario("setup1", ["environment.object.friction=null", f"{EFFECTS}={said}"]).environment.object
    assert found == with_effects(plain, parse(said, "effects"), "here")
    assert found.value("Fc") == 0.4 and len(found.additions.laws) == 1
    for none in ("null", "[]"):
        assert load_scenario("setup1", [f"{EFFECTS}={none}"]) == load_scenario("setup1")


def test_an_unknown_scenario_lists_the_known_ones():
    with pytest.raises(BadInput, match="setup1, setup1-carrying, setup1-delay"):
        load_scenario("setup9")


def test_a_foreign_box_keeps_the_object_the_noise_and_the_surface_of_the_scenario():
    own = load_scenario("setup1-free-running").environment
    foreign = load_scenario("setup1-free-running", ["environment.!=ForeignBox"]).environment
    assert isinstance(foreign, ForeignBox)
    assert (foreign.object, foreign.noise, foreign.cloud) == (own.object, own.noise, own.cloud)
    assert load_scenario("setup1", ["environment=!ForeignBox {sensors: {delay: 0.002}}"]).environment == ForeignBox(
        sensors=ForeignSensors(delay=0.002)
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("surface: 0.1", "environment.surface: found 0.1, expected -0.02 to 0.02 m"),
        ("sensors: {delay: 0.03}", "environment.sensors.delay: found 0.03, expected 0 to 0.02 s"),
        ("sensors: {corner: 0}", "environment.sensors.corner: found 0.0, expected a finite number > 0"),
        ("laws: {k3: -1}", "environment.laws.k3: found -1.0"),
        ("laws: {wall: 0.01, wall_k: 1e12}", "environment.m: found 1 on springs of 1e+12"),
        ("object: {effects: [{name: force_bias, parameters: {bias: 1}}]}", "environment.object.effects: found effects"),
    ],
)
def test_nonsense_of_a_foreign_box_is_refused_with_its_place(change, message):
    with pytest.raises(BadInput) as error:
        load_scenario("setup1", [f"environment=!ForeignBox {{{change}}}"])
    assert str(error.value).startswith(f"setup1: {message}")


def test_a_telerobot_measures_by_its_own_sensors():
    with pytest.raises(BadInput, match=r"environment.sensors: found .*expected telerobot.sensor.noise"):
        load_scenario("setup3", ["environment=!ForeignBox {sensors: {delay: 0.002}}"])
