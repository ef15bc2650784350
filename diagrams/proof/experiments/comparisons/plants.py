"""The free-running estimator on plants that it does not share: other physics, other sensors, a surface elsewhere."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis.metrics import ForceError
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, ratio_of
from mmt_drake.diagrams.proof.experiments.targets import FIRST_HALF_SECOND, MEDIAN_TOUCH, REST_OF_CONTACT, TOUCHES
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario

_FOREIGN: Final = "environment.!=ForeignBox"
_FREE: Final = "environment.object.friction=null"
_RUBBING: Final = (_FREE, "environment.object.parameters.Fc=0.5")
_SENSORS: Final = "environment.sensors={position_resolution: 1.0e-5, velocity_window: 0.01}"
_LAB: Final = ("environment.sensors={position_resolution: 1.0e-5, delay: 0.002}", "environment.surface=0.0002")
PLANTS: Final[Mapping[str, tuple[str, ...]]] = {
    "own": (),
    "foreign": (_FOREIGN,),
    "own, no friction": (_FREE,),
    "foreign, no friction": (_FOREIGN, _FREE),
    "own, 0.5 N": _RUBBING,
    "foreign, 0.5 N": (_FOREIGN, *_RUBBING),
    "foreign, 0.5 N, positions to 10 um, velocity over 10 ms": (_FOREIGN, *_RUBBING, _SENSORS),
    "foreign, force 2 ms late": (_FOREIGN, "environment.sensors.delay=0.002"),
    "foreign, force below 40 Hz": (_FOREIGN, "environment.sensors.corner=40.0"),
    "foreign, 0.5 N, force 2 ms late": (_FOREIGN, *_RUBBING, "environment.sensors.delay=0.002"),
    "foreign, 0.5 N, force below 40 Hz": (_FOREIGN, *_RUBBING, "environment.sensors.corner=40.0"),
    "foreign, 0.5 N, positions to 10 um, force 2 ms late, surface 0.2 mm higher": (_FOREIGN, *_RUBBING, *_LAB),
    "foreign, 0.5 N, surface 0.2 mm higher": (_FOREIGN, *_RUBBING, "environment.surface=0.0002"),
    "foreign, 0.5 N, surface 1 mm lower": (_FOREIGN, *_RUBBING, "environment.surface=-0.001"),
    "foreign, 0.5 N, surface 1 mm higher": (_FOREIGN, *_RUBBING, "environment.surface=0.001"),
}
"""What a case is called -> what is set in `setup1-free-running`."""
_LENGTH_S: Final = 60.0
_STAGES: Final = {
    "error_first_0.5s_true": FIRST_HALF_SECOND,
    "error_rest_true": REST_OF_CONTACT,
    "error_touches_true": TOUCHES,
}


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Every plant under the same motion."""
    return {name: station_on(name, asked) for name in PLANTS}


def station_on(plant: str, asked: Asked, *changes: str) -> Scenario:
    """`setup1-free-running` on one of the plants, with further changes."""
    scenario = load_scenario("setup1-free-running", [*PLANTS[plant], *changes])
    return replace(scenario, seed=asked.seed, duration=asked.seconds or _LENGTH_S)


def judge(found: Cases) -> Findings:
    """The rendered force against the plant's, whole run, first seconds and touches included."""
    headers = ["plant", "against the measured force, after 5 s [%]", "after 5 s [%]", "first 0.5 s of contact [%]"]
    headers += ["all after it [%]", "first 50 ms of all touches [%]", "of the median touch [%]", "normal [%]"]
    caption = (
        "Error of the rendered force along x and y; all but the first and the last column against the plant's force "
        "without noise or delay, the last against the measured one. The first touch is that of an object which nobody "
        "knows: it is felt as what is believed beforehand, and all touches together show that."
    )
    return findings_of({name: _judged(case) for name, case in found.items()}, headers, caption)


def _judged(case: MeasuredRun) -> CaseFindings:
    measured = case.metrics.rendered_error
    errors: list[ForceError | None] = [measured, case.true_error, *map(case.metrics.stages.get, _STAGES)]
    row: list[Cell] = [case.name, *(in_percent(ratio_of(error)) for error in errors)]
    each = case.metrics.median_touch_error
    stages = [Reached(case.name, target, ratio_of(case.metrics.stages.get(name))) for name, target in _STAGES.items()]
    return CaseFindings(
        [*row, in_percent(each), in_percent(measured.normal["all"])],
        reached=[*stages, Reached(case.name, MEDIAN_TOUCH, each)],
    )


COMPARED_PLANTS: Final = Comparison(
    name="plants",
    title="Is the rendered force right on a plant that the estimator does not share?",
    lead=(
        "`setup1-free-running`, strokes, friction of 0.1 N that holds and 0.05 N that slides unless a case says "
        "otherwise. The own plant calls the estimator's equations; the foreign one is another simulation, with another "
        "integrator and another rule for sticking."
    ),
    cases=cases,
    judge=judge,
    file=lambda number, name: str(number),
)
