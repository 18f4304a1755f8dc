"""Commands that end in every way in which a command can."""

from surefetch.common.errors import BadInput, InfrastructureError, Refused


def main(argv: list[str]) -> int:
    """End as the first word says."""
    match argv:
        case ["bad-input"]:
            raise BadInput("the word blorp is not understood")
        case ["infrastructure"]:
            raise InfrastructureError("belief is not there")
        case ["refused"]:
            raise Refused("FAILED", "the lift failed", 1)
        case ["interrupted"]:
            raise KeyboardInterrupt
        case ["bug"]:
            raise ZeroDivisionError("nothing to divide by")
    return 0
