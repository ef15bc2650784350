"""Model-mediated teleoperation on Drake.

`import mmt_drake as mmt` offers these names, each imported when it is first used. They stay; modules below may move.
`help(mmt.run)` and so on tells their arguments.

    run, build_station, load_scenario    a station from a scenario: run it, or have its diagram
    measure                              how far the rendered force of a run is off
    load, save, Recording                recordings, in every format
    diagnose, fit                        what a model leaves out that recordings show; a first model from them
    simulate, load_model, save_model     a model's answer to a recorded motion; model files
    LIBRARY, register_file               the effects that are known, by name; one's own
    LeafSystem, KernelSystem             bases of one's own systems
    MmtError                             of every error that is told in one line

    recording = mmt.run("setup1-free-running", seconds=20, record="out.mcap")
    outcome = mmt.diagnose([recording], mmt.load_model("model.yaml"))
    frame = recording.to_dataframe()
"""

from pathlib import Path

import lazy_loader

from mmt_drake.kernel_cache import discard_stale

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

discard_stale(Path(__file__).parent)
