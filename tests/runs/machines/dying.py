"""An agent that kills whoever trains it."""

import os
import signal
from typing import Any

from agents.reference import Random


class Dies(Random):
    """Dies where it should learn."""

    def learn(self, total_timesteps: int, callback: Any = None, progress_bar: bool = False) -> "Dies":
        """End this process."""
        os.kill(os.getpid(), signal.SIGKILL)
        return self
