"""Two adaptations at once, without training: what each changes of the world, how pairs do, a table and a heat map."""

from sb3_adaptnet.evaluation.stacking.cells import Cell, measure_pairs
from sb3_adaptnet.evaluation.stacking.heat_map import write_heat_map
from sb3_adaptnet.evaluation.stacking.parts import Pair, Part, pairs_of, part_of
from sb3_adaptnet.evaluation.stacking.table import markdown, write_csv

__all__ = ["Cell", "Pair", "Part", "markdown", "measure_pairs", "pairs_of", "part_of", "write_csv", "write_heat_map"]
