"""Finds the camera's library, and says plainly what is missing."""

import importlib
from types import ModuleType

from mmt_drake.errors import MissingDependency, MmtError, one_line


class CameraError(MmtError):
    """A camera, or a recording of one, that cannot be used; the message says which and why."""


def load_sdk() -> ModuleType:
    """The module `pyrealsense2`, which brings its own librealsense.

    Raises:
        MissingDependency: it is not here, or does not load.
    """
    try:
        return importlib.import_module("pyrealsense2")
    except ImportError as error:
        raise MissingDependency(
            f"realsense: Python package pyrealsense2 not found ({one_line(error)}); get it with: "
            "pip install 'mmt_drake[realsense]'"
        ) from None
