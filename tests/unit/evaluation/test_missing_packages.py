"""On a desk that lacks some of the packages, a command names what it needs."""

import subprocess
import sys

import pytest

DESK = """
import sys
from importlib.abc import MetaPathFinder

LACKS = set(sys.argv[1].split(","))


class Lacking(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in LACKS:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Lacking())
from surefetch.common.cli import main

sys.exit(main(sys.argv[2:]))
"""
"""`surefetch`, where the imports that the first argument names find nothing."""


def on_a_desk_without(lacks: str, *words: str) -> tuple[int, str]:
    """Exit status, and what was said."""
    done = subprocess.run(
        [sys.executable, "-c", DESK, lacks, *words], capture_output=True, text=True, check=False
    )
    return done.returncode, done.stderr


NEEDS = "surefetch: {} needs the package {}, which is not installed here.\n"


@pytest.mark.parametrize(
    ("lacks", "words", "needed"),
    [
        ("surefetch.executor", "study episodes", "surefetch-executor"),
        ("surefetch.executor", "study perception", "surefetch-executor"),
        ("surefetch.perception", "study perception", "surefetch-perception"),
        ("surefetch.executor", "study record", "surefetch-executor"),
        ("surefetch.perception", "study record", "surefetch-perception"),
        ("surefetch.belief", "study fit", "surefetch-belief"),
        ("surefetch.planner", "replay", "surefetch-planner"),
        ("surefetch.evaluation", "run", "surefetch-evaluation"),
        ("surefetch.perception", "serve perception", "surefetch-perception"),
    ],
)
def test_a_command_names_the_package_of_ours_that_it_needs(
    lacks: str, words: str, needed: str
) -> None:
    status, said = on_a_desk_without(lacks, *words.split(), "--help")
    assert (status, said) == (2, NEEDS.format(words, needed))


@pytest.mark.parametrize("word", ["record", "perception"])
def test_a_package_of_others_is_named_with_the_extra_that_brings_it(word: str) -> None:
    lacks = "cv2,surefetch.executor,surefetch.perception"
    status, said = on_a_desk_without(lacks, "study", word, "--help")
    assert status == 2
    assert said == (
        f"surefetch: study {word} needs the Python package cv2, which is not installed here.\n"
        "  It comes with surefetch-evaluation[demo].\n"
    )


def test_a_module_that_is_missing_from_a_package_that_is_there_is_our_own_error() -> None:
    status, said = on_a_desk_without("surefetch.belief.filter", "study", "fit", "--help")
    assert status == 3
    assert said.endswith("surefetch: this is an error in surefetch itself; please report it.\n")
