"""Errors: one line, whatever is in them, and the same one in another process."""

import pickle

from mmt_drake.errors import BadInput


def test_the_message_is_one_line():
    error = BadInput("a.csv", at="row 3", found="x\ny", expected="a number")
    assert str(error) == "a.csv: row 3: found x y, expected a number"


def test_an_error_survives_the_way_to_another_process():
    error = BadInput("a.csv", at="row 3", found="x", expected="y")
    copy = pickle.loads(pickle.dumps(error))
    assert (str(copy), copy.source, copy.at, copy.found, copy.expected) == (str(error), "a.csv", "row 3", "x", "y")
