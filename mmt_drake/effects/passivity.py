"""The condition under which an effect gives no energy that was not put in.

It is a function of the values: a contact spring that hardens is passive, one that softens is not. What is rendered to a
hand has to be passive (Colgate, Hogan: "Robust control of dynamically interacting systems", Int. J. Control 48(1),
1988); what is only fitted may be anything.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from mmt_drake.model.structure import Structure


class Passive(NamedTuple):
    """Where an effect can only take energy out of the motion, or hold it and give it back.

    Attributes:
        where: the condition, for people; empty: with all values within the bounds.
        holds: the same of a model and the values in it.
    """

    where: str
    holds: Callable[[Structure, Mapping[str, Any]], bool]


ALWAYS: Final = Passive("", lambda model, values: True)
"""With all values within the bounds."""
