"""The two loops that draw: a layer laid over a picture, sampled bilinearly in place.

At this many samples a pixel, under the lens's blur, bilinear sampling moves no edge.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(cache=True, fastmath=True, inline="always")
def _mix(body, row, column, p, q, below):  # type: ignore[no-untyped-def]
    """The sample of ``body`` over the light ``below``, ``p`` columns and ``q`` rows beyond a place.

    Places are unsigned: for signed ones numba tests for wrap-around.
    """
    one = np.uint64(1)
    j, i = np.uint64(row), np.uint64(column)
    light, light_next = body[j, i, 0], body[j + one, i, 0]
    cover, cover_next = body[j, i, 1], body[j + one, i, 1]
    light += p * (body[j, i + one, 0] - light)
    light_next += p * (body[j + one, i + one, 0] - light_next)
    cover += p * (body[j, i + one, 1] - cover)
    cover_next += p * (body[j + one, i + one, 1] - cover_next)
    light += q * (light_next - light)
    cover += q * (cover_next - cover)
    return below * (np.float32(1) - cover) + light


@njit(cache=True, fastmath=True, nogil=True)
def lay_over(picture, body, matrix, skipped):  # type: ignore[no-untyped-def]
    """Lay ``body`` (rows, columns, 2) over ``picture`` (rows, columns) in place.

    ``matrix`` (3, 3), affine, takes columns and rows to those of the body, where the first row of
    ``picture`` counts as row ``skipped``.
    """
    rows, columns = body.shape[0], body.shape[1]
    # Places and weights of a row first: that loop has no access to the body, and is vectorised.
    place = np.empty((2, picture.shape[1]), np.int32)
    beyond = np.empty((2, picture.shape[1]), np.float32)
    du, dv = matrix[0, 0], matrix[1, 0]
    du4, dv4 = np.float32(du), np.float32(dv)
    for j in range(picture.shape[0]):
        # Along this row the body's coordinates are u = u0 + du i, v = v0 + dv i: keep the i for
        # which both lie within the body.
        u0 = matrix[0, 1] * (skipped + j) + matrix[0, 2]
        v0 = matrix[1, 1] * (skipped + j) + matrix[1, 2]
        first, last = 0.0, picture.shape[1] - 1.0
        for start, slope, limit in ((u0, du, columns - 1.01), (v0, dv, rows - 1.01)):
            if abs(slope) < 1e-9:
                if start < 0.0 or start > limit:
                    last = -1.0
            else:
                a, b = -start / slope, (limit - start) / slope
                first, last = max(first, min(a, b)), min(last, max(a, b))
        begin = math.ceil(first + 1e-3)
        u1, v1 = np.float32(u0 + du * begin), np.float32(v0 + dv * begin)
        count = max(math.floor(last - 1e-3) + 1 - begin, 0)
        for i in range(count):
            u, v = u1 + du4 * np.float32(i), v1 + dv4 * np.float32(i)
            m, n = np.int32(u), np.int32(v)
            beyond[0, i], beyond[1, i] = u - np.float32(m), v - np.float32(n)
            place[0, i], place[1, i] = n, m
        line = picture[j, begin : begin + count]
        for i in range(count):
            line[i] = _mix(body, place[0, i], place[1, i], beyond[0, i], beyond[1, i], line[i])


@njit(cache=True, fastmath=True, nogil=True)
def lay_along_rays(picture, body, rays, matrix):  # type: ignore[no-untyped-def]
    """The same where each sample of the picture has its own ray (rows, columns, 2).

    ``matrix`` (3, 3), a homography, takes rays to columns and rows of the body.
    """
    rows, columns = body.shape[0], body.shape[1]
    for j in range(picture.shape[0]):
        for i in range(picture.shape[1]):
            x, y = rays[j, i, 0], rays[j, i, 1]
            w = 1.0 / (matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2])
            # Rounded before they are compared: what rounds to the last column has none beside it.
            u = np.float32((matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) * w)
            v = np.float32((matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) * w)
            if 0.0 <= u < columns - 1 and 0.0 <= v < rows - 1:
                m, n = np.int32(u), np.int32(v)
                p, q = u - np.float32(m), v - np.float32(n)
                picture[j, i] = _mix(body, n, m, p, q, picture[j, i])
