"""Perceive a picture as the service does, and set it against its truth."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Final

import numpy as np

from surefetch.common.hypotheses import MEMBERSHIP_LABELS
from surefetch.common.messages import Answers, Target
from surefetch.evaluation.seeing.images import Picture, Thing
from surefetch.evaluation.seeing.metrics import (
    LEAST_PX,
    SAME_IOU,
    VISIBLE_SHARE,
    Asked,
    Bits,
    Found,
    Scored,
    box_of,
    mask_iou,
)
from surefetch.executor.simulation.scene_bodies import CONTAINER_SEGMENT, SCREEN_SEGMENT
from surefetch.perception.candidate import Candidate
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import Perceived, observe
from surefetch.perception.ports import Backend

ATTRIBUTES: Final = ("color", "shape", "marking")
INSIDE, OUTSIDE, _ = MEMBERSHIP_LABELS


def scored(picture: Picture, backend: Backend, geometry: LatestGeometry) -> Scored:
    """What the back-end makes of a picture, and what is there."""
    perceived = observe(picture.frame, picture.target, backend, geometry)
    shown = [np.asarray(picture.segmentation == k) for k in range(len(picture.things))]
    enough = [int(np.count_nonzero(bits)) >= LEAST_PX for bits in shown]
    return Scored(
        layout=picture.layout,
        view=picture.view,
        shape=picture.frame.depth_m.shape,
        detections=_detections(perceived),
        objects=tuple(_found(bits) for bits, big in zip(shown, enough, strict=True) if big),
        ignored=_ignored(picture, shown, enough),
        target=_target(picture, shown),
        container=_container(perceived),
        true_container=_true_container(picture),
        answers=tuple(_answers(picture, perceived, shown, backend)),
    )


def _detections(perceived: Perceived) -> tuple[Found, ...]:
    pairs = zip(perceived.scene.candidates, perceived.answers, strict=True)
    found = [Found(one.box_px, one.bits, one.score) for one, answers in pairs if answers]
    return tuple(sorted(found, key=lambda one: -one.score))


def _found(bits: Bits) -> Found:
    return Found(box_of(bits), bits)


def _ignored(picture: Picture, shown: Sequence[Bits], enough: Sequence[bool]) -> tuple[Bits, ...]:
    small = [bits for bits, big in zip(shown, enough, strict=True) if bits.any() and not big]
    screens = np.asarray(picture.segmentation == SCREEN_SEGMENT)
    return (*small, screens) if screens.any() else tuple(small)


def _target(picture: Picture, shown: Sequence[Bits]) -> tuple[float, float, float, float] | None:
    if picture.target_index is None or picture.target_share < VISIBLE_SHARE:
        return None
    return box_of(shown[picture.target_index])


def _container(perceived: Perceived) -> Found | None:
    found, bits = perceived.scene.container, perceived.scene.container_bits
    if found is None:
        return None
    seen = found.mask if bits is None else bits
    return Found(box_of(seen), seen, found.score)


def _true_container(picture: Picture) -> Found | None:
    bits = np.asarray(picture.segmentation == CONTAINER_SEGMENT)
    return _found(bits) if int(np.count_nonzero(bits)) >= LEAST_PX else None


def _answers(
    picture: Picture, perceived: Perceived, shown: Sequence[Bits], backend: Backend
) -> Iterator[Asked]:
    """Every value of the vocabulary, asked about every object that was found."""
    pairs = [
        (candidate, picture.things[body])
        for candidate, answers in zip(perceived.scene.candidates, perceived.answers, strict=True)
        if answers is not None and (body := _body_under(candidate, shown)) is not None
    ]
    candidates = [candidate for candidate, _ in pairs]
    for k, target in enumerate(_targets(backend)):
        replies = backend.scorer.score(perceived.scene, candidates, target)
        for (_, thing), reply in zip(pairs, replies, strict=True):
            yield from _identity(thing, target, reply)
            if k == 0 and thing.inside is not None:
                yield "membership", thing.inside, reply.membership.label


def _body_under(candidate: Candidate, shown: Sequence[Bits]) -> int | None:
    overlaps = [mask_iou(candidate.bits, bits) for bits in shown]
    best = int(np.argmax(overlaps)) if overlaps else -1
    if best < 0 or overlaps[best] < SAME_IOU:
        return None
    return best if int(np.count_nonzero(shown[best])) >= LEAST_PX else None


def _targets(backend: Backend) -> Iterator[Target]:
    """Targets that together name every colour, shape and marking once."""
    known = backend.vocabulary
    for color, shape, marking in zip_longest(known.colors, known.shapes, known.markings):
        yield Target(noun=shape or "object", color=color, shape=shape, marking=marking)


def _identity(thing: Thing, target: Target, reply: Answers) -> Iterator[Asked]:
    for name in ATTRIBUTES:
        answer = getattr(reply, name)
        if answer is not None:
            yield name, getattr(thing.attributes, name) == getattr(target, name), answer.label
