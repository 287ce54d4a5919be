/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels in a list of rays: see rows.h.
 *
 * From pixel to pixel a row goes on in small steps; from its end to the start of the next row it jumps. So the first
 * jump is a guess, which rows from all over the list must confirm.
 */
#include "rays/rows.h"

#include <math.h>

/* A step so many times as long as the one before it, or after it, is a jump. Steps of a wide view differ between its
 * middle and its corners, but hardly from their neighbours. */
#define JUMP_FACTOR 4

/* So many rows confirm a guess, or all if there are fewer. There must be at least FEWEST_ROWS. */
#define WITNESS_COUNT 16
#define FEWEST_ROWS   4

#define SHORTEST_ROW 8

/* The length of the way between two elements, over the axes. May be NaN, which is neither short nor long. */
static float way(const mlrt_const_array *vectors, size_t from, size_t to)
{
    const unsigned char *data = vectors->data;
    const float *a = (const float *)(const void *)(data + from * vectors->stride);
    const float *b = (const float *)(const void *)(data + to * vectors->stride);
    return fabsf(b[0] - a[0]) + fabsf(b[1] - a[1]) + fabsf(b[2] - a[2]);
}

/* Does the list go on in small steps on both sides of element `start`, but not to it? */
static int jumps_to(const mlrt_const_array *vectors, size_t start)
{
    const float jump = way(vectors, start - 1, start);
    return jump > JUMP_FACTOR * way(vectors, start - 2, start - 1) &&
           jump > JUMP_FACTOR * way(vectors, start, start + 1);
}

static uint32_t find_period(const mlrt_const_array *vectors, uint32_t count)
{
    float step = way(vectors, 0, 1);
    uint32_t length = 1;
    while (length <= count / FEWEST_ROWS) {
        const float next = way(vectors, length, length + 1);
        ++length;
        if (!(next <= JUMP_FACTOR * step)) break;
        step = next;
    }
    if (length < SHORTEST_ROW || count % length || count / length < FEWEST_ROWS) return 0;
    const uint32_t row_count = count / length, first_jump = row_count > WITNESS_COUNT ? row_count / WITNESS_COUNT : 1;
    for (uint32_t row = 1; row < row_count; row += first_jump) {
        const size_t start = (size_t)row * length;
        if (!jumps_to(vectors, start)) return 0;
        /* Rows are beside each other. */
        if (!(JUMP_FACTOR * way(vectors, start - length, start) < (float)length * way(vectors, start, start + 1)))
            return 0;
    }
    return length;
}

uint32_t mlrt_find_row_length(const struct mlrt_source *rays)
{
    if (rays->count < FEWEST_ROWS * SHORTEST_ROW || rays->rays_per_origin > 1) return 0;
    const int directions_are_equal = way(&rays->directions, 0, 1) == 0 && way(&rays->directions, 1, 2) == 0;
    return find_period(directions_are_equal ? &rays->points : &rays->directions, rays->count);
}
