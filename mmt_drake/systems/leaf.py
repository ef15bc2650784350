"""Drake's `LeafSystem`, freed with its diagram though it is written in Python."""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable, Collection
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems import framework
from pydrake.systems.framework import (
    BasicVector,
    CacheIndex,
    Context,
    DependencyTicket,
    InputPort,
    OutputPort,
    ValueProducer,
)

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model.parameters import FORCE_LATENESS, THETA
from mmt_drake.model.scene_layout import SCENE_SIZE

INPUT_SIZES = {
    "motion": 6, "hand": 6, "commanded": 6, "intended": 6, "measurement": 9, "raw_measurement": 9, "position": 3,
    "clearance": 1, "force": 3, "command": 3, "remote_force": 3, "remote_energy": 3, "reading": 3, "rendered_force": 3,
    "load": 1, "in_contact": 1, "contact": 1, "proxy": 3, "normal": 3, "body": 4, "body_position": 2,
    "held_body": HELD_SIZE, "theta": len(THETA), "stable": 1, "model_status": 1, "high_band": 3, "stamp": 1, "input": 1,
    "device": 3, "switches": 2, "status": 6, "age": 1, "sent_age": 1, "camera": 3, "estimated_force": 3,
    "true_force": 3, "filtered_force": 3, "facet": 4, "model": MESSAGE_SIZE,
    "residual_ratio": 1, "learner_status": 1, "grip": 1, "held": 4, "carried": 5, "scene": SCENE_SIZE, "thing": 1,
    "told_thing": 1, "force_lateness": len(FORCE_LATENESS),
}  # fmt: skip
"""Sizes of the vector inputs that are the same wherever they stand; their meaning is in CONVENTIONS.md."""

Calc = Callable[[Context, Any], None]
Alloc = Callable[[], AbstractValue]


class _OneDict(type(framework.LeafSystem)):  # type: ignore[misc]  # pybind11's metaclass, which has no name
    """Classes without a second `__dict__`.

    Drake's classes have one that Python 3.11 does not know of. To a class without `__slots__` it adds another at the
    same place, so that its collector finds what stands there twice, takes the counts for wrong, and never frees a
    circle through it: a system and a port of it, say, and with them the diagram and all that it holds.
    """

    def __new__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> _OneDict:
        return super().__new__(cls, name, bases, {"__slots__": (), **namespace})


class LeafSystem(framework.LeafSystem, metaclass=_OneDict):
    """Drake's, and what computes an output or a cache entry holds it weakly where that is a method of its own.

    Drake keeps these functions where Python's collector does not look. One that holds the system, or a port of it, in
    another way keeps it for ever: a function within `__init__` that uses `self`, say. (Of events Drake takes care.)
    Another base beside this one has to say `__slots__ = ()`.
    """

    def __init__(self) -> None:
        super().__init__()
        self._reads: dict[str, Callable[[Context], Any]] = {}

    def declare_inputs(self, *names: str, optional: Collection[str] = (), **sizes: int) -> tuple[InputPort, ...]:
        """Declare inputs, which `inputs_at` reads.

        Args:
            names: of `INPUT_SIZES`, or `point_cloud`.
            optional: those of them that may stay unconnected.
            sizes: name -> size of further ones; one of size 0 is left out.

        Returns:
            The ports that were declared.
        """
        ports = []
        for name, size in ({name: INPUT_SIZES.get(name) for name in names} | sizes).items():
            if size == 0:
                self._reads[name] = _nothing
                continue
            if size is None:
                port = self.DeclareAbstractInputPort(name, AbstractValue.Make(Cloud.empty()))
            else:
                port = self.DeclareVectorInputPort(name, size)
            self._reads[name] = _if_connected(port) if name in optional else port.Eval
            ports.append(port)
        return tuple(ports)

    def take_as_connected(self, port: InputPort) -> None:
        """Say once, when the diagram is built, that an optional input is connected: it is then no longer asked for."""
        self._reads[port.get_name()] = port.Eval

    def inputs_at(self, context: Context) -> list[Any]:
        """Values of all inputs in their order; None of one that is left out, or not connected."""
        return [read(context) for read in self._reads.values()]

    def tickets(self, inputs: Collection[str]) -> set[DependencyTicket]:
        """Those of time and of the inputs of these names that there are."""
        ports = (self.GetInputPort(name) for name in inputs if self.HasInputPort(name))
        return {self.time_ticket(), *(port.ticket() for port in ports)}

    def declare_function(self, name: str, size: int, function: Callable[..., Any]) -> None:
        """Declare an output that is a function of time and all inputs: function(t, *inputs), a number or a vector.

        Raises:
            BadInput: as it runs: the function returns another number of numbers.
        """
        held = self._weak(function)
        owner: Callable[[], Any] = weakref.ref(self)

        def calc(context: Context, output: BasicVector) -> None:
            system = owner()
            value = np.atleast_1d(held(context.get_time(), *system.inputs_at(context)))
            if value.shape != (size,):
                found = f"{value.size} numbers of shape {value.shape}"
                raise BadInput(type(system).__name__, at=name, found=found, expected=f"{size} numbers in a row")
            output.SetFromVector(value)

        self.DeclareVectorOutputPort(name, size, calc, self.tickets(self._reads))

    def DeclareVectorOutputPort(  # noqa: N802
        self, name: str, model: int | BasicVector, calc: Calc, *args: Any, **kwargs: Any
    ) -> OutputPort:
        """As Drake's."""
        return super().DeclareVectorOutputPort(name, model, self._weak(calc), *args, **kwargs)

    def DeclareAbstractOutputPort(  # noqa: N802
        self, name: str, alloc: Alloc, calc: Calc, *args: Any, **kwargs: Any
    ) -> OutputPort:
        """As Drake's."""
        return super().DeclareAbstractOutputPort(name, self._weak(alloc), self._weak(calc), *args, **kwargs)

    def declare_cached(self, name: str, alloc: Alloc, calc: Calc, sources: set[DependencyTicket]) -> Cached:
        """Drake's `DeclareCacheEntry` of what `calc` computes from `sources`."""
        producer = ValueProducer(self._weak(alloc), self._weak(calc))
        return Cached(self, self.DeclareCacheEntry(name, producer, sources).cache_index())

    def _weak(self, function: Callable[..., Any]) -> Callable[..., Any]:
        if not inspect.ismethod(function) or function.__self__ is not self:
            return function
        method, system = function.__func__, weakref.ref(self)
        return lambda *args: method(system(), *args)


def _nothing(context: Context) -> None:
    """The value of an input that is not there."""


def _if_connected(port: InputPort) -> Callable[[Context], Any]:
    return lambda context: port.Eval(context) if port.HasValue(context) else None


class Cached:
    """A cache entry of a system, which Drake's own `CacheEntry` would keep for ever."""

    def __init__(self, system: LeafSystem, index: CacheIndex) -> None:
        self._system: Callable[[], Any] = weakref.ref(system)
        self._index = index

    def Eval(self, context: Context) -> Any:  # noqa: N802
        """Its value, as Drake's."""
        return self._system().get_cache_entry(self._index).Eval(context)

    def ticket(self) -> DependencyTicket:
        """What depends on it says so by this."""
        return self._system().cache_entry_ticket(self._index)
