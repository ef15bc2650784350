"""What the estimator knows after a fit."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, NamedTuple, Self

import numpy as np

from mmt_drake.estimation.output_error.adequacy import Adequacy
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.fit import MOST_NOISE
from mmt_drake.estimation.output_error.unknowns import (
    FRICTION,
    LATENESS,
    OBJECT,
    UNKNOWNS,
    Information,
    Stick,
    derivatives,
    theta_of,
)
from mmt_drake.estimation.output_error.window import Window
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.message_layout import MESSAGE_SIZE
from mmt_drake.model.parameters import FORCE_LATENESS, THETA
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

FIRST_NOISE = 0.05
"""[N], before there is a fit to tell it from."""


class Told(NamedTuple):
    """What a fit hands over.

    Attributes:
        theta: in the order of `mmt_drake.model.parameters.THETA`.
        deviation: standard deviations of theta.
        lateness: how late the force is, in the order of `FORCE_LATENESS` [s].
        held: where friction holds the body (`mmt_drake.model.held_body`).
        status: a `ModelStatus`.
        left: residual over its noise.
        thing: which object it is (`Learner.met`).
        model: (MESSAGE_SIZE,) the message whose laws are taken to act beside theta; zeros: there is none.
    """

    theta: Array
    deviation: Array
    lateness: Array
    held: Array
    model: Array
    status: float
    left: float
    thing: float = 0.0

    def vector(self) -> Array:
        """All of it, one after the other."""
        return np.concatenate([*self[:_NUMBERS], self[_NUMBERS:]])

    @classmethod
    def from_vector(cls, vector: Array) -> Self:
        """What `vector` has made."""
        parts = vector[_THETA], vector[_DEVIATION], vector[_LATENESS], vector[_HELD], vector[_MODEL]
        return cls(*parts, *vector[_MODEL.stop :].tolist())


RESOLUTION: Final = 5e-4
"""No number is known better than to this part: what is compared are means over a few milliseconds, and
even without noise numbers end that far off."""
_SIZES = len(THETA), len(THETA), len(FORCE_LATENESS), HELD_SIZE, MESSAGE_SIZE  # of its parts that are arrays
_NUMBERS = len(_SIZES)
_THETA, _DEVIATION, _LATENESS, _HELD, _MODEL = map(Layout().part, _SIZES)


@dataclass(frozen=True)
class Knowledge:
    """All that is known after a fit; never changed.

    Attributes:
        window: the samples at hand.
        start: where the body is at the first of them.
        x: the unknowns of the fit.
        stick: static friction.
        normal: k and b of the normal axis, or of the prior.
        memory: what samples that were let go say of the unknowns.
        normal_memory: and of normal k and b.
        noise: deviation of measured less simulated force [N].
        noise_slope: what `Objective.slope_of_noise` is for each unknown and each sample that is compared [N^2].
        noise_share: and what share of what the samples say of each is that noise, inf where they say nothing.
        covariance: of the unknowns (8, 8).
        normal_covariance: (2, 2).
        held: where friction holds the body (`mmt_drake.model.held_body`).
        rival: other unknowns that may explain the samples better, or None.
        tried: how many rivals there were, and how many steps the present one has made.
        fits: how many there were.
        fresh: samples since the last fit.
        interrupted: whether time broke off once, so that the body need not have been at rest at the first sample.
        adequacy: what is to be thought of the model.
        trusted: the unknowns and static friction when the model last explained the latest contact.
        model: (MESSAGE_SIZE,) the message whose laws are taken to act; zeros: there is none.
        thing: identity of the object; 0: nobody has said.
        looks: of it, (LOOKS,) of a scene's row from its height on; empty where nobody has said.
        others: identity -> what is known of another object, without samples.
    """

    window: Window
    start: Beginning
    x: Array
    stick: Stick
    normal: Array
    memory: Information
    normal_memory: Information
    noise: float
    noise_slope: Array
    noise_share: Array
    covariance: Array
    normal_covariance: Array
    held: Array
    rival: Array | None = None
    tried: tuple[int, int] = (0, 0)
    fits: int = 0
    fresh: int = 0
    interrupted: bool = False
    adequacy: Adequacy = field(default_factory=Adequacy)
    trusted: tuple[Array, Stick] | None = None
    model: Array = field(default_factory=partial(np.zeros, MESSAGE_SIZE))
    thing: int = 0
    looks: tuple[float, ...] = ()
    others: Mapping[int, "Knowledge"] = field(default_factory=dict)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def of_another(self, **changes: Any) -> Self:
        """The same but for these, where another object or model is to be fitted: nothing is known of what it leaves."""
        nothing = np.zeros(UNKNOWNS)
        return replace(self, noise=FIRST_NOISE, noise_slope=nothing, noise_share=nothing, rival=None, **changes)

    @property
    def rests(self) -> bool:
        """Whether the samples say next to nothing of the object."""
        return bool(np.all(self.noise_share[OBJECT] > MOST_NOISE))

    @property
    def told(self) -> Told:
        """What is handed over."""
        adequacy = self.adequacy
        status = float(adequacy.status)
        return Told(
            self.theta, self.deviation, self.lateness, self.held, self.model, status, adequacy.left, float(self.thing)
        )

    @property
    def theta(self) -> Array:
        """What is handed over, in the order of `mmt_drake.model.parameters.THETA`."""
        return theta_of(self.x, self.stick, self.normal)

    @property
    def deviation(self) -> Array:
        """Standard deviations of theta; of static friction the grid on which it is sought."""
        theta = self.theta
        own = np.hypot(derivatives(theta) * np.sqrt(np.diag(self.covariance)[OBJECT]), RESOLUTION * theta[OBJECT])
        normal = np.sqrt(np.diag(self.normal_covariance))
        return np.array([*own, *normal, math.hypot(own[FRICTION], 0.25 * self.stick.excess), 0.25 * self.stick.speed])

    @property
    def lateness(self) -> Array:
        """How late the force is, in the order of `FORCE_LATENESS` [s]."""
        (total, share), covariance = self.x[LATENESS], self.covariance[LATENESS, LATENESS]
        slope = np.array([[1.0 - share, -total], [share, total], [1.0, 0.0]])
        return np.array([*slope[:, 0] * total, *np.sqrt(np.diag(slope @ covariance @ slope.T))])
