"""Every failed episode of a policy on one page: frames, belief, set, action and cause."""

import html
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.mask import decode
from surefetch.evaluation.replaying.results import EpisodeResult, StepResult
from surefetch.evaluation.showing import pictures, words
from surefetch.evaluation.showing.observed import Observed, Step, steps

WIDTH_PX: Final = 420
QUALITY: Final = 80
BARS: Final = 6
FOLDER: Final = "frames"

Retell = Callable[[EpisodeResult], Observed]
Cause = Callable[[EpisodeResult], tuple[str, str] | None]


def entries(
    failed: Sequence[EpisodeResult], retell: Retell, cause: Cause, folder: Path
) -> Iterator[str]:
    """HTML of each episode; its frames are written into the folder's `frames`.

    Args:
        failed: the episodes.
        retell: gives an episode its frames back.
        cause: what went wrong, and why it is thought so.
        folder: of the page.
    """
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    for episode in failed:
        observed = retell(episode)
        looks = list(steps(observed.events))
        shown = "".join(
            _step(step, _kept(look, observed, folder, f"{episode.family}-{episode.seed}-{n}"))
            for n, (look, step) in enumerate(zip(looks, episode.steps, strict=True))
        )
        yield _entry(episode, observed, cause(episode), shown)


def _entry(
    episode: EpisodeResult, observed: Observed, found: tuple[str, str] | None, shown: str
) -> str:
    address = f"{episode.family}:{episode.seed}"
    asked = observed.accepted.understood if observed.accepted is not None else ""
    what, why = found if found is not None else ("", "")
    told = " · ".join(
        [episode.verdict.replace("_", " "), *([what] if what else []), *([why] if why else [])]
    )
    left = " It left its recording and was finished in the simulator." * episode.finished_live
    return (
        f'<article id="{html.escape(address)}"><h3>{html.escape(address)} '
        f"<small>{html.escape(asked)}</small></h3><p class='bad'>{html.escape(told)}</p>"
        f"<p>{html.escape(', '.join(episode.actions) or 'nothing was done')}. "
        f"{html.escape(episode.why)}{left}</p><div class='steps'>{shown}</div></article>"
    )


def _step(step: StepResult, image: str) -> str:
    mass = {**step.belief, "unobs": step.unobs, "abs": step.abs}
    heaviest = dict(words.ranked(mass)[:BARS])
    if step.z_true not in heaviest:
        heaviest[step.z_true] = step.p_true
    bars = "".join(_bar(z, p, step) for z, p in heaviest.items())
    gamma = ", ".join(map(words.hypothesis, step.gamma)) or "nothing"
    action = "it was over" if step.action is None else step.action.replace("_", " ")
    seen = ", ".join(f"T{seen}" for seen in step.observations) or "nothing counted"
    return (
        f'<figure><img loading="lazy" width="{WIDTH_PX}" src="{image}" alt="{html.escape(step.q)}">'
        f"<figcaption><b>{html.escape(step.q.replace('_', ' '))}</b>: {html.escape(seen)}"
        f"<div class='bars'>{bars}</div><div>Γ = {{{html.escape(gamma)}}}</div>"
        f"<div><b>→ {html.escape(action)}</b></div>"
        f"<div class='note'>{html.escape(step.because)}</div></figcaption></figure>"
    )


def _bar(z: str, p: float, step: StepResult) -> str:
    true = " (true)" if z == step.z_true else ""
    kind = "in" if z in step.gamma else "out"
    return (
        f"<div class='bar'><span>{html.escape(words.hypothesis(z))}{true}</span>"
        f"<i class='{kind}' style='width:{110 * p:.1f}px'></i><em>{p:.3f}</em></div>"
    )


def _kept(look: Step, observed: Observed, folder: Path, name: str) -> str:
    """Write one frame; its path from the page."""
    path = f"{FOLDER}/{name}.jpg"
    image = annotated(look, observed)
    height = round(image.shape[0] * WIDTH_PX / image.shape[1])
    small = cv2.resize(image, (WIDTH_PX, height), interpolation=cv2.INTER_AREA)
    bgr = cv2.cvtColor(small, cv2.COLOR_RGB2BGR)
    _, encoded = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    (folder / path).write_bytes(encoded.tobytes())
    return path


def annotated(look: Step, observed: Observed) -> NDArray[np.uint8]:
    """The frame (h, w, 3) of a look with masks and, at each, its track and answer."""
    frame = observed.frames[look.captured.frame]
    seen = observed.observations.get(look.captured.frame)
    tracks = look.believed.tracks if look.believed is not None else ()
    answers = dict(c.split(" ", 1) for c in look.believed.counted) if look.believed else {}
    image = frame.rgb.copy()
    for detection in seen.detections if seen is not None else ():
        track = pictures.track_of(detection, tracks)
        if track is None or not detection.representative:
            continue
        color = pictures.track_color(track.id)
        image[pictures.outline(decode(detection.mask))] = color
        text = f"T{track.id} {answers.get(str(track.id), '')}".strip().replace("mismatch", "x")
        x, y = round(detection.box_px[0]), max(16, round(detection.box_px[1]) - 5)
        for thickness, ink in ((4, (255, 255, 255)), (1, (20, 20, 20))):
            cv2.putText(image, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.55, ink, thickness)
    return image
