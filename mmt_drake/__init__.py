"""Model-mediated teleoperation on Drake.

`import mmt_drake as mmt` offers what `__init__.pyi` lists, each imported when it is first used. These names stay;
modules below may move.

    station = mmt.build_station(mmt.load_scenario("setup1-free-running"), record="out.mcap")
    station.simulate()
    outcome = mmt.diagnose([mmt.load("out.mcap")], mmt.load_model("model.yaml"))
"""

from pathlib import Path

import lazy_loader

from mmt_drake.kernel_cache import discard_stale

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

discard_stale(Path(__file__).parent)
