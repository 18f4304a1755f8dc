"""Does the layout still say what the documents say that it says?"""

import importlib
import importlib.util
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import cv2
import pytest
from packaging.requirements import Requirement

from surefetch.common.cli import COMMANDS, SERVE
from surefetch.common.topics import SERVICES

ROOT = Path(__file__).parents[2]
MEMBERS = (
    "common",
    "services/executor",
    "services/perception",
    "services/belief",
    "services/planner",
    "evaluation",
)


def toml(path: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / path).read_text("utf-8"))


def project(member: str) -> dict[str, Any]:
    found: dict[str, Any] = toml(f"{member}/pyproject.toml")["project"]
    return found


def requirements(member: str) -> list[Requirement]:
    about = project(member)
    extras = about.get("optional-dependencies", {}).values()
    words = [*about["dependencies"], *(word for extra in extras for word in extra)]
    return [Requirement(word) for word in words]


def constraints() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pins = [line.split("#")[0].strip() for line in lines]
    return {canonical(name): version for name, _, version in (p.partition("==") for p in pins if p)}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_distribution_is_a_member() -> None:
    found = {path.parent.relative_to(ROOT).as_posix() for path in ROOT.glob("*/pyproject.toml")}
    found |= {path.parent.relative_to(ROOT).as_posix() for path in ROOT.glob("*/*/pyproject.toml")}
    assert found == set(MEMBERS)


def test_the_shared_namespace_has_no_init_file() -> None:
    """One such file would make every other distribution's package vanish."""
    assert [m for m in MEMBERS if (ROOT / m / "src/surefetch/__init__.py").exists()] == []


@pytest.mark.parametrize("member", MEMBERS)
def test_every_package_is_typed(member: str) -> None:
    packages = [path for path in (ROOT / member / "src/surefetch").iterdir() if path.is_dir()]
    assert [path.name for path in packages if not (path / "py.typed").is_file()] == []


def test_the_distributions_are_of_one_version_and_name_each_other_by_it() -> None:
    (version,) = {project(member)["version"] for member in MEMBERS}
    for member in MEMBERS:
        for needed in requirements(member):
            if needed.name.startswith("surefetch-"):
                assert str(needed.specifier) == f"=={version}", (member, needed)


@pytest.mark.parametrize("member", MEMBERS)
def test_every_dependency_has_an_exact_version_that_fits(member: str) -> None:
    pins = constraints()
    for needed in requirements(member):
        if not needed.name.startswith("surefetch-"):
            assert needed.specifier.contains(pins[canonical(needed.name)]), (member, needed)


def test_every_development_tool_has_an_exact_version_that_fits() -> None:
    pins = constraints()
    for word in toml("pyproject.toml")["dependency-groups"]["dev"]:
        needed = Requirement(word)
        assert needed.specifier.contains(pins[canonical(needed.name)]), needed


def test_torch_is_the_same_version_wherever_it_is_named() -> None:
    first_line = (ROOT / "constraints.txt").read_text("utf-8").splitlines()[1]
    named = [first_line.split("#")[0].strip()]
    named += toml("pyproject.toml")["tool"]["uv"]["constraint-dependencies"]
    for member in MEMBERS:
        named += [str(one) for one in requirements(member) if one.name == "torch"]
    assert set(named) == {f"torch=={constraints()['torch']}"}


def test_opencv_is_a_version_that_has_hand_eye_calibration() -> None:
    (needed,) = (one for one in requirements("services/perception") if "opencv" in one.name)
    assert not needed.specifier.contains("5.0.0")
    assert callable(cv2.calibrateHandEye)


def test_the_import_contracts_are_kept() -> None:
    """The contracts are in `pyproject.toml`."""
    program = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [program, "--no-cache"], cwd=ROOT, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout


def test_only_the_simulated_cell_and_the_scorer_know_the_truth() -> None:
    """Perception, belief, planner and the executor's planning must not."""
    known = {
        member
        for member in MEMBERS
        for path in (ROOT / member).glob("src/surefetch/**/*.py")
        if re.search(r"\b(AskTruth|TRUTH)\b", path.read_text("utf-8"))
    }
    assert known == {"common", "services/executor", "evaluation"}


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "README.md", "ARCHITECTURE.md"])
def test_every_test_file_that_a_page_names_is_there(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    named = {f"tests/{path}" for path in re.findall(r"`tests/([\w/]+\.py)`", text)}
    assert [path for path in sorted(named) if not (ROOT / path).is_file()] == []


def test_every_service_can_be_served() -> None:
    assert tuple(SERVE) == SERVICES


@pytest.mark.parametrize("word", [*COMMANDS, *(f"serve {name}" for name in SERVE)])
def test_every_word_of_the_command_line_leads_to_a_function(word: str) -> None:
    target = SERVE[word.split()[1]] if " " in word else COMMANDS[word].function
    module, function = target.split(":")
    assert callable(getattr(importlib.import_module(module), function))


@pytest.mark.parametrize("module", ["running.run", "running.replay", "showing.view"])
def test_a_desk_follows_a_cell_without_the_robot_and_perception(module: str) -> None:
    """A module that is None in `sys.modules` counts as not installed."""
    program = (
        "import importlib, sys\n"
        "sys.modules |= {f'surefetch.{name}': None for name in ('executor', 'perception')}\n"
        f"importlib.import_module('surefetch.evaluation.{module}')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
