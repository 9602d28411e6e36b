"""Many runs from one YAML file: read it, plan run folders, let Ray or a plain loop attend to them, show all in a table.

The unit of work is one run folder: begun, gone on with or skipped, whatever became of the processes before.
"""

from sb3_adaptnet.sweeps.plan import prepare, units_of
from sb3_adaptnet.sweeps.status import read_status
from sb3_adaptnet.sweeps.sweep_file import Sweep, read_sweep
from sb3_adaptnet.sweeps.unit import Unit, UnitFolder

__all__ = ["Sweep", "Unit", "UnitFolder", "prepare", "read_status", "read_sweep", "units_of"]
