"""Two adaptations at once, without training: how pairs do, a table and a heat map."""

from sb3_adaptnet.evaluation.stacking.cells import Cell, measure_pairs
from sb3_adaptnet.evaluation.stacking.heat_map import write_heat_map
from sb3_adaptnet.evaluation.stacking.table import markdown, read_csv, renewed, write_csv

__all__ = ["Cell", "markdown", "measure_pairs", "read_csv", "renewed", "write_csv", "write_heat_map"]
