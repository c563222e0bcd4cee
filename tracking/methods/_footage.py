"""The frames in which the camera rests, and a part measured in them as one model with the rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import cv2
import numpy as np

from servosight.models.core import Array, FrameProgress, Image, Single
from servosight.tracking.acquisition import POINT
from servosight.tracking.composite import (
    TRUST,
    FoundPart,
    Hint,
    PartMeter,
    PoseFit,
    StabilisedSample,
    distrust,
    find_parts,
    leap_deg,
    longest_sure,
    oblique_view,
    outline_of,
    paces_rad,
    parts_otherwise,
    rough_enough,
    settled_part,
    without_false_turns,
)
from servosight.tracking.core import (
    UNKNOWN,
    Candidate,
    Tilt,
    Track,
    TrackOptions,
    TrackRefused,
    known_median,
    outline_at,
)
from servosight.tracking.methods._along_axis import along_axis
from servosight.tracking.methods._composite_track import (
    at_mid_exposure,
    first_rad,
    in_plane,
    track_of,
)
from servosight.tracking.methods._entered import clear_of, left_out_of
from servosight.tracking.methods._notes import left_out
from servosight.tracking.methods._pointing import astray, hint_of, nothing_there, pointed_part
from servosight.tracking.methods._repeated import with_repeats
from servosight.tracking.methods._rivals import best_first
from servosight.tracking.methods._total_sigma import with_total_sigma
from servosight.tracking.methods._verified import elsewhere, verify
from servosight.tracking.verification import FrameSample, sampled_where_it_moves
from servosight.tracking.video import Film, Frame, Window, windowed
from servosight.tracking.video.drawing import SeenPart, refusal_picture

_LEAST_FRAMES = 12
_LEAST_POINTED = 0.15
_LEAPS = (
    "leaps by {:.0f} deg from one frame to the next and rests before and after; expected a part "
    "that turns"
)
_SHADOW = "the shadow that moves with the part is taken out: the frames show the background there"
_LEAST_TRIED = 0.4  # about a rough pivot: about a better one a part may explain enough


@dataclass(frozen=True)
class Footage:
    """The frames in which the camera rests, and what the user wants measured in them.

    ``stamps_s`` (frames,) are the file's own times, ``missing`` how many pictures before each frame
    could not be used. ``window`` is the piece of the pictures that is looked at, all if None.
    ``tilt`` is what other pictures of the part, larger or of another colour, showed of it.
    """

    film: Film
    options: TrackOptions
    sample: FrameSample
    stabilised: StabilisedSample
    stamps_s: Array
    missing: tuple[int, ...]
    hint: Hint | None
    window: Window | None = None
    tilt: Tilt = UNKNOWN

    def knowing(self, track: Track | None) -> Footage:
        """With what a track of these frames showed of the tilt; None: of no track."""
        return self if track is None else replace(self, tilt=track.tilt)

    @classmethod
    def of(cls, film: Film, options: TrackOptions, window: Window | None = None) -> Footage:
        """From a video; ``TrackRefused`` where the camera does not rest."""
        sample = FrameSample(_as_it_is)
        seen = windowed(film.decoded(), window)
        rows = [(frame.time_s, frame.missing) for frame in sample.watch(seen)]
        stamps_s = np.array([time_s for time_s, _ in rows])
        missing = tuple(count for _, count in rows)
        sample = sampled_where_it_moves(sample, lambda: windowed(film.decoded(), window))
        share = 1.0 if window is None else window.height / film.images[0].shape[0]
        stabilised = StabilisedSample.of(sample, share)
        if len(stabilised.pictures) < _LEAST_FRAMES:
            raise TrackRefused(
                f"{film.path}: the camera rests for too short a time; expected half a second at "
                "least in which it stays in place, cut the video or mount the camera.",
                partial(refusal_picture, film.images),
            )
        if window is not None:
            stabilised = replace(stabilised, origin_px=(window.x, window.y))
        hint = hint_of(film, options, stabilised, stamps_s)
        return cls(film, options, sample, stabilised, stamps_s, missing, hint, window)

    def in_colour(self) -> Footage | None:
        """The same frames in the colour in which they change most, aligned as in grey; None where
        no colour changes."""
        return self._showing(self.stabilised.in_colour(*self._colours))

    def without_shadow(self) -> Footage | None:
        """The same frames without the shadow that moves on the background; None where none does."""
        return self._showing(self.stabilised.without_shadow(*self._colours))

    def _showing(self, stabilised: StabilisedSample | None) -> Footage | None:
        return None if stabilised is None else replace(self, stabilised=stabilised)

    @cached_property
    def _colours(self) -> tuple[Single, Single]:
        """The pictures' differences of colour Cb and Cr, (n, height, width) each."""
        same = frozenset(self.sample.index)
        cb, cr = (FrameSample(_as_it_is, only=same) for _ in range(2))
        for frame in windowed(self.film.decoded(coloured=True), self.window):
            assert frame.colour is not None
            for sample, image in zip((cb, cr), frame.colour, strict=True):
                sample.add(replace(frame, image=image))
        return self.stabilised.still(cb), self.stabilised.still(cr)

    @property
    def least_explained(self) -> float:
        """The share of the change that a part must explain."""
        return _LEAST_POINTED if self.options.pointed else TRUST.least_measured

    @property
    def least_tried(self) -> float:
        """The share from which a part is looked at more closely."""
        return min(_LEAST_TRIED, self.least_explained)

    def parts(self, found: list[FoundPart] | None = None) -> list[FoundPart]:
        """The parts that turn, the one that explains most of the change first; or further ones
        than ``found``. Not the part that was tracked before."""
        pictures, content = self.stabilised.pictures, self.stabilised.content
        first = elsewhere(self.options, self.film, pictures.shape[1:])
        if first is not None:
            pictures = np.where(first, known_median(pictures), pictures)
        if found is None:
            parts = find_parts(pictures, self.hint, content)
            parts = best_first(self.stabilised, parts, self.settled)
        else:
            parts = parts_otherwise(pictures, found, self.hint, content)
        if first is None:
            return parts
        return [
            replace(one, beside=first if one.beside is None else first | one.beside)
            for one in parts
        ]

    def settled(self, part: FoundPart) -> tuple[FoundPart, PartMeter]:
        """The part learnt about the better pivot that it leads to, and its meter; once for each."""
        if id(part) not in self._settled:
            learnt = settled_part(self.stabilised, part, self.hint)
            self._settled[id(part)] = part, learnt
        return self._settled[id(part)][1]

    @cached_property
    def _settled(self) -> dict[int, tuple[FoundPart, tuple[FoundPart, PartMeter]]]:
        """By the parts' identity, which is theirs as long as they are kept here."""
        return {}

    def check(self, parts: Sequence[FoundPart]) -> None:
        """``TrackRefused``, with all parts drawn, where the one to measure is not there."""
        pick = self.options.pick
        if len(parts) < pick or parts[pick - 1].explained_there < self.least_tried:
            raise self.nothing(parts)

    def measured(self, part: FoundPart, progress: FrameProgress | None) -> Track:
        """The part's track; ``TrackRefused`` where the frames do not confirm it."""
        settled, meter = self.settled(part)
        if not meter.visible:  # what is left about the pivot that it leads to is no part
            raise self.nothing([])
        share = max(part.explained_there, settled.explained_there)
        if share < self.least_explained:
            seen = SeenPart(self.candidate(settled).pivot_px, self._outline(settled))
            raise TrackRefused(
                f"{self.film.path}: the part that may turn about {seen.pivot_px[0]:.0f},"
                f"{seen.pivot_px[1]:.0f} explains only {share:.0%} of what changes; expected "
                f"{self.least_explained:.0%} at least, as of a part in full view, {POINT}.",
                partial(self._drawn, [seen]),
                found=True,
            )
        first, last = self.stabilised.near
        if last == self.sample.index[-1]:  # the frames after it are not sampled
            last = self.film.header.count
        fits, rivals = [], []
        for frame, fit, others in meter.measured(self._frames(), first, last):
            fits.append(fit)
            rivals.append(others)
            if progress is not None:
                progress(frame.index + 1, self.film.header.count)
        found = np.array([fit is not None for fit in fits])
        fits = without_false_turns(fits)
        sure = longest_sure(fits, rivals)
        fits = [fit if kept else None for fit, kept in zip(fits, sure, strict=True)]
        stamps_s, missing = self.stamps_s[: len(fits)], list(self.missing[: len(fits)])
        track = track_of(self.film, self.options, meter, stamps_s, missing, fits)
        notes = left_out(track, first, last, bool((found & ~sure).any()))
        if self.stabilised.shadow is not None:
            notes += (_SHADOW,)
        notes += self._astray(track)
        track = replace(track, notes=(*notes, *track.notes))
        return self._confirmed(track, meter, fits, settled)

    def _astray(self, track: Track) -> tuple[str, ...]:
        """A note where a track is about another place than the pivot pointed at."""
        return astray(track, self.stabilised, self.hint, max(self.film.images[0].shape))

    def _confirmed(
        self, track: Track, meter: PartMeter, fits: list[PoseFit | None], part: FoundPart
    ) -> Track:
        """The track at mid-exposure with the sigma of its pivot and of its times, where the frames
        confirm it."""
        pictures = list(self.stabilised.pictures)
        seen = replace(
            self.sample, index=self.stabilised.index.tolist(), pictures=pictures,
            roll_rad=self.stabilised.roll_rad.tolist(),
        )  # fmt: skip
        origin = np.array(self.stabilised.origin_px)
        pieces = meter.pieces(first_rad(fits))
        lines = [self.stabilised.in_video(one) - origin for one in pieces]
        shown = outline_at(track, float(track.angle_deg[self.stabilised.reference_index]))
        draw = partial(self._drawn, [SeenPart(track.pivot_px, shown)])
        resting = np.array([self.stabilised.rests(number) for number in range(len(fits))])
        verify(
            self.film, self.options, track, track.pivot_px - origin, lines,
            seen, resting, draw, partial(left_out_of, part, self.stabilised.content),
        )  # fmt: skip
        angle_rad = np.array([np.nan if fit is None else fit.angle_rad for fit in fits])
        sampled = meter.sampled(self.film.images[0].shape)
        turns = (meter.in_sampled(one) for one in (angle_rad, paces_rad(angle_rad)))
        view = oblique_view(sampled, *turns)
        track, apart_deg = in_plane(track, meter, fits, view)
        track = replace(track, sigma_deg=np.hypot(track.sigma_deg, apart_deg))
        track = with_repeats(track)
        seen_deg, sigma_deg = track.angle_deg[track.found], track.sigma_deg[track.found]
        # About another place than the one pointed at it may be a part and its shadow.
        pointed = self.options.pointed and not self._astray(track)
        why = distrust(apart_deg, sigma_deg, fits, pointed)
        by_sigma = distrust(apart_deg, 0.0 * sigma_deg, fits, pointed) is None
        # Of what enters the picture, an uncertain angle, or one that its grey does not confirm, is
        # as likely someone's at the border.
        coloured = not self.stabilised.channel.luma
        if why is None and coloured and not clear_of(part, self.stabilised):
            why, by_sigma = "enters the picture, and its colour alone shows that it turns", False
        rough = by_sigma and rough_enough(seen_deg, sigma_deg, meter.doubt_px)
        rough = rough and clear_of(part, self.stabilised)
        stamps_s = self.stamps_s[: len(fits)]
        leap = leap_deg(stamps_s, np.where(track.found, track.angle_deg, np.nan))
        if leap > 0.0:
            why, rough = _LEAPS.format(leap), False
        x, y = track.pivot_px
        sentence = f"{self.film.path}: the part about {x:.0f},{y:.0f} {why}, {POINT}."
        if why is not None and not rough:
            raise TrackRefused(sentence, draw, measured=True, uncertain=by_sigma and not leap)
        if view is not None:
            view = view.as_doubtful(float(np.deg2rad(self.tilt.doubt_deg)))
            pivot_px = self.stabilised.in_video(view.pivot_px)
            track = along_axis(track, view, angle_rad, pivot_px)
        track = with_total_sigma(at_mid_exposure(track, self.film, meter, stamps_s, fits))
        if why is not None:
            raise TrackRefused(sentence, draw, measured=True, uncertain=True, rough=track)
        return track

    def _frames(self) -> Iterator[Frame]:
        return windowed(self.film.decoded(coloured=self.stabilised.coloured), self.window)

    def nothing(self, parts: Sequence[FoundPart]) -> TrackRefused:
        """That the part is not there, with the parts that were found drawn."""
        options = self.options
        if options.pick > 1:
            one = len(parts) == 1
            found = "1 part that may turn is" if one else f"{len(parts)} parts that may turn are"
            why = (
                f"--pick is {options.pick}, and {found} found; expected the number of "
                "one that is found, or point at it with --tip X,Y"
            )
        elif options.pointed:
            why = nothing_there(options, self.film.images[0].shape)
        else:
            why = (
                "nothing that turns explains what changes in the picture; expected a part that "
                f"turns in full view, {POINT}"
            )
        seen = [SeenPart(self.candidate(part).pivot_px, self._outline(part)) for part in parts]
        return TrackRefused(f"{self.film.path}: {why}.", partial(self._drawn, seen))

    def candidate(self, part: FoundPart) -> Candidate:
        """A part that was found, in the video's own pixels."""
        x, y = self.stabilised.in_video(np.array(part.pivot_px))
        return Candidate(pivot_px=(float(x), float(y)), explained=round(part.explained, 3))

    def _outline(self, part: FoundPart) -> Array:
        return self.stabilised.in_video(outline_of(part, self.stabilised))

    def _drawn(self, parts: Sequence[SeenPart]) -> Image:
        """Parts on the picture that all frames were aligned with."""
        whole = self.film.images[0]

        def large(picture: Image) -> Image:
            image = whole.copy()
            piece = image if self.window is None else self.window.of(image)
            cv2.resize(picture, piece.shape[::-1], dst=piece, interpolation=cv2.INTER_LINEAR)
            return image

        stabilised = self.stabilised
        others = np.clip(
            np.round(stabilised.pictures[:: 1 + len(stabilised.pictures) // 24]), 0, 255
        )
        images = [large(stabilised.reference), *(large(one.astype(np.uint8)) for one in others)]
        at_s = float(self.stamps_s[stabilised.reference_index])
        return refusal_picture(images, parts, at_s, pointed_part(stabilised, self.hint))


def _as_it_is(image: Image) -> Image:
    return image
