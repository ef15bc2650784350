"""What `import mmt_drake` offers."""

from .analysis.metrics import measure as measure
from .diagnosis.diagnose import diagnose as diagnose
from .diagnosis.first_model import fit as fit
from .diagrams.stations.run import run as run
from .diagrams.stations.scenario import load_scenario as load_scenario
from .diagrams.stations.station import build_station as build_station
from .effects import LIBRARY as LIBRARY
from .effects import register_file as register_file
from .errors import MmtError as MmtError
from .model_files import load_model as load_model
from .model_files import save_model as save_model
from .recording import Recording as Recording
from .recording import load as load
from .recording import save as save
from .simulation import simulate as simulate
from .systems.kernel_system import KernelSystem as KernelSystem
from .systems.leaf import LeafSystem as LeafSystem

__version__: str
