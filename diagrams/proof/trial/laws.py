"""The trial's effects by name: where each acts and what it changes in the plant or the sensor.

Names and parameters of the library's effects are those of the contract; the others are the trial's own, physically
plausible, and no effect of the library describes them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.sensor import Sensor

Values = Mapping[str, float]


@dataclass(frozen=True)
class Hidden:
    """Where an effect acts and what it does.

    Attributes:
        block: friction, contact, body, force_sensor, channel or geometry.
        plant: the physics with it, from the physics without it and its parameters.
        sensor: the same for the sensor chain.
        family: of laws of the library, of one outside it.
    """

    block: str
    plant: Callable[[Physics, Values], Physics] = lambda physics, values: physics
    sensor: Callable[[Sensor, Values], Sensor] = lambda sensor, values: sensor
    family: str = ""


@dataclass(frozen=True)
class Concealed:
    """An effect that is in a recording.

    Attributes:
        name: in `LAWS`.
        parameters: symbol -> value, SI units.
    """

    name: str
    parameters: Mapping[str, float]

    @property
    def block(self) -> str:
        """Where it acts."""
        return LAWS[self.name].block


def linear_object(base: Values) -> Physics:
    """The plant of a nominal model: `m k1 k2 b1 b2 Fc normal_k normal_b`, SI units."""
    b, Fc = base["b1"], base["Fc"]
    same = {name: base[name] for name in ("m", "k1", "k2", "b2", "normal_k", "normal_b")}
    return Physics(**same, b_plus=b, b_minus=b, Fd_plus=Fc, Fd_minus=Fc, Fs_plus=Fc, Fs_minus=Fc)


def with_effects(physics: Physics, sensor: Sensor, effects: tuple[Concealed, ...]) -> tuple[Physics, Sensor]:
    """Plant and sensor with these effects in them."""
    for effect in effects:
        law = LAWS[effect.name]
        physics, sensor = law.plant(physics, effect.parameters), law.sensor(sensor, effect.parameters)
    return physics, sensor


def _levels(physics: Physics, *, Fs_plus: float, Fs_minus: float, Fd_plus: float, Fd_minus: float) -> Physics:
    return physics._replace(Fs_plus=Fs_plus, Fs_minus=Fs_minus, Fd_plus=Fd_plus, Fd_minus=Fd_minus)


def _more_coulomb(physics: Physics, p: Values) -> Physics:
    Fc = physics.Fd_plus + p["Fc"]
    return _levels(physics, Fs_plus=Fc, Fs_minus=Fc, Fd_plus=Fc, Fd_minus=Fc)


def _karnopp(physics: Physics, p: Values) -> Physics:
    held = _levels(physics, Fs_plus=p["Fs"], Fs_minus=p["Fs"], Fd_plus=p["Fd"], Fd_minus=p["Fd"])
    return held._replace(v_d=p.get("v_d", 0.0))


def _bristles(physics: Physics, p: Values) -> Physics:
    Fs = p.get("Fs", physics.Fd_plus)
    physics = physics._replace(sigma0=p["sigma0"], sigma1=p.get("sigma1", 0.0), v_s=p.get("v_s", 0.0))
    return physics._replace(Fs_plus=Fs, Fs_minus=Fs)


def _bouc_wen(physics: Physics, p: Values) -> Physics:
    return physics._replace(alpha=p["alpha"], beta=p["beta"], gamma=p.get("gamma", p["beta"]))


def _set(**symbols: str) -> Callable[[Physics, Values], Physics]:
    """Plant fields -> the parameters that they are set to."""
    return lambda physics, p: physics._replace(**{field: p[symbol] for field, symbol in symbols.items()})


def _same(*symbols: str) -> Callable[[Physics, Values], Physics]:
    return _set(**{symbol: symbol for symbol in symbols})


def _reading(**symbols: str) -> Callable[[Sensor, Values], Sensor]:
    """Sensor fields -> the parameters that they are set to."""

    def changed(sensor: Sensor, p: Values) -> Sensor:
        fields: dict[str, Any] = {field: p[symbol] for field, symbol in symbols.items()}
        return replace(sensor, **fields)

    return changed


LAWS: Final[dict[str, Hidden]] = {
    "viscous_friction": Hidden(
        "friction", lambda s, p: s._replace(b_plus=s.b_plus + p["b"], b_minus=s.b_minus + p["b"])
    ),
    "asymmetric_viscous_friction": Hidden("friction", _same("b_plus", "b_minus")),
    "coulomb_friction": Hidden("friction", _more_coulomb),
    "asymmetric_friction": Hidden(
        "friction", _set(Fs_plus="Fc_plus", Fd_plus="Fc_plus", Fs_minus="Fc_minus", Fd_minus="Fc_minus")
    ),
    "static_friction": Hidden("friction", _karnopp),
    "stribeck_friction": Hidden("friction", _set(Fs_plus="Fs", Fs_minus="Fs", v_s="v_s")),
    "presliding_friction": Hidden("friction", _bristles),
    "load_dependent_friction": Hidden("friction", _same("mu")),
    "quadratic_drag": Hidden("friction", _same("c")),
    "nonlinear_stiffness": Hidden("contact", _same("k3")),
    "hunt_crossley_damping": Hidden("contact", _set(hunt_crossley="lambda")),
    "viscoelastic_relaxation": Hidden("contact", _same("k_maxwell", "tau")),
    "hysteresis": Hidden("contact", _bouc_wen),
    "contact_gap": Hidden("contact", _same("gap")),
    "stiffness_drift": Hidden("contact", _set(drift_rate="rate")),
    "stiffness_step": Hidden("contact", _set(step_loss="loss", step_time="time")),
    "constant_force": Hidden("body", lambda s, p: s._replace(F=s.F + p["F"])),
    "ground_spring": Hidden("body", lambda s, p: s._replace(k1=s.k1 + p["k"])),
    "mass_change": Hidden("body", _set(mass_time="time", dm="dm")),
    "second_mode": Hidden("body", _set(mode_m="m2", mode_k="k", mode_b="b")),
    "end_stop": Hidden("body", _set(stop_position="position", stop_stiffness="stiffness", stop_side="side")),
    "torque_ripple": Hidden("body", _set(ripple_F="amplitude", ripple_period="period", ripple_phase="phase")),
    "force_bias": Hidden("force_sensor", sensor=_reading(bias="bias")),
    "force_drift": Hidden("force_sensor", sensor=_reading(drift="rate")),
    "force_lag": Hidden("force_sensor", sensor=_reading(lag="tau")),
    "force_crosstalk": Hidden("force_sensor", sensor=_reading(crosstalk="gain")),
    "force_saturation": Hidden("force_sensor", sensor=_reading(limit="limit")),
    "periodic_disturbance": Hidden(
        "force_sensor", sensor=_reading(amplitude="amplitude", frequency="frequency", phase="phase")
    ),
    "tip_mass": Hidden("force_sensor", sensor=_reading(carried="m_tip")),
    "time_delay": Hidden("channel", sensor=_reading(delay="delay")),
    "frame_misalignment": Hidden("geometry", sensor=lambda s, p: replace(s, turn=(p["rx"], p["ry"], p["rz"]))),
    # Outside the library.
    "rough_patch": Hidden("friction", _set(patch_F="F", patch_from="from", patch_to="to"), family="dry_friction"),
    "ageing_friction": Hidden(
        "friction", _set(ageing_F="F", ageing_time="time", ageing_distance="distance"), family="dry_friction"
    ),
    "frictional_heating": Hidden("friction", _set(heat_power="power", heat_tau="tau"), family="dry_friction"),
    "run_in_softening": Hidden("contact", _set(run_in="loss", run_in_distance="distance"), family="contact_stiffness"),
    "load_stiffening": Hidden(
        "contact", _set(load_gain="gain", load_at="load", load_width="width"), family="contact_stiffness"
    ),
    "probe_slip": Hidden("contact", _set(slip_mu="mu"), family="dry_friction"),
    "loose_mass": Hidden(
        "body", _set(loose_m="m", loose_clearance="clearance", loose_restitution="restitution"), family="inertia"
    ),
    "table_vibration": Hidden("body", _set(table_amplitude="amplitude", table_from="frequency", table_rate="rate")),
    "sensor_play": Hidden("force_sensor", sensor=_reading(play="width")),
    "clock_drift": Hidden("channel", sensor=_reading(delay_rate="rate"), family="timing"),
    # What remains beneath an effect.
    "texture": Hidden("body", _set(texture_F="F", texture_length="length")),
    "wandering_friction": Hidden("friction", _set(wander_F="F", wander_period="period")),
    "flicker_noise": Hidden("force_sensor", sensor=_reading(flicker="amplitude", flicker_seed="seed")),
    "power_drag": Hidden("friction", _set(drag="c")),
    # Of a driven body alone, whose drive lags behind the command that a servo's log has (`one_axis`).
    "input_lag": Hidden("channel"),
    # Of a transmission alone, whose drive train is the plant's contact.
    "gear_play": Hidden("drive", _same("gap")),
    # Of a tip on a surface alone (`palpation`).
    "surface_shape": Hidden("geometry"),
    "stiffness_map": Hidden("contact"),
    "tool_offset": Hidden("geometry"),
    # Of a material alone, which has no plant.
    "hardening_relaxation": Hidden("contact"),
}
"""name -> law"""


OUTSIDE: Final[tuple[str, ...]] = tuple(LAWS)[list(LAWS).index("rough_patch") : list(LAWS).index("texture")]
"""Names of the effects that the library does not have."""

IN_TWO_DIRECTIONS: Final = ("frame_misalignment",)
"""Effects that only a probe shows in full which slides in two directions; none of them is one of a pair."""

INSIDE: Final[tuple[str, ...]] = tuple(LAWS)[: list(LAWS).index("rough_patch")]
"""Names of the library's effects that a flexible object can have concealed."""
