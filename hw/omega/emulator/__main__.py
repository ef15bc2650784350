"""`python -m mmt_drake.hw.omega.emulator FOLDER` builds the emulated library, for any program to find through FDSDK."""

import sys
from pathlib import Path

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.omega.emulator.build import build_library


def main() -> int:
    """Build, and say how it is used."""
    if len(sys.argv) != 2:
        print("usage: python -m mmt_drake.hw.omega.emulator FOLDER", file=sys.stderr)
        return 2
    folder = Path(sys.argv[1]).resolve()
    try:
        build_library(folder)
    except MissingDependency as error:
        print(error, file=sys.stderr)
        return 2
    print(f"FDSDK={folder}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
