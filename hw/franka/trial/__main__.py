"""`python -m mmt_drake.hw.franka.trial [MOMENTS]` prints the table of faults."""

from __future__ import annotations

import math
import sys

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.franka.trial.kinds import KINDS
from mmt_drake.hw.franka.trial.run import try_fault


def main() -> int:
    """Print; the exit status is 1 if anything was not as it must be."""
    moments = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    try:
        load_franky()
        emulated = EmulatedFranka()
    except MissingDependency as error:
        print(error, file=sys.stderr)
        return 2
    wrong = 0
    with emulated as franka:
        print(f"{'fault':36}{'moments':>8}{'at rest after [ms]':>20}{'allowed [ms]':>14}{'moved [mm]':>12}")
        for name in KINDS:
            outcome = try_fault(name, franka, moments)
            figures = outcome.rest_after, outcome.allowed, outcome.moved
            after, allowed, moved = ("goes on" if math.isnan(value) else f"{1e3 * value:.0f}" for value in figures)
            print(f"{name:36}{outcome.moments:8}{after:>20}{allowed:>14}{moved:>12}", flush=True)
            for line in outcome.wrong:
                print(f"    {line}")
            wrong += len(outcome.wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
