"""Every refusal is an error with a name; `cli.main` turns it into a sentence and an exit code."""


class SurefetchError(Exception):
    """What was wrong, with which input, and what to do. The user sees it as it is."""

    exit_code = 3


class BadInput(SurefetchError):
    """The user's words, files or settings cannot be used. Nothing was moved."""

    exit_code = 2


class InfrastructureError(SurefetchError):
    """A process, a link or a device that is needed is not there."""

    exit_code = 3


class DeviceFault(InfrastructureError):
    """A device did not do what it was told, and has come to rest."""


class CodecError(SurefetchError):
    """Bytes that are no valid message of the expected type; the text names the field."""


class Refused(SurefetchError):
    """The other side answered, and its answer is no: `reason` is for programs."""

    def __init__(self, reason: str, text: str, exit_code: int = 3) -> None:
        super().__init__(text)
        self.reason = reason
        self.exit_code = exit_code


class PeerMissing(InfrastructureError):
    """A service is not there, or died while it was asked."""

    def __init__(self, service: str, text: str) -> None:
        super().__init__(text)
        self.service = service


class NoAnswer(InfrastructureError):
    """A service is there but did not answer in time."""

    def __init__(self, service: str, text: str) -> None:
        super().__init__(text)
        self.service = service
