"""A force read off a table over one signal: the shape of a mismatch that repeats and has no name.

`at` are increasing values of the signal, `value` as many forces [N]; linear between them, held beyond the first and the
last. Where the force acts depends on the signal that it is `of`:

- `sliding_velocity` [m/s]: on the body, against its motion as friction is: F = -value(v), in the plane over the speed;
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

from mmt_drake.effects.effect import Effect, Parameter, Values
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import ActiveLaw, At, Law, Numbers, Own, Result, Slot, curve_at, law, norm
from mmt_drake.model.structure import Structure

# The first parameter of these laws is the index of the signal in `At`.


@law(Slot.BODY, in_plane=True)
def _against_motion(at: At, q: Own, p: Numbers) -> Result:
    if at.v_across == 0.0:
        return -curve_at(at.v, p), 0.0, 0.0, 0.0
    speed = norm(at.v, at.v_across)
    # What is the same forth and back has no direction: it stays with its axis.
    odd = 0.5 * (curve_at(speed, p) - curve_at(-speed, p))
    even = 0.5 * (curve_at(at.v, p) + curve_at(-at.v, p))
    return -(odd * at.v / speed + even), 0.0, 0.0, 0.0


@law(Slot.BODY)
def _against(at: At, q: Own, p: Numbers) -> Result:
    return -curve_at(at[int(p[0])], p), 0.0, 0.0, 0.0


@law(Slot.FRICTION)
def _level(at: At, q: Own, p: Numbers) -> Result:
    level = curve_at(at[int(p[0])], p)
    return level, level, 0.0, 0.0


@law(Slot.CONTACT)
def _in_contact(at: At, q: Own, p: Numbers) -> Result:
    return curve_at(at[int(p[0])], p), 0.0, 0.0, 0.0


@law(Slot.CONTACT)
def _stiffness(at: At, q: Own, p: Numbers) -> Result:
    return at.d * curve_at(at[int(p[0])], p), 0.0, 0.0, 0.0


@law(Slot.SENSOR, order=1)
def _in_reading(at: At, q: Own, p: Numbers) -> Result:
    return at.force + curve_at(at[int(p[0])], p), q[0], q[1], 0.0


class TableSignal(NamedTuple):
    """A signal that a table may be over.

    Attributes:
        block: where its force acts.
        law: of the force.
        over: the signal, as tracks call it.
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
    "sliding_velocity": TableSignal("friction", _against_motion, "sliding_velocity", damping=1.0),
    "load": TableSignal("friction", _level, "load", level=True),
    "friction_over_time": TableSignal("friction", _level, "time", level=True),
    "friction_over_position": TableSignal("friction", _level, "position", level=True),
    "deflection": TableSignal("contact", _in_contact, "deflection", stiffness=1.0),
    "deflection_rate": TableSignal("contact", _in_contact, "deflection_rate", damping=1.0),
    "stiffness_over_time": TableSignal("contact", _stiffness, "time", unit="N/m"),
    "stiffness_over_load": TableSignal("contact", _stiffness, "load", unit="N/m"),
    "position": TableSignal("body", _against, "position", stiffness=1.0),
    "time": TableSignal("force_sensor", _in_reading, "time"),
    "force": TableSignal("force_sensor", _in_reading, "force"),
    "normal_force": TableSignal("force_sensor", _in_reading, "normal_force"),
}
_IN_AT = {"sliding_velocity": "v", "time": "t", "position": "x", "deflection": "d", "deflection_rate": "d_rate"}


def _apply(model: Structure, values: Values) -> Structure:
    at, value, signal = values["at"], values["value"], SIGNALS[values["of"]]
    knots = tuple(zip(at, value, strict=True))
    steepest = max(abs(y1 - y0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(knots))
    stiffness = max(map(abs, value)) if signal.unit == "N/m" else signal.stiffness * steepest
    index = float(At._fields.index(_IN_AT.get(signal.over, signal.over)))
    return model.with_law(ActiveLaw(signal.law, (index,), stiffness, signal.damping * steepest, curve=knots))


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
    block_of=lambda values: SIGNALS[values["of"]].block,
    starts=lambda scales: [],  # learned, not searched for
)
