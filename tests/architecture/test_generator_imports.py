"""The scene generator must not know what any method makes of a scene."""

import subprocess
import sys

FORBIDDEN = ("surefetch.perception", "surefetch.belief", "surefetch.planner")


def test_the_generator_imports_no_perception_belief_or_planner() -> None:
    """R10: else scenes could be dropped because a method fails on them."""
    code = (
        "import sys, surefetch.evaluation.scenes.generate\n"
        f"print([name for name in sys.modules if name.startswith({FORBIDDEN!r})])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == "[]"
