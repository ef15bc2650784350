"""`python -m mmt_drake.hw.omega.trial [MOMENTS]` prints the table of faults"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.hw.omega.trial.kinds import KINDS
from mmt_drake.hw.omega.trial.run import try_fault


def main() -> int:
    """Print; the exit status is 1 if anything was not as it must be."""
    moments = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    with tempfile.TemporaryDirectory(prefix="emulated-") as folder:
        try:
            omega = EmulatedOmega(load_emulated(Path(folder)))
        except MissingDependency as error:
            print(error, file=sys.stderr)
            return 2
        print(f"{'fault':36}{'moments':>8}{'felt':>6}{'most [N]':>10}{'zero after [ms]':>17}{'allowed [ms]':>14}")
        wrong = 0
        for name in KINDS:
            outcome = try_fault(name, omega, moments)
            after, allowed = (
                "goes on" if math.isnan(seconds) else f"{1e3 * seconds:.1f}"
                for seconds in (outcome.zero_after, outcome.allowed)
            )
            numbers = f"{outcome.moments:8}{outcome.felt:6}{outcome.greatest_force:10.2f}"
            print(f"{name:36}{numbers}{after:>17}{allowed:>14}")
            for line in outcome.wrong:
                print(f"    {line}")
            wrong += len(outcome.wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
