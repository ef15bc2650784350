"""The contract that every LeafSystem of mmt_drake passes: documented ports, true feedthrough, all state in the Context.

A new system needs a case in contract_cases.py; `test_every_system_has_a_case` fails until it has one.
"""

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import contract
import pytest
from contract_cases import CASES
from pydrake.systems.framework import BasicVector, Context, InputPort, PortDataType

import mmt_drake.systems
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.surface_system import SurfaceSystem

BASES = (LeafSystem, KernelSystem, SurfaceSystem)
TICKS = 400  # 0.4 s: one and a half presses of contract.motion
# What tells a port's unit: the unit itself, a flag's values, the equation whose symbols it holds.
UNIT = re.compile(r"\[[^\]]+\]|\b[01](\.0)? (or|where|while|free)\b|eq\. \d|counts|how many")
# "`port` (size): meaning", in a line of its own or shared with others, up to the next line of the list.
PORT = r"`{name}`+(?:, `+\w+`+)* \((?P<size>[^)]*)\)(?P<rest>.*?)(?=\n\s*- |\n\s*\n|\Z)"


OURS = [name for name, case in CASES.items() if not case.drakes_own]
STATELESS_SELF = [name for name, case in CASES.items() if not case.writes_files]


def system_classes() -> Iterator[type[LeafSystem]]:
    """Every LeafSystem defined in mmt_drake.systems, private ones too."""
    for info in pkgutil.iter_modules(mmt_drake.systems.__path__, "mmt_drake.systems."):
        for _, cls in inspect.getmembers(importlib.import_module(info.name), inspect.isclass):
            if issubclass(cls, LeafSystem) and cls.__module__ == info.name and cls not in BASES:
                yield cls


def test_every_system_has_a_case(tmp_path: Path) -> None:
    covered = {type(case.make(tmp_path)) for case in CASES.values()}
    forgotten = [cls.__name__ for cls in system_classes() if cls not in covered]
    assert not forgotten, f"add a Case for {', '.join(forgotten)}"


def optional(port: str, block: dict[str, Any]) -> bool:
    """Whether an input is there only where an argument asks for it."""
    return re.search(rf"`{port}` \([^)]*\):[^-]*; there only with", block["prose"]) is not None


@pytest.mark.parametrize("name", OURS)
def test_the_docstring_names_the_class_and_its_ports_in_order(name: str, tmp_path: Path) -> None:
    system = CASES[name].make(tmp_path)
    block = contract.documented_ports(type(system))
    assert block["name"] == type(system).__name__
    there = [
        port for port in block.get("input_ports") or [] if port in contract.inputs(system) or not optional(port, block)
    ]
    assert there == contract.inputs(system)
    assert (block.get("output_ports") or []) == contract.outputs(system)


@pytest.mark.parametrize("name", OURS)
def test_the_docstring_gives_size_and_unit_of_every_port(name: str, tmp_path: Path) -> None:
    system = CASES[name].make(tmp_path)
    prose = contract.documented_ports(type(system))["prose"]
    ports = [system.get_input_port(i) for i in range(system.num_input_ports())]
    ports += [system.get_output_port(i) for i in range(system.num_output_ports())]
    for port in ports:
        told = re.search(PORT.replace("{name}", port.get_name()), prose, re.S)
        assert told, f"say '`{port.get_name()}` (size): meaning [unit]'"
        if port.get_name() in CASES[name].any_size or port.get_name() == "readout":
            continue
        if port.get_data_type() == PortDataType.kAbstractValued:
            assert "abstract" in told["size"]
        else:
            assert re.match(rf"{port.size()}\b", told["size"]), f"{port.get_name()} has size {port.size()}"
            assert UNIT.search(told["rest"]), f"say the unit of {port.get_name()}"


@pytest.mark.parametrize("name", OURS)
def test_every_input_is_read(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: set[str] = set()

    def noted(evaluate: Callable[..., Any]) -> Callable[..., Any]:
        return lambda port, context: (read.add(port.get_name()), evaluate(port, context))[1]

    for way in ("Eval", "EvalAbstract"):
        monkeypatch.setattr(InputPort, way, noted(getattr(InputPort, way)))
    system = CASES[name].make(tmp_path)
    diagram = contract.wire(system)
    list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 50))
    assert set(contract.inputs(system)) <= read


OPERATORS = ["ScriptedOperator", "InteractiveOperator"]
RENDERERS = [
    "ImpedanceRenderer",
    "FusedRenderer",
    "ProxySpringRenderer",
    "DirectForceRenderer",
    "PassivityControlledForce",
]


def rows_of_conventions(checkout: Path) -> Iterator[tuple[str, str, str]]:
    """(system, inputs, outputs) of the table under `## Ports`; groups written out, later rows add to earlier ones."""
    section = (checkout / "CONVENTIONS.md").read_text().split("## Ports")[1].split("\n## ")[0]
    for line in section.splitlines():
        if line.startswith("|") and "---" not in line and not line.startswith("| system"):
            who, reads, writes = (cell.strip() for cell in line.split("|")[1:-1])
            group = {"every operator": OPERATORS, "every renderer": RENDERERS}.get(who)
            for name in group or re.findall(r"`(\w+)`", who):
                yield name, reads, writes


def test_ports_are_those_of_the_table_in_conventions(checkout: Path, tmp_path: Path) -> None:
    told: dict[str, tuple[str, str]] = {}
    for name, reads, writes in rows_of_conventions(checkout):
        before = told.get(name, ("", ""))
        told[name] = before[0] + reads, before[1] + writes
    seen = set()
    for name, (reads, writes) in told.items():
        for case in (case for case in CASES if case.split("-")[0] == name and not CASES[case].drakes_own):
            system = CASES[case].make(tmp_path)
            sometimes = {
                port for port in re.findall(r"`([a-z_]+)` \(\d+; only", reads) if not system.HasInputPort(port)
            }
            told_in, told_out = (
                [told for told in re.findall(r"`([a-z_]+)`(?: \((\d+))?", cell) if told[0] not in sometimes]
                for cell in (reads, writes)
            )
            assert {port for port, _ in told_in} == set(contract.inputs(system))
            assert {port for port, _ in told_out} == set(contract.outputs(system)) - {"readout"}
            sizes = {port: system.GetInputPort(port).size() for port, size in told_in if size}
            sizes |= {port: system.GetOutputPort(port).size() for port, size in told_out if size}
            assert sizes == {port: int(size) for port, size in told_in + told_out if size}
            seen.add(name)
    assert seen >= {*OPERATORS, *RENDERERS, "FlexibleBox", "ContactDetector", "RlsEstimator", "NetworkChannel"}


@pytest.mark.parametrize("name", CASES)
def test_direct_feedthrough_is_declared_exactly_where_an_output_follows_an_input_at_once(
    name: str, tmp_path: Path
) -> None:
    system = CASES[name].make(tmp_path)
    declared = {
        (i, o)
        for i in contract.inputs(system)
        for o in contract.outputs(system)
        if system.HasDirectFeedthrough(system.GetInputPort(i).get_index(), system.GetOutputPort(o).get_index())
    }
    other = tmp_path / "other"  # a recording has one writer
    other.mkdir()
    observed = contract.dependencies(CASES[name].make(other), TICKS, CASES[name].every)
    assert not observed & CASES[name].computed_together
    assert observed | CASES[name].computed_together == declared


@pytest.mark.parametrize("name", STATELESS_SELF)
def test_two_runs_and_a_second_instance_give_the_same_bits(name: str, tmp_path: Path) -> None:
    system = CASES[name].make(tmp_path)
    diagram = contract.wire(system)
    first = list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, TICKS))
    assert list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, TICKS)) == first
    other = CASES[name].make(tmp_path)
    diagram = contract.wire(other)
    assert list(contract.run(diagram, other, diagram.CreateDefaultContext(), 0, TICKS)) == first
    for port, values in zip(contract.outputs(system), zip(*first, strict=True), strict=True):
        moved = any(value != values[0] for value in values)
        assert moved != (port in CASES[name].still), f"{port}: the run shows nothing unless the output moves"


@pytest.mark.parametrize("name", STATELESS_SELF)
def test_a_context_cloned_half_way_goes_on_with_the_same_bits(name: str, tmp_path: Path) -> None:
    system = CASES[name].make(tmp_path)
    diagram = contract.wire(system)
    context = diagram.CreateDefaultContext()
    list(contract.run(diagram, system, context, 0, TICKS // 2))
    clone = context.Clone()
    went_on = list(contract.run(diagram, system, context, TICKS // 2, TICKS))
    assert list(contract.run(diagram, system, clone, TICKS // 2, TICKS)) == went_on
    whole = list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, TICKS))
    assert whole[TICKS // 2 :] == went_on


@pytest.mark.parametrize("name", STATELESS_SELF)
def test_a_run_changes_nothing_in_self(name: str, tmp_path: Path) -> None:
    system = CASES[name].make(tmp_path)
    diagram = contract.wire(system)
    before = contract.frozen(vars(system))
    list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, TICKS))
    assert contract.frozen(vars(system)) == before


@pytest.mark.parametrize("name", CASES)
def test_a_run_compiles_nothing_that_was_not_compiled_at_construction(name: str, tmp_path: Path) -> None:
    first = tmp_path / "first"
    first.mkdir()
    CASES[name].make(first)  # fills numba's cache: to compile a kernel compiles what it calls, to load it does not
    contract.forget_kernels()  # of other cases too
    system = CASES[name].make(tmp_path)
    diagram = contract.wire(system)
    before = contract.compiled()
    list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, TICKS))
    assert contract.compiled() == before


class _Careless(LeafSystem):
    """Everything the contract forbids: a counter in self, an input that an output uses and does not declare."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self._force = self.DeclareVectorInputPort("force", 3)
        self.DeclareVectorOutputPort("sum", 1, self._sum, {self.time_ticket()})

    def _sum(self, context: Context, output: BasicVector) -> None:
        self.count += 1
        output.SetFromVector([self._force.Eval(context).sum() + self.count])


def test_a_careless_system_is_caught() -> None:
    system = _Careless()
    declared = system.HasDirectFeedthrough(0, 0)
    assert ("force", "sum") in contract.dependencies(_Careless(), 10)
    assert not declared
    diagram = contract.wire(system)
    before = contract.frozen(vars(system))
    first = list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 10))
    assert contract.frozen(vars(system)) != before
    assert list(contract.run(diagram, system, diagram.CreateDefaultContext(), 0, 10)) != first
    with pytest.raises(AssertionError, match="has no"):
        contract.documented_ports(_Careless)
