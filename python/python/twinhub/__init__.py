"""twinhub: stabilizer for e-bikes with two hub motors, and its test bench.

Parameters and modes of bicycles, simulated rides, and ride logs, with the code and the numbers of
the ``twinhub`` command. All quantities are SI, and every name carries its unit; frames and signs
are those of Meijaard et al. (2007): x forward, y right, z down; roll, steer and yaw positive to
the right.

* `bicycles`, `parameters`, `parameter_units`: parameter sets of the benchmark bicycle.
* `modes`: weave, capsize and caster over speed, under motor torques.
* `courses`, `ride`: a simulated ride, as numpy columns.
* `read_log`: a ride log (MCAP), as numpy columns.
* `TwinhubError`: the base of every error.
"""

from ._bicycle import bicycles, parameter_units, parameters
from ._log import Columns, Event, Log, Recovery, read_log
from ._modes import Crossing, Modes, modes
from ._ride import Metrics, Ride, courses, ride
from ._twinhub import __version__
from .errors import InputError, LogError, RideError, TwinhubError, UnknownNameError

__all__ = [
    "Columns",
    "Crossing",
    "Event",
    "InputError",
    "Log",
    "LogError",
    "Metrics",
    "Modes",
    "Recovery",
    "Ride",
    "RideError",
    "TwinhubError",
    "UnknownNameError",
    "__version__",
    "bicycles",
    "courses",
    "modes",
    "parameter_units",
    "parameters",
    "read_log",
    "ride",
]
