"""Array operations in kernels give what numpy gives."""

import numpy as np
import pytest
from numba import njit

from mmt_drake.numeric.arrays import Array, assign, fixed_tuple


@njit
def first_three(values: Array) -> tuple[float, float, float]:
    return fixed_tuple(values, 3)


@pytest.mark.parametrize("values", [np.arange(1.0, 6.0), np.arange(1.0, 9.0)[::2], np.arange(1.0, 6.0)[2:]])
def test_a_tuple_holds_the_first_numbers_whatever_lies_between_them(values: Array) -> None:
    assert first_three(values) == tuple(values[:3])


def test_numbers_are_assigned_to_as_many_and_no_others() -> None:
    target, values = np.zeros(4), np.arange(4.0)
    assign(target[::-1], values)
    assert target.tolist() == [3.0, 2.0, 1.0, 0.0]
    with pytest.raises(ValueError, match="lengths differ"):
        assign(target, values[:3])
