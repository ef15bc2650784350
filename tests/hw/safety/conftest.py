"""The contract test's helpers, which stand beside those of the library's own systems."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "systems"))
