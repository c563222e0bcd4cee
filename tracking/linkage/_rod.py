"""The rod between two parts that turn: a rigid piece whose ends follow circles about their pivots.

Both parts' angles are known, so that a rod is two points, one carried by each part: its pins. They
stay a length apart, and what lies between them moves with them. Pairs of points on a grid are tried
on few samples, the best on more, and the best of these are refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.core import Rod, Track, threaded
from servosight.tracking.linkage._between import BetweenParts, Strip

_FRAMES = 16
_GRID_PX, _GRID_SHARE = 6.0, 0.1
"""Of the grid of pins: at least, and of the horn's reach."""
_HORN, _LEVER = 1.15, 3.0
"""Pins lie within so many reaches of the horn from its pivot, and from the surface's."""
_MOVES_PX = 4.0
"""From end to end, either pin."""
_SHORTEST_PX = 24.0
_MOST_SLACK_PX = 2.5
_GRID_SLACK_PX, _SLACK_PX = 1.5, 0.7
"""By how much pins come apart (rms) that halves what they count, on the grid and refined."""
_GRID_COST, _COST = 1.0, 3.0
_ROUGH: Strip = np.linspace(0.2, 0.8, 7), np.zeros(1)
_CLOSER: Strip = np.linspace(0.15, 0.85, 15), np.array([-2.0, 0.0, 2.0])
_WIDE: Strip = np.linspace(0.05, 0.95, 31), np.arange(-8.0, 8.5, 2.0)
_SURVIVORS, _FINALISTS = 3000, 10
_AT_ONCE = 2000
_STEPS_PX = (3.0, 1.5, 0.75, 0.4, 0.2)
_MOST_STEPS = 12
_LEAST_EXPLAINED = 0.6


def find_rod(
    images: Sequence[Image], index: Sequence[int], surface: Track, horn: Track
) -> Rod | None:
    """The rod between surface and horn; None where the pictures show none.

    ``images`` are pictures in which the camera stays in place, ``index`` the numbers of their
    frames.
    """
    known = np.flatnonzero(surface.found[list(index)] & horn.found[list(index)])
    if known.size < _FRAMES // 2:
        return None
    order = known[np.argsort(horn.angle_deg[list(index)][known], kind="stable")]
    chosen = order[np.unique(np.linspace(0, order.size - 1, _FRAMES).round().astype(int))]
    scene = BetweenParts.of(
        [images[n] for n in chosen], [index[n] for n in chosen], (surface, horn)
    )
    pins = _stiff_pairs(scene, horn)
    if not len(pins):
        return None
    for strip, kept in ((_ROUGH, _SURVIVORS), (_CLOSER, _FINALISTS)):
        pieces = np.array_split(pins, -(-len(pins) // _AT_ONCE))
        scores = threaded(partial(_rough_score, scene, strip), pieces)
        pins = pins[np.argsort(-np.concatenate(scores), kind="stable")[:kept]]
    refined = np.array(threaded(partial(_refined, scene), list(pins)))
    best = int(np.argmax(_length_px(scene, refined) * _score(scene, refined)))
    return _rod(scene, refined[best])


def _carried(scene: BetweenParts, pins: Array) -> tuple[Array, Array]:
    """Pins (n, 4), on the surface and on the horn, in each frame: (n, frames, 2) each."""
    return scene.carried(0, pins[:, :2]), scene.carried(1, pins[:, 2:])


def _slack_px(on_surface: Array, on_horn: Array) -> Array:
    """By how much pins (n, frames, 2) come apart, rms, (n,)."""
    return np.asarray(np.hypot(*np.moveaxis(on_surface - on_horn, -1, 0)).std(1))


def _length_px(scene: BetweenParts, pins: Array) -> Array:
    """Mean distance between pins (n, 4), (n,): a long rod explains more than a piece of it."""
    return np.asarray(np.hypot(*np.moveaxis(np.subtract(*_carried(scene, pins)), -1, 0)).mean(1))


def _stiff_pairs(scene: BetweenParts, horn: Track) -> Array:
    """Pairs of points (n, 4) that stay a length apart, from their pivots at angle zero."""
    reach = float(np.hypot(*(horn.outline_px - np.array(horn.pivot_px)).T).max())
    grid = max(_GRID_PX, _GRID_SHARE * reach)
    lever, arm = (
        _moving(scene, part, _disc(factor * reach, grid))
        for part, factor in ((0, _LEVER), (1, _HORN))
    )
    places = scene.carried(0, lever)

    def stiff(point: Array) -> Array:
        pin = scene.carried(1, point[None])
        apart = np.hypot(*np.moveaxis(places - pin, -1, 0))
        chosen = lever[(apart.std(1) < _MOST_SLACK_PX) & (apart.mean(1) > _SHORTEST_PX)]
        return np.hstack([chosen, np.broadcast_to(point, chosen.shape)])

    return np.vstack([np.zeros((0, 4)), *threaded(stiff, list(arm))])


def _disc(radius: float, grid: float) -> Array:
    """A grid of points (n, 2) within a circle about zero."""
    side = np.arange(-radius, radius + grid, grid)
    points = np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)
    return np.asarray(points[np.hypot(*points.T) <= radius])


def _moving(scene: BetweenParts, part: int, points: Array) -> Array:
    """Those of the points (n, 2) that the part carries by more than a little."""
    ranges = np.ptp(scene.carried(part, points), axis=1)
    return np.asarray(points[np.hypot(*ranges.T) > _MOVES_PX])


def _score(
    scene: BetweenParts, pins: Array, strip: Strip = _WIDE, cost: float = _COST,
    slack_px: float = _SLACK_PX,
) -> Array:  # fmt: skip
    """What pins (n, 4) explain at a sample, less what they do not; less as they come apart; (n,).

    What is not explained counts ``cost`` times: a strip that is too long explains more as well.
    Lines beside the rod do not count. How wide it is is not known, so that those in the middle
    count most.
    """
    ends = _carried(scene, pins)
    gain, whole = scene.explained(*ends, strip)
    lines = np.maximum(gain - cost * (whole - gain), 0.0)
    weight = 1.0 - (strip[1] / (strip[1][-1] + 1.0)) ** 2
    return np.asarray(lines @ weight / (1.0 + (_slack_px(*ends) / slack_px) ** 2))


def _rough_score(scene: BetweenParts, strip: Strip, pins: Array) -> Array:
    """What pins (n, 4) explain, on the grid: the longer, the more, (n,)."""
    return _length_px(scene, pins) * _score(scene, pins, strip, _GRID_COST, _GRID_SLACK_PX)


def _refined(scene: BetweenParts, pins: Array) -> Array:
    """Pins (4,) from which no small step leads to a better score.

    Steps along the rod are among them: by these the pins are determined least.
    """
    best = float(_score(scene, pins[None])[0])
    along = (pins[2:] + scene.pivots[1]) - (pins[:2] + scene.pivots[0])
    along /= np.hypot(*along)
    across = np.array([-along[1], along[0]])
    single = np.vstack([np.eye(4), np.tile(along, 2), np.tile(across, 2)])
    moves = np.vstack([single, -single])
    for step in _STEPS_PX:
        for _ in range(_MOST_STEPS):
            scores = _score(scene, pins + step * moves)
            if scores.max() <= best:
                break
            pins, best = pins + step * moves[np.argmax(scores)], float(scores.max())
    return pins


def _rod(scene: BetweenParts, pins: Array) -> Rod | None:
    """The rod with these pins (4,), where it explains enough of what changes between the parts."""
    ends = _carried(scene, pins[None])
    gain, whole = scene.explained(*ends, (_WIDE[0], _CLOSER[1]))
    share = float(gain.sum() / max(whole.sum(), 1e-9))
    slack = float(_slack_px(*ends)[0])
    if share < _LEAST_EXPLAINED or slack > 2.0 * _SLACK_PX:
        return None
    (ax, ay), (bx, by) = pins[:2] + scene.pivots[0], pins[2:] + scene.pivots[1]
    return Rod(
        surface_px=(float(ax), float(ay)),
        horn_px=(float(bx), float(by)),
        explained=round(share, 3),
        slack_px=round(slack, 3),
    )
