/* SPDX-License-Identifier: MIT */
/*
 * Rows of the next tile, in the caller's arrays, prefetched one after the other while the tile before it is finished.
 */
#ifndef MLRT_BASE_ROWS_AHEAD_H
#define MLRT_BASE_ROWS_AHEAD_H

#include <stddef.h>
#include <stdint.h>

/* At most: five arrays that are read, and seven that are written. */
#define MLRT_ROWS_AHEAD_LIMIT 12

enum mlrt_row_use { MLRT_ROW_IS_READ, MLRT_ROW_IS_WRITTEN, MLRT_ROW_IS_CROWDED /* and written */ };

/* An array's rows of a tile. */
struct mlrt_row_ahead {
    const unsigned char *first;
    size_t size;     /* bytes of a row in the tile */
    size_t distance; /* between rows */
    enum mlrt_row_use use;
};

struct mlrt_rows_ahead {
    uint32_t height; /* rows */
    uint32_t count;  /* arrays */
    struct mlrt_row_ahead each[MLRT_ROWS_AHEAD_LIMIT];
};

/* Adds an array: where the tile's first row begins, the bytes of a row in the tile, the distance of rows. */
void mlrt_add_rows_ahead(const void *first, size_t size, size_t distance, int is_written, struct mlrt_rows_ahead *rows);

/* Prefetches row `i` of each array, if there is one. */
void mlrt_prefetch_rows(const struct mlrt_rows_ahead *rows, uint32_t i);

#endif
