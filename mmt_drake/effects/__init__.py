"""The library of effects that a simulation may have left out, one file each."""

from mmt_drake.effects import coulomb_friction, ground_spring, static_friction, viscous_friction
from mmt_drake.effects.effect import Effect, Parameter

#: name -> effect
LIBRARY: dict[str, Effect] = {
    module.EFFECT.name: module.EFFECT for module in (coulomb_friction, ground_spring, static_friction, viscous_friction)
}

__all__ = ["LIBRARY", "Effect", "Parameter"]
