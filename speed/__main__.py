"""`python -m speed`: set one thread for everything before anything starts threads, then measure."""

import os
import sys

for _name in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[_name] = "1"

from speed.command import main

if __name__ == "__main__":
    sys.exit(main())
