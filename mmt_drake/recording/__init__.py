"""Recordings in and out: units, clocks, frames."""

from mmt_drake.recording.files import load, load_all, save
from mmt_drake.recording.mcap_writer import McapWriter
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import AXES

__all__ = ["AXES", "McapWriter", "Recording", "load", "load_all", "save"]
