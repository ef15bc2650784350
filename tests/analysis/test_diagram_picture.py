"""The picture of a diagram shows what is connected to what."""

import pytest
from matplotlib.text import Text
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer, Gain, Multiplexer, PassThrough

from mmt_drake.analysis.diagram_picture import Lane, Wire, block_diagram, wires
from mmt_drake.analysis.plotting import png
from mmt_drake.errors import BadInput

PLACES = {"left": (0, 0), "twin": (0, 1), "right": (1, 0)}
LANES = (Lane("here"), Lane("there"))


@pytest.fixture
def diagram():
    """left and twin, joined, split again and handed to right; right goes back to left."""
    builder = DiagramBuilder()
    left = builder.AddNamedSystem("left", PassThrough(1))
    twin = builder.AddNamedSystem("twin", Gain(2.0, 1))
    right = builder.AddNamedSystem("right", PassThrough(2))
    join, split, again = (builder.AddSystem(part) for part in (Multiplexer(2), Demultiplexer(2), Multiplexer(2)))
    builder.Connect(left.get_output_port(), join.get_input_port(0))
    builder.Connect(twin.get_output_port(), join.get_input_port(1))
    builder.Connect(join.get_output_port(0), split.get_input_port(0))
    for i in (0, 1):
        builder.Connect(split.get_output_port(i), again.get_input_port(i))
    builder.Connect(again.get_output_port(0), right.get_input_port())
    builder.Connect(left.get_output_port(), twin.get_input_port())
    builder.ExportInput(left.get_input_port())
    return builder.Build()


def test_multiplexers_and_demultiplexers_are_wire(diagram):
    port = diagram.GetSubsystemByName("right").get_input_port().get_name()
    gain = diagram.GetSubsystemByName("twin").get_input_port().get_name()
    expected = {Wire("left", "right", (port,)), Wire("twin", "right", (port,)), Wire("left", "twin", (gain,))}
    assert set(wires(diagram)) == expected


class Reader(LeafSystem):
    """Gives `speed` (2) and `load` (1), and both again as `readout` (3)."""

    def __init__(self):
        super().__init__()
        for name, size in (("speed", 2), ("load", 1), ("readout", 3)):
            self.DeclareVectorOutputPort(name, size, lambda context, output: None)


class Receiver(LeafSystem):
    """Takes whatever is `sent`."""

    def __init__(self, size):
        super().__init__()
        self.DeclareVectorInputPort("sent", size)


@pytest.mark.parametrize(("sizes", "part", "told"), [((2, 1), 0, "speed"), ((2, 1), 1, "load"), ((1, 2), 1, "readout")])
def test_a_part_of_a_readout_goes_by_the_name_of_the_output_that_it_is(sizes, part, told):
    builder = DiagramBuilder()
    reader = builder.AddNamedSystem("reader", Reader())
    split = builder.AddSystem(Demultiplexer(list(sizes)))
    join = builder.AddSystem(Multiplexer([sizes[part]]))
    target = builder.AddNamedSystem("target", Receiver(sizes[part]))
    builder.Connect(reader.GetOutputPort("readout"), split.get_input_port(0))
    builder.Connect(split.get_output_port(part), join.get_input_port(0))
    builder.Connect(join.get_output_port(0), target.GetInputPort("sent"))
    assert wires(builder.Build()) == [Wire("reader", "target", (told,))]


def texts(figure):
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


def test_every_box_lane_and_wire_is_named(diagram):
    figure = block_diagram(diagram, PLACES, LANES, notes={"right": "far away"})
    shown = texts(figure)
    assert {"left", "twin", "right", "here", "there", "far away"} <= set(shown)
    assert sum(wire.signals[0] in shown for wire in wires(diagram)) == 3
    assert png(figure).startswith(b"\x89PNG")


def test_a_hidden_system_takes_its_wires_along(diagram):
    assert "right" not in texts(block_diagram(diagram, PLACES, LANES, hidden=("right",)))


def test_a_system_without_a_place_in_the_lanes_is_bad_input(diagram):
    with pytest.raises(BadInput, match=r"right: found no place, expected a place in columns 0 to 1"):
        block_diagram(diagram, {"left": (0, 0), "twin": (0, 1)}, LANES)
    with pytest.raises(BadInput, match=r"right: found \(2, 0\)"):
        block_diagram(diagram, {**PLACES, "right": (2, 0)}, LANES)
