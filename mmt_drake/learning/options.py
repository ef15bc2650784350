"""Options of a learner."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mmt_drake.quantities import Checked, Quantity


@dataclass(frozen=True)
class Learning(Checked):
    """How a learner goes about it.

    Attributes:
        window: how much of the contact is looked at [s]. Where nothing could be said of it twice as much is looked at
            the next time, three times at most.
        doubt: what must be left of the contact, over its noise, for a look to be worth while [1]: along the surface by
            the estimator, the median over the later half of the window; along the normal by a spring, a damper and a
            height, over all of it.
        delay: in simulation, after which an answer is taken up [s of simulation]; it is waited for, so that runs repeat
            bit for bit. With `worker`, in real time, an answer is taken up when it comes.
        sample: about the time between samples of a window [s].

    Raises:
        BadInput: a value that is out of range.
    """

    window: Annotated[float, Quantity("s", 3.0, 60.0)] = 8.0
    doubt: Annotated[float, Quantity("1", 1.0, 100.0)] = 1.3
    delay: Annotated[float, Quantity("s", 0.1, 600.0)] = 20.0
    sample: Annotated[float, Quantity("s", 1e-4, 0.01)] = 0.002

    CALLED: ClassVar = "learner"
