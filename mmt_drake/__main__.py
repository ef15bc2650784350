"""`python -m mmt_drake` is `mmt-drake`."""

import sys

from mmt_drake.cli.main import main

sys.exit(main())
