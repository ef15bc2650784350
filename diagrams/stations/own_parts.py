"""Parts of a person's own: a class, handed in or named as `my.py:MyEstimator`, that makes a system with known ports.

The class is called with the fast path's step, `MyEstimator(period=0.001)` [s]. Which ports its system may have, and
their sizes, is what the station's table says of the part in whose place it stands.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Self

from pydrake.systems.framework import InputPort, OutputPort, PortDataType, System

from mmt_drake.errors import BadInput, MmtError
from mmt_drake.own_code import own_code_named, read_code
from mmt_drake.recording.signals import SIGNALS
from mmt_drake.systems.leaf import INPUT_SIZES

Make = Callable[..., System]
"""Called with `period`, the fast path's step [s]."""


@dataclass(frozen=True)
class OwnPart:
    """Base of the options of own parts.

    Attributes:
        code: `my.py:MyEstimator`, a file and a class in it; of one that was handed in its name.
        make: what was handed in.

    Raises:
        BadInput: the code has another form.
    """

    code: str
    make: Make | None = field(default=None, metadata={"in_files": False})
    PART: ClassVar[str]
    """In the station."""
    NEEDED: ClassVar[tuple[str, ...]]
    """Output ports that it must have."""
    APART: ClassVar[tuple[str, ...]] = ()
    """Input ports that the part of a station may have, but not one's own."""

    def __post_init__(self) -> None:
        file, _, name = self.code.rpartition(":")
        if self.make is None and not (file.endswith(".py") and name.isidentifier()):
            raise BadInput(f"own {self.PART}", at="code", found=repr(self.code), expected="FILE.py:CLASS")

    @classmethod
    def of(cls, part: str | Make) -> Self:
        """From `my.py:MyEstimator`, or from the class.

        Raises:
            BadInput: a text of another form.
        """
        return cls(part) if isinstance(part, str) else cls(getattr(part, "__qualname__", type(part).__name__), part)

    @property
    def called(self) -> str:
        """The name of the class."""
        return self.code.rpartition(":")[2]

    def made(self, step: float) -> System:
        """A new system, its ports checked.

        Args:
            step: of the fast path [s].

        Raises:
            BadInput: there is no such file or class, it raises, or a port is missing, unknown or of another size.
        """
        make = self._class() if self.make is None else self.make
        expected = f"{self.called}(period={step:g}) to be a Drake system"
        try:
            with own_code_named():
                system = make(period=step)
        except MmtError:
            raise
        except Exception as error:
            raise BadInput(self.code, found=f"{type(error).__name__}: {error}", expected=expected) from error
        if not isinstance(system, System):
            raise BadInput(self.code, found=type(system).__name__, expected=expected)
        self._check(system)
        return system

    def _class(self) -> Make:
        file, _, name = self.code.rpartition(":")
        make: Make | None = getattr(read_code(file, f"a Python file with a class {name}"), name, None)
        if not callable(make):
            raise BadInput(file, found=f"no {name}", expected=f"a class {name}")
        return make

    def _check(self, system: System) -> None:
        inputs, outputs = part_ports(self.PART)
        known: Mapping[str, int | None] = {name: size for name, size in inputs.items() if name not in self.APART}
        has: Mapping[str, int | None] = dict(map(_port, map(system.get_output_port, range(system.num_output_ports()))))
        for name in self.NEEDED:
            if name not in has:
                needed = _listed({name: outputs[name] for name in self.NEEDED})
                self._refuse(f"no output port {name} ({outputs[name]})", f"{needed} among its outputs")
        for name, size in has.items():
            if name in outputs and size != outputs[name]:
                self._refuse(f"output port {_listed({name: size})}", _listed({name: outputs[name]}))
        for name, size in map(_port, map(system.get_input_port, range(system.num_input_ports()))):
            if name not in known:
                self._refuse(f"input port {name}, which nothing feeds", f"no others than {_listed(known)}")
            if size != known[name]:
                self._refuse(f"input port {_listed({name: size})}", _listed({name: known[name]}))

    def _refuse(self, found: str, expected: str) -> None:
        raise BadInput(self.code, found=found, expected=f"{expected} (docs/own_parts.md)")


def part_ports(part: str) -> tuple[dict[str, int | None], dict[str, int]]:
    """The inputs that a part of a station is fed by, and its outputs that are recorded: name -> size.

    None is the size of a port for a `mmt_drake.cloud.Cloud`.
    """
    from mmt_drake.diagrams.stations.table import NETS, READS, RECORDED  # which imports the options

    own, sizes = f"{part}.", {signal.name: signal.size for signal in reversed(SIGNALS)}
    inputs = [name.removeprefix(own) for name in READS if name.startswith(own)]
    sources = ((signal, one) for signal, net in RECORDED.items() for one in NETS.get(net, net).split(" | "))
    outputs = {one.split()[0]: sizes[signal] for signal, one in sources if one.startswith(own)}
    return {name: INPUT_SIZES.get(name) for name in inputs}, {
        net.removeprefix(own): size for net, size in outputs.items()
    }


def _port(port: InputPort | OutputPort) -> tuple[str, int | None]:
    """Name and size."""
    return port.get_name(), None if port.get_data_type() == PortDataType.kAbstractValued else port.size()


def _listed(ports: Mapping[str, int | None]) -> str:
    return ", ".join(f"{name} ({'a Cloud' if size is None else size})" for name, size in ports.items())
