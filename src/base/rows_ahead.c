/* SPDX-License-Identifier: MIT */
/* Rows of the next tile: see rows_ahead.h. */
#include "base/rows_ahead.h"

#include "base/platform.h"

#define LINE_SIZE 64

/*
 * Lines at the same place of different pages fall into one set of a first-level cache, which has room for about a dozen
 * of them. So rows of results that are whole pages apart push each other out before they are written. These are
 * prefetched into the second level, as if to be read: no prefetch for writing stops there. Rows to be read stay in the
 * first level, since tiles of any-hit rays are bounded faster than rows arrive from the second.
 */
#define CROWDING_DISTANCE 4096

void mlrt_add_rows_ahead(const void *first, size_t size, size_t distance, int is_written, struct mlrt_rows_ahead *rows)
{
    const int is_crowded = is_written && distance % CROWDING_DISTANCE == 0;
    const enum mlrt_row_use use = is_crowded   ? MLRT_ROW_IS_CROWDED
                                  : is_written ? MLRT_ROW_IS_WRITTEN
                                               : MLRT_ROW_IS_READ;
    rows->each[rows->count++] = (struct mlrt_row_ahead){first, size, distance, use};
}

void mlrt_prefetch_rows(const struct mlrt_rows_ahead *rows, uint32_t i)
{
    if (i >= rows->height) return;
    for (const struct mlrt_row_ahead *row = rows->each; row < rows->each + rows->count; ++row) {
        const unsigned char *at = row->first + i * row->distance;
        const unsigned char *end = at + ((uintptr_t)at % LINE_SIZE + row->size);
        if (row->use == MLRT_ROW_IS_CROWDED) {
            for (; at < end; at += LINE_SIZE) MLRT_PREFETCH(at, 0, 2);
        } else if (row->use == MLRT_ROW_IS_READ) {
            for (; at < end; at += LINE_SIZE) MLRT_PREFETCH(at, 0, 3);
        } else {
            for (; at < end; at += LINE_SIZE) MLRT_PREFETCH(at, 1, 3);
        }
    }
}
