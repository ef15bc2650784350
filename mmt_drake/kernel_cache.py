"""Keeps compiled kernels in step with the sources.

Numba's disk cache watches the file a kernel stands in, not the files of the kernels it has inlined. A change of
one law would leave its callers with the old one, silently. So whenever a source that may hold a kernel has changed,
all of the package's own cached kernels are dropped, and compiled anew at their first use.
"""

import contextlib
import hashlib
import os
from pathlib import Path

_STAMP = "kernels.stamp"
# Folders whose kernels, if any, are called by no kernel elsewhere (laws of effects: through their addresses only).
_ON_THEIR_OWN = ("cli", "analysis", "diagnosis", "effects", "systems", "viewer")


def discard_stale(package: Path) -> bool:
    """Delete the cached kernels below `package` if a source has changed since they were compiled.

    Returns:
        Whether there was something to discard. A folder that cannot be written is left alone: there numba keeps
        its cache elsewhere, by the time stamps of an installation that changes as a whole.
    """
    digest = hashlib.sha256()
    for source in sorted(package.rglob("*.py")):
        if source.relative_to(package).parts[0] in _ON_THEIR_OWN:
            continue
        status = source.stat()
        digest.update(f"{source} {status.st_mtime_ns} {status.st_size}\n".encode())
    stamp = package / "__pycache__" / _STAMP
    current = digest.hexdigest()
    with contextlib.suppress(OSError):
        if stamp.exists() and stamp.read_text() == current:
            return False
        for folder in _folders(package):
            for cached in folder.rglob("__pycache__/*.nb[ic]"):
                cached.unlink(missing_ok=True)
        stamp.parent.mkdir(exist_ok=True)
        # A rename, so that no process reads half a stamp.
        temporary = stamp.with_name(f"{_STAMP}.{os.getpid()}")
        temporary.write_text(current)
        temporary.replace(stamp)
        return True
    return False


def _folders(package: Path) -> list[Path]:
    """Where cached kernels may be: in a checkout the subpackages `diagrams` and `hw` stand beside the package."""
    root = package.parent
    beside = [root / "diagrams", root / "hw"] if (root / "pyproject.toml").exists() else []
    return [package, *beside]
