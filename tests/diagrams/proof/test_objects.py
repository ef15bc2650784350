"""What is rendered, from the first touch on with parameters estimated meanwhile, is what the object gives."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.objects import (
    RANGES,
    RESOLUTION_M,
    drawn,
    in_a_lab,
    objects_findings,
    objects_table,
    report_of,
    run_objects,
)
from mmt_drake.diagrams.proof.studies import Asked


@pytest.fixture(scope="module")
def four():
    return run_objects(Asked(Path(), count=4))


def test_of_objects_drawn_at_random_the_median_is_within_1_and_the_95th_percentile_within_5_percent(four) -> None:
    for figures in (four.figures_to_reach()[:3], four.figures_to_reach()[3:6]):  # own plant, and one of other physics
        assert [figure.target.to_reach for figure in figures] == [0.01, 0.05, None]
        assert figures[0].reached and figures[1].reached
    own, foreign = (four.figures_to_reach()[i].value for i in (2, 5))
    assert own == max(case.error for case in four.cases) and foreign == max(case.foreign for case in four.cases)
    for case in four.cases:
        np.testing.assert_allclose(case.found[:8], case.true[:8], rtol=0.02)


def test_all_contact_after_its_first_half_second_is_asked_of_three_plants(four) -> None:
    asked = four.figures_to_reach()[6:]
    assert [(figure.case.partition("error")[2], figure.target.to_reach, figure.reached) for figure in asked] == [
        (plant, to_reach, True)
        for plant in ("", ", foreign plant", ", foreign plant, sensors of a lab")
        for to_reach in (0.015, 0.05)
    ]
    for figure in asked:  # the first numbers are worse than the last
        assert figure.value > four.statistics()["median"]


def test_a_lab_s_sensors_read_in_steps_and_the_force_late() -> None:
    read = in_a_lab(np.linspace(0.0, 1e-3, 90).reshape(10, 9))
    np.testing.assert_allclose(read[:, :3] / RESOLUTION_M, np.round(read[:, :3] / RESOLUTION_M), atol=1e-9)
    np.testing.assert_allclose(read[2:, 6:], np.linspace(0.0, 1e-3, 90).reshape(10, 9)[:-2, 6:], atol=1e-12)


def test_the_bound_of_the_noise_stands_beside_the_object_at_the_percentile(four) -> None:
    cases = [replace(case, errors={"all": 0.01 * k}, noise_leaves=0.001 * k) for k, case in enumerate(four.cases)]
    most = replace(four, cases=tuple(cases)).figures_to_reach()[1]
    assert most.value == pytest.approx(np.quantile(0.01 * np.arange(4), 0.95)) and most.bound == 0.003


def test_draws_are_within_their_ranges_and_each_is_another() -> None:
    models = [drawn(number, 5, isotropic=False) for number in range(30)]
    for name, (low, high) in RANGES.items():
        values = [model.parameter(name) for model in models]
        assert low <= min(values) < max(values) <= high and len(set(values)) == 30
    assert all(model.normal.k != model.parameter("k2") for model in models)
    assert drawn(3, 5).normal.k == drawn(3, 5).parameter("k2")


def test_the_document_is_plain_and_the_page_tells_the_worst(four, tmp_path) -> None:
    document = json.loads(json.dumps(report_of(four).document))
    assert len(document["cases"]) == 4 and document["figures_to_reach"][0]["value"] == document["statistics"]["median"]
    page = report_of(four).write(tmp_path).read_text()
    assert objects_findings(four)[0] in page and "95th percentile [%]" in page
    assert [row[0] for row in objects_table(four).rows if row[0]] == [str(case.number) for case in four.worst()]
