"""A force read off a table over one signal: the shape of a mismatch that repeats and has no name.

`at` are increasing values of the signal, `value` as many forces [N]; linear between them, held beyond the first and the
last. Where the force acts depends on the signal that it is `of`:

- `sliding_velocity` [m/s]: on the body, against its motion as friction is: F = -value(v);
- `load` [N]: a level of friction value(N) >= 0 beside the structure's own, while sliding and to break away;
- `deflection` [m], `deflection_rate` [m/s]: in the contact, beside spring and damper, counted as theirs;
- `position` [m]: on the body, against its displacement as a spring to the world: F = -value(x);
- `time` [s], `force`, `normal_force` [N]: added to the recorded tangential force;
- `friction_over_time` [s], `friction_over_position` [m]: a level of friction as `load` is one;
- `stiffness_over_time` [s], `stiffness_over_load` [N]: value [N/m] times the deflection, in the contact.

It is learned where nothing in the library explains what is left.

Easily confused with:

- `stribeck_friction`: over `sliding_velocity` a table can draw its curve; the few numbers of a law with a name are to
  be preferred where they fit as well. Starts from rest tell them apart: a table does not stick.
- `nonlinear_stiffness`: over `deflection` a table can draw its curve; strokes beyond the table's ends tell them apart.
"""

from itertools import pairwise
from typing import NamedTuple

from mmt_drake.effects.effect import Effect, Parameter, Scales, Values
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import ActiveLaw, At, Law, Numbers, Own, Result, Slot, curve_at, law
from mmt_drake.model.structure import Structure


@law(Slot.BODY)
def _against_velocity(at: At, q: Own, p: Numbers) -> Result:
    return -curve_at(at.v, p), 0.0, 0.0, 0.0


@law(Slot.FRICTION)
def _friction_over_load(at: At, q: Own, p: Numbers) -> Result:
    level = curve_at(at.load, p)
    return level, level, 0.0, 0.0


@law(Slot.FRICTION)
def _friction_over_time(at: At, q: Own, p: Numbers) -> Result:
    level = curve_at(at.t, p)
    return level, level, 0.0, 0.0


@law(Slot.FRICTION)
def _friction_over_position(at: At, q: Own, p: Numbers) -> Result:
    level = curve_at(at.x, p)
    return level, level, 0.0, 0.0


@law(Slot.CONTACT)
def _stiffness_over_time(at: At, q: Own, p: Numbers) -> Result:
    return at.d * curve_at(at.t, p), 0.0, 0.0, 0.0


@law(Slot.CONTACT)
def _stiffness_over_load(at: At, q: Own, p: Numbers) -> Result:
    return at.d * curve_at(at.load, p), 0.0, 0.0, 0.0


@law(Slot.CONTACT)
def _with_deflection(at: At, q: Own, p: Numbers) -> Result:
    return curve_at(at.d, p), 0.0, 0.0, 0.0


@law(Slot.CONTACT)
def _with_deflection_rate(at: At, q: Own, p: Numbers) -> Result:
    return curve_at(at.d_rate, p), 0.0, 0.0, 0.0


@law(Slot.BODY)
def _against_position(at: At, q: Own, p: Numbers) -> Result:
    return -curve_at(at.x, p), 0.0, 0.0, 0.0


@law(Slot.SENSOR, order=1)
def _over_time(at: At, q: Own, p: Numbers) -> Result:
    return at.force + curve_at(at.t, p), q[0], q[1], 0.0


@law(Slot.SENSOR, order=1)
def _over_force(at: At, q: Own, p: Numbers) -> Result:
    return at.force + curve_at(at.force, p), q[0], q[1], 0.0


@law(Slot.SENSOR, order=1)
def _over_normal_force(at: At, q: Own, p: Numbers) -> Result:
    return at.force + curve_at(at.normal_force, p), q[0], q[1], 0.0


class TableSignal(NamedTuple):
    """What a table may be over.

    Attributes:
        block: where its force acts.
        law: of the force.
        over: the signal, as `At` and tracks call it.
        stiffness, damping: 1 if its slope is a stiffness or a damping of the body, else 0.
        level: whether its values are levels of friction, not below 0.
        unit: of its values.
    """

    block: str
    law: Law
    over: str
    stiffness: float = 0.0
    damping: float = 0.0
    level: bool = False
    unit: str = "N"


SIGNALS = {
    "sliding_velocity": TableSignal("friction", _against_velocity, "sliding_velocity", damping=1.0),
    "load": TableSignal("friction", _friction_over_load, "load", level=True),
    "friction_over_time": TableSignal("friction", _friction_over_time, "time", level=True),
    "friction_over_position": TableSignal("friction", _friction_over_position, "position", level=True),
    "deflection": TableSignal("contact", _with_deflection, "deflection", stiffness=1.0),
    "deflection_rate": TableSignal("contact", _with_deflection_rate, "deflection_rate", damping=1.0),
    "stiffness_over_time": TableSignal("contact", _stiffness_over_time, "time", unit="N/m"),
    "stiffness_over_load": TableSignal("contact", _stiffness_over_load, "load", unit="N/m"),
    "position": TableSignal("body", _against_position, "position", stiffness=1.0),
    "time": TableSignal("force_sensor", _over_time, "time"),
    "force": TableSignal("force_sensor", _over_force, "force"),
    "normal_force": TableSignal("force_sensor", _over_normal_force, "normal_force"),
}


def _apply(model: Structure, values: Values) -> Structure:
    at, value, signal = values["at"], values["value"], SIGNALS[values["of"]]
    knots = tuple(zip(at, value, strict=True))
    steepest = max(abs(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(knots))
    stiffness, damping = signal.stiffness * steepest, signal.damping * steepest
    if signal.unit == "N/m":
        stiffness = max(map(abs, value))
    return model.with_law(ActiveLaw(signal.law, (), stiffness, damping, curve=knots))


def _check(model: Structure, values: Values, source: str) -> None:
    at, value = values["at"], values["value"]
    if len(at) < 2:
        raise BadInput(source, at="at", found=f"{len(at)} values", expected="two or more")
    if len(value) != len(at):
        raise BadInput(source, at="value", found=f"{len(value)} values", expected=f"{len(at)}, as many as `at` has")
    for i, (low, high) in enumerate(pairwise(at)):
        if not low < high:
            raise BadInput(source, at=f"at[{i + 1}]", found=high, expected=f"more than {low!r} before it")
    if SIGNALS[values["of"]].level and min(value) < 0.0:
        raise BadInput(source, at="value", found=min(value), expected="levels of friction, not below 0 N")


def _no_starts(scales: Scales) -> list[Values]:
    return []  # learned, not searched for


def _block(values: Values) -> str:
    return SIGNALS[values["of"]].block


EFFECT = Effect(
    name="tabulated_force",
    block="any",
    parameters=(
        Parameter("of", "signal", vanishes_at="sliding_velocity", kind="choice", choices=tuple(SIGNALS)),
        Parameter("at", "unit of the signal", vanishes_at=(0.0, 1.0), kind="list"),
        Parameter("value", "N", vanishes_at=(0.0, 0.0), kind="list"),
    ),
    equation="a force read off a table over one signal, linear between its points, held at its ends",
    source="Masri and Caughey 1979, J. Applied Mechanics 46(2) (restoring-force surfaces)",
    change=_apply,
    check=_check,
    block_of=_block,
    starts=_no_starts,
)
