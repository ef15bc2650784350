"""The layout of a model message as a vector (`mmt_drake.model_message`)."""

from typing import Final

from mmt_drake.model.laws import LAW_PARAMETERS
from mmt_drake.model.parameters import THETA

HEAD: Final = ("version", "structure", "object", "number")
MOST_EFFECTS: Final = 2
"""That one message may tell."""
ENTRY: Final = 1 + LAW_PARAMETERS
"""Numbers of an effect: which one, and its values in the order of its parameters."""
MESSAGE: Final = (
    *HEAD,
    *THETA,
    *(f"effect{i + 1}{of}" for i in range(MOST_EFFECTS) for of in ("", *(f"_{k + 1}" for k in range(ENTRY - 1)))),
)
"""Names of its numbers."""
MESSAGE_SIZE: Final = len(MESSAGE)
MESSAGE_NUMBER: Final = HEAD.index("number")
"""Where the number of the message stands."""
EFFECTS: Final = len(HEAD) + len(THETA)
"""Where its effects begin."""
