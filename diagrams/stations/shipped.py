"""The scenarios that come with the project."""

from pathlib import Path

SCENARIOS = Path(__file__).parent / "scenarios"


def shipped() -> list[str]:
    """Their names."""
    return sorted(path.stem for path in SCENARIOS.glob("*.yaml"))
