"""Sets of effects that no recording of one axis can tell apart, as the library publishes them (`Effect.equal_to`)."""

from collections.abc import Callable

from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import ranges
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.effect import Effect, both_ways


def turns(problem: Problem, fitted: Fitted) -> bool:
    """Whether what slides in the recordings goes both ways."""
    return both_ways("sliding_velocity")({}, ranges(problem, fitted))


def equal_sets(fitted: Fitted, turning: bool = True) -> tuple[frozenset[str], ...]:
    """What else the effects of a fit could be called, in full: sets of names, no two for one place of a model.

    Args:
        fitted: the fit.
        turning: see `turns`.
    """
    model = fitted.hypothesis.nominal
    massless = "m" in model.SYMBOLS and model.value("m") == 0.0
    return _sets(fitted, lambda e: e.equal_to + e.equal_one_way * (not turning) + e.equal_massless * massless)


def always_equal(fitted: Fitted) -> tuple[frozenset[str], ...]:
    """Those of `equal_sets` that are equal in every motion and every model."""
    return _sets(fitted, lambda effect: effect.equal_to)


def _sets(fitted: Fitted, equals: Callable[[Effect], tuple[str, ...]]) -> tuple[frozenset[str], ...]:
    key, has = fitted.hypothesis.key, _structural(fitted)
    found: dict[frozenset[str], None] = {}
    for effect in LIBRARY.values():
        for text in equals(effect):
            other = frozenset(text.split(" + "))
            if effect.name in key:
                names = (key - {effect.name}) | other
                found[names - has if other & has else names] = None
            elif other <= key | has:
                found[(key - other) | {effect.name}] = None
    nominal = fitted.hypothesis.nominal

    def is_possible(names: frozenset[str]) -> bool:
        effects = [LIBRARY[name] for name in names]
        return len({e.target for e in effects}) == len(effects) and all(e.acts_on(nominal) for e in effects)

    return tuple(filter(is_possible, found))


def are_equal(one: Fitted, other: Fitted) -> bool:
    """Whether two fits say the same by other names; what the model handed in has anyway need not be named."""
    has = _structural(one)
    return any(other.hypothesis.key in (names, names - has) for names in equal_sets(one))


def _structural(fitted: Fitted) -> frozenset[str]:
    """Effects that the model handed in has, by name or as parameters of its own."""
    model = fitted.hypothesis.nominal
    own = frozenset(name for name, e in LIBRARY.items() if e.adds_to is not None and model.value(e.adds_to) != 0.0)
    return own | {effect.name for effect, _ in fitted.hypothesis.believed}
