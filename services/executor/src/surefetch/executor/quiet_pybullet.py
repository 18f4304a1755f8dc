"""PyBullet, imported in silence: it greets on stdout, where a command's JSON belongs."""

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def silent_stdout() -> Iterator[None]:
    """What C code prints in the block is dropped."""
    sys.stdout.flush()
    buffers = ctypes.CDLL(None)
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        buffers.fflush(None)
        os.dup2(kept, 1)
        os.close(nowhere)
        os.close(kept)


with silent_stdout():
    import pybullet

__all__ = ["pybullet"]
