"""Model-mediated teleoperation on Drake.

`import mmt_drake as mmt` offers what `__init__.pyi` lists, each imported when it is first used. These names stay;
modules below may move.

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
