"""Errors of devices before they run, and fault codes while they do."""

from enum import IntEnum
from typing import Self

from mmt_drake.errors import MmtError


class DeviceError(MmtError):
    """A device cannot be reached, opened or set up; the message says why and what to do."""


class FaultCode(IntEnum):
    """A number that a port shows, and what it means in words."""

    words: str

    def __new__(cls, code: int, words: str = "") -> Self:
        member = int.__new__(cls, code)
        member._value_ = code
        member.words = words
        return member
