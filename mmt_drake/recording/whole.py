"""The end of a recording whose run fails: nothing is left for bad input, and all of it, named, for anything else."""

from collections.abc import Iterator
from contextlib import contextmanager

from mmt_drake.errors import BadInput
from mmt_drake.recording.mcap_writer import McapWriter


@contextmanager
def whole_or_none(writer: McapWriter, told_as: object = None) -> Iterator[None]:
    """Leave no part of a recording behind where bad input ends it, and say where it is where anything else does.

    Args:
        writer: of the recording; alone it keeps what it has, for those who have only that.
        told_as: the name in the message where the file could not be written; its own by default.

    Raises:
        BadInput: as raised within; a full disk without the promise that its beginning is kept.
    """
    try:
        yield
    except BadInput as error:
        writer.discard()
        if str(error.source) != writer.name or not isinstance(error.__cause__, OSError):
            raise
        expected = "room for the recording; its beginning is removed"
        raise BadInput(told_as or writer.name, found=error.found, expected=expected) from error
    except Exception as error:
        if writer.stands:
            error.add_note(f"recorded until then: {writer.path}")
        raise
