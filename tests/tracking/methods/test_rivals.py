"""Of two explanations of one motion the one that leaves less when both are learnt in full."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NoReturn

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.composite import FoundPart, StabilisedSample, found_about, settled_part
from servosight.tracking.core import turned
from servosight.tracking.methods._rivals import best_first
from servosight.tracking.verification import FrameSample
from servosight.tracking.video import Frame

HINGE = np.array([150.0, 190.0])
BESIDE = HINGE + np.array([14.0, 11.0])
FLAP = np.array([[-34.0, 6.0], [34.0, 6.0], [18.0, -92.0], [-18.0, -92.0]])
ANGLE_DEG = 42.0 * np.sign(np.sin(np.linspace(0.01, 9.0, 40))) + 2.0 * np.sin(np.arange(40.0))


def filmed() -> list[Image]:
    """A plain flap that rests at two angles, over a texture."""
    rng = np.random.default_rng(2)
    bench = 90.0 + 8.0 * cv2.GaussianBlur(rng.standard_normal((300, 320)), (0, 0), 2.0)
    pictures = []
    for angle in ANGLE_DEG:
        image = bench.astype(np.float32)
        corners: Array = turned(FLAP + HINGE, (HINGE[0], HINGE[1]), np.deg2rad(angle))
        cv2.fillPoly(image, [np.round(16 * corners).astype(np.int32)], 200.0, cv2.LINE_AA, shift=4)
        seen = image + 1.0 * rng.standard_normal(image.shape)
        pictures.append(np.clip(np.round(seen), 0, 255).astype(np.uint8))
    return pictures


@pytest.fixture(scope="module")
def stabilised() -> StabilisedSample:
    sample = FrameSample(lambda image: image)
    for index, image in enumerate(filmed()):
        sample.add(Frame(index, index / 30.0, image))
    return StabilisedSample.of(sample)


@pytest.fixture(scope="module")
def both(stabilised: StabilisedSample) -> tuple[FoundPart, FoundPart]:
    """The flap learnt about its hinge, and about a point beside it."""
    pictures, content = stabilised.pictures, stabilised.content
    found = [found_about(pictures, place, None, content) for place in (HINGE, BESIDE)]
    assert found[0] is not None
    assert found[1] is not None
    return found[0], found[1]


def explaining(part: FoundPart, share: float) -> FoundPart:
    """The same part as if it explained that share of what changes."""
    return replace(part, explained=share, part=replace(part.part, explained=share))


def not_learnt(part: FoundPart) -> NoReturn:
    raise AssertionError(f"learnt about {part.pivot_px}")


def test_the_one_that_leaves_less_comes_first(
    stabilised: StabilisedSample, both: tuple[FoundPart, FoundPart]
) -> None:
    hinge, beside = explaining(both[0], 0.80), explaining(both[1], 0.82)
    settled = partial(settled_part, stabilised, hint=None)
    order = best_first(stabilised, [beside, hinge], settled)
    assert order[0] is hinge
    assert order[1] is beside
    assert best_first(stabilised, [hinge, beside], settled)[0] is hinge


def test_one_that_explains_far_less_is_not_learnt(
    stabilised: StabilisedSample, both: tuple[FoundPart, FoundPart]
) -> None:
    hinge, beside = explaining(both[0], 0.60), explaining(both[1], 0.82)
    assert best_first(stabilised, [beside, hinge], not_learnt)[0] is beside
    assert best_first(stabilised, [], not_learnt) == []
