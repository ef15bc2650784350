"""Units that people write, and how many of the SI's each is."""

import re

_PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "": 1.0, "k": 1e3}
_RAD_DEG = 0.017453292519943295
_TABLE: dict[str, tuple[str, float]] = {
    **{f"{prefix}{base}": (base, size) for base in ("m", "s", "N", "V", "A") for prefix, size in _PREFIXES.items()},
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    **{f"{prefix}N m": ("N m", size) for prefix, size in _PREFIXES.items()},
    **{f"N {prefix}m": ("N m", size) for prefix, size in _PREFIXES.items()},
    "deg": ("rad", _RAD_DEG),
    "rev": ("rad", 360.0 * _RAD_DEG),
    "in": ("m", 0.0254),
    "min": ("s", 60.0),
    "gf": ("N", 9.80665e-3),
    "kgf": ("N", 9.80665),
    "lbf": ("N", 4.4482216152605),
    "g": ("kg", 1e-3),
    "kg": ("kg", 1.0),
    "1": ("1", 1.0),
}
_TABLE |= {f"{name}/s": (f"{unit}/s", size) for name, (unit, size) in _TABLE.items() if unit in ("m", "rad")}
_TABLE["rpm"] = ("rad/s", 6.0 * _RAD_DEG)

_SAME = {"sec": "s", "seconds": "s", "second": "s", "msec": "ms", "usec": "us", "newton": "N", "volt": "V", "amp": "A"}
_SAME |= {"°": "deg", "degrees": "deg", "degree": "deg", "inch": "in", "mps": "m/s", "mmps": "mm/s", "radps": "rad/s"}
_SAME |= {"degps": "deg/s", "dps": "deg/s", "-": "1", "": "1", "mNm": "mN m", "Nm": "N m", "Nmm": "N mm", "kNm": "kN m"}


def in_si(written: str) -> tuple[str, float] | None:
    """The SI unit of a unit as people write it, and how much of that it is; None: it is none that is known.

    `mm` is (`m`, 0.001), `mm/s` (`m/s`, 0.001), `deg` (`rad`, 0.0174...), `N*m`, `N.m` and `Nm` are (`N m`, 1).
    """
    plain = re.sub(r"[*.·_ ]+", " ", written.strip().replace("µ", "u").replace("μ", "u"))
    return _TABLE.get(_SAME.get(plain, plain))


def known(unit: str) -> list[str]:
    """The units of which an SI unit is made, as they may be written."""
    return [name for name, (si, _) in _TABLE.items() if si == unit]


def split(header: str) -> tuple[str, str | None]:
    """A column's header as name and unit: `x [mm]`, `x (mm)`, `x_mm` are `x` in `mm`; None: it tells no unit."""
    bracketed = re.fullmatch(r"(.*\S)\s*(?:\[(.*)\]|\((.*)\))", header)
    if bracketed and in_si(unit := bracketed[2] or bracketed[3] or ""):
        return bracketed[1], unit
    name, _, unit = header.rpartition("_")
    # A word of one letter that is no prefix's unit may be an axis or an index.
    return (name, unit) if name and unit not in ("1", "-", "g") and in_si(unit) else (header, None)
