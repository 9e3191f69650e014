"""twinhub: stabilizer for e-bikes with two hub motors, and its test bench.

Parameters and modes of bicycles, simulated rides, and ride logs, with the code and the numbers of
the ``twinhub`` command. All quantities are SI, and every name carries its unit; frames and signs
are those of Meijaard et al. (2007): x forward, y right, z down; roll, steer and yaw positive to
the right.

* `Bicycle`, `Tyre`, `Rider`, `Motors`, `Sensors`, `Road`, `Wind`, `Law`, `Course`, `Scenario`, `Study`: whatever has
  a name and a file, with its values.
* `bicycles`, `parameters`, `parameter_units`: parameter sets of the benchmark bicycle.
* `modes`: weave, capsize and caster over speed, under motor torques; `linearise`, `gradients`,
  `stability_map`.
* `courses`, `ride`: a simulated ride, as numpy columns; `batch`: many of them, on all cores.
* `laws`, `Controller`: the stabilizer itself, tick by tick, and what it believes (`Known`).
* `tune`: schedules, ramps and thresholds against effort, falls and energy.
* `design`: schedules with a proof.
* `league`: controllers against each other over a population of riders.
* `diagnose`, `experiment`: what the model gets wrong about measured rides, and why.
* ``twinhub.gym``: a Gymnasium environment.
* `read_log`: a ride log (MCAP), as numpy columns.
* `TwinhubError`: the base of every error.
"""

from ._batch import Batch, batch
from ._bicycle import bicycles, parameter_units, parameters
from ._controller import Controller, laws
from ._design import Design, design
from ._diagnose import Diagnosis, Experiment, diagnose, experiment
from ._league import League, league, merge_leagues
from ._linear import Gradients, Linear, gradients, linearise
from ._log import Columns, Event, Log, Recovery, read_log
from ._map import StabilityMap, stability_map
from ._messages import (
    NEVER_NS,
    Estimate,
    ImuSample,
    Known,
    Measurement,
    MotorSample,
    Output,
    RiderIntent,
    RollSample,
    SteerSample,
    WheelSample,
)
from ._modes import Crossing, Modes, modes
from ._ride import Metrics, Perception, Ride, courses, ride
from ._things import (
    Bicycle,
    Course,
    Law,
    Motors,
    Rider,
    Road,
    Run,
    Scenario,
    Sensors,
    Study,
    Thing,
    Tyre,
    Wind,
)
from ._tune import Trial, Tuning, Weighted, effort_nm, energy_wh_per_km, tune
from ._twinhub import __version__
from .errors import InputError, LogError, RideError, TwinhubError, UnknownNameError

__all__ = [
    "Batch",
    "Bicycle",
    "Columns",
    "Controller",
    "Course",
    "Crossing",
    "Design",
    "Diagnosis",
    "Estimate",
    "Event",
    "Experiment",
    "Gradients",
    "ImuSample",
    "InputError",
    "Known",
    "Law",
    "League",
    "Linear",
    "Log",
    "LogError",
    "Measurement",
    "Metrics",
    "Modes",
    "MotorSample",
    "Motors",
    "NEVER_NS",
    "Output",
    "Perception",
    "Recovery",
    "Ride",
    "RideError",
    "Rider",
    "RiderIntent",
    "Road",
    "RollSample",
    "Run",
    "Scenario",
    "Sensors",
    "StabilityMap",
    "SteerSample",
    "Study",
    "Thing",
    "Trial",
    "Tuning",
    "TwinhubError",
    "Tyre",
    "UnknownNameError",
    "Weighted",
    "WheelSample",
    "Wind",
    "__version__",
    "batch",
    "bicycles",
    "courses",
    "design",
    "diagnose",
    "effort_nm",
    "energy_wh_per_km",
    "experiment",
    "gradients",
    "laws",
    "league",
    "linearise",
    "merge_leagues",
    "modes",
    "parameter_units",
    "parameters",
    "read_log",
    "ride",
    "stability_map",
    "tune",
]
