"""What the results in a folder were made with: nothing is mixed, and nothing is done twice."""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import msgspec

from surefetch.common import injections
from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES, Parameters, profile_parameters
from surefetch.common.version import VERSION
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying import results
from surefetch.evaluation.replaying.campaign import Campaign
from surefetch.evaluation.replaying.contenders import Contender

NAME: Final = "manifest.json"
CODE: Final = (
    "surefetch.common",
    "surefetch.belief",
    "surefetch.planner",
    "surefetch.evaluation.fitting",
    "surefetch.evaluation.policies",
    "surefetch.evaluation.recordings",
    "surefetch.evaluation.replaying",
    "surefetch.evaluation.running.metrics",
)
"""What decides how an episode is replayed and scored: packages and modules."""


@dataclass(frozen=True)
class Manifest:
    """The two parts of ``manifest.json``."""

    made_with: Mapping[str, Any]
    """What all policies in a folder share; other results are refused."""
    policies: Mapping[str, Mapping[str, Any]]
    """By policy what it was; one that was another is played again."""


def made_with(campaign: Campaign) -> dict[str, Any]:
    """Versions, recordings, parameters and outcomes of a campaign."""
    scenes = recording_store.scenes(campaign.recordings)
    recorded = campaign.recordings / NAME
    return {
        "surefetch": VERSION,
        "recordings": json.loads(recorded.read_text("utf-8")) if recorded.exists() else {},
        "scenes": {"n": len(scenes), "hash": _hash([repr(scenes).encode()])},
        "parameters": {
            name: parameters_hash(profile_parameters(name, campaign.parameters))
            for name in PROFILES
        },
        "outcomes": {"mode": campaign.conditions.mode, "draw": campaign.conditions.draw},
        "finish_live": campaign.finish_live,
        "injected": injections.told(campaign.conditions.injections),
    }


def parameters_hash(parameters: Parameters) -> str:
    """Of fitted numbers."""
    return _hash([msgspec.json.encode(parameters)])


def played_as(one: Contender, command: str) -> dict[str, Any]:
    """What a policy was, and the command that played it."""
    return {
        "profile": one.profile.name,
        "variant": one.variant,
        "code": code_hash(one),
        "command": command,
    }


def read(folder: Path) -> Manifest | None:
    """The manifest of a folder; None where there is none. Raises BadInput for a damaged one."""
    path = folder / NAME
    if not path.exists():
        return None
    try:
        return msgspec.json.decode(path.read_bytes(), type=Manifest)
    except (msgspec.DecodeError, OSError) as error:
        raise BadInput(f"{path} is damaged: {error}\n  Name another folder.") from None


def write(folder: Path, manifest: Manifest) -> None:
    """Write it; all or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    partial = folder / f"{NAME}.partial"
    partial.write_bytes(msgspec.json.format(msgspec.json.encode(manifest), indent=1))
    partial.replace(folder / NAME)


def begin(folder: Path, made: Mapping[str, Any]) -> Manifest:
    """The manifest to go on from.

    Raises:
        BadInput: the folder holds results that were made with something else.
    """
    found = read(folder)
    if found is None:
        return Manifest(made, {})
    differing = [key for key in made if found.made_with.get(key) != made[key]]
    if differing:
        key = differing[0]
        raise BadInput(
            f"{folder} holds results made with other {', '.join(differing)}:\n"
            f"  {key} there: {found.made_with.get(key)}\n  {key} now: {made[key]}\n"
            "  Name another folder for these."
        )
    return found


def is_played(folder: Path, manifest: Manifest, label: str, now: Mapping[str, Any]) -> bool:
    """Whether this very policy's episodes are there already."""
    then = manifest.policies.get(label)
    same = then is not None and _but_command(then) == _but_command(now)
    return same and results.path_of(folder, label).exists()


def code_hash(one: Contender) -> str:
    """Of everything that decides how this policy is replayed, its own module included."""
    return _hash(_contents(one))


def _contents(one: Contender) -> Iterator[bytes]:
    module, colon, _ = one.name.partition(":")
    for name in (*CODE, module) if colon else CODE:
        for root in _roots(import_module(name)):
            for path in sorted(root.rglob("*")) if root.is_dir() else (root,):
                if path.is_file() and "__pycache__" not in path.parts:
                    yield path.read_bytes()


def _roots(module: ModuleType) -> list[Path]:
    """A module's file, or the folders of a package."""
    return [Path(root) for root in getattr(module, "__path__", (str(module.__file__),))]


def _but_command(record: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in record.items() if key != "command"}


def _hash(parts: Iterable[bytes]) -> str:
    whole = hashlib.blake2b(digest_size=8)
    for part in parts:
        whole.update(part)
    return whole.hexdigest()
