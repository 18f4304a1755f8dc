"""Which policies there are, and the profile that goes with each. Pure."""

from typing import Final

from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES

OWN_PROFILE: Final = {"ours": "extended", "paper-method": "paper"}
"""Policies that bring their own profile."""
DEFAULT_PROFILE: Final = "extended"


def choose(profile: str | None, policy: str | None) -> tuple[str, str]:
    """Profile and policy as asked for, each completed from the other.

    Raises:
        BadInput: an unknown name, or a policy with another profile than its own.
    """
    if profile is not None and profile not in PROFILES:
        raise BadInput(f'there is no profile "{profile}".\n  Profiles: {", ".join(PROFILES)}')
    if policy is None:
        wanted = profile or DEFAULT_PROFILE
        return wanted, policy_of(wanted)
    if policy not in OWN_PROFILE:
        raise BadInput(f'there is no policy "{policy}".\n  Policies: {", ".join(OWN_PROFILE)}')
    own = OWN_PROFILE[policy]
    if profile is not None and profile != own:
        raise BadInput(
            f'the policy "{policy}" brings its own profile, {own}; it cannot run with '
            f'"{profile}".\n  Leave one of them out, or name two that go together.'
        )
    return own, policy


def policy_of(profile: str) -> str:
    """The policy that brings this profile."""
    return next(name for name, own in OWN_PROFILE.items() if own == profile)
