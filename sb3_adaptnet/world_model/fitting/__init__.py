"""From a policy to a fitted world model: data, stages of the fit, a table of errors."""

from sb3_adaptnet.world_model.fitting.collecting import collect
from sb3_adaptnet.world_model.fitting.error_table import ErrorTable, error_table
from sb3_adaptnet.world_model.fitting.fit import STAGES, Stage, fit, set_statistics

__all__ = ["STAGES", "ErrorTable", "Stage", "collect", "error_table", "fit", "set_statistics"]
