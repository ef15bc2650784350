"""Laws that are added to a model: each compiled on its own, and called by the kernels through its address.

A kernel is compiled once. What is active in it stands in its parameter vector: for every law the slot, the address of
the compiled function and its numbers. So an effect costs nothing where it is absent and some 15 ns an evaluation where
it is there, a search over many effects compiles nothing, and a law from a user's own file is as good as one of the
package.

A law is a function of three tuples::

    @law(Slot.CONTACT)
    def cubic(at, q, p):
        return p[0] * at.d**3, 0.0, 0.0, 0.0

`at` (`At`) is what there is to know at an instant, `q` the law's own memory of two numbers, `p` its parameters. It
returns four numbers, whose meaning is that of the slot (`Slot`). A law that is alike in all directions of the plane
also reads what the other axis does (`in_plane`): of `at` what ends in `_across`, and that axis's memory, q[2] and q[3].
All of this is 0 where an axis is by itself.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from types import ModuleType
from typing import Any, NamedTuple

from llvmlite import ir
from numba import cfunc, njit, types
from numba.extending import intrinsic

Memory = tuple[float, float, float, float]
"""Of all laws on a body, or of all in a sensor."""
NOTHING = (0.0, 0.0, 0.0, 0.0)
"""An empty memory."""
Own = tuple[float, float, float, float]
"""q of a law: its own part of the memory, then the same of the other axis of the plane."""
Numbers = tuple[float, ...]
"""p of a law."""
Result = tuple[float, float, float, float]
LawFunction = Callable[["At", Own, Numbers], Result]

LAW_PARAMETERS = 6
OSCILLATION = 7.0
"""An oscillation wants steps this much finer than a decay of the same rate: a law reports its rate times this."""


class Slot(IntEnum):
    """The part of a model in which a law acts, and the meaning of the four numbers that it returns.

    - `DRIVE`: what drives a body in the place of its input, `at.force` [N]; the rest as in `BODY`. At most one, which
      comes before all others: their `at.force` is what it gives.
    - `BODY`: force on the body [N], counted along its motion; the rates of q[0] and q[1]; the fastest rate at which
      they decay now [1/s], which bounds the integration step (0 for a law without memory).
    - `CONTACT`: force of a further element beside the contact spring [N], counted along the deflection as that of the
      spring is; the rest as in `BODY`. Acts while the contact holds; its memory is emptied at each touch.
    - `FRICTION`: the level of friction [N] while sliding in `at.direction`, and the level that must be overcome to
      slide in that direction from rest [N]; 0, 0. Levels of several laws add up, together with the model's own. Where
      friction is a vector in the plane, `abs(at.v)` is the speed.
    - `INERTIA`: mass added to the body [kg]; 0, 0, 0.
    - `SENSOR`: what the force sensor reads instead of `at.force` [N]; the new q[0] and q[1]; 0. Called once a sample,
      with the velocity of the probe as `at.v`.
    """

    DRIVE = 0
    BODY = 1
    CONTACT = 2
    FRICTION = 3
    INERTIA = 4
    SENSOR = 5


class At(NamedTuple):
    """The knowledge of a law at an instant.

    Attributes:
        t: time since the first sample [s].
        x, v: displacement of the body and its velocity [m], [m/s] (in `kelvin_voigt`, and v in `SENSOR`: of the probe).
        d, d_rate: deflection of the contact spring and its rate [m], [m/s].
        load: normal load N [N].
        direction: of sliding, -1 or 1, or 0 if at rest.
        force: in `SENSOR`: the tangential force before the law; elsewhere what the input drives the body with [N].
        normal_force: in `SENSOR`: along the surface normal [N].
        h: in `SENSOR`: time since the previous sample [s], 0 at the first.
        v_across, d_across, d_rate_across: v, d and d_rate along the other axis of the plane; 0 where an axis is by
            itself.
    """

    t: float
    x: float
    v: float
    d: float
    d_rate: float
    load: float
    direction: float
    force: float
    normal_force: float
    h: float
    v_across: float = 0.0
    d_across: float = 0.0
    d_rate_across: float = 0.0


_kinds: Any = types
AT_TYPE = _kinds.NamedUniTuple(types.float64, len(At._fields), At)
OWN_TYPE = _kinds.UniTuple(types.float64, 4)
NUMBERS_TYPE = _kinds.UniTuple(types.float64, LAW_PARAMETERS)
RESULT_TYPE = _kinds.UniTuple(types.float64, 4)
_SIGNATURE = RESULT_TYPE(AT_TYPE, OWN_TYPE, NUMBERS_TYPE)


def _compiled(function: LawFunction) -> Any:
    return cfunc(_SIGNATURE, cache=True, error_model="numpy")(function)


@dataclass(frozen=True)
class Law:
    """A compiled law.

    Attributes:
        function: `(at, q, p) -> (4 numbers)`, in the part of Python that numba compiles.
        slot: where it acts.
        remembers: whether it uses its memory.
        order: of sensor laws: the lesser reads first.
        every_axis: of sensor laws: whether it reads the force along the surface normal as well.
        in_plane: of laws on a body: whether it reads what the other axis of the plane does.
        stored: the energy that it holds [J], of the same arguments, and 0, 0, 0; None: it holds none.
    """

    function: LawFunction
    slot: Slot
    remembers: bool = False
    order: int = 0
    every_axis: bool = False
    in_plane: bool = False
    stored: LawFunction | None = None

    @cached_property
    def _compiled(self) -> Any:
        return _compiled(self.function)

    @cached_property
    def _compiled_stored(self) -> Any:
        return None if self.stored is None else _compiled(self.stored)

    @property
    def address(self) -> int:
        """Of the machine code, in this process; compiled at first use and cached on disk."""
        return int(self._compiled.address)

    @property
    def stored_address(self) -> int:
        """The same of what it holds in store; 0: it holds nothing."""
        return 0 if self._compiled_stored is None else int(self._compiled_stored.address)

    def __call__(self, at: At, q: Own, p: Numbers) -> Result:
        """The law in plain Python, for tests and tables."""
        return self.function(at, q, p)

    def __reduce__(self) -> tuple[Callable[[str, str, str], Law], tuple[str, str, str]]:
        """Laws travel between processes by name; machine code stays where it is."""
        return find_law, (self.function.__module__, self.function.__qualname__, inspect.getfile(self.function))


def find_law(module: str, name: str, path: str) -> Law:
    """The law that a module holds under a name; a module that cannot be imported by its name is read from its file."""
    if module not in sys.modules and importlib.util.find_spec(module.partition(".")[0]) is None:
        load_file(module, path)
    found: Law = getattr(importlib.import_module(module), name)
    return found


def load_file(module: str, path: str) -> ModuleType:
    """Import a Python file under a name of its own."""
    spec = importlib.util.spec_from_file_location(module, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is no Python file")
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[module] = loaded
    try:
        spec.loader.exec_module(loaded)
    except BaseException:
        del sys.modules[module]
        raise
    return loaded


def law(
    slot: Slot,
    *,
    remembers: bool = False,
    order: int = 0,
    every_axis: bool = False,
    in_plane: bool = False,
    stored: LawFunction | None = None,
) -> Callable[[LawFunction], Law]:
    """Decorator: make a function the law of an effect; arguments as the attributes of `Law`."""
    return lambda function: Law(function, slot, remembers, order, every_axis, in_plane, stored)


_SOONER_OR_LATER = (0.0, 0.1, 1.0, 10.0, 100.0)  # [s]


@dataclass(frozen=True)
class ActiveLaw:
    """A law with its numbers in a model.

    Attributes:
        law: what is computed.
        values: p of the law, at most LAW_PARAMETERS numbers.
        stiffness, damping: what it adds at most to the body's stiffness [N/m] and damping [N s/m]; integration
            steps are chosen by it.
        lightens: what it takes at most from the body's mass [kg].
        curve: knots (x, y) of a curve that the law reads with `curve_at`, x increasing; or none. It stands at the
            end of the kernel vector, and the law finds its address in p[CURVE] and its length in p[CURVE_LENGTH].
    """

    law: Law
    values: tuple[float, ...]
    stiffness: float = 0.0
    damping: float = 0.0
    lightens: float = 0.0
    curve: tuple[tuple[float, float], ...] = ()

    @property
    def pushes_at_rest(self) -> bool:
        """Whether it pushes, sooner or later, a body at rest under a load, its spring without deflection.

        One with a curve may, and one that is not defined there.
        """
        if self.law.slot in (Slot.FRICTION, Slot.INERTIA, Slot.SENSOR):
            return False
        if self.curve:  # which stands in a kernel vector: a call without one would read anywhere
            return True
        p = (*self.values, *(0.0 for _ in range(LAW_PARAMETERS - len(self.values))))
        rest = At(**(dict.fromkeys(At._fields, 0.0) | {"load": 1.0}))
        try:
            return any(self.law(rest._replace(t=t), NOTHING, p)[0] != 0.0 for t in _SOONER_OR_LATER)
        except (ArithmeticError, ValueError):
            return True


MOST_REMEMBERING = 2
"""Laws with memory that a body can have, and that a sensor can have."""

CURVE_LENGTH, CURVE = LAW_PARAMETERS - 2, LAW_PARAMETERS - 1


def _typed_number_at(typingctx: Any, address: Any, index: Any) -> Any:
    """The number at an index of an array that begins at an address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        start = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        return builder.load(builder.gep(start, [arguments[1]]))

    return types.float64(types.int64, types.int64), codegen


number_at: Any = intrinsic(_typed_number_at)


@njit(error_model="numpy", forceinline=True)
def norm(along: float, across: float) -> float:
    """Of a vector in the plane, not 0 where squares underflow; `math.hypot` takes ten times as long."""
    return max(math.sqrt(along * along + across * across), abs(along), abs(across))


@njit(error_model="numpy")
def curve_at(x: float, p: Numbers) -> float:
    """The law's curve at x: linear between the knots, held beyond the first and the last."""
    n, address = int(p[CURVE_LENGTH]), int(p[CURVE])
    low, high = 0, n - 1
    if x <= number_at(address, low):
        return number_at(address, n)
    if x >= number_at(address, high):
        return number_at(address, n + high)
    while high - low > 1:
        middle = (low + high) // 2
        if number_at(address, middle) <= x:
            low = middle
        else:
            high = middle
    x0, y0 = number_at(address, low), number_at(address, n + low)
    slope = (number_at(address, n + high) - y0) / (number_at(address, high) - x0)
    return y0 + slope * (x - x0)
