"""Numbers as people read them."""


def significant(value: float, digits: int) -> str:
    """A number to so many significant digits, 6 at most, without an exponent from 0.0001 to a million."""
    return f"{float(f'{value:.{digits}g}'):g}"


def percent(ratio: float | None) -> str:
    """A ratio as percent; None is unknown."""
    return "unknown" if ratio is None else f"{significant(100.0 * ratio, 3)} %"


def in_percent(ratio: float | None) -> float | None:
    """A ratio as the number of percent for a table; None stays None."""
    return None if ratio is None else 100.0 * ratio


def milliseconds(seconds: float | None) -> str:
    """A time [s] as milliseconds; None is unknown."""
    return "an unknown time" if seconds is None else f"{significant(1e3 * seconds, 4)} ms"
