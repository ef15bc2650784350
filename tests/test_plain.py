"""Results become data that files have words for."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mmt_drake.plain import plain


@dataclass(frozen=True)
class Found:
    names: tuple[str, ...]
    error: np.float64


def test_dataclasses_arrays_and_scalars_of_numpy_are_python_s_own_to_any_depth():
    found = {"cases": (Found(("k", "b"), np.float64(0.5)), np.array([[1, 2]])), 3: np.True_}
    assert plain(found) == {"cases": [{"names": ["k", "b"], "error": 0.5}, [[1, 2]]], "3": True}


def test_for_json_what_is_not_finite_is_none_and_what_has_no_word_is_what_it_is_called():
    found = [np.array([1.0, np.nan]), float("inf"), Path("run.mcap")]
    assert plain(found, finite=True) == [[1.0, None], None, "run.mcap"]
    assert plain(found)[1:] == [float("inf"), Path("run.mcap")]
