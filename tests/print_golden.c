/* SPDX-License-Identifier: MIT */
/*
 * print_golden - the golden numbers of this machine, from every method and instruction set that it has
 *
 * Needs the library and the procedural scenes only, so that it runs wherever the library does: under an emulator, too.
 * One line for each way of tracing; exits with 0 if all numbers are those of golden.h.
 */
#include <stdio.h>
#include <stdlib.h>

#include "common/scene.h"
#include "golden.h"

struct way {
    const char *name;
    int32_t method;
    uint32_t shortcuts_off;
    int on_kdtree;
};

static const struct way ways[] = {
    {"default", MLRT_METHOD_DEFAULT, 0, 0},
    {"default of a kd-tree", MLRT_METHOD_DEFAULT, 0, 1},
    {"ray", MLRT_METHOD_RAY, 0, 0},
    {"ray, kd-tree", MLRT_METHOD_RAY, 0, 1},
    {"packet2", MLRT_METHOD_PACKET2, 0, 1},
    {"packet4", MLRT_METHOD_PACKET4, 0, 1},
    {"multilevel", MLRT_METHOD_MULTILEVEL, 0, 1},
    {"multilevel, as in the paper", MLRT_METHOD_MULTILEVEL, 7, 1},
    {"tile", MLRT_METHOD_TILE, 0, 0},
};
enum { WAYS = sizeof ways / sizeof *ways };

static const char *const isa_names[] = {"auto", "scalar", "sse", "avx2", "avx512", "neon"};

/* Each scene as boxes and as a tuned kd-tree. */
struct trees {
    mlrt_tree *boxes[GOLDEN_SCENES];
    mlrt_tree *kdtrees[GOLDEN_SCENES];
};

static void check(int32_t status, const char *what)
{
    if (status == MLRT_OK) return;
    fprintf(stderr, "print_golden: %s: %s\n", what, mlrt_status_string(status));
    exit(2);
}

static void build_trees(struct trees *trees, mlrt_pool *pool)
{
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        struct scene scene;
        if (load_scene(golden_scene(s), &scene)) exit(2);
        const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                                .vertices = scene.vertices,
                                .vertex_count = scene.vertex_count,
                                .indices = scene.indices,
                                .triangle_count = scene.triangle_count};
        const mlrt_tree_options boxes = {.struct_size = sizeof boxes, .pool = pool};
        const mlrt_kdtree_options tuned = {.struct_size = sizeof tuned, .preset = MLRT_KDTREE_TUNED};
        check(mlrt_build_tree(&mesh, 1, &boxes, &trees->boxes[s]), "build");
        check(mlrt_build_kdtree(&mesh, 1, &tuned, &trees->kdtrees[s]), "build");
        free_scene(&scene);
    }
}

static int is_supported(const mlrt_tree *tree, int32_t isa)
{
    mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa};
    return mlrt_trace_ray(tree, &ray, &options, &hit) != MLRT_ERROR_UNSUPPORTED;
}

static int report(int32_t isa, const char *way, const char *what, uint64_t hash, uint64_t expected)
{
    const int is_right = hash == expected;
    printf("%-6s  %-27s  %-8s  0x%016llX%s\n", isa_names[isa], way, what, (unsigned long long)hash,
           is_right ? "" : "  WRONG");
    return is_right;
}

static int try_pictures(mlrt_tree *const *trees, const char *what, const char *name, const mlrt_trace_options *options)
{
    static struct golden_hit hits[GOLDEN_COUNT];
    uint64_t hash = GOLDEN_START;
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        check(golden_picture(trees[s], s, options, hits), "picture");
        hash = hash_golden_hits(hash, hits);
    }
    return report(options->isa, name, what, hash, GOLDEN_HITS);
}

static int try_packets(mlrt_tree *const *trees, const char *name, const mlrt_trace_options *options)
{
    static struct golden_hit hits[GOLDEN_COUNT];
    uint64_t hash = GOLDEN_START;
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        check(golden_packet(trees[s], s, options, s % 2 ? GOLDEN_WIDTH : 0, hits), "packet");
        hash = hash_golden_hits(hash, hits);
    }
    return report(options->isa, name, "packet", hash, GOLDEN_HITS);
}

static int try_rest(const struct trees *trees, const mlrt_trace_options *options)
{
    uint64_t hash = GOLDEN_START;
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        check(hash_golden_rest(&hash, trees->kdtrees[s], s, options), "rest");
        check(hash_golden_rest(&hash, trees->boxes[s], s, options), "rest");
    }
    return report(options->isa, "default", "rest", hash, GOLDEN_REST);
}

static int try_isa(const struct trees *trees, int32_t isa, mlrt_pool *pool)
{
    int is_right = 1;
    for (int w = 0; w < WAYS; w++) {
        mlrt_trace_options options = {.struct_size = sizeof options,
                                      .method = ways[w].method,
                                      .isa = isa,
                                      .shortcuts_off = ways[w].shortcuts_off,
                                      .pool = pool};
        mlrt_tree *const *const list = ways[w].on_kdtree ? trees->kdtrees : trees->boxes;
        is_right &= try_pictures(list, "picture", ways[w].name, &options);
        is_right &= try_packets(list, ways[w].name, &options);
    }
    mlrt_trace_options options = {.struct_size = sizeof options, .isa = isa, .pool = pool};
    is_right &= try_rest(trees, &options);
    /* Counting is done by kernels of their own. */
    mlrt_counters counters = {.struct_size = sizeof counters};
    options.counters = &counters;
    return is_right & try_pictures(trees->boxes, "counted", "default", &options);
}

int main(void)
{
    mlrt_pool *pool = NULL;
    struct trees trees;
    int is_right = 1;
    check(mlrt_create_pool(2, &pool), "pool");
    build_trees(&trees, pool);
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        if (!is_supported(trees.boxes[0], isa)) continue;
        is_right &= try_isa(&trees, isa, isa % 2 ? pool : NULL);
    }
    for (int s = 0; s < GOLDEN_SCENES; s++) {
        mlrt_destroy_tree(trees.kdtrees[s]);
        mlrt_destroy_tree(trees.boxes[s]);
    }
    mlrt_destroy_pool(pool);
    printf("%s\n", is_right ? "golden" : "NOT the golden numbers");
    return !is_right;
}
