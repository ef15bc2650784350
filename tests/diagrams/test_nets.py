"""Nets connect what they name, and the table of a station names nothing that no station has."""

import re
from itertools import chain

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource, Demultiplexer, Multiplexer, PassThrough

from mmt_drake.diagrams.stations.nets import Nets, Tap
from mmt_drake.diagrams.stations.returned import RETURNED
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.diagrams.stations.station import build_parts
from mmt_drake.diagrams.stations.table import AGES, NETS, OUTPUTS, PARTS, READS, RECORDED, SHOWN_BEFORE
from mmt_drake.errors import BadInput

# What a simulated station has not: ports of devices, of a link, and of a run in real time or with a viewer.
ELSEWHERE = re.compile(
    r"(link|pace|switch|limiter|while_well|hand_age|arm_age|camera_age|announcer|arm_announcer|live_view)\."
    r"|operator\.(ages|status|switches|applied_force|grip)$|arm\.(age|switches|device)$"
)


def source() -> System:
    return ConstantVectorSource([1.0, 2.0, 3.0, 4.0, 5.0])


@pytest.mark.parametrize(
    ("net", "tap"),
    [
        ("hand.y0", Tap("hand", "y0", 0, 5)),
        ("hand.y0[1:3]", Tap("hand", "y0", 1, 2)),
        ("arm.y0 | hand.y0", Tap("hand", "y0", 0, 5)),
        ("hand.y0 | arm.y0", Tap("hand", "y0", 0, 5)),
        ("hand.y0 if arm.y0", None),
        ("arm.y0", None),
        ("hand.speed", None),
        ("tip[0:2]", Tap("hand", "y0", 2, 2)),
        ("far.received", Tap("link", "received", 3, 2)),
        ("far.b", Tap("link", "received", 4, 1)),
    ],
)
def test_a_net_is_the_first_of_its_sources_that_is_here(net: str, tap: Tap | None) -> None:
    over = {"far.received": Tap("link", "received", 3, 2)}
    nets = Nets({"hand": source()}, {"tip": "hand.y0[2:5]"}, {"far": {"a": 1, "b": 1}}, over)
    assert nets.tap(net) == tap


def test_more_numbers_than_there_are_is_refused() -> None:
    with pytest.raises(BadInput, match=r"hand.y0\[3:7\]: found 5 numbers, expected 7 or more"):
        Nets({"hand": source()}).tap("hand.y0[3:7]")


def test_a_joined_net_of_which_a_part_is_missing_is_refused() -> None:
    with pytest.raises(BadInput, match=r"hand.y0 \+ leg.y: found nothing that gives leg.y"):
        Nets({"hand": source()}).taps("hand.y0 + leg.y")


@pytest.mark.parametrize(
    ("net", "numbers", "between"),
    [
        ("hand.y0", [1, 2, 3, 4, 5], []),
        ("hand.y0[0:2] + hand.y0[2:5]", [1, 2, 3, 4, 5], []),
        ("hand.y0[3:5]", [4, 5], ["hand.y0"]),
        ("hand.y0[3:5] + hand.y0[0:1]", [4, 5, 1], ["arm.u", "hand.y0"]),
        ("hand.y0[1:4] + hand.y0[2:3]", [2, 3, 4, 3], ["arm.u", "hand.y0", "hand.y0 2"]),
    ],
)
def test_what_is_read_is_what_the_net_names_and_what_stands_between_is_named_after_it(
    net: str, numbers: list[float], between: list[str]
) -> None:
    parts = {"hand": source(), "arm": PassThrough(len(numbers))}
    builder = DiagramBuilder()
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    Nets(parts).connect(builder, {"arm.u": net}, {"seen": "arm.y", "unknown": "leg.y"})
    diagram = builder.Build()
    assert diagram.num_output_ports() == 1
    np.testing.assert_array_equal(diagram.GetOutputPort("seen").Eval(diagram.CreateDefaultContext()), numbers)
    joints = [s.get_name() for s in diagram.GetSystems() if isinstance(s, Multiplexer | Demultiplexer)]
    assert sorted(joints) == between


STATIONS = (
    ("setup1", ("renderer=!DirectForce {passivity: {}}", "to_renderer.delay=0.004", "hand={mass: 1.2}")),
    ("setup1", ("renderer=!FusedReflection {}", "estimator=!OutputErrorOptions {}", "switching=operator")),
    ("setup1", ("renderer=!ProxySpring {}", "environment.cloud=!SimulatedDepthCamera {}")),
    ("setup3", ("estimator=!OutputErrorOptions {}", "switching=operator", "touch={}")),
    ("setup1", ("environment.surface=!Sphere {}",)),
    ("setup1-learning", ()),
    ("setup1-carrying", ()),
    ("setup4", ()),
    ("setup4", ("environment.cloud=!SimulatedDepthCamera {}",)),
)


@pytest.fixture(scope="module")
def ports() -> set[str]:
    """`part.port`, inputs and outputs, of stations that between them have every simulated part."""
    found: set[str] = set()
    for name, changes in STATIONS:
        for part, system in build_parts(Site(load_scenario(name, changes))).items():
            inputs = (system.get_input_port(i) for i in range(system.num_input_ports()))
            outputs = (system.get_output_port(i) for i in range(system.num_output_ports()))
            found |= {f"{part}.{port.get_name()}" for port in chain(inputs, outputs)}
    return found


def test_the_table_names_parts_nets_and_ports_that_there_are(ports: set[str]) -> None:
    known = {*(part.name for part in PARTS), "link"}
    packet = {f"to_operator.{name}" for name in RETURNED}
    nets = chain(
        *(NETS.values(), READS.values(), RECORDED.values(), OUTPUTS.values(), SHOWN_BEFORE.values(), AGES.values()),
        (signal.net for signal in RETURNED.values()),
    )
    terms = {re.sub(r"\[.*", "", term) for net in nets for term in re.split(r" \| | \+ | if ", net)}
    assert {term for term in terms if "." not in term} <= {*NETS, "returned", "watched"}
    assert {term.split(".")[0] for term in terms if "." in term} <= known
    assert {p for p in (terms | set(READS)) - ports - packet if "." in p and not ELSEWHERE.match(p)} == set()
