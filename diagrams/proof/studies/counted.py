"""How many of how many, and what that bounds."""

from collections.abc import Sequence
from typing import Any

from scipy.stats import binomtest


def counted(flags: Sequence[bool], *, from_above: bool) -> dict[str, Any]:
    """How many of how many, and the one-sided 95 % bound of the rate behind it (Clopper and Pearson, exact).

    Args:
        flags: one at least, a case each.
        from_above: whether the rate is bounded from above (`at_most`), or else from below (`at_least`).
    """
    said = binomtest(sum(flags), len(flags), alternative="less" if from_above else "greater")
    low, high = said.proportion_ci(0.95, method="exact")
    return {"count": sum(flags), "of": len(flags), **({"at_most": high} if from_above else {"at_least": low})}
