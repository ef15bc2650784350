"""What the contract test needs: signals for every port name of CONVENTIONS.md, and ways to run and compare systems."""

import dataclasses
import re
import sys
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import yaml
from numba.core.dispatcher import Dispatcher
from pydrake.common.value import AbstractValue
from pydrake.perception import PointCloud
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, LeafSystem, PortDataType, System

from mmt_drake.cloud import Cloud, plane
from mmt_drake.cloud.seen import UNCOLOURED
from mmt_drake.model.scene_layout import MOST, ROW, SeenState
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect

PERIOD = 1e-3
OMEGA = 2 * np.pi * 2.0


# ---------------------------------------------------------------------------------------------- signals by port name
def motion(t: float) -> np.ndarray:
    """(6,) a probe that comes down, slides 5 mm deep in the object, and lifts, every 0.25 s."""
    w = 2 * np.pi * 4.0
    position = [0.02 * np.sin(OMEGA * t), 0.03 * np.sin(0.7 * OMEGA * t), 0.005 * np.cos(w * t)]
    velocity = [0.02 * OMEGA * np.cos(OMEGA * t), 0.021 * OMEGA * np.cos(0.7 * OMEGA * t), -0.005 * w * np.sin(w * t)]
    return np.array(position + velocity)


def force(t: float) -> np.ndarray:
    """(3,) of the size that such a motion meets."""
    return np.array([np.sin(3 * t), -2 * np.cos(5 * t), 1 + np.sin(11 * t)])


def flag(t: float) -> np.ndarray:
    """(1,) true in contact."""
    return np.array([float(motion(t)[2] < 0)])


def theta(t: float) -> np.ndarray:
    """(10,) of a body that slides at the first touch; at the second friction holds it."""
    Fc = 0.05 if t < 0.25 else 40.0
    return np.array([1.0, 0.0, 500.0 + 20 * np.sin(t), 60.0, 60.0, Fc, 500.0, 60.0, 0.1, 0.005])


def surface(t: float) -> Cloud:
    """The top of a box that moves along x, 2 mm a point."""
    frame = np.floor(t * 30) / 30
    return _TOP.moved(np.array([0.01 * frame, 0.0, 0.0]), float(frame))


_TOP = plane(61 * 61, (0.12, 0.12))


def facet(t: float) -> np.ndarray:
    """(4,) a plane that turns under the tip, a little below the table."""
    n = np.array([0.3 * np.sin(4.0 * t), 0.2 * np.cos(3.0 * t), 1.0])
    return np.append(n / np.linalg.norm(n), -0.001)


def model(t: float) -> np.ndarray:
    """(28,) an object that stiffens a little, and then another law beside; anything else is refused."""
    effects = ToldEffect("nonlinear_stiffness", {"k3": 100.0}), ToldEffect("hysteresis", {"alpha": 0.1, "beta": 150.0})
    first = t < 0.25
    return ModelMessage(UNKNOWN_THETA, effects=effects[:1] if first else effects, number=1 if first else 2).vector()


def camera_points(t: float) -> PointCloud:
    """The same surface from a camera whose pixels fail now and then."""
    points = surface(t).points().T.astype(np.float32)
    points[:, : 1 + int(100 * t)] = np.nan
    cloud = PointCloud(points.shape[1])
    cloud.mutable_xyzs()[:] = points
    return cloud


def scene(t: float) -> np.ndarray:
    """(72,) two objects, one of which is under the probe and goes with it, a little higher than it was."""
    rows = np.zeros((MOST, ROW))
    frame = np.floor(t * 30) / 30
    rows[0] = 1.0, SeenState.SEEN, 0.01 * frame, 0.0, 1e-3 * frame, 0.05, 0.12, 0.12, 80.0, 5.0, 60.0, frame
    rows[1] = 2.0, SeenState.MERGED, 0.2, 0.0, -0.01, 0.04, 0.08, 0.08, *UNCOLOURED, frame
    return rows.ravel()


SIGNALS: dict[str, Callable[[float], Any]] = {
    "motion": motion,
    "position": lambda t: motion(t)[:3],
    "force": force,
    "input": lambda t: np.array([np.sin(20 * t)]),
    "measurement": lambda t: np.concatenate([motion(t), force(t)]),
    "in_contact": flag,
    "contact": flag,
    "clearance": lambda t: motion(t)[2:3],
    "stable": lambda t: np.ones(1),
    "theta": theta,
    "stamp": lambda t: np.array([t]),
    "held_body": lambda t: np.array([0.01 * t, 0.02, t - 0.02, 0.01, 0.02 * t, t - 0.02, t - 0.01]),
    "commanded": motion,
    "intended": motion,
    "remote_force": force,
    "remote_energy": lambda t: np.array([0.01, 0.02, 0.03]) * t,
    "residual_ratio": lambda t: np.array([1.0 + 0.1 * np.sin(3.0 * t)]),
    "learner_status": lambda t: np.array([float(round(5.0 * t) % 3)]),
    "model_status": lambda t: np.array([float(round(20.0 * t) % 2)]),
    "high_band": lambda t: np.array([300.0 + 20 * np.sin(t), 20.0, 0.5]),
    "point_cloud": surface,
    "rendered_force": force,
    "proxy": lambda t: motion(t)[:3],
    "normal": lambda t: np.array([0.0, 0.0, 1.0]),
    "body_position": lambda t: motion(t)[:2],
    "camera_points": camera_points,
    "facet": facet,
    "model": model,
    "grip": lambda t: np.array([0.0 if t % 0.5 < 0.1 else 6.0 + np.sin(9.0 * t)]),
    "held": lambda t: np.array([float(t % 0.5 > 0.1), 1e-4 * t, 2e-4 * t, 0.0]),
    "carried": lambda t: np.array([2.0, 0.3 + 0.01 * np.sin(t), 0.05, 0.1, 5.0]),
    "scene": scene,
    "told_thing": lambda t: np.array([float(t < 0.1)]),
    "thing": lambda t: np.array([1.0 if t < 0.25 else 2.0]),
}


def signal(system: System, port_name: str) -> Callable[[float], Any]:
    """What to feed a port: by its name, or sines of its size."""
    if port_name in SIGNALS:
        return SIGNALS[port_name]
    port = system.GetInputPort(port_name)
    if port.get_data_type() == PortDataType.kAbstractValued:
        return surface
    rates = 3.0 + np.arange(port.size())
    return lambda t: np.sin(rates * t)


class _Feed(LeafSystem):
    """A function of time on a port; no state."""

    def __init__(self, function: Callable[[float], Any]) -> None:
        super().__init__()
        first = function(0.0)
        if isinstance(first, np.ndarray):
            calc = lambda context, out: out.SetFromVector(function(context.get_time()))  # noqa: E731
            self.DeclareVectorOutputPort("signal", first.size, calc, {self.time_ticket()})
        else:
            calc = lambda context, out: out.set_value(function(context.get_time()))  # noqa: E731
            self.DeclareAbstractOutputPort("signal", lambda: AbstractValue.Make(first), calc, {self.time_ticket()})


# ------------------------------------------------------------------------------------------------------ ports and docs
def inputs(system: System) -> list[str]:
    return [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]


def outputs(system: System) -> list[str]:
    return [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]


def documented_ports(cls: type) -> dict[str, Any]:
    """The YAML of the `.. pydrake_system::` block, and under `prose` the rest of the class docstring."""
    doc = cls.__doc__ or ""
    match = re.search(r"^( *)\.\. pydrake_system::\n((?:\1 +.*\n|\s*\n)+)", doc + "\n", flags=re.M)
    assert match, f"{cls.__name__} has no `.. pydrake_system::` block in its docstring"
    lines = match.group(2).splitlines()
    indent = min(len(line) - len(line.lstrip()) for line in lines if line.strip())
    block: dict[str, Any] = yaml.safe_load("\n".join(line[indent:] for line in lines))
    block["prose"] = doc.replace(match.group(0).rstrip("\n"), "")
    return block


# ------------------------------------------------------------------------------------------------------------- running
def wire(system: System) -> Diagram:
    """The system with a feed on every input."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name in inputs(system):
        feed = builder.AddSystem(_Feed(signal(system, name)))
        builder.Connect(feed.get_output_port(), system.GetInputPort(name))
    return builder.Build()


def frozen(value: Any) -> Any:
    """A comparable image of what a port or an attribute holds: numbers bit by bit, containers and dataclasses deep."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, Cloud):
        return "Cloud", float(value.stamp), frozen(np.asarray(value.points()))
    if isinstance(value, PointCloud):
        return "PointCloud", frozen(value.xyzs())
    if isinstance(value, float):
        return np.float64(value).tobytes()
    if isinstance(value, (int, str, bytes, type(None))):
        return value
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [(f.name, frozen(getattr(value, f.name))) for f in dataclasses.fields(value)]
    if isinstance(value, dict):
        return [(frozen(k), frozen(v)) for k, v in value.items()]
    if isinstance(value, (list, tuple, deque)):
        return [frozen(v) for v in value]
    if isinstance(value, np.random.Generator):
        return frozen(value.bit_generator.state)
    if type(value).__module__.startswith("mmt_drake") and hasattr(value, "__dict__"):
        return type(value).__name__, frozen(vars(value))
    return type(value).__name__


def read(system: System, context: Context) -> list[Any]:
    """The value of every output port, frozen; `context` is the system's own."""
    return [frozen(system.GetOutputPort(name).Eval(context)) for name in outputs(system)]


def run(diagram: Diagram, system: System, context: Context, start: int, stop: int) -> Iterator[list[Any]]:
    """Advances tick by tick from tick `start` to `stop`; yields the outputs after each."""
    simulator = Simulator(diagram, context)
    simulator.Initialize(InitializeParams(suppress_initialization_events=start > 0))
    for tick in range(start + 1, stop + 1):
        simulator.AdvanceTo(tick * PERIOD)
        yield read(system, system.GetMyContextFromRoot(context))


def kernels() -> dict[str, Dispatcher]:
    """Every numba kernel of the package, by where it stands."""
    return {
        f"{name}.{item.__name__}": item
        for name, module in list(sys.modules.items())
        if name.split(".")[0] == "mmt_drake"
        for item in vars(module).values()
        if isinstance(item, Dispatcher) and item.__module__ == name
    }


def compiled() -> dict[str, list[Any]]:
    """The signatures for which each kernel has been compiled, or loaded from numba's cache."""
    return {name: list(kernel.signatures) for name, kernel in kernels().items()}


def forget_kernels() -> None:
    """Bring every kernel back to where it is before the first call; what is on disk stays."""
    plane.cache_clear()  # or a surface that is there already would need no kernel
    for kernel in kernels().values():
        kernel._reset_overloads()


def perturbed(value: Any) -> Any:
    """Another value for the same port."""
    if isinstance(value, Cloud):
        return value.moved(np.array([0.0004, 0.0003, -0.002]), value.stamp + 1e-3)
    if isinstance(value, PointCloud):
        moved = PointCloud(value)
        moved.mutable_xyzs()[:] += 1e-3
        return moved
    if value.size == 1 and value[0] in (0.0, 1.0):
        return 1.0 - value
    return 0.9 * value - 2e-3  # enough to lift the probe off, or press it in


def dependencies(system: System, ticks: int, every: int = 5) -> set[tuple[str, str]]:
    """Pairs (input, output) where the output is seen to change at once when the input does, along a run."""
    diagram = wire(system)
    context = diagram.CreateDefaultContext()
    simulator = Simulator(diagram, context)

    def outputs_now(perturb: str | None = None) -> dict[str, Any]:
        root = diagram.CreateDefaultContext()
        root.SetTimeStateAndParametersFrom(context)
        root.DisableCaching()  # an undeclared dependency would hide in the cache
        own = system.GetMyMutableContextFromRoot(root)
        if perturb is not None:
            port = system.GetInputPort(perturb)
            port.FixValue(own, perturbed(port.Eval(own)))
        return dict(zip(outputs(system), read(system, own), strict=True))

    found = set()
    for tick in range(0, ticks, every):
        simulator.AdvanceTo(tick * PERIOD)
        before = outputs_now()
        for name in inputs(system):
            after = outputs_now(perturb=name)
            found |= {(name, out) for out in before if before[out] != after[out]}
    return found
