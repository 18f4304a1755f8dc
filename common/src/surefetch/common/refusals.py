"""Errors as answers and back, so that an asker meets the error that the other side raised."""

from typing import Final

from surefetch.common.errors import (
    BadInput,
    CodecError,
    NoAnswer,
    PeerMissing,
    Refused,
    SurefetchError,
)
from surefetch.common.messages import RefusedReply

BAD_SCHEMA: Final = "BAD_SCHEMA"
BAD_KEY: Final = "BAD_KEY"
BUSY: Final = "BUSY"
BAD_INPUT: Final = "BAD_INPUT"
PEER_MISSING: Final = "PEER_MISSING"
NO_ANSWER: Final = "NO_ANSWER"
ERROR: Final = "ERROR"


def refusal_of(error: SurefetchError) -> RefusedReply:
    """What a service answers when it raises this error."""
    service = error.service if isinstance(error, PeerMissing | NoAnswer) else None
    return RefusedReply(
        reason=_reason(error),
        text=str(error)[:20_000],
        exit_code=error.exit_code,
        service=service,
    )


def error_of(refusal: RefusedReply) -> SurefetchError:
    """The error that such an answer stands for, to be raised by the asker."""
    if refusal.reason == PEER_MISSING and refusal.service is not None:
        return PeerMissing(refusal.service, refusal.text)
    if refusal.reason == NO_ANSWER and refusal.service is not None:
        return NoAnswer(refusal.service, refusal.text)
    return Refused(refusal.reason, refusal.text, refusal.exit_code)


def _reason(error: SurefetchError) -> str:
    match error:
        case Refused(reason=reason):
            return reason
        case BadInput():
            return BAD_INPUT
        case PeerMissing():
            return PEER_MISSING
        case NoAnswer():
            return NO_ANSWER
        case CodecError():
            return BAD_SCHEMA
        case _:
            return ERROR
