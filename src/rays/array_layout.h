/* SPDX-License-Identifier: MIT */
/* Where the arrays of a source have the rays of its blocks, for read_arrays.h. */
#ifndef MLRT_RAYS_ARRAY_LAYOUT_H
#define MLRT_RAYS_ARRAY_LAYOUT_H

#include "rays/source.h"

/* Where the elements of a block lie in an array. Distances are in bytes. */
struct mlrt_array_layout {
    const unsigned char *data;
    size_t stride;   /* between elements; 0: all rays share one */
    size_t step;     /* between neighbours in a row of a block; 0: they share one element */
    size_t row_step; /* between the rows of a block */
    int has_word;    /* the word behind each element belongs to another array, so it may be read too */
};

/* The layouts of a source's arrays: the same for all blocks of a tile. */
struct mlrt_array_reader {
    const struct mlrt_source *source;
    struct mlrt_array_layout points;
    struct mlrt_array_layout directions;
    struct mlrt_array_layout t_min;
    struct mlrt_array_layout t_max;
    struct mlrt_array_layout skip;
    int points_have_t_min;     /* the word behind each point is its t_min */
    int directions_have_t_max; /* the word behind each direction is its t_max */
    int are_structs;           /* each direction follows the word behind its point */
};

/*
 * Sets up the reader of a source. Returns 0 if whole blocks cannot be read: for a camera, and if the number of rays per
 * origin is neither 1 nor a multiple of a packet's rays.
 */
int mlrt_begin_reading(const struct mlrt_source *source, struct mlrt_array_reader *reader);

#endif
