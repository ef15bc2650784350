"""The shipped layout for Foxglove, which opens recordings in `.mcap`: the file that it takes, and what that shows."""

import json
import re
from collections.abc import Iterator
from importlib import resources
from typing import Any, Final

_FILE: Final = "foxglove_layout.json"
_TOPIC = re.compile(r"(/[\w/]+)(?:\.(.+))?")


def layout_text() -> str:
    """The layout, as the file that Foxglove imports (Layouts, Import from file)."""
    return resources.files("mmt_drake").joinpath("data", _FILE).read_text()


def shown() -> list[tuple[str, str]]:
    """What the layout shows: topic, and the field of its messages; an empty one where all of a message is shown."""
    found = (_TOPIC.fullmatch(text) for text in _texts(json.loads(layout_text())["configById"]))
    return sorted({(match[1], match[2] or "") for match in found if match is not None})


def _texts(value: Any) -> Iterator[str]:
    """Every key and every text in it."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield key
            yield from _texts(part)
    elif isinstance(value, list):
        for part in value:
            yield from _texts(part)
    elif isinstance(value, str):
        yield value
