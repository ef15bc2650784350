"""How far touches say that the surface is from where the cloud shows it, as known by the end of a run."""

from dataclasses import dataclass
from typing import Any

from mmt_drake.recording.recording import Recording


@dataclass(frozen=True)
class SurfaceRaised:
    """The surface's height over the cloud's.

    Attributes:
        height: by which the cloud was moved up [m]; 0 where touches do not say for sure that it is elsewhere.
        deviation: standard deviation of the surface's height over that [m].
        believed: the same before the first touch [m].
    """

    height: float
    deviation: float
    believed: float

    def line(self) -> str:
        """For a terminal."""
        if self.deviation >= self.believed:
            return "surface: no touch told its height: the hand has to leave it, and to come down on it again"
        if self.height == 0.0:
            return f"surface: where the cloud shows it, as far as touches tell (+- {1e3 * self.deviation:.2f} mm)"
        where = "above" if self.height > 0.0 else "below"
        told = f"{1e3 * abs(self.height):.2f} +- {1e3 * self.deviation:.2f} mm"
        return f"surface: touches say that it is {told} {where} where the cloud shows it, and it was corrected"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {"height_m": self.height, "deviation_m": self.deviation}


def surface_raised(recording: Recording) -> SurfaceRaised | None:
    """What the last sample of a recording says of it; None where no touch was asked."""
    names = "surface_raised_height", "surface_raised_deviation"
    if not all(name in recording for name in names):
        return None
    height, deviation = (recording[name] for name in names)
    return SurfaceRaised(float(height[-1]), float(deviation[-1]), float(deviation[0]))
