"""What one look is: its viewing condition, the cover state after it, whether its answers count.

Pure. Views and covers are rows of the cell file; none is named here.
"""

from typing import Final

from surefetch.common.cell import InformRow
from surefetch.common.messages import CoverState
from surefetch.planner.actions import State

BETWEEN: Final = "between"
"""Viewing condition of a frame that was taken from none of the cell's views."""


def cover_after(before: State, seen: CoverState) -> State:
    """The verified cover state; what cannot be seen stays as it was last seen."""
    return before if seen == "unknown" else seen


def gives_what_it_promised(row: InformRow, view: str | None, cover: State) -> bool:
    """Whether a look is the fresh observation for which an information action was taken.

    That the executor reports success is not enough: a cover is off when it is seen to be off.
    """
    return view == row.view and (row.kind == "view" or cover == "open")


def condition(
    rows: tuple[InformRow, ...], view: str | None, tried: InformRow | None, cover: State
) -> str:
    """The viewing condition q of a look.

    Args:
        rows: information actions of the cell.
        view: where the frame was taken; None between views.
        tried: the information action that came directly before.
        cover: the cover state, this look included.

    Returns:
        After a removal that this look verifies, the removal's own condition; else the view's.
    """
    if view is None:
        return BETWEEN
    if tried is not None and tried.kind != "view" and gives_what_it_promised(tried, view, cover):
        return tried.q
    return next((row.q for row in rows if row.kind == "view" and row.view == view), view)
