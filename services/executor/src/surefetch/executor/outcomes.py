"""What came of every command: a repeated one is answered from here and moves nothing."""

import hashlib

from surefetch.common import codec
from surefetch.common.errors import Refused
from surefetch.common.messages import Command, Outcome
from surefetch.common.topics import EXECUTE

ID_REUSED = "ID_REUSED"


class Outcomes:
    """Outcomes by command id, with a digest of what was commanded."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[bytes, Outcome]] = {}

    def of(self, command: Command) -> Outcome | None:
        """What came of this very command, or None if it is new.

        Raises:
            Refused: ID_REUSED, another command had this id.
        """
        known = self._known.get(command.cmd_id)
        if known is None:
            return None
        digest, outcome = known
        if digest != _digest(command):
            raise Refused(
                ID_REUSED,
                f"command {command.cmd_id} was another one before; every command needs an id of "
                f"its own. Nothing was moved.",
            )
        return outcome

    def keep(self, command: Command, outcome: Outcome) -> None:
        """Remember what came of a command."""
        self._known[command.cmd_id] = _digest(command), outcome


def _digest(command: Command) -> bytes:
    encoded = codec.encode(command, max_bytes=EXECUTE.max_request_bytes)
    return hashlib.blake2b(encoded, digest_size=16).digest()
