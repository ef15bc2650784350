"""What stands on disk is gone with the last who holds it, and nobody is warned of it."""

import gc
import warnings

import numpy as np
import pytest

from mmt_drake.recording.stored import StoredColumn, StoredPoints


@pytest.mark.parametrize("kind", [StoredColumn, StoredPoints])
@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_a_file_is_closed_with_the_last_who_holds_it(kind: type[StoredColumn] | type[StoredPoints]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("always", ResourceWarning)
        stored = kind()
        stored.add(np.ones((3, 3)))
        file = stored._file
        del stored
        gc.collect()
    assert file.closed


def test_what_was_read_outlives_the_file() -> None:
    stored = StoredColumn()
    stored.add(np.arange(3.0))
    values = stored.read()
    del stored
    gc.collect()
    assert values.tolist() == [0.0, 1.0, 2.0]
