"""Location of a mismatch in a whole diagram: every block replayed by itself on what was recorded at its inputs.

A block whose recorded output its replay gives again is not to blame, however wrong that output is: it was handed wrong
input. So the first block along the signal's way whose replay differs is where simulation and reality part.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import System

from mmt_drake.analysis.signals import EVEN, mean_step, on_even_clock
from mmt_drake.cloud import Cloud
from mmt_drake.diagnosis.decide.block_replay import BlockReplay, compared
from mmt_drake.diagnosis.signals.smoother import noise_floor
from mmt_drake.errors import BadInput, suggest
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording
from mmt_drake.recording.signals import SIGNALS, Signal, signal_names

__all__ = ["Block", "BlockReplay", "Surface", "differing", "replay_block", "replay_blocks"]


_TWICE = np.sqrt(3.0)  # noise of this strength beside noise of 1 makes 2


@dataclass(frozen=True)
class Surface:
    """What a block sees: the object's surface, which moves with the body.

    Attributes:
        port: abstract input port that takes a `Cloud`.
        cloud: undisplaced [m, table frame]; it is moved by the recorded `body_position`.
        period: between two clouds [s].
        noise: standard deviation of each coordinate of each point, fresh in every cloud [m].
    """

    port: str
    cloud: Cloud
    period: float
    noise: float = 0.0


@dataclass(frozen=True)
class Block:
    """One system of a diagram, and which recorded signals stand at its ports.

    Attributes:
        name: of the block.
        system: with its initial state as its default; it is not changed. One discrete update period at most.
        inputs: input port -> the signals (CONVENTIONS.md, "Recordings") that make it up, one after the other.
        outputs: signal -> output port, and where in it the signal starts.
        surface: what it sees, if it does.
        sensed: whether the recording has its inputs through sensors, while the block itself had them without noise.
    """

    name: str
    system: System
    inputs: Mapping[str, tuple[str, ...]]
    outputs: Mapping[str, tuple[str, int]]
    surface: Surface | None = None
    sensed: bool = False


def replay_blocks(
    recording: Recording,
    blocks: Iterable[Block],
    *,
    counts: Flags | None = None,
    noise: Mapping[str, float] | None = None,
) -> tuple[BlockReplay, ...]:
    """Replay every block on its recorded inputs and compare every output that was recorded too.

    Args:
        recording: of a run from its first tick on, as states are not recorded; at the blocks' own period.
        blocks: in the order of the signal's way.
        counts: (n,) samples that enter the errors; all by default. Before and between them blocks run all the same.
        noise: column -> standard deviation of its sensor's noise; by default what `noise_floor` finds.

    Returns:
        One entry per block and output, in order; those that were not recorded have `nrmse` None and say why.

    Raises:
        BadInput: an uneven clock with gaps, a period that is not the blocks', a port or signal that does not exist.
    """
    even = on_even_clock(recording)
    counts = np.ones(len(even), dtype=bool) if counts is None else counts
    if counts.shape != even.time.shape or not counts.any():
        found = f"{np.count_nonzero(counts)} of {len(counts)}"
        raise BadInput(recording.source, at="counts", found=found, expected=f"some of {len(even)} samples")
    if noise is None:
        noise = {name: found.std for name, found in noise_floor(recording).items()}
    generator = np.random.default_rng(0)
    return tuple(found for block in blocks for found in _replays(even, block, counts, noise, generator))


def differing(replays: Iterable[BlockReplay]) -> tuple[str, ...]:
    """Names of the blocks with an output that differs, in the order of the replays, each once."""
    return tuple(dict.fromkeys(found.block for found in replays if found.differs))


def replay_block(recording: Recording, block: Block, generator: np.random.Generator | None = None) -> dict[str, Array]:
    """What a block makes of its recorded inputs: signal -> (n, k), at every tick before the update of that tick.

    That is what a recorder in the diagram sees. The recording's samples are taken for the block's ticks, from 0 on.

    Args:
        recording: on an even clock.
        block: every output is given, recorded or not.
        generator: of the noise of what the block sees; a fixed seed by default.

    Raises:
        BadInput: an input was not recorded, or does not fit its port; the recording's step is not the block's period.
    """
    system, step = block.system, _step(recording, block)
    context = system.CreateDefaultContext()
    drives = [(system.GetInputPort(port), _table(recording, block, port)) for port in block.inputs]
    sinks = {name: (system.GetOutputPort(port), start) for name, (port, start) in block.outputs.items()}
    made = {name: np.empty((len(recording), _signal(recording, name).size)) for name in sinks}
    updates = system.GetUniquePeriodicDiscreteUpdateAttribute() is not None
    clouds = None if block.surface is None else _clouds(recording, block.surface, step, generator)
    for k in range(len(recording)):
        context.SetTime(k * step)
        for port, table in drives:
            port.FixValue(context, table[k])
        if block.surface is not None and clouds is not None and (cloud := next(clouds)) is not None:
            system.GetInputPort(block.surface.port).FixValue(context, cloud)
        for name, (port, start) in sinks.items():
            values = made[name]
            values[k] = port.Eval(context)[start : start + values.shape[1]]
        if updates:
            context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    return made


def _clouds(
    recording: Recording, surface: Surface, step: float, generator: np.random.Generator | None
) -> Iterator[Cloud | None]:
    """At every tick the cloud that is new then, or None."""
    generator = np.random.default_rng(0) if generator is None else generator
    time = step * np.arange(len(recording))
    number = np.floor(time / surface.period + 1e-9).astype(np.intp)
    at = surface.period * number
    x, y = (np.interp(at, time, recording[f"body_position_{axis}"]) for axis in "xy")
    for k in range(len(time)):
        if k > 0 and number[k] == number[k - 1]:
            yield None
            continue
        cloud = surface.cloud.moved((float(x[k]), float(y[k]), 0.0), float(at[k]))
        if surface.noise > 0.0:
            points = cloud.points()
            cloud = Cloud(points + surface.noise * generator.standard_normal(points.shape), stamp=float(at[k]))
        yield cloud


def _step(recording: Recording, block: Block) -> float:
    """The block's period [s], or the recording's step where it has none."""
    step, attribute = mean_step(recording), block.system.GetUniquePeriodicDiscreteUpdateAttribute()
    if attribute is None:
        return step
    period = float(attribute.period_sec())
    if abs(step - period) > EVEN * period:
        expected = f"the period of {block.name}, {period:g} s"
        raise BadInput(recording.source, at="time", found=f"a step of {step:.6g} s", expected=expected)
    return period


def _signal(recording: Recording, name: str) -> Signal:
    """The signal of this name: of several, the one whose columns were recorded, else the first."""
    known = [signal for signal in SIGNALS if signal.name == name]
    if not known:
        raise BadInput("block", at="signal", found=name, expected=f"a known signal{suggest(name, signal_names())}")
    return next((signal for signal in known if all(column in recording for column in signal.columns)), known[0])


def _is_recorded(recording: Recording, name: str) -> bool:
    return all(column in recording for column in _signal(recording, name).columns)


def _columns(recording: Recording, name: str) -> Array:
    return np.column_stack([recording[column] for column in _signal(recording, name).columns])


def _table(recording: Recording, block: Block, port: str) -> Array:
    table = np.hstack([_columns(recording, name) for name in block.inputs[port]])
    size = block.system.GetInputPort(port).size()
    if table.shape[1] != size:
        found, expected = f"{table.shape[1]} columns", f"{size} numbers"
        raise BadInput("block", at=f"{block.name}.{port}", found=found, expected=expected)
    return table


def _replays(
    recording: Recording, block: Block, counts: Flags, noise: Mapping[str, float], generator: np.random.Generator
) -> Iterator[BlockReplay]:
    inputs = [name for names in block.inputs.values() for name in names]
    inputs += ["body_position"] if block.surface is not None else []
    missing = [name for name in inputs if not _is_recorded(recording, name)]
    if missing or not any(_is_recorded(recording, name) for name in block.outputs):
        note = f"Not replayed: {', '.join(missing or block.outputs)} not recorded."
        yield from (BlockReplay(block.name, name, None, note=note) for name in block.outputs)
        return
    made = replay_block(recording, block, generator)
    again = made
    if block.sensed and (noisier := _noisier(recording, inputs, noise, generator)):
        again = replay_block(replace(recording, columns={**recording.columns, **noisier}), block, generator)
    for name in block.outputs:
        if not _is_recorded(recording, name):
            yield BlockReplay(block.name, name, None, note=f"Not compared: {name} not recorded.")
            continue
        signal, recorded = _signal(recording, name), _columns(recording, name)
        own = [noise.get(column, 0.0) for column in signal.columns]
        chance = again[name] - made[name] + own * generator.standard_normal(recorded.shape)
        if signal.quantity == "flag" and again is not made:
            # The instant of a switch falls on one tick or the next, by chance.
            chance[1:][recorded[1:] != recorded[:-1]] = 1.0
        rate = 1.0 / mean_step(recording)
        yield compared(block.name, name, recorded, made[name], chance, counts, rate, held=signal.held)


def _noisier(
    recording: Recording, inputs: Iterable[str], noise: Mapping[str, float], generator: np.random.Generator
) -> dict[str, Array]:
    """The input columns that have noise, with twice the noise.

    A block that feels the size of the noise and not its sign, as a proxy that noise pushes out of the surface, then
    moves as far as it moved with the noise that was recorded.
    """
    columns = (column for name in inputs for column in _signal(recording, name).columns)
    return {
        column: recording[column] + _TWICE * noise[column] * generator.standard_normal(len(recording))
        for column in columns
        if noise.get(column, 0.0) > 0.0
    }
