"""How a process ends whose state is in doubt: at once, with what happened in the log."""

import logging
import os
import sys
from collections.abc import Callable
from typing import Final

log = logging.getLogger(__name__)

UNEXPECTED: Final = 70
"""The exit status after an unexpected error."""


def or_die(job: Callable[[], None]) -> Callable[[], None]:
    """The job, but an unexpected error ends the process."""

    def guarded() -> None:
        try:
            job()
        except BaseException:
            die()

    return guarded


def die() -> None:
    """Log the exception at hand and end the process, whatever else is running in it."""
    log.critical("unexpected error; the process ends", exc_info=True)
    logging.shutdown()
    sys.stdout.flush()
    os._exit(UNEXPECTED)
