"""The signals of a recording: their columns, their topics, their messages.

One table holds every name that a recording may use (CONVENTIONS.md, "Recordings").
A *signal* is what one message carries; its *columns* are the message's numbers, one name each.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from mmt_drake.errors import BadInput, suggest
from mmt_drake.model.held_body import HELD_BODY
from mmt_drake.model.message_layout import MESSAGE
from mmt_drake.model.parameters import FORCE_LATENESS, SLIDING_THETA, TANGENTIAL_THETA, THETA, THETA_UNITS
from mmt_drake.model.scene_layout import COLOUR, PLACES, PLAIN_SCENE, SCENE, SCENE_UNITS

AXES = ("x", "y", "z")
ORIENTATION = tuple(f"orientation_{part}" for part in (*AXES, "w"))
"""Columns of the quaternion by which the probe is turned against the table."""

Kind = Literal["contact", "single_axis", "driven_body", "motion"]
# A scalar has its own unit, a number that of the recording, which is then of one axis or of a driven body.
Quantity = Literal["position", "velocity", "force", "orientation", "flag", "theta", "code", "scalar", "number"]

POSE = "geometry_msgs/msg/PoseStamped"
POINT = "geometry_msgs/msg/PointStamped"
QUATERNION = "geometry_msgs/msg/QuaternionStamped"
TWIST = "geometry_msgs/msg/TwistStamped"
WRENCH = "geometry_msgs/msg/WrenchStamped"
BOOL = "std_msgs/msg/Bool"
FLOAT = "std_msgs/msg/Float64"
ARRAY = "std_msgs/msg/Float64MultiArray"
CLOUD = "sensor_msgs/msg/PointCloud2"

CLOUD_TOPIC = "/cloud"

_UNIT_OF = {"position": "m", "velocity": "m/s", "force": "N", "stored_energy": "J", "lateness": "s", "camera_age": "s",
    "body_height": "m", "grip": "N", "grip_slipped": "m"}  # fmt: skip
"""By quantity, or by name."""


@dataclass(frozen=True)
class Signal:
    """The content of one topic.

    Attributes:
        name: base name of its columns, and its key in ``McapWriter.write_block``.
        topic: where it stands in a bag.
        msgtype: the ROS 2 message it is written as.
        columns: the recording's columns, in the order of the message's numbers.
        quantity: what it is; decides which messages are read and how clocks are matched.
    """

    name: str
    topic: str
    msgtype: str
    columns: tuple[str, ...]
    quantity: Quantity

    @property
    def size(self) -> int:
        """Number of its columns."""
        return len(self.columns)

    @property
    def units(self) -> tuple[str, ...]:
        """Of each column; empty for flags, codes and ratios, and for a driven body, whose unit is its own."""
        if self.name == "held_body":
            return ("m", "m", "s", "m", "m", "s", "s")
        if self.name in ("carried", "carried_deviation"):
            return tuple(_CARRIED_UNITS.get(column.rsplit("_", 1)[1], "") for column in self.columns)
        if self.name == "scene":
            return tuple(SCENE_UNITS[column.split("_", 2)[2]] for column in self.columns)
        if self.name in ("places", "surface_raised"):
            return ("m",) * self.size
        if self.name == "model":
            return tuple(THETA_UNITS.get(number.removeprefix("model_"), "") for number in self.columns)
        if self.name in ("force_lateness", "link_clock"):
            return ("s",) * self.size
        if self.quantity == "theta":
            numbers = (column.removeprefix("theta_").removeprefix("deviation_") for column in self.columns)
            return tuple(THETA_UNITS[number] for number in numbers)
        return (_UNIT_OF.get(self.quantity, _UNIT_OF.get(self.name, "")),) * self.size

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Columns of which a recording has all or none."""
        if self.name == "scene":  # of its rows the colours may be absent
            coloured = tuple(column for column in self.columns if column.endswith(COLOUR))
            return tuple(column for column in self.columns if column not in coloured), coloured
        # Of theta's ten, static friction may be absent, and with it the normal axis, each two together.
        return self.columns[:6], self.columns[6:8], self.columns[8:]

    @property
    def held(self) -> bool:
        """True if it keeps its value between messages (flags, theta, codes) instead of moving on linearly."""
        return self.quantity in ("flag", "theta", "code")


def _vector(name: str, topic: str, msgtype: str, quantity: Quantity) -> Signal:
    return Signal(name, topic, msgtype, tuple(f"{name}_{axis}" for axis in AXES), quantity)


def _scalar(name: str, topic: str, quantity: Quantity) -> Signal:
    return Signal(name, topic, BOOL if quantity == "flag" else FLOAT, (name,), quantity)


def _array(name: str, topic: str, numbers: Iterable[str]) -> Signal:
    return Signal(name, topic, ARRAY, tuple(f"{name}_{number}" for number in numbers), "theta")


CONDITIONS = ("current", "voltage", "tension", "pressure", "temperature")
"""Columns of whatever else was recorded beside a motion (`mmt_drake.over`), in the unit of the recording."""

LINK_CLOCKS = ("own", "peer_tick", "peer_sent", "arrived", "shown")
"""Time stamps of one end of a link: when its tick was due; of the newest sample of the peer when its tick was due, when
it was sent, and when it arrived; of which instant of the peer is shown. `own` and `arrived` are on this side's clock,
the others on the peer's."""

CARRIED = ("state", "m", "centre", "swing")
"""What becomes of an object in a grip, its mass, centre below the grip and damping ratio of its swing."""
_CARRIED_UNITS = {"m": "kg", "centre": "m"}

SIGNALS = (
    _vector("master_position", "/omega/pose", POSE, "position"),
    _vector("master_velocity", "/omega/twist", TWIST, "velocity"),
    _vector("position", "/telerobot/pose", POSE, "position"),
    _vector("velocity", "/telerobot/twist", TWIST, "velocity"),
    Signal("orientation", "/telerobot/orientation", QUATERNION, ORIENTATION, "orientation"),
    _vector("force", "/telerobot/wrench", WRENCH, "force"),
    _vector("command_force", "/telerobot/command", WRENCH, "force"),
    _vector("rendered_force", "/renderer/wrench", WRENCH, "force"),
    _scalar("in_contact", "/environment/in_contact", "flag"),
    _scalar("detected_contact", "/contact_detector/in_contact", "flag"),
    _scalar("operator_contact", "/operator_contact_detector/in_contact", "flag"),
    _scalar("renderer_status", "/renderer/status", "code"),
    _vector("update_jump", "/renderer/update_jump", WRENCH, "force"),
    _scalar("stored_energy", "/renderer/stored_energy", "scalar"),
    _array("theta", "/estimator/theta", THETA),
    _array("theta", "/estimator/theta", SLIDING_THETA),
    _array("theta", "/estimator/theta", TANGENTIAL_THETA),
    _scalar("theta_stable", "/estimator/stable", "flag"),
    _array("theta_deviation", "/estimator/deviation", THETA),
    _scalar("estimator_status", "/estimator/status", "code"),
    _scalar("model_status", "/estimator/model_status", "code"),
    _scalar("residual_ratio", "/estimator/residual_ratio", "scalar"),
    _array("force_lateness", "/estimator/force_lateness", FORCE_LATENESS),
    _array("model", "/estimator/model", MESSAGE),
    _scalar("learner_status", "/learner/status", "code"),
    _array("held_body", "/estimator/held_body", HELD_BODY),
    _vector("estimated_force", "/estimator/wrench", WRENCH, "force"),
    _vector("filtered_force", "/estimator/filtered_wrench", WRENCH, "force"),
    _vector("true_force", "/environment/wrench", WRENCH, "force"),
    Signal("body_position", "/environment/body", POINT, ("body_position_x", "body_position_y"), "position"),
    _array("carried", "/load_estimator/carried", CARRIED),
    _array("carried_deviation", "/load_estimator/deviation", CARRIED[1:]),
    _scalar("carried_status", "/load_estimator/status", "code"),
    _scalar("carries", "/renderer/carries", "flag"),
    _scalar("body_height", "/environment/body_height", "scalar"),
    _scalar("grip", "/omega/grip", "scalar"),
    _scalar("grip_holds", "/gripper/holds", "code"),
    _scalar("grip_slipped", "/gripper/slipped", "scalar"),
    _vector("proxy_position", "/contact_detector/proxy", POINT, "position"),
    _array("scene", "/scene/objects", SCENE),
    _array("scene", "/scene/objects", PLAIN_SCENE),
    _array("places", "/environment/places", PLACES),
    _scalar("told_thing", "/estimator/thing", "code"),
    _scalar("remembered", "/memory/remembered", "code"),
    _scalar("touched", "/environment/touched", "code"),
    _scalar("probe_zero", "/probe_compensation/zero", "code"),
    _array("surface_raised", "/touched_surface/raised", ("height", "deviation")),
    # A run in real time, and on devices.
    _vector("applied_force", "/omega/wrench", WRENCH, "force"),
    _scalar("safety_armed", "/safety/armed", "flag"),
    _scalar("safety_reason", "/safety/reason", "code"),
    _scalar("telerobot_fault", "/telerobot/fault", "code"),
    _scalar("telerobot_waits", "/telerobot/waits", "flag"),
    _scalar("peer_alive", "/link/alive", "flag"),
    _array("link_clock", "/link/clock", LINK_CLOCKS),
    _scalar("lateness", "/pacing/lateness", "scalar"),
    _scalar("overruns", "/pacing/overruns", "code"),
    _scalar("camera_fault", "/camera/fault", "code"),
    _scalar("camera_age", "/camera/age", "scalar"),
    _scalar("camera_lost", "/camera/lost", "code"),
    # One axis of a contact, and a driven body: plain numbers, in the unit of the recording.
    _scalar("position", "/probe/position", "number"),
    _scalar("velocity", "/probe/velocity", "number"),
    _scalar("force", "/probe/force", "number"),
    _scalar("input", "/driven_body/input", "number"),
    _scalar("output", "/driven_body/output", "number"),
    _scalar("output_rate", "/driven_body/output_rate", "number"),
    _scalar("load", "/driven_body/load", "number"),
    _scalar("goal", "/driven_body/goal", "number"),
    # What a number of a model may be over.
    *(_scalar(name, f"/condition/{name}", "number") for name in CONDITIONS),
)

UNITS = {column: unit for signal in SIGNALS for column, unit in zip(signal.columns, signal.units, strict=True)}
"""Column -> its unit, as of `Signal.units`."""

FLAGS = frozenset(signal.name for signal in SIGNALS if signal.quantity == "flag")
"""Columns of 0 and 1."""

HELD = frozenset(column for signal in SIGNALS if signal.held for column in signal.columns)
"""Columns that keep their value between messages, see `Signal.held`."""

_BY_SIZE = {(signal.name, signal.size): signal for signal in SIGNALS}

# What must be there, by kind. The first name is what the kind is recognised by.
REQUIRED: dict[Kind, tuple[str, ...]] = {
    "driven_body": ("input", "output"),
    "single_axis": ("position", "force"),
    "contact": tuple(f"{name}_{axis}" for name in ("position", "force") for axis in AXES),
    "motion": tuple(f"position_{axis}" for axis in AXES),
}
_OPTIONAL: dict[Kind, tuple[str, ...]] = {
    "driven_body": ("output_rate", "load", "goal", *CONDITIONS),
    "single_axis": ("velocity", "in_contact", *CONDITIONS),
}


def signal_of(name: str, size: int) -> Signal:
    """The signal of this base name and this number of columns.

    Raises:
        BadInput: there is none.
    """
    if (name, size) not in _BY_SIZE:
        sizes = [str(known.size) for known in SIGNALS if known.name == name]
        expected = f"size {' or '.join(sizes)}" if sizes else f"a known signal{suggest(name, signal_names())}"
        raise BadInput("signal", at=name, found=f"size {size}", expected=expected)
    return _BY_SIZE[name, size]


def signals_in(columns: Iterable[str]) -> list[Signal]:
    """The signals whose columns are all among these, no column twice."""
    left, found = set(columns), []
    for signal in SIGNALS:
        if left.issuperset(signal.columns):
            found.append(signal)
            left.difference_update(signal.columns)
    return found


def signal_names() -> list[str]:
    """The base names, each once."""
    return list(dict.fromkeys(signal.name for signal in SIGNALS))


def kind_of(columns: Iterable[str]) -> Kind:
    """The kind of recording that has these columns; one with none of the telling names counts as contact."""
    names = set(columns)
    if names & {"input", "output"}:
        return "driven_body"
    if names & {"position", "force"}:
        return "single_axis"
    if not any(name.startswith("force_") for name in names) and names.issuperset(REQUIRED["motion"]):
        return "motion"
    return "contact"


def columns_of(kind: Kind) -> tuple[str, ...]:
    """Every column, ``time`` apart, that a recording of this kind may have."""
    if kind in _OPTIONAL:
        return REQUIRED[kind] + _OPTIONAL[kind]
    return tuple(
        dict.fromkeys(column for signal in SIGNALS if signal.quantity != "number" for column in signal.columns)
    )
