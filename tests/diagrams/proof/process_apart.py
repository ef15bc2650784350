"""Programs that need a process of their own, which loads a library of its own."""

import os
import subprocess
import sys
from pathlib import Path


def output_of(program: str, checkout: Path, *arguments: str) -> str:
    """What a Python program of this checkout prints; it must end well."""
    environ = {**os.environ, "PYTHONPATH": os.pathsep.join([str(checkout), os.environ.get("PYTHONPATH", "")])}
    line = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(line, env=environ, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout
