"""Prints the Debian packages that are missing for mmt_drake, on one line; nothing if there are none.

Runs on the bare system Python before anything is installed, so it uses the standard library alone.
"""

import ctypes
import importlib.util
import sys

# Shared object that pydrake or open3d loads at import -> the Debian/Ubuntu package that brings it.
LIBRARIES = {
    "libusb-1.0.so.0": "libusb-1.0-0",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libX11.so.6": "libx11-6",
    "libglib-2.0.so.0": "libglib2.0-0",
}


def loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


packages = [package for library, package in LIBRARIES.items() if not loads(library)]
if importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
    packages.append(f"python{sys.version_info.major}.{sys.version_info.minor}-venv")
print(*packages)
