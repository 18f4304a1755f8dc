"""Wiring of the planner service: `surefetch serve planner`."""

from surefetch.common.parameters import profile_parameters
from surefetch.common.runner import serve
from surefetch.common.settings import read_settings
from surefetch.common.topics import PLANNER
from surefetch.planner.service import PlannerService


def main(argv: list[str]) -> int:
    """Serve until told to stop. Raises BadInput for settings that cannot be used."""
    settings = read_settings(argv, PLANNER)
    return serve(
        lambda bus: PlannerService(
            bus,
            settings.cell,
            lambda profile: profile_parameters(profile, settings.parameters),
        ),
        settings,
    )
