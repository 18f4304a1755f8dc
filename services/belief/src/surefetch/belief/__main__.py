"""Wiring of the belief service: `surefetch serve belief`."""

from surefetch.belief.service import BeliefService
from surefetch.common.parameters import profile_parameters
from surefetch.common.runner import serve
from surefetch.common.settings import read_settings
from surefetch.common.topics import BELIEF


def main(argv: list[str]) -> int:
    """Serve until told to stop. Raises BadInput for settings that cannot be used."""
    settings = read_settings(argv, BELIEF)
    return serve(
        lambda _: BeliefService(
            lambda profile: profile_parameters(profile, settings.parameters), settings.cell.name
        ),
        settings,
    )
