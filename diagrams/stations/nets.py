"""Nets: who reads whose numbers, as text, and the wires that Drake needs for that.

A *net* is text: `operator.motion`, a part's output port; `operator.motion[0:3]`, some of its numbers; the name of
another net, `probe` or `probe[0:3]`; `renderer.status if renderer.stored_energy`, where both are here; the first of
several that is here, `to_renderer.received | operator.motion`; or several one after the other, `probe + tip`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort, PortDataType, System
from pydrake.systems.primitives import Demultiplexer, Multiplexer

from mmt_drake.errors import BadInput

_NONE: Mapping[str, Any] = MappingProxyType({})
_READOUT = "readout"  # a port that holds the system's other vector outputs, one after the other in their order


class Tap(NamedTuple):
    """Where a net comes from: so many numbers of a part's output port, or an abstract value.

    Attributes:
        part, port: names.
        start: the first of the numbers.
        size: how many; 0 for an abstract value.
    """

    part: str
    port: str
    start: int = 0
    size: int = 0

    def overlaps(self, other: Tap) -> bool:
        """Whether two taps of one port have a number in common."""
        return self.start < other.start + other.size and other.start < self.start + self.size


class Nets:
    """The nets among parts.

    Args:
        parts: name -> system.
        named: name of a net -> net.
        packets: part -> names and sizes of what its port `received` carries, which then are ports of the part, too.
        over: ports of parts that are elsewhere -> what shows them here.
    """

    def __init__(
        self,
        parts: Mapping[str, System],
        named: Mapping[str, str] = _NONE,
        packets: Mapping[str, Mapping[str, int]] = _NONE,
        over: Mapping[str, Tap] = _NONE,
    ) -> None:
        self.parts, self._named, self._over = parts, named, over
        self.packets = dict(packets)

    def tap(self, net: str) -> Tap | None:
        """Where a net comes from; None if it comes from nothing that is here."""
        for alternative in net.split(" | "):
            term, _, condition = alternative.partition(" if ")
            name, cut, numbers = term.partition("[")
            found = None if condition and self.tap(condition) is None else self._whole(name)
            if found is not None and cut:
                first, last = (int(number) for number in numbers.rstrip("]").split(":"))
                if last > found.size:
                    raise BadInput("nets", at=term, found=f"{found.size} numbers", expected=f"{last} or more")
                return found._replace(start=found.start + first, size=last - first)
            if found is not None:
                return found
        return None

    def taps(self, net: str) -> list[Tap]:
        """Where a net comes from that joins several, none or all of which are here; neighbours of one port are one.

        Raises:
            BadInput: one is here, another is not.
        """
        terms = list(filter(None, self._named.get(net, net).split(" + ")))
        found = [tap for tap in map(self.tap, terms) if tap is not None]
        if 0 < len(found) < len(terms):
            missing = ", ".join(term for term in terms if self.tap(term) is None)
            raise BadInput("nets", at=net, found=f"nothing that gives {missing}", expected="all that are joined")
        joined: list[Tap] = []
        for tap in found:
            last = joined[-1] if joined else None
            if last is not None and tap.size and last[:2] == tap[:2] and last.start + last.size == tap.start:
                joined[-1] = last._replace(size=last.size + tap.size)
            else:
                joined.append(tap)
        return joined

    def _whole(self, name: str) -> Tap | None:
        if name in self._named:
            return self.tap(self._named[name])
        if name in self._over:
            return self._over[name]
        part, port = name.split(".")
        packet = self.packets.get(part, {})
        if port in packet:
            carried = self._whole(f"{part}.received")
            before = sum(list(packet.values())[: list(packet).index(port)])
            return carried and carried._replace(start=carried.start + before, size=packet[port])
        system = self.parts.get(part)
        return None if system is None or not system.HasOutputPort(port) else _output(part, system, port)

    def input(self, name: str) -> InputPort | None:
        """The input `part.port`; None if the part has no such port."""
        part, port = name.split(".")
        return self.parts[part].GetInputPort(port) if self.parts[part].HasInputPort(port) else None

    def connect(self, builder: DiagramBuilder, reads: Mapping[str, str], shown: Mapping[str, str] = _NONE) -> None:
        """Connect parts, and give the diagram its outputs.

        What is split or joined on the way is named after its net: `environment.readout` after what is split,
        `recorder.signals` after what is joined.

        Args:
            builder: of the diagram, with all parts in it.
            reads: `part.port`, an input -> net; a port that the part does not have reads nothing.
            shown: name of an output of the diagram -> its net, if that is here.
        """
        read = {name: taps for name, net in reads.items() if self.input(name) is not None and (taps := self.taps(net))}
        outputs = {name: tap for name, net in shown.items() if (tap := self.tap(net)) is not None}
        ports = self._split(builder, {tap for taps in (*read.values(), outputs.values()) for tap in taps})
        for name, taps in read.items():
            source = ports[taps[0]]
            if len(taps) > 1:
                whole = builder.AddNamedSystem(name, Multiplexer([tap.size for tap in taps]))
                for i, tap in enumerate(taps):
                    builder.Connect(ports[tap], whole.get_input_port(i))
                source = whole.get_output_port(0)
            builder.Connect(source, self.input(name))
        for name, tap in outputs.items():
            builder.ExportOutput(ports[tap], name)

    def _split(self, builder: DiagramBuilder, taps: set[Tap]) -> dict[Tap, OutputPort]:
        """A port for every tap; those of one port that do not overlap share a demultiplexer."""
        ports: dict[Tap, OutputPort] = {}
        rows: dict[str, list[list[Tap]]] = defaultdict(list)
        for tap in sorted(taps, key=lambda tap: (*tap[:2], -tap.size, tap.start)):
            port = self.parts[tap.part].GetOutputPort(tap.port)
            if tap.size in (0, port.size()):
                ports[tap] = port
                continue
            alongside = rows[f"{tap.part}.{tap.port}"]
            for row in alongside:
                if not any(tap.overlaps(other) for other in row):
                    row.append(tap)
                    break
            else:
                alongside.append([tap])
        for name, alongside in rows.items():
            for i, row in enumerate(alongside):
                source = self.parts[row[0].part].GetOutputPort(row[0].port)
                edges = sorted({0, source.size(), *(edge for t in row for edge in (t.start, t.start + t.size))})
                sizes = np.diff(edges).tolist()
                splits = builder.AddNamedSystem(f"{name} {i + 1}" if i else name, Demultiplexer(sizes))
                builder.Connect(source, splits.get_input_port(0))
                ports |= {tap: splits.get_output_port(edges.index(tap.start)) for tap in row}
        return ports


def _output(part: str, system: System, port: str) -> Tap:
    """An output of a system, of its readout if it has one: one evaluation for all that are read."""
    found = system.GetOutputPort(port)
    if found.get_data_type() == PortDataType.kAbstractValued:
        return Tap(part, port)
    if system.HasOutputPort(_READOUT):
        outputs = [system.get_output_port(i) for i in range(system.GetOutputPort(_READOUT).get_index())]
        names = [output.get_name() for output in outputs]
        if port in names:
            return Tap(part, _READOUT, sum(output.size() for output in outputs[: names.index(port)]), found.size())
    return Tap(part, port, 0, found.size())


def shown_first(system: System, port: str) -> NDArray[np.float64]:
    """What a system shows on a port before anything happens."""
    value: NDArray[np.float64] = system.GetOutputPort(port).Eval(system.CreateDefaultContext())
    return value
