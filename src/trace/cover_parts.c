/* SPDX-License-Identifier: MIT */
/*
 * Covers of several triangles. Each triangle that hides a cell in part adds its open edges to the cell: those inside of
 * which not all rays are known to pass. A new triangle whose open edges are all edges of others, too, may be the last
 * part of a cover. The cover is complete if something remains after this: drop each triangle that has an open edge
 * which no other one has, and repeat that until none is dropped.
 */
#include "trace/cover_parts.h"

#include <string.h>

/* Adds edges[count] to those of a cell, and finds the same edge of other triangles. Returns 0 if there is none. */
static int add_edge(struct mlrt_cell_parts *cell)
{
    struct mlrt_open_edge *edge = &cell->edges[cell->count];
    edge->others = 0;
    for (uint32_t i = 0; i < cell->count; ++i) {
        struct mlrt_open_edge *other = &cell->edges[i];
        if (memcmp(other->first, edge->last, sizeof edge->last) != 0) continue;
        if (memcmp(other->last, edge->first, sizeof edge->first) != 0) continue;
        other->others |= 1u << cell->count;
        edge->others |= 1u << i;
    }
    ++cell->count;
    return edge->others != 0;
}

/* Returns the edges of those triangles of a cell that share all of their open edges. */
static uint32_t find_shared(const struct mlrt_open_edge *edges, uint32_t count)
{
    uint32_t shared = (1u << count) - 1, before;
    do {
        before = shared;
        for (uint32_t i = 0; i < count; ++i) {
            if (!(shared >> i & 1) || edges[i].others & shared) continue;
            for (uint32_t j = 0; j < count; ++j) shared &= ~((uint32_t)(edges[j].number == edges[i].number) << j);
        }
    } while (shared != before);
    return shared;
}

/*
 * Adds a triangle to a cell, whose bit in open[i] tells whether edge i is open. Returns the edges of a cover of which
 * it is the last part, or 0.
 */
static uint32_t add_to_cell(const struct mlrt_bundle_leaf *leaf, uint32_t triangle, int is_backward,
                            const uint32_t open[3], uint32_t place, struct mlrt_cell_parts *cell)
{
    int is_last = 1;
    for (uint32_t i = 0; i < cell->count; ++i) {
        if (cell->edges[i].number == leaf->numbers[triangle]) return 0; /* it lies in several leaves */
    }
    for (uint32_t i = 0; i < 3; ++i) {
        const float *from = leaf->corners + 3 * (size_t)leaf->row * i + triangle;
        const float *to = leaf->corners + 3 * (size_t)leaf->row * ((i + 1) % 3) + triangle;
        struct mlrt_open_edge *edge = &cell->edges[cell->count];
        if (!(open[i] >> place & 1)) continue;
        for (size_t k = 0; k < 3; ++k) {
            edge->first[k] = (is_backward ? to : from)[k * leaf->row];
            edge->last[k] = (is_backward ? from : to)[k * leaf->row];
        }
        edge->number = leaf->numbers[triangle];
        is_last &= add_edge(cell);
    }
    return is_last ? find_shared(cell->edges, cell->count) : 0;
}

void mlrt_add_cover_part(struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                         mlrt_cell_test *skips, struct mlrt_cover_parts *parts, struct mlrt_offered_packets *offered)
{
    const int is_backward = offered->backward >> mlrt_lowest_bit(offered->in_part) & 1; /* all have this sign (L22) */
    if (MLRT_UNLIKELY(leaf->state.odd >> triangle & 1)) return; /* the leaf does not have its corners (bvh/unit.h) */
    for (uint32_t left = offered->in_part; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        struct mlrt_cell_parts *cell = &parts->cells[place];
        if (!(parts->waited >> place & 1)) cell->count = 0;
        if (cell->count + 3 > MLRT_MOST_OPEN_EDGES) continue;
        uint32_t cover = add_to_cell(leaf, triangle, is_backward, parts->open, place, cell), last = MLRT_NONE;
        parts->waited |= 1u << place;
        offered->may &= ~(1u << place);
        if (!cover) continue;
        for (; cover; cover &= cover - 1) {
            const uint32_t number = cell->edges[mlrt_lowest_bit(cover)].number;
            if (number != last && skips(bundle->arrays, place, last = number)) break;
        }
        if (cover) continue;
        bundle->hulls.closed.cover[place] = leaf->numbers[triangle];
        offered->covered |= 1u << place;
    }
}

void mlrt_end_cover_parts(struct mlrt_bundle *bundle, struct mlrt_cover_parts *parts)
{
    const uint32_t waited = parts->waited;
    parts->waited = 0;
    bundle->state.closed &= ~(waited & bundle->state.going);
    if (mlrt_skips_attempt(&parts->lone_squares) || !waited) return;
    const int is_vain = 2 * mlrt_count_bits(waited & bundle->state.covered) < mlrt_count_bits(waited);
    mlrt_note_attempt(is_vain, 1, MLRT_LONE_SQUARE_BACKOFF, &parts->lone_squares);
}
