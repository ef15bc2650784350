"""The experiments, by the names that the command line has for them; what runs one is imported when it is run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from mmt_drake.diagrams.studies.study import Asked, Report, Study
from mmt_drake.errors import BadInput

Progress = Callable[[float], None]

_RUN: Final = ("operator", "seconds", "seed")


def _numbered(number: int) -> Study:
    def steps(asked: Asked) -> float:
        from mmt_drake.diagrams.experiments import PLANS

        return len(PLANS[number].cases())

    def run(asked: Asked, progress: Progress) -> Report:
        from mmt_drake.diagrams import experiments

        result = experiments.run_experiment(number, **asked.of_a_run(), jobs=asked.jobs, progress=progress)
        return experiments.report_of(result)

    return Study(f"experiment {number}, cases", _RUN, steps, run)


def _second_steps(asked: Asked) -> float:
    from mmt_drake.diagrams.experiments import second
    from mmt_drake.diagrams.experiments.second.run import ESTIMATORS

    return len(ESTIMATORS) * sum(contact.take is not None for contact in second.known_contacts())


def _second(asked: Asked, progress: Progress) -> Report:
    from mmt_drake.diagrams.experiments import second

    return second.report_of(second.run_second(out=asked.out, seed=asked.seed, seconds=asked.seconds, progress=progress))


def _engines_steps(asked: Asked) -> float:
    from mmt_drake.diagrams.experiments import engines

    return engines.runs_of()


def _engines(asked: Asked, progress: Progress) -> Report:
    from mmt_drake.diagrams.experiments import engines

    return engines.report_of(engines.run_engines(progress=progress))


def _ablation_steps(asked: Asked) -> float:
    from mmt_drake.diagrams.experiments import ablation

    return len(ablation.CAUSES) * len(ablation.RUNS)


def _ablation(asked: Asked, progress: Progress) -> Report:
    from mmt_drake.diagrams.experiments import ablation

    return ablation.report_of(ablation.run_ablation(**asked.of_a_run(), jobs=asked.jobs, progress=progress))


def _objects_count(asked: Asked) -> int:
    count = 100 if asked.count is None else asked.count
    if count < 1:
        raise BadInput("experiment objects", found=f"--count {count}", expected="one object at least")
    return count


def _objects(asked: Asked, progress: Progress) -> Report:
    from mmt_drake.diagrams.experiments import objects

    result = objects.run_objects(
        _objects_count(asked),
        estimator=asked.estimator or "output_error",
        isotropic=not asked.anisotropic,
        seed=asked.seed,
        progress=progress,
    )
    return objects.report_of(result)


def _cloud_steps(asked: Asked) -> float:
    from mmt_drake.diagrams.experiments import cloud

    return float(cloud.plan_of(asked.count, asked.seed).motion().cycle)


def _cloud(asked: Asked, progress: Progress) -> Report:
    from mmt_drake.diagrams.experiments import cloud

    return cloud.report_of(cloud.run_cloud(cloud.plan_of(asked.count, asked.seed), progress=progress))


def _comparison(name: str, takes: tuple[str, ...]) -> Study:
    def steps(asked: Asked) -> float:
        from mmt_drake.diagrams.experiments import comparisons

        return len(comparisons.chosen(name, asked.estimator).cases(asked.seed, asked.seconds))

    def run(asked: Asked, progress: Progress) -> Report:
        from mmt_drake.diagrams.experiments import comparisons

        comparison = comparisons.chosen(name, asked.estimator)
        compared = comparisons.run_comparison(comparison, **asked.of_a_run(), jobs=asked.jobs, progress=progress)
        return comparisons.report_of(compared)

    return Study(f"{name}, runs", takes, steps, run)


EXPERIMENTS: Final[dict[str, Study]] = {
    "1": _numbered(1),
    "2": Study("experiment 2, cases", ("seconds", "seed"), _second_steps, _second),
    "3": _numbered(3),
    "engines": Study("engines, runs", (), _engines_steps, _engines),
    "ablation": Study("ablation, runs", _RUN, _ablation_steps, _ablation),
    "objects": Study("objects", ("seed", "estimator", "count", "anisotropic"), _objects_count, _objects),
    "cloud": Study("cloud", ("seed", "count"), _cloud_steps, _cloud, simulated=True),
    "estimators": _comparison("estimators", ("seconds", "seed", "estimator")),  # its cases differ in their motion
    "network": _comparison("network", _RUN),
    "updates": _comparison("updates", _RUN),
    "peers": _comparison("peers", _RUN),
    "bands": _comparison("bands", ("seconds", "seed")),  # and so do these
}
