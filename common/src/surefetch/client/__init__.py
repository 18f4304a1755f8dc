"""Fetch things from a program of your own.

::

    from surefetch.client import Cell

    with Cell("tcp/127.0.0.1:7447") as cell:
        for event in cell.fetch("the red cylinder"):
            print(event.step, type(event.happening).__name__)
"""

from surefetch.client.cell import Cell

__all__ = ["Cell"]
