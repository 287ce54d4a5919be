/* SPDX-License-Identifier: MIT */
/*
 * The golden numbers: hashes over ids and bits of t, u, v of procedural scenes, and over everything else that is
 * promised to be the same on every machine. They have one definition, here, for test_golden.c, which holds the
 * reference against them too, and for print_golden.c, which needs nothing but the library and so runs on any machine.
 */
#ifndef TESTS_GOLDEN_H
#define TESTS_GOLDEN_H

#include <stdint.h>

#include "mlrt.h"

/* A change of these is a change of answers. The reference gave the first. */
#define GOLDEN_HITS 0x984850255297C12Du /* closest hits: pictures, and the same rays as packets */
#define GOLDEN_REST 0xD76C5D2F24F1C012u /* trees, shadows of points and of pictures, all hits, points off triangles */

#define GOLDEN_START 0xCBF29CE484222325u /* of either hash, before the first scene */

enum { GOLDEN_WIDTH = 80, GOLDEN_HEIGHT = 60, GOLDEN_COUNT = GOLDEN_WIDTH * GOLDEN_HEIGHT, GOLDEN_SCENES = 3 };

struct golden_hit {
    float t;
    float u;
    float v;
    uint32_t mesh;
    uint32_t triangle;
    int32_t facing; /* not hashed */
};

/* The name of a procedural scene of the examples, and what looks at it. */
const char *golden_scene(int scene);
mlrt_camera golden_camera(int scene);

/* All rays of a picture at once, by mlrt_render_tiles and by mlrt_trace_packet. They return the status. */
int32_t golden_picture(const mlrt_tree *tree, int scene, const mlrt_trace_options *options,
                       struct golden_hit hits[GOLDEN_COUNT]);
int32_t golden_packet(const mlrt_tree *tree, int scene, const mlrt_trace_options *options, uint32_t row_length,
                      struct golden_hit hits[GOLDEN_COUNT]);

uint64_t hash_golden_hits(uint64_t hash, const struct golden_hit hits[GOLDEN_COUNT]);

/*
 * What a tree adds to GOLDEN_REST: itself, shadows at the hits of its picture, and all hits of some of its rays. Of
 * each scene a tuned kd-tree adds first, then boxes. Returns a status; with MLRT_OK *hash is new.
 */
int32_t hash_golden_rest(uint64_t *hash, const mlrt_tree *tree, int scene, const mlrt_trace_options *options);

#endif
