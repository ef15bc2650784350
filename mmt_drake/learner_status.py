"""The status of a learner, as its port and its column count it."""

from enum import IntEnum


class LearnerStatus(IntEnum):
    """What a learner is about."""

    WATCHING = 0  # the numbers explain the contact, or too little of it was seen
    LOOKING = 1  # a diagnosis is under way
    TOLD = 2  # laws, or what the force sensor adds, are told
    NOT_FELT = 3  # what was found last is not to be felt, or cannot be: the channel's, active
    CANNOT_TELL = 4  # what the numbers leave has no name so far
    FAILED = 5  # the diagnosis did

    @property
    def words(self) -> str:
        """For a person."""
        return _WORDS[self]


_WORDS = {
    LearnerStatus.WATCHING: "nothing is in doubt, or too little contact was seen",
    LearnerStatus.LOOKING: "it is looking",
    LearnerStatus.TOLD: "what it found is told",
    LearnerStatus.NOT_FELT: "what it found is not to be felt",
    LearnerStatus.CANNOT_TELL: "what is left has no name",
    LearnerStatus.FAILED: "its last look failed",
}
