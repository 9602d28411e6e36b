"""Why an episode ends, as pure functions over arrays.

What counts as a fall is decided by contact sensors (`model/build.py` adds them) and, on uneven ground, by heights
(`simulation/falls.py`). On flat ground and among obstacles a link that is no foot falls as soon as it touches, however
high it is: nobody leans on a block with a hand. The authors' release also asks that the link be less than 0.15 m above
the ground, and on uneven ground so do these environments (`fall_height`): of what ended the walks of who had learned to
walk there every second to fourth was a shin that brushed the edge of a step, its knee up in the air, and they would
have walked on. Of who had not learned it nearly every fall is one by either rule.
"""

import numpy as np
from numpy.typing import NDArray

ENDS = ("", "fall", "lost", "diverged", "time")
"""Reasons by code; 0 goes on, 1 to 3 terminate, 4 truncates."""
RUNNING, FALL, LOST, DIVERGED, TIME = range(5)
LOST_DISTANCE = 3.0
"""An episode ends when the character is this much [m] farther from its target than when the target was sampled."""


def ends(
    fallen: NDArray[np.bool_], lost: NDArray[np.bool_], diverged: NDArray[np.bool_], timed_out: NDArray[np.bool_]
) -> NDArray[np.int8]:
    """Codes (N,) into `ENDS`; where several hold, diverged outranks fall, fall lost, and lost time."""
    code = np.where(timed_out, TIME, RUNNING)
    code[lost] = LOST
    code[fallen] = FALL
    code[diverged] = DIVERGED
    return code.astype(np.int8)
