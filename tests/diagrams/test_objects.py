"""What is rendered, from the first touch on with parameters estimated meanwhile, is what the object gives."""

from __future__ import annotations

import json

import numpy as np
import pytest

from diagrams.experiments.objects import (
    RANGES,
    drawn,
    objects_findings,
    objects_table,
    run_model,
    run_objects,
    write_objects,
)
from diagrams.scenario import load_scenario
from mmt_drake.analysis.signals import BAND_NAMES


@pytest.fixture(scope="module")
def three():
    return run_objects(3, jobs=1)


def test_the_thesis_s_object_is_rendered_within_half_a_percent_in_each_band() -> None:
    case = run_model(load_scenario("setup1").environment.object)
    assert {band for band in BAND_NAMES if (case.errors[band] or 0.0) > 0.005} == set()


def test_objects_drawn_at_random_are_found_and_rendered_within_a_percent(three) -> None:
    assert three.statistics()["median"] < 0.01
    for case in three.cases:
        np.testing.assert_allclose(case.found[:8], case.true[:8], rtol=0.02)


def test_draws_are_within_their_ranges_and_each_is_another() -> None:
    models = [drawn(number, 5, isotropic=False) for number in range(30)]
    for name, (low, high) in RANGES.items():
        values = [model.parameter(name) for model in models]
        assert low <= min(values) < max(values) <= high and len(set(values)) == 30
    assert all(model.normal.k != model.parameter("k2") for model in models)
    assert drawn(3, 5).normal.k == drawn(3, 5).parameter("k2")


def test_the_document_is_plain_and_the_page_tells_the_worst(three, tmp_path) -> None:
    document = json.loads(json.dumps(three.to_json()))
    assert len(document["cases"]) == 3 and document["statistics"]["median"] < document["to_reach"]["median"]
    page = write_objects(three, tmp_path).read_text()
    assert objects_findings(three)[0] in page
    assert [row[0] for row in objects_table(three).rows if row[0]] == [str(case.number) for case in three.worst()]
