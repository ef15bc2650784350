"""Errors of devices before they run."""

from mmt_drake.errors import MmtError


class DeviceError(MmtError):
    """A device cannot be reached, opened or set up; the message says why and what to do."""
