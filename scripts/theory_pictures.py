"""The picture of an effect: its own curve, and what it does to a response, each with and without it.

Nothing is drawn from a formula: both panels are short simulations by the compiled kernels, so that a picture shows what
a fit and `simulate` compute.
"""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator

from mmt_drake.analysis.plotting import BLUE, GREY, in_style
from mmt_drake.effects.effect import Effect, Scales, Values
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Structure
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed

BOX: Final = FlexibleBoxModel(BoxParameters(m=0.8, k1=0.0, k2=400.0, b1=5.0, b2=20.0, Fc=0.3), NormalContact(600, 20))
SPRING: Final = KelvinVoigt(k=400.0, b=6.0)
SLIDER: Final = KelvinVoigt(b=5.0).with_value("Fc", 0.3)
BODY: Final = DrivenBodyModel(m=0.8, b=5.0, k=60.0, Fc=0.3)
GEARS: Final = TransmissionModel(ratio=0.5)

#: Parameters that a person would notice in these models; of any other effect the first start of a search is taken.
SHOWN: Final[Mapping[str, Values]] = {
    "viscous_friction": {"b": 9.0},
    "asymmetric_viscous_friction": {"b_plus": 20.0, "b_minus": 8.0},
    "coulomb_friction": {"Fc": 0.5},
    "asymmetric_friction": {"Fc_plus": 1.2, "Fc_minus": 0.6},
    "static_friction": {"Fs": 1.2, "Fd": 0.5, "v_d": 0.004},
    "stribeck_friction": {"Fs": 1.2, "v_s": 0.05},
    "presliding_friction": {"sigma0": 300.0},
    "load_dependent_friction": {"mu": 0.2},
    "smooth_coulomb_friction": {"Fc": 0.6, "v_s": 0.05},
    "dahl_friction": {"Fc": 0.6, "sigma": 200.0},
    "elastoplastic_play": {"Fc": 0.6, "k": 200.0, "gap": 0.006},
    "quadratic_drag": {"c": 30.0},
    "nonlinear_stiffness": {"k3": 3e6},
    "hunt_crossley_damping": {"lambda": 200.0},
    "viscoelastic_relaxation": {"k_maxwell": 300.0, "tau": 0.1},
    "hardening_relaxation": {"k3_maxwell": 3e6, "tau": 0.1},
    "hysteresis": {"alpha": 300.0, "beta": 150.0},
    "contact_gap": {"gap": 0.008},
    "stiffness_drift": {"rate": 0.25},
    "stiffness_step": {"time": 1.3, "loss": 0.5},
    "power_law_stiffness": {"k": 8500.0, "p": 1.5},
    "normal_nonlinear_stiffness": {"k3": 2e7},
    "normal_hunt_crossley_damping": {"lambda": 400.0},
    "normal_viscoelastic_relaxation": {"k_maxwell": 600.0, "tau": 0.1},
    "normal_hardening_relaxation": {"k3_maxwell": 3e7, "tau": 0.1},
    "normal_hysteresis": {"alpha": 400.0, "beta": 500.0},
    "normal_stiffness_drift": {"rate": 0.25},
    "constant_force": {"F": 0.8},
    "ground_spring": {"k": 60.0},
    "mass_change": {"time": 1.3, "dm": 0.8},
    "second_mode": {"m2": 0.3, "k": 120.0, "b": 0.6},
    "end_stop": {"position": 0.012, "stiffness": 800.0},
    "gravity_offset": {"angle": 0.3},
    "torque_ripple": {"amplitude": 0.5, "period": 0.01, "phase": 0.0},
    "force_bias": {"bias": 0.5},
    "force_drift": {"rate": 0.3},
    "force_lag": {"tau": 0.03},
    "force_crosstalk": {"gain": 0.2},
    "force_saturation": {"limit": 1.5},
    "periodic_disturbance": {"amplitude": 0.3, "frequency": 6.0, "phase": 0.0},
    "time_delay": {"delay": 0.03},
    "input_lag": {"tau": 0.03},
    "probe_slip": {"mu": 0.3},
    "surface_shape": {
        "x": (-0.03, 0.0, 0.03, 0.06), "y": (-0.03, 0.0, 0.03, 0.06),
        "height": (-0.003,) * 4 + (0.0,) * 4 + (-0.001,) * 4 + (-0.004,) * 4, "deviation": (1e-4,) * 16,
    },
    "stiffness_map": {
        "x": (-0.03, 0.03), "y": (-0.03, 0.0, 0.03, 0.06),
        "stiffness": (400.0,) * 4 + (900.0,) * 2 + (400.0,) * 2, "deviation": (20.0,) * 8,
    },
    "frame_misalignment": {"rx": 0.1, "ry": 0.0, "rz": 0.0},
    "tool_offset": {"x": 0.004, "y": 0.0, "z": 0.002},
    "gear_play": {"gap": 0.006},
    "dead_band": {"width": 0.8},
    "tabulated_force": {
        "of": "sliding_velocity", "at": (-0.2, -0.03, 0.03, 0.2), "value": (-0.6, -0.9, 0.9, 0.6),
    },
}  # fmt: skip
SCALES: Final = Scales(2.0, 0.1, 0.02, 0.01, 3.0, 0.8, 400.0, 4.0, 3.2, 1e-3)
"""Of the simulations below."""

# Text stays text, names of elements and the points of a line are the same every time.
_SVG: Final = {"svg.fonttype": "none", "svg.hashsalt": "theory", "path.simplify": False}

STEP_S: Final = 1e-3
EVERY: Final = 12  # samples from one point of a line to the next
TIME: Final[Array] = np.arange(3201, dtype=np.float64) * STEP_S

# Strokes and dwells, the probe lifted off once and its pressure swelling.
_STROKES = PchipInterpolator(
    [0, 0.1, 0.4, 0.8, 1.0, 1.3, 1.6, 1.9, 2.05, 2.2, 2.35, 2.8, 3.2],
    [0, 0.0, 0.04, 0.04, -0.02, -0.02, 0.03, 0.03, 0.0, 0.025, -0.01, 0.03, 0.03],
)
_HEIGHT = PchipInterpolator(
    [0, 0.6, 1.2, 1.8, 1.9, 2.0, 2.1, 3.2], [-4e-3, -7e-3, -3e-3, -6e-3, 2e-3, 2e-3, -5e-3, -3e-3]
)


@dataclass(frozen=True)
class Picture:
    """A drawing and what it shows.

    Attributes:
        svg: the drawing, text of an SVG file.
        caption: in one line, with the parameters.
    """

    svg: str
    caption: str


@dataclass(frozen=True)
class _Panel:
    """What one panel shows: a model, what it is driven with, what is drawn over what."""

    model: Structure
    recording: Recording
    curve: Callable[[Recording, Mapping[str, Array]], tuple[Array, Array]]
    across: str
    up: str
    shows: str


def picture(effect: Effect) -> Picture | None:
    """The picture of an effect; None for one that cannot be shown, without parameters here and without starts.

    Raises:
        BadInput: the effect refuses these models or its own starts.
    """
    values = SHOWN.get(effect.name) or next(iter(effect.starts(SCALES)), None)
    if values is None:
        return None
    single = {symbol: value for symbol, value in values.items() if not isinstance(value, str | tuple | list)}
    units = {parameter.symbol: parameter.unit for parameter in effect.parameters}
    units |= {symbol: "" for symbol, unit in units.items() if unit == "1"}
    numbers = ", ".join(f"{symbol} = {value:g} {units[symbol]}".rstrip() for symbol, value in single.items())
    block = effect.block if effect.block_of is None else effect.block_of(values)
    in_a_box = block in BOX.BLOCKS and set(effect.needs) <= {"normal_k"} and not effect.only_in
    if effect.name in _ON_SURFACE:
        panels = [*_ON_SURFACE[effect.name]]
    elif effect.axis == "z":
        panels = [_DEPTH, _PRESSED]
    else:
        panels = [_CURVES[block], _RESPONSE] if in_a_box else [_GEARS if "ratio" in effect.needs else _PENDULUM]
    sides = ("Left: ", "Right: ") if len(panels) > 1 else ("Shown: ",)
    shown = " ".join(f"{side}{panel.shows}." for side, panel in zip(sides, panels, strict=True))
    caption = f"Grey without, blue with {numbers or 'such a table'}. {shown}"
    with in_style(**_SVG):
        return Picture(_svg(_drawn(effect, values, panels)), caption)


def _answer(model: Structure, recording: Recording) -> Mapping[str, Array]:
    """What `replayed` gives; a single axis is pressed with a load that swells, which no recording of one axis has."""
    if not isinstance(model, KelvinVoigt):
        return replayed(model, recording)
    force, load = np.empty(len(recording)), 2.5 + 1.5 * np.sin(4.0 * recording.time)
    kelvin_voigt.replay(
        recording.time, recording["position"], recording["velocity"], load, model.kernel_vector(), force
    )
    return {"force": force}


def _drawn(effect: Effect, values: Values, panels: Sequence[_Panel]) -> Figure:
    figure = Figure(figsize=(7.2, 2.5))
    figure.subplots_adjust(left=0.085, right=0.99, top=0.96, bottom=0.19, wspace=0.22)
    axes: list[Axes] = list(figure.subplots(1, len(panels), width_ratios=[1.0, 1.5][: len(panels)], squeeze=False)[0])
    for axis, panel in zip(axes, panels, strict=True):
        with_it = effect.apply(panel.model, effect.checked(values, panel.model, effect.name))
        for model, color, width in ((panel.model, GREY, 1.8), (with_it, BLUE, 1.2)):
            x, y = panel.curve(panel.recording, _answer(model, panel.recording))
            axis.plot(x[::EVERY], y[::EVERY], color=color, linewidth=width)
        axis.set_xlabel(panel.across)
        axis.set_ylabel(panel.up)
    return figure


def _svg(figure: Figure) -> str:
    """The figure as SVG that is the same text every time, coordinates to a tenth of a point."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = re.sub(r"\d+\.\d{2,}", lambda number: f"{float(number[0]):.1f}".removesuffix(".0"), buffer.getvalue())
    return re.sub(r"[ \t]+\n", "\n", text)


def _strokes() -> Recording:
    """The probe on a flexible box."""
    columns = {"position_x": 0.0 * TIME, "position_y": _STROKES(TIME), "position_z": _HEIGHT(TIME)}
    columns |= {"velocity_x": 0.0 * TIME, "velocity_y": _STROKES(TIME, 1), "velocity_z": _HEIGHT(TIME, 1)}
    half = 0.15 * np.sin(5.0 * TIME)  # the hand nods about y
    columns |= dict.fromkeys(("orientation_x", "orientation_z"), 0.0 * TIME)
    columns |= {"orientation_y": np.sin(half), "orientation_w": np.cos(half)}
    return Recording(TIME, columns | {f"force_{axis}": 0.0 * TIME for axis in "xyz"}, "strokes")


def _swings(amplitude: float) -> Recording:
    """One axis that swings to and fro, further and further [m]."""
    omega, growth = 2.0 * np.pi / 0.8, amplitude / TIME[-1]
    position = growth * TIME * np.sin(omega * TIME)
    velocity = growth * (np.sin(omega * TIME) + omega * TIME * np.cos(omega * TIME))
    return Recording(TIME, {"position": position, "velocity": velocity, "force": 0.0 * TIME}, "swings")


def _turns(amplitude: float) -> Recording:
    """The input of a transmission that swings as the axis of `_swings` does [m]."""
    swung = _swings(amplitude)["position"]
    return Recording(TIME, {"input": swung, "output": 0.0 * TIME}, "turns")


def _pushes() -> Recording:
    """A driven body pushed as the probe moves."""
    return Recording(TIME, {"input": 60.0 * _STROKES(TIME), "output": 0.0 * TIME}, "pushes")


def _over_time(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return recording.time, answer["force_y"]


def _along(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return 1e3 * recording["position_y"], answer["force_y"]


def _pressed(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return recording.time, answer["force_z"]


def _over_depth(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    touching = recording["position_z"] < 0.0
    return -1e3 * recording["position_z"][touching], answer["force_z"][touching]


def _over_velocity(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return recording["velocity"], -answer["force"]


def _over_position(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return 1e3 * recording["position"], -answer["force"]


def _output(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return recording.time, 1e3 * answer["output"]


def _over_input(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return 1e3 * recording["input"], 1e3 * answer["output"]


def _over_true_force(recording: Recording, answer: Mapping[str, Array]) -> tuple[Array, Array]:
    return replayed(BOX, recording)["force_y"], answer["force_y"]


_RESPONSE: Final = _Panel(
    BOX, _strokes(), _over_time, "time [s]", "force on the probe [N]",
    "the probe strokes and dwells on a flexible box, lifted off from 1.9 to 2.1 s",
)  # fmt: skip
_PRESSED: Final = _Panel(
    BOX, _strokes(), _pressed, "time [s]", "normal force [N]",
    "the probe presses on a flexible box, lifted off from 1.9 to 2.1 s",
)  # fmt: skip
_DEPTH: Final = _Panel(
    BOX, _strokes(), _over_depth, "depth [mm]", "normal force [N]", "the normal force over the depth of these presses",
)  # fmt: skip
_TIP: Final = SurfaceContact(k=400.0, b=6.0)
_ACROSS: Final = _Panel(
    _TIP, _strokes(), _along, "along the surface [mm]", "tangential force [N]",
    "a tip strokes over a surface on which it glides freely, the tangential force over the way",
)  # fmt: skip
_RIDGE: Final = _Panel(
    _TIP, _strokes(), _over_time, "time [s]", "tangential force [N]",
    "the same over time, lifted off from 1.9 to 2.1 s",
)  # fmt: skip
_PRESSES: Final = _Panel(
    _TIP, _strokes(), _pressed, "time [s]", "normal force [N]",
    "a tip strokes over a level surface while the hand nods by 17 degrees to each side",
)  # fmt: skip
_ON_SURFACE: Final = {
    "probe_slip": (_ACROSS, _RIDGE), "surface_shape": (_ACROSS, _RIDGE), "tool_offset": (_PRESSES,),
    "stiffness_map": (_PRESSES,),
}  # fmt: skip
_SENSOR: Final = _Panel(
    BOX, _strokes(), _over_true_force, "true force [N]", "recorded force [N]", "what is recorded of a force",
)  # fmt: skip
_PENDULUM: Final = _Panel(
    replace(BODY, gravity=Gravity("pendulum", 4.0)), _pushes(), _output, "time [s]", "output [mm]",
    "a driven pendulum that is pushed to and fro",
)  # fmt: skip
_GEARS: Final = _Panel(
    GEARS, _turns(0.04), _over_input, "input [mm]", "output [mm]",
    "a transmission of ratio 0.5 whose input swings further and further, slowly",
)  # fmt: skip
_CURVES: Final = {
    "friction": _Panel(
        SLIDER, _swings(0.02), _over_velocity, "sliding velocity [m/s]", "friction [N]",
        "friction against a sliding velocity that is prescribed, so that nothing can stick",
    ),
    "contact": _Panel(
        SPRING, _swings(0.012), _over_position, "deflection [mm]", "contact force [N]",
        "the contact's force over a deflection that swings further and further",
    ),
    "body": _Panel(BODY, _pushes(), _output, "time [s]", "output [mm]", "a driven body that is pushed to and fro"),
    "force_sensor": _SENSOR,
    "channel": _SENSOR,
    "geometry": _SENSOR,
}  # fmt: skip
