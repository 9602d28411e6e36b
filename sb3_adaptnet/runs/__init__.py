"""Training runs: entries of the zoo, folders, checkpoints, curves.

`runs.training` starts and resumes them; it is not imported here, since it draws with matplotlib, which loads slowly.
"""

from sb3_adaptnet.runs.experiment import Experiment, callbacks, hyperparameters
from sb3_adaptnet.runs.history import Row, read_rows
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings

__all__ = [
    "Experiment",
    "Row",
    "RunFolder",
    "RunSettings",
    "callbacks",
    "hyperparameters",
    "read_rows",
]
