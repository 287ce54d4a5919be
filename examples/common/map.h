/* SPDX-License-Identifier: MIT */
/* map.h - pictures in false colours of what the ray of each pixel costs, with a legend */
#ifndef MAP_H
#define MAP_H

#include <mlrt.h>

/* What is shown, each of mlrt_trace_ray for the ray alone. */
enum {
    MAP_NONE,
    MAP_NODES, /* nodes and leaves that it opens (mlrt_counters.cell_count) */
    MAP_TESTS, /* triangles that it is tested against (triangle_test_count) */
    MAP_DEPTH, /* t of its hit; a miss is black */
    MAP_JUDGE, /* triangles and decisions that float arithmetic leaves to double or exact arithmetic */
    MAP_TIME   /* nanoseconds of a call: the least of several, which other programs disturb less */
};
#define MAP_WORDS "nodes|tests|depth|judge|time"

/*
 * Draws a map of the camera's picture: 3 bytes per pixel, from black (0) to yellow. The brightest colour stands for the
 * value that 99 % of the pixels do not exceed, and the legend for its numbers. Returns 0, or 1 after a message on
 * stderr.
 */
int draw_map(const mlrt_tree *tree, const mlrt_camera *camera, int32_t map, uint8_t *rgb);

#endif
