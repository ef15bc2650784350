"""Numbers whose type says their unit and range are checked, and asked about, by that alone."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Mass, Quantity, quantities


@dataclass(frozen=True)
class _Thing(Checked):
    m: Mass = 1.0
    offset: Annotated[float, Quantity("N", -math.inf)] = 0.0
    share: Annotated[float | None, Quantity("1", 0.0, 1.0)] = None
    count: Annotated[int, Quantity("", 1, whole=True)] = 1
    kind: Literal["hard", "soft"] = "hard"

    CALLED: ClassVar = "thing"


def test_the_fields_that_are_quantities_are_told_in_their_order() -> None:
    assert {name: quantity.unit for name, quantity in quantities(_Thing).items()} == {
        "m": "kg",
        "offset": "N",
        "share": "1",
        "count": "",
    }
    assert list(quantities(_Thing)) == ["m", "offset", "share", "count"]


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"m": 0.0}, "thing: m: found 0.0, expected a finite number > 0"),
        ({"offset": math.nan}, "thing: offset: found nan, expected a finite number >= -inf"),
        ({"share": 1.5}, "thing: share: found 1.5, expected 0 to 1"),
        ({"m": True}, "thing: m: found True, expected a number"),
        ({"count": 1.0}, "thing: count: found 1.0, expected a whole number"),
        ({"kind": "wet"}, "thing: kind: found wet, expected one of hard, soft"),
    ],
)
def test_a_quantity_out_of_range_is_refused(values: dict[str, object], told: str) -> None:
    _Thing(m=np.float64(0.1), offset=-3.0, share=1, count=np.int64(2), kind="soft")  # type: ignore[arg-type]
    with pytest.raises(BadInput, match=told.replace(".", r"\.")):
        _Thing(**values)  # type: ignore[arg-type]
