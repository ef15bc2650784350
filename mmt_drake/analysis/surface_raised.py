"""How far touches say that the surface is from where the cloud shows it, as known by the end of a run."""

from dataclasses import dataclass
from typing import Any

from mmt_drake.recording.recording import Recording

_NOTICED_M = 1e-4


@dataclass(frozen=True)
class SurfaceRaised:
    """The surface's height over the cloud's.

    Attributes:
        height: of the surface over where the cloud shows it [m].
        deviation: standard deviation of that [m].
    """

    height: float
    deviation: float

    def line(self) -> str:
        """For a terminal."""
        told = f"{1e3 * abs(self.height):.2f} +- {1e3 * self.deviation:.2f} mm"
        if abs(self.height) < max(2.0 * self.deviation, _NOTICED_M):
            return f"surface: touches say that it is where the cloud shows it ({told})"
        where = "above" if self.height > 0.0 else "below"
        return f"surface: touches say that it is {told} {where} where the cloud shows it, and it was corrected"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {"height_m": self.height, "deviation_m": self.deviation}


def surface_raised(recording: Recording) -> SurfaceRaised | None:
    """What the last sample of a recording says of it; None where no touch was asked, or none came."""
    names = "surface_raised_height", "surface_raised_deviation"
    if not all(name in recording for name in names):
        return None
    height, deviation = (recording[name] for name in names)
    if deviation[-1] == deviation[0] and height[-1] == 0.0:
        return None
    return SurfaceRaised(float(height[-1]), float(deviation[-1]))
