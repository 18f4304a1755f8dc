"""The one base of everything that crosses the bus or enters a journal."""

from typing import Annotated, Final

import msgspec

Name = Annotated[str, msgspec.Meta(min_length=1, max_length=128)]
Text = Annotated[str, msgspec.Meta(max_length=20_000)]
Xyz = tuple[float, float, float]
"""Three lengths in metres; the field's name says what and in which frame."""

INFINITE: Final = {"may_be": "infinite"}
Threshold = Annotated[float, msgspec.Meta(extra=INFINITE)]
"""The one kind of number that may be infinite on the wire: nothing reaches it."""


class Message(msgspec.Struct, frozen=True, tag=True, forbid_unknown_fields=True, kw_only=True):
    """A frozen, tagged value. Unknown, missing or mistyped fields are refused when decoding."""


class Empty(Message, frozen=True):
    """A question without arguments, or an answer without content."""
