"""Finds the library that talks to a Franka, and says plainly what is missing."""

import importlib
import importlib.metadata
from types import ModuleType

from mmt_drake.errors import MissingDependency

_GET_IT = "get it with: pip install 'mmt_drake[franka]'"


def load_franky() -> ModuleType:
    """Import `franky`; it must not share a process with `pylibfranka`.

    Raises:
        MissingDependency: the package, or a version of it that streams set-points, is not here.
    """
    try:
        franky = importlib.import_module("franky")
    except ImportError as error:
        missing = getattr(error, "name", None) == "franky"
        why = "not found" if missing else f"cannot be loaded ({error})"
        raise MissingDependency(f"franka: Python package franky-control {why}; {_GET_IT}") from None
    if not hasattr(franky, "CartesianImpedanceTrackingMotion"):
        version = importlib.metadata.version("franky-control")
        raise MissingDependency(f"franka: franky-control 2.0 or newer not found, but {version}; {_GET_IT}")
    return franky
