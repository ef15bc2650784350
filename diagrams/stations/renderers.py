"""Renderers of a scenario: what an operator may be made to feel."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydrake.systems.framework import System

from mmt_drake.diagrams.stations.own_parts import OwnPart
from mmt_drake.diagrams.stations.returned import RETURNED
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import InPlane
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.quantities import Checked, Damping, Mass, Quantity, Stiffness
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.structures import RenderedStructure
from mmt_drake.rendering.updates import AtOnce, Policy
from mmt_drake.systems import direct_force, fused_reflection, impedance_reflection, proxy_spring
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.systems.compliant_tip import TipSettings
from mmt_drake.systems.impedance_reflection import ProbeInput
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.passivity_controlled_force import PassivityControlledForce

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

_MODEL = ("theta", "stable", "in_contact")


class _Renderer(ABC):
    """What every renderer says of itself.

    Attributes:
        switched: whether it has a model that contact switches.
        high_band: a second model that the telerobot fits for it.
        passivity: control at both ends of the network.
        updates: how parameters that arrive are taken up; None: it has none.
        arm: that is modelled between the hand and the object; None: the object is at the hand.
    """

    switched = True
    high_band: HighBand | None = None
    passivity: PassivityControl | None = None
    updates: Policy | None = None
    arm: ModelledArm | None = None

    @property
    @abstractmethod
    def name(self) -> str:
        """What it renders, in a word."""

    @property
    def receives(self) -> tuple[str, ...]:
        """What crosses the network for it, keys of `mmt_drake.diagrams.stations.returned.RETURNED`."""
        return _MODEL

    @property
    def between(self) -> str:
        """What the network back shows between packets: flags and parameters are held, a force moves on."""
        return "hold"

    @property
    def sees(self) -> bool:
        """Whether it needs the surface."""
        return False


@dataclass(frozen=True)
class ModelledArm(Checked):
    """The telerobot's arm, as its controller makes it yield: a mass on a spring and a damper.

    Attributes:
        mass: apparent mass at its tip [kg].
        stiffness, damping: of its controller, the telerobot's own [N/m], [N s/m].

    Raises:
        BadInput: a value out of range.
    """

    mass: Mass = 3.0
    stiffness: Stiffness = 1500.0
    damping: Damping = 120.0

    CALLED: ClassVar = "modelled arm"

    @property
    def tip(self) -> TipSettings:
        """The same as a tip; of its sensor nothing is used."""
        return TipSettings(mass=self.mass, impedance=Impedance(stiffness=self.stiffness, damping=self.damping))


@dataclass(frozen=True)
class ImpedanceReflection(_Renderer):
    """The estimated object, integrated on the operator's side.

    Attributes:
        substeps: Runge-Kutta steps per tick at least.
        updates: how parameters that arrive are taken up.
        probe: `moved` or `placed`, see `mmt_drake.systems.impedance_reflection`.
        in_plane: whether its friction is a vector or that of each axis, as in the thesis.
        arm: the telerobot's, between the hand and the object; null: the object is rendered as if the probe were where
            the hand is.
        mu: friction of the probe on the surface, where that is not level; null: it never slips.
        effects: laws that the object is known to have beside the numbers that the estimator tells, as in a model file:
            those of a contact, body or friction, with values that are passive; two at most, a clearance on a level
            surface alone.
        structure: as what theta is rendered: a flexible_box; a mass_spring_damper that the hand has hold of (thesis,
            eq. 1); a spring to where it has touched (eq. 10). See `mmt_drake.rendering.structures`.

    Raises:
        BadInput: an effect that is unknown, not to be felt or has values that it does not allow; effects of what is no
            flexible box.
    """

    substeps: int = 1
    updates: Policy = field(default_factory=AtOnce)
    probe: ProbeInput = "moved"
    in_plane: InPlane = "vector"
    arm: ModelledArm | None = None
    mu: Annotated[float | None, Quantity("1", positive=True)] = None
    effects: tuple[ToldEffect, ...] = ()
    structure: RenderedStructure = "flexible_box"
    name = "runge_kutta"
    receives = (*_MODEL, "held_body", "model_status", "model")

    def __post_init__(self) -> None:
        _ = self._model
        if self.effects and self.structure != "flexible_box":
            expected = f"none: a {self.structure} has no laws"
            raise BadInput("renderer", at="effects", found=self.effects[0].name, expected=expected)

    @property
    def _model(self) -> ModelMessage | None:
        return ModelMessage(UNKNOWN_THETA, effects=self.effects) if self.effects else None

    def build(self, site: Site) -> LeafSystem:
        """The renderer.

        Raises:
            BadInput: effects on a surface that the body carries, or on which the probe slips; a clearance on one that
                is not level.
        """
        shape = site.scenario.shape
        carried = shape is not None and shape.fixed_to == "body"
        if self.effects and (carried or self.mu is not None):
            expected = "none: laws act where the surface stays and the probe does not slip on it"
            raise BadInput(site.scenario.name, at="renderer.effects", found=self.effects[0].name, expected=expected)
        if self._model is not None and self._model.clearance > 0.0 and site.scenario.seen_by_operator:
            found, expected = f"a clearance of {self._model.clearance:g} m", "none: it acts on a level surface alone"
            raise BadInput(site.scenario.name, at="renderer.effects", found=found, expected=expected)
        return impedance_reflection.ImpedanceRenderer(
            period=site.step,
            substeps=self.substeps,
            updates=self.updates,
            probe=self.probe,
            in_plane=self.in_plane,
            carried=carried,
            mu=self.mu,
            model=self._model,
            structure=self.structure,
        )


@dataclass(frozen=True)
class ProxySpring(_Renderer):
    """A spring to the proxy on the point cloud, eq. 3.

    Attributes:
        k: its stiffness [N/m].
    """

    k: float = 500.0
    name = "proxy_spring"
    sees = True

    def build(self, site: Site) -> LeafSystem:
        """The renderer.

        Raises:
            BadInput: the stiffness is not positive.
        """
        return proxy_spring.ProxySpringRenderer(self.k, site.proxy)


@dataclass(frozen=True)
class DirectForce(_Renderer):
    """The telerobot's force, sent to the operator as it is measured: no model.

    Attributes:
        passivity: time-domain passivity control at both ends; null: none.
    """

    passivity: PassivityControl | None = None
    between = "linear"
    switched = False

    @property
    def name(self) -> str:
        """What it renders, in a word."""
        return "direct" if self.passivity is None else "passivity_controlled"

    @property
    def receives(self) -> tuple[str, ...]:
        """What crosses the network for it."""
        return ("remote_force",) if self.passivity is None else ("remote_force", "remote_energy")

    def build(self, site: Site) -> LeafSystem:
        """The renderer."""
        if self.passivity is None:
            return direct_force.DirectForceRenderer(period=site.step)
        return PassivityControlledForce(period=site.step, control=self.passivity)


@dataclass(frozen=True)
class FusedReflection(_Renderer):
    """`ImpedanceReflection`, and above a frequency in part a variable spring that the telerobot fits as well.

    Attributes:
        substeps, updates, in_plane: as there.
        high_band: the second model.
    """

    substeps: int = 1
    updates: Policy = field(default_factory=AtOnce)
    high_band: HighBand = field(default_factory=HighBand)
    in_plane: InPlane = "vector"
    name = "fused"
    receives = (*_MODEL, "high_band", "held_body", "model_status")

    def build(self, site: Site) -> LeafSystem:
        """The renderer.

        Raises:
            BadInput: the object's surface is not level.
        """
        if site.scenario.shape is not None:
            expected = "!ImpedanceReflection: it renders a level surface alone"
            raise BadInput(site.scenario.name, at="renderer", found="!FusedReflection", expected=expected)
        return fused_reflection.FusedRenderer(
            self.high_band, period=site.step, substeps=self.substeps, updates=self.updates, in_plane=self.in_plane
        )


@dataclass(frozen=True)
class OwnRenderer(OwnPart, _Renderer):
    """A renderer of a person's own, which is given what it has ports for."""

    PART = "renderer"
    NEEDED = ("force",)
    APART = ("high_band", "remote_energy")  # whose other ends come with the renderers that have them

    @cached_property
    def _reads(self) -> tuple[str, ...]:
        system = self.made(1e-3)
        return tuple(system.get_input_port(index).get_name() for index in range(system.num_input_ports()))

    @property
    def name(self) -> str:
        """The name of its class."""
        return self.called

    @property
    def receives(self) -> tuple[str, ...]:
        """What crosses the network for it."""
        return tuple(name for name in RETURNED if name in self._reads) or _MODEL

    @property
    def between(self) -> str:
        """A force alone moves on between packets."""
        return "linear" if self.receives == ("remote_force",) else "hold"

    @property
    def sees(self) -> bool:
        """Whether it needs the surface."""
        return "point_cloud" in self._reads

    def build(self, site: Site) -> System:
        """The renderer."""
        return self.made(site.step)


Renderer = ImpedanceReflection | ProxySpring | DirectForce | FusedReflection | OwnRenderer
