"""Drake's `LeafSystem`, freed with its diagram though it is written in Python."""

from __future__ import annotations

import inspect
import weakref
from collections.abc import Callable
from typing import Any

from pydrake.common.value import AbstractValue
from pydrake.systems import framework
from pydrake.systems.framework import BasicVector, CacheIndex, Context, DependencyTicket, OutputPort, ValueProducer

Calc = Callable[[Context, Any], None]
Alloc = Callable[[], AbstractValue]


class _OneDict(type(framework.LeafSystem)):  # type: ignore[misc]
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
