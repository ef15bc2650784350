"""librealsense by its Python package, which is loaded where it is needed."""

import functools
import importlib
from types import ModuleType
from typing import Any

from mmt_drake.errors import MissingDependency, one_line


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


@functools.cache
def _kept_context() -> Any:
    """Held while the process lives: librealsense crashes where its last one goes while its device watcher starts."""
    return load_sdk().context()


def new_context() -> Any:
    """A new one, as a recording can be opened once in each."""
    _kept_context()
    return load_sdk().context()
