"""OpenMP threads that soon sleep while they wait; imported before torch, whose library reads this once.

Waiting threads spin for milliseconds by default: with physics threads, or another process, on the same cores that slows
training tenfold (measured: 84 instead of 1,800 samples per second). Some microseconds of spinning, as many as pass
between two small products, keep the speed of spinning where nothing else runs. Values that the user set are kept.
"""

import os

if "OMP_WAIT_POLICY" not in os.environ:
    os.environ["OMP_WAIT_POLICY"] = "PASSIVE"
    os.environ.setdefault("GOMP_SPINCOUNT", "20000")
