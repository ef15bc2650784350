"""The estimators there are, by the options that choose them."""

from __future__ import annotations

from typing import Final

from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions

EstimatorOptions = RlsOptions | OutputErrorOptions
NAMES: Final[dict[type, str]] = {RlsOptions: "rls", OutputErrorOptions: "output_error"}
"""What an estimator is called, in results and on the command line; see `mmt_drake.cli.experiment`."""
