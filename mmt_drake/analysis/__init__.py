"""The numbers and figures behind a recording: errors by band, lags, energy, charts and one page that shows them.

Everything here reads a `mmt_drake.recording.Recording` and nothing else, so that what an experiment prints can be
computed again from the file it left.
"""
