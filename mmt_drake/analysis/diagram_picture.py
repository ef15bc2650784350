"""A picture of a Drake diagram: boxes where they are to stand, wires as they really are connected."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Rectangle
from pydrake.systems.framework import Diagram, InputPortIndex, OutputPort, PortDataType, System
from pydrake.systems.primitives import Demultiplexer, Multiplexer

from mmt_drake.analysis.plotting import BLACK, BLUE, DPI, GREEN, ORANGE, PURPLE, WIDTH_IN, styled
from mmt_drake.errors import BadInput

_WIRES = (Multiplexer, Demultiplexer)
_SAY_NOTHING = ("sent", "received", "signals", "readout")  # port names that do not tell what passes
_READOUT = "readout"  # a port that holds the system's other vector outputs, one after the other in their order

_ROW_IN, _HEAD_IN, _FOOT_IN = 0.95, 0.36, 0.06
_SIDE_IN = 0.3  # beside the last column, for labels of vertical wires
_BOX_IN = (1.08, 0.54)
_LABEL_GAP_IN = 0.05
_LEVEL_ENOUGH_IN = 1.2  # for several signals side by side
_LANE_COLORS = ((BLUE, "#F2F6FA"), (ORANGE, "#FAF6EC"), (GREEN, "#F0F7F3"), (PURPLE, "#F8F1F5"))  # edge, ground

Point = tuple[float, float]
Side = str
Part = tuple[int, int]  # the first element of a vector and how many


@dataclass(frozen=True)
class Wire:
    """Everything that one system hands to another.

    Attributes:
        source, target: their names.
        signals: names of what passes: the target's port, or the source's where that says more.
    """

    source: str
    target: str
    signals: tuple[str, ...]


@dataclass(frozen=True)
class Lane:
    """A stripe of the picture.

    Attributes:
        title: what its systems have in common.
        columns: how many columns it is wide.
    """

    title: str
    columns: int = 1


def wires(diagram: Diagram) -> list[Wire]:
    """The wires of a diagram, one `Wire` per pair of systems; multiplexers and demultiplexers count as wire."""
    connections = {
        (target.get_name(), int(index)): (source, int(port))
        for (target, index), (source, port) in diagram.connection_map().items()
    }

    def sources(name: str, index: int, part: Part | None = None) -> list[tuple[str, str]]:
        """Names of the systems, and of what they give, at the far end of an input; of that input only a part."""
        source, port = connections[name, index]
        if isinstance(source, Demultiplexer):
            sizes = source.get_output_ports_sizes()
            return sources(source.get_name(), 0, (sum(sizes[:port]), sizes[port]))
        if isinstance(source, Multiplexer):
            return [far for i in range(source.num_input_ports()) for far in sources(source.get_name(), i)]
        return [(source.get_name(), _signal(source, source.get_output_port(port), part))]

    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for system in boxes(diagram):
        for index in range(system.num_input_ports()):
            if (system.get_name(), index) not in connections:
                continue
            here = system.get_input_port(InputPortIndex(index)).get_name()
            for source, there in sources(system.get_name(), index):
                signals = found[source, system.get_name()]
                label = there if here in _SAY_NOTHING else here
                if label not in signals:
                    signals.append(label)
    return [Wire(*pair, tuple(signals)) for pair, signals in found.items()]


def _signal(system: System, port: OutputPort, part: Part | None) -> str:
    """The port's name, or of a readout the name of the output that the part is."""
    start = 0
    if port.get_name() == _READOUT and part is not None:
        for i in range(system.num_output_ports()):
            other = system.get_output_port(i)
            if other.get_data_type() != PortDataType.kVectorValued or other.get_name() == _READOUT:
                continue
            if (start, other.size()) == part:
                return str(other.get_name())
            start += other.size()
    return str(port.get_name())


def boxes(diagram: Diagram) -> list[System]:
    """The diagram's systems without those that only split and join vectors."""
    return [system for system in diagram.GetSystems() if not isinstance(system, _WIRES)]


@styled
def block_diagram(
    diagram: Diagram,
    positions: Mapping[str, tuple[int, int]],
    lanes: Sequence[Lane],
    *,
    notes: Mapping[str, str] | None = None,
    hidden: Collection[str] = (),
) -> Figure:
    """Draw the systems of a diagram, left to right, and the signals between them.

    Args:
        diagram: what to draw.
        positions: name of a system -> (column, row), both from 0, rows downwards.
        lanes: stripes from the left; together as many columns as there are.
        notes: name of a system -> the small line in its box; the name of its class by default.
        hidden: systems to be left out with their wires.

    Raises:
        BadInput: a system is neither placed nor hidden, or one stands outside the lanes.
    """
    columns = sum(lane.columns for lane in lanes)
    shown = {system.get_name(): system for system in boxes(diagram) if system.get_name() not in hidden}
    for name in shown:
        if not 0 <= positions.get(name, (columns, 0))[0] < columns:
            expected = f"a place in columns 0 to {columns - 1}, or hidden"
            raise BadInput(diagram.get_name(), at=name, found=positions.get(name, "no place"), expected=expected)
    rows = 1 + max((positions[name][1] for name in shown), default=0)
    size = (WIDTH_IN, _HEAD_IN + rows * _ROW_IN + _FOOT_IN)
    figure = Figure(figsize=size, dpi=DPI)
    FigureCanvasAgg(figure)
    panel = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    panel.set_axis_off()
    panel.set(xlim=(0.0, size[0]), ylim=(0.0, size[1]))

    pitch = (WIDTH_IN - _SIDE_IN) / columns
    edges = _draw_lanes(panel, lanes, pitch, size)
    at = {name: positions[name] for name in shown}
    top = size[1] - _HEAD_IN
    centres = {name: ((column + 0.5) * pitch, top - (row + 0.5) * _ROW_IN) for name, (column, row) in at.items()}
    drawn = [wire for wire in wires(diagram) if wire.source in centres and wire.target in centres]
    for wire, path in zip(drawn, _paths(drawn, centres), strict=True):
        _draw_wire(panel, wire, path)
    for name, system in shown.items():
        note = (notes or {}).get(name, type(system).__name__)
        _draw_box(panel, centres[name], name, note, edges[positions[name][0]])
    return figure


def _sides(source: Point, target: Point) -> tuple[Side, Side]:
    """The sides at which a wire leaves and enters: straight where it can be, else with one bend.

    To the right it leaves sideways and enters from above or below, to the left the other way round, so that of two
    wires between the same rows one keeps left of the other.
    """
    right, down = target[0] - source[0], source[1] - target[1]
    if abs(down) < 1e-9:
        return ("right", "left") if right > 0.0 else ("left", "right")
    vertical = ("bottom", "top") if down > 0.0 else ("top", "bottom")
    if abs(right) < 1e-9:
        return vertical
    return ("right", vertical[1]) if right > 0.0 else (vertical[0], "right")


def _paths(drawn: Sequence[Wire], centres: Mapping[str, Point]) -> list[list[Point]]:
    """Corners of every wire; those that share a side of a box are spread along it in the order of where they go."""
    ends: dict[tuple[str, Side], list[tuple[float, int]]] = defaultdict(list)
    sides = [_sides(centres[wire.source], centres[wire.target]) for wire in drawn]
    for number, (wire, (leaves, enters)) in enumerate(zip(drawn, sides, strict=True)):
        for box, side, other in ((wire.source, leaves, wire.target), (wire.target, enters, wire.source)):
            across = centres[other][1] if side in ("left", "right") else centres[other][0]
            ends[box, side].append((across, number))

    def end(box: str, side: Side, number: int) -> tuple[Point, int]:
        """The point where a wire meets a box, and how many share that side."""
        order = sorted(ends[box, side])
        share = ([n for _, n in order].index(number) + 1) / (len(order) + 1) - 0.5
        (x, y), (width, height) = centres[box], _BOX_IN
        if side in ("left", "right"):
            return (x + (width / 2 if side == "right" else -width / 2), y + share * height), len(order)
        return (x + share * width, y + (height / 2 if side == "top" else -height / 2)), len(order)

    paths = []
    for number, (wire, (leaves, enters)) in enumerate(zip(drawn, sides, strict=True)):
        (start, started), (stop, stopped) = end(wire.source, leaves, number), end(wire.target, enters, number)
        if {leaves, enters} == {"left", "right"}:
            y = start[1] if started >= stopped else stop[1]
            paths.append([(start[0], y), (stop[0], y)])
        elif {leaves, enters} == {"top", "bottom"}:
            x = start[0] if started >= stopped else stop[0]
            paths.append([(x, start[1]), (x, stop[1])])
        else:
            corner = (stop[0], start[1]) if leaves == "right" else (start[0], stop[1])
            paths.append([start, corner, stop])
    return paths


def _draw_lanes(panel: Axes, lanes: Sequence[Lane], pitch: float, size: Point) -> list[str]:
    """Draw the stripes; gives the colour of the boxes in each column."""
    edges: list[str] = []
    for lane, (edge, ground) in zip(lanes, _LANE_COLORS * len(lanes), strict=False):
        left = len(edges) * pitch
        edges += [edge] * lane.columns
        last = lane is lanes[-1]
        right = size[0] if last else len(edges) * pitch
        panel.add_patch(Rectangle((left + 0.03, 0.03), right - left - 0.06, size[1] - 0.06, color=ground, linewidth=0))
        panel.text((left + right) / 2, size[1] - 0.11, lane.title, ha="center", va="top", fontsize=10, weight="bold")
    return edges


def _draw_box(panel: Axes, centre: Point, name: str, note: str, edge: str) -> None:
    (x, y), (width, height) = centre, _BOX_IN
    panel.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - height / 2),
            width,
            height,
            boxstyle="round,pad=0,rounding_size=0.07",
            facecolor="white",
            edgecolor=edge,
            linewidth=1.3,
            zorder=3,
        )
    )
    panel.text(x, y + 0.08, name, ha="center", va="center", fontsize=8.5, weight="bold", zorder=4)
    panel.text(x, y - 0.11, note, ha="center", va="center", fontsize=6.8, color="#555555", zorder=4)


def _draw_wire(panel: Axes, wire: Wire, path: Sequence[Point]) -> None:
    panel.plot(*zip(*path, strict=True), color=BLACK, linewidth=1.0, solid_capstyle="butt", zorder=1)
    arrow = {
        "arrowstyle": "-|>",
        "color": BLACK,
        "linewidth": 1.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
        "mutation_scale": 9.0,
    }
    panel.annotate("", path[-1], path[-2], arrowprops=arrow, zorder=2)
    (x0, y0), (x1, y1) = path[0], path[1]
    text: dict[str, Any] = {"fontsize": 7.2, "color": BLACK, "zorder": 5, "linespacing": 1.05}
    if abs(y1 - y0) < 1e-9:
        between = ", " if abs(x1 - x0) > _LEVEL_ENOUGH_IN else "\n"
        at = (x0 + x1) / 2, y0 + _LABEL_GAP_IN
        panel.text(*at, between.join(wire.signals), ha="center", va="bottom", **text)
    else:
        left = path[-1][0] < x0 - 1e-9  # on the side to which the wire turns, where no neighbour runs
        at = x0 + (-_LABEL_GAP_IN if left else _LABEL_GAP_IN), (y0 + y1) / 2
        panel.text(*at, "\n".join(wire.signals), ha="right" if left else "left", va="center", **text)
