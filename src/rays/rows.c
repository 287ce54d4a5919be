/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels in a list of rays: see rows.h.
 *
 * Steps between the pixels of a row are small; the step from its end to the start of the next row is a jump. So the
 * first jump gives a guess of the row length. Rows from all over the list must confirm it.
 */
#include "rays/rows.h"

#include <math.h>

/*
 * A step that is more than this many times as long as the steps beside it is a jump. In a wide view, steps in the
 * middle and in the corners differ, but hardly steps beside each other.
 */
#define JUMP_FACTOR 4

/* A guess is tried at about this many rows, spread over the list, or at all rows if there are fewer. */
#define WITNESS_COUNT 16

/* Lists of fewer or shorter rows remain lists. */
#define FEWEST_ROWS  4
#define SHORTEST_ROW 8

/*
 * The length of the step between two elements, as a sum over the axes. It can be a NaN: comparisons with that are
 * false.
 */
static float step_length(const mlrt_const_array *vectors, uint32_t from, uint32_t to)
{
    const float *a = mlrt_element(vectors, from), *b = mlrt_element(vectors, to);
    return fabsf(b[0] - a[0]) + fabsf(b[1] - a[1]) + fabsf(b[2] - a[2]);
}

/* 1 if the step to element `start` is a jump, compared with the steps before and after it. */
static int jumps_to(const mlrt_const_array *vectors, uint32_t start)
{
    const float jump = step_length(vectors, start - 1, start);
    return jump > JUMP_FACTOR * step_length(vectors, start - 2, start - 1) &&
           jump > JUMP_FACTOR * step_length(vectors, start, start + 1);
}

/* The number of elements of a row, or 0 if these are no rows. */
static uint32_t find_period(const mlrt_const_array *vectors, uint32_t count)
{
    float step = step_length(vectors, 0, 1);
    uint32_t length = 1;
    while (length <= count / FEWEST_ROWS) {
        const float next = step_length(vectors, length, length + 1);
        ++length;
        if (!(next <= JUMP_FACTOR * step)) break;
        step = next;
    }
    if (length < SHORTEST_ROW || count % length || count / length < FEWEST_ROWS) return 0;
    const uint32_t row_count = count / length, row_step = row_count > WITNESS_COUNT ? row_count / WITNESS_COUNT : 1;
    for (uint32_t row = 1; row < row_count; row += row_step) {
        const uint32_t start = row * length;
        if (!jumps_to(vectors, start)) return 0;
        /* The start of a row must lie close to that of the row before, compared with the length of a row. */
        const float row_distance = step_length(vectors, start - length, start);
        if (!(JUMP_FACTOR * row_distance < (float)length * step_length(vectors, start, start + 1))) return 0;
    }
    return length;
}

static MLRT_NOINLINE uint32_t find_row_length(const struct mlrt_source *rays)
{
    const int directions_are_equal =
        step_length(&rays->arrays.directions, 0, 1) == 0 && step_length(&rays->arrays.directions, 1, 2) == 0;
    return find_period(directions_are_equal ? &rays->arrays.points : &rays->arrays.directions, rays->count);
}

uint32_t mlrt_find_row_length(const struct mlrt_source *rays)
{
    if (rays->count < FEWEST_ROWS * SHORTEST_ROW || rays->arrays.rays_per_origin > 1) return 0;
    uint32_t length;
    MLRT_COMPUTE(length = find_row_length(rays));
    return length;
}
