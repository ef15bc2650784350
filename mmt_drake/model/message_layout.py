"""The layout of a model message as a vector (`mmt_drake.model_message`)."""

from typing import Final

from mmt_drake.model.laws import LAW_PARAMETERS
from mmt_drake.model.parameters import THETA

HEAD: Final = ("version", "structure", "object", "number")
SENSOR: Final = ("force_bias", "force_drift", "force_crosstalk", "force_lag")
"""What the force sensor adds to what is, by the effect of that name: [N], [N/s], [1], [s]."""
MOST_EFFECTS: Final = 2
"""That one message may tell."""
ENTRY: Final = 1 + 2 * LAW_PARAMETERS
"""Numbers of an effect: which one, its values in the order of its parameters, and their standard deviations."""
_OF_EFFECT = ("", *(f"{of}_{k + 1}" for of in ("", "_deviation") for k in range(LAW_PARAMETERS)))
MESSAGE: Final = (*HEAD, *THETA, *SENSOR, *(f"effect{i + 1}{of}" for i in range(MOST_EFFECTS) for of in _OF_EFFECT))
"""Names of its numbers."""
MESSAGE_SIZE: Final = len(MESSAGE)
MESSAGE_NUMBER: Final = HEAD.index("number")
"""Where the number of the message stands."""
OF_SENSOR: Final = slice(len(HEAD) + len(THETA), len(HEAD) + len(THETA) + len(SENSOR))
"""Where what the force sensor adds stands."""
EFFECTS: Final = OF_SENSOR.stop
"""Where its effects begin."""
