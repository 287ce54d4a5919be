/* SPDX-License-Identifier: MIT */
/*
 * The paper's method does what it is for: beams find the deepest entry point, culling decides rightly, steps are saved,
 * and each rule of the builder shapes the tree. Answers are the same without any of that, so other tests would not see
 * it go. What is compared here is therefore the work: with brute force over all rays of a beam, and with golden counts
 * on procedural scenes, which are the same on every machine.
 *
 * Each of these changes, made one at a time, makes the test before it fail, and often others:
 *
 *   - entry_points_are_the_deepest_common_nodes: no entry-point search (every beam enters at the root); the entry
 *     point is always the first leaf's lowest bifurcation; a far side is not searched, but counts at once; empty
 *     leaves have potential; inverse culling decides the wrong way; slopes twice as wide as they are; no covers.
 *   - culling_loses_no_ray_and_is_seldom_idle: no inverse culling; inverse culling without planes behind the
 *     origin; inverse culling along one axis only; no direct culling.
 *   - counts_are_golden: leaves are not tested against the beam; no extra check after culling; tiles are not
 *     split; pieces search from the root; tiles that enter a leaf are split all the same; no whole tiles; no
 *     whole tiles at the last level; no entry lists; lists of two leaves; the outlines of a list are not looked
 *     at; no beam is missed; every ray is a group; the outlines of triangles are not looked at; hits do not end
 *     the way down; interval traversal: always both children.
 *   - counts_looking_back_are_golden: a cover does not end the region, along an axis upward or downward.
 *   - packets_are_cut_into_groups: groups of any spread; groups of any extent; no mailbox.
 *   - trees_are_golden: rule 1: an empty side of 20 %; rule 1 off; rule 2 off; rule 2: triangles go to the larger
 *     side; rule 2: whatever it costs; rule 3 off; rule 3: a minimum half as large; no clipping; no retraction;
 *     no bonus for empty sides; no bad splits; bad splits in small cells too; the heuristic without areas; the
 *     heuristic without the cost of a step; splits end only where it pays without regard to the leaf; no bins; no
 *     limit on the depth; no limit on references.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job/job.h"
#include "mlrta/beam.h"
#include "mlrta/beam_culling.h"
#include "mlrta/entry_point.h"
#include "mlrta/kdtree.h"
#include "rays/camera.h"
#include "scene/tree.h"

#include "common/scene.h"
#include "common/view.h"
#include "support.h"

enum { SIDE = 256 };

/* A procedural scene of the examples, its paper tree, and what looks at it. */
struct subject {
    const char *name;
    struct scene scene;
    mlrt_mesh mesh;
    mlrt_tree *tree;
    mlrt_camera camera;
    struct mlrt_view view;
};

static mlrt_tree *build_tree(const struct subject *subject, const mlrt_kdtree_options *options)
{
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_kdtree(&subject->mesh, 1, options, &tree), MLRT_OK);
    return tree;
}

static struct subject make_subject(const char *name)
{
    struct subject subject = {.name = name};
    assert_int_equal(load_scene(name, &subject.scene), 0);
    subject.mesh = (mlrt_mesh){.struct_size = sizeof subject.mesh};
    subject.mesh.vertices = (const void *)subject.scene.vertices;
    subject.mesh.vertex_count = (uint32_t)subject.scene.vertex_count;
    subject.mesh.indices = subject.scene.indices;
    subject.mesh.triangle_count = (uint32_t)subject.scene.triangle_count;
    subject.tree = build_tree(&subject, NULL);
    assert_int_equal(camera_of_view(&subject.scene.view, SIDE, SIDE, &subject.camera), 0);
    assert_int_equal(mlrt_make_view(&subject.camera, &subject.view), MLRT_OK);
    return subject;
}

static void free_subject(struct subject *subject)
{
    mlrt_destroy_tree(subject->tree);
    free_scene(&subject->scene);
}

/* ---- brute force ------------------------------------------------------------------------------------------------- */

struct plain_ray {
    double origin[3];
    double direction[3];
    double t_max;
};

static struct plain_ray pixel_ray(const struct subject *subject, uint32_t x, uint32_t y)
{
    struct plain_ray ray = {.t_max = INFINITY};
    float d[3];
    mlrt_view_point(&subject->view, x, y, d);
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = subject->view.eye[k];
        ray.direction[k] = d[k];
    }
    return ray;
}

/*
 * How far a ray is from missing a box: the length of its way through it, or, if the box is flat, through which it has
 * no way, the distance along the ray from its crossing to where it enters or leaves the box's other sides. Negative if
 * the ray misses the box.
 */
static double way_through(const struct plain_ray *ray, const struct mlrt_box *box)
{
    double enter = 0, leave = ray->t_max, crossing = NAN;
    for (int k = 0; k < 3; k++) {
        const double a = (box->lo[k] - ray->origin[k]) / ray->direction[k];
        const double b = (box->hi[k] - ray->origin[k]) / ray->direction[k];
        if (box->lo[k] == box->hi[k]) {
            crossing = a;
            continue;
        }
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    return isnan(crossing) ? leave - enter : fmin(leave - crossing, crossing - enter);
}

/* What rounding in `way_through` cannot make up. */
#define CERTAIN 1e-6

static struct mlrt_box half_of(const struct mlrt_box *cell, const struct mlrt_node *node, int upper)
{
    struct mlrt_box half = *cell;
    (upper ? half.lo : half.hi)[mlrt_node_axis(node)] = node->u.split;
    return half;
}

/* A node on the way down from the root: which half at each of `depth` levels. */
struct path {
    uint32_t depth;
    uint8_t upper[MLRT_DEPTH_LIMIT];
};

/* Shortens `common` to what it shares with `path`; the first path is taken as it is. */
static void share_path(const struct path *path, int *is_first, struct path *common)
{
    if (*is_first) {
        *common = *path;
        *is_first = 0;
    }
    uint32_t depth = 0;
    while (depth < common->depth && depth < path->depth && common->upper[depth] == path->upper[depth]) depth++;
    common->depth = depth;
}

/* Lets `common` be above all leaves with triangles through which the ray certainly passes. */
static void add_leaves(const struct mlrt_tree *tree, uint32_t node, const struct mlrt_box *cell,
                       const struct plain_ray *ray, struct path *path, int *is_first, struct path *common)
{
    const struct mlrt_node *here = &tree->kdtree.nodes[node];
    if (!(way_through(ray, cell) > CERTAIN)) return;
    if (mlrt_node_is_leaf(here)) {
        if (mlrt_leaf_count(here) > 0) share_path(path, is_first, common);
        return;
    }
    for (int upper = 0; upper < 2; upper++) {
        const struct mlrt_box half = half_of(cell, here, upper);
        path->upper[path->depth++] = (uint8_t)upper;
        add_leaves(tree, mlrt_node_child(here) + (uint32_t)upper, &half, ray, path, is_first, common);
        path->depth--;
    }
}

/* The node at the end of a path. */
static uint32_t node_of(const struct mlrt_tree *tree, const struct path *path)
{
    uint32_t node = 0;
    for (uint32_t i = 0; i < path->depth; i++) node = mlrt_node_child(&tree->kdtree.nodes[node]) + path->upper[i];
    return node;
}

/* 1 if the node `upper` is on the path. */
static int is_above(const struct mlrt_tree *tree, uint32_t upper, const struct path *path)
{
    uint32_t node = 0;
    for (uint32_t i = 0; node != upper && i < path->depth; i++) {
        node = mlrt_node_child(&tree->kdtree.nodes[node]) + path->upper[i];
    }
    return node == upper;
}

/* How entry points compare with brute force, over the tiles of a picture. */
struct entry_tally {
    unsigned tiles, missed, equal, above, wrong;
};

/*
 * Compares the entry point of a tile with the deepest node above all leaves that its rays pass. The tile's rays end at
 * the first leaf's covering triangle if it has one, as the search's do: `end` is the region that the beam is left with.
 */
static void compare_entry_point(const struct subject *subject, const struct mlrt_job *job, uint32_t x, uint32_t y,
                                uint32_t side, struct entry_tally *tally)
{
    struct mlrt_beam beam;
    struct entry_point entry = {0, 0, subject->tree->bounds};
    mlrt_counters counters = {.struct_size = sizeof counters};
    uint32_t cover = MLRT_NONE;
    if (!mlrt_make_view_beam(&subject->view, x, y, side, side, &beam)) return;
    const int found = mlrt_find_entry_point(job, &beam, &entry, &cover, &counters);
    struct path path = {0}, common = {0};
    int is_first = 1;
    for (uint32_t j = 0; j < side; j++) {
        for (uint32_t i = 0; i < side; i++) {
            struct plain_ray ray = pixel_ray(subject, x + i, y + j);
            for (int k = 0; k < 3; k++) {
                const double end = ray.direction[k] < 0 ? beam.region.lo[k] : beam.region.hi[k];
                if (!isinf(end)) ray.t_max = fmin(ray.t_max, (end - ray.origin[k]) / ray.direction[k]);
            }
            ray.t_max *= 1 + 1e-5; /* the covering triangle's own leaf counts, though the region ends there */
            path.depth = 0;
            add_leaves(subject->tree, 0, &subject->tree->bounds, &ray, &path, &is_first, &common);
        }
    }
    tally->tiles++;
    if (found == BEAM_MISSES) {
        tally->missed++;
        tally->wrong += !is_first;
    } else if (!is_first) {
        tally->equal += entry.node == node_of(subject->tree, &common);
        tally->above += entry.node != node_of(subject->tree, &common);
        tally->wrong += !is_above(subject->tree, entry.node, &common);
    }
}

static struct entry_tally compare_entry_points(const struct subject *subject, int32_t culling, int check, uint32_t side)
{
    struct entry_tally tally = {0};
    struct mlrt_job job = {.tree = subject->tree, .multilevel = {.culling = culling, .culling_check = check}};
    for (uint32_t y = 0; y < SIDE; y += side) {
        for (uint32_t x = 0; x < SIDE; x += side) compare_entry_point(subject, &job, x, y, side, &tally);
    }
    printf("%s, tiles of %u, culling %d: %u tiles, %u missed, %u at the deepest node, %u above it\n", subject->name,
           (unsigned)side, (int)culling, tally.tiles, tally.missed, tally.equal, tally.above);
    return tally;
}

/* ---- entry points ------------------------------------------------------------------------------------------------ */

static const char *const names[] = {"room", "scan:20000", "doubled"};
enum { SCENE_COUNT = 3 };

static void entry_points_are_the_deepest_common_nodes(void **state)
{
    (void)state;
    /* By scene and side of 8 or 32 pixels: tiles whose entry point is the deepest node, or above it. */
    static const unsigned expected[SCENE_COUNT][2][2] = {
        {{1024, 0}, {56, 0}},
        {{611, 20}, {45, 2}},
        {{957, 46}, {55, 1}},
    };
    int failed = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        for (int size = 0; size < 2; size++) {
            const struct entry_tally tally = compare_entry_points(&subject, MLRT_CULLING_INVERSE, 0, size ? 32 : 8);
            assert_int_equal(tally.wrong, 0);
            failed |= tally.equal != expected[s][size][0] || tally.above != expected[s][size][1];
        }
        free_subject(&subject);
    }
    assert_false(failed);
}

static void direct_culling_loses_no_ray_either(void **state)
{
    (void)state;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        for (int check = 0; check < 2; check++) {
            assert_int_equal(compare_entry_points(&subject, MLRT_CULLING_DIRECT, check, 16).wrong, 0);
        }
        free_subject(&subject);
    }
}

/* ---- culling decisions ------------------------------------------------------------------------------------------- */

/*
 * Decisions about cells that rays of a beam pass: `lost` excluded a child that a ray passes; `idle` kept an empty one.
 */
struct decisions {
    unsigned all, lost, idle;
};

typedef int (*culling_test)(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c);

static int cull_with_check(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const int children = cull_inverse(beam, cell, a, c);
    return children == BOTH_CHILDREN ? check_children(beam, cell, a, c) : children;
}

static void count_decisions(const struct mlrt_tree *tree, uint32_t node, const struct mlrt_box *cell,
                            const struct mlrt_beam *beam, const struct plain_ray *rays, size_t ray_count,
                            culling_test cull, struct decisions *decisions)
{
    const struct mlrt_node *here = &tree->kdtree.nodes[node];
    if (mlrt_node_is_leaf(here)) return;
    const int a = (int)mlrt_node_axis(here);
    const int children = cull(beam, cell, a, here->u.split);
    int passed = 0;
    struct mlrt_box half[2];
    for (int upper = 0; upper < 2; upper++) {
        half[upper] = half_of(cell, here, upper);
        const int child = upper == beam->negative[a] ? NEAR_CHILD : FAR_CHILD;
        for (size_t i = 0; i < ray_count && !(passed & child); i++) {
            if (way_through(&rays[i], &half[upper]) > CERTAIN) passed |= child;
        }
    }
    decisions->all++;
    decisions->lost += (passed & ~children) != 0;
    decisions->idle += (children & ~passed) != 0;
    for (int upper = 0; upper < 2; upper++) {
        const int child = upper == beam->negative[a] ? NEAR_CHILD : FAR_CHILD;
        if (passed & child) {
            count_decisions(tree, mlrt_node_child(here) + (uint32_t)upper, &half[upper], beam, rays, ray_count, cull,
                            decisions);
        }
    }
}

static void culling_loses_no_ray_and_is_seldom_idle(void **state)
{
    (void)state;
    static const culling_test culls[] = {cull_inverse, cull_direct, cull_with_check};
    static const char *const titles[] = {"inverse", "direct", "inverse, checked"};
    static const unsigned expected[SCENE_COUNT][3][2] = {
        {{2529, 58}, {2529, 209}, {2529, 58}},
        {{25996, 2436}, {25996, 2719}, {25996, 2436}},
        {{13951, 1876}, {13951, 2309}, {13951, 1862}},
    };
    static struct plain_ray rays[16 * 16];
    int failed = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        for (int c = 0; c < 3; c++) {
            struct decisions decisions = {0};
            for (uint32_t tile = 0; tile < 256; tile += 5) {
                const uint32_t x = tile % 16 * 16, y = tile / 16 * 16;
                struct mlrt_beam beam;
                if (!mlrt_make_view_beam(&subject.view, x, y, 16, 16, &beam)) continue;
                for (uint32_t i = 0; i < 256; i++) rays[i] = pixel_ray(&subject, x + i % 16, y + i / 16);
                count_decisions(subject.tree, 0, &subject.tree->bounds, &beam, rays, 256, culls[c], &decisions);
            }
            printf("%s, %s: %u decisions, %u lost a ray, %u kept a child that no ray passes\n", names[s], titles[c],
                   decisions.all, decisions.lost, decisions.idle);
            assert_int_equal(decisions.lost, 0);
            failed |= decisions.all != expected[s][c][0] || decisions.idle != expected[s][c][1];
        }
        free_subject(&subject);
    }
    assert_false(failed);
}

/* ---- steps and tests --------------------------------------------------------------------------------------------- */

static mlrt_counters count_picture(const struct subject *subject, const mlrt_trace_options *given)
{
    static uint32_t ids[SIDE * SIDE];
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_trace_options options = *given;
    mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
    options.struct_size = sizeof options;
    options.counters = &counters;
    assert_int_equal(mlrt_render_tiles(subject->tree, &subject->camera, &options, &hits, NULL, NULL), MLRT_OK);
    return counters;
}

enum {
    NO_LISTS = MLRT_SHORTCUT_ENTRY_LISTS,
    PAPER = MLRT_SHORTCUT_WHOLE_TILES | MLRT_SHORTCUT_ENTRY_LISTS,
    MULTILEVEL = MLRT_METHOD_MULTILEVEL
};

static const struct {
    const char *title;
    mlrt_trace_options options;
} ways[] = {
    {"2x2 packets", {.method = MLRT_METHOD_PACKET2}},
    {"4x4 packets", {.method = MLRT_METHOD_PACKET4}},
    {"the paper's", {.method = MULTILEVEL, .shortcuts_off = PAPER}},
    {"the paper's, direct", {.method = MULTILEVEL, .shortcuts_off = PAPER, .culling = MLRT_CULLING_DIRECT}},
    {"the paper's, direct, checked",
     {.method = MULTILEVEL, .shortcuts_off = PAPER, .culling = MLRT_CULLING_DIRECT, .culling_check = 1}},
    {"the paper's, checked", {.method = MULTILEVEL, .shortcuts_off = PAPER, .culling_check = 1}},
    {"the paper's, 64 to 16 by 4",
     {.method = MULTILEVEL,
      .shortcuts_off = PAPER,
      .initial_tile_size = 64,
      .minimum_tile_size = 16,
      .split_factor = 4}},
    {"the paper's, 128 to 8 by 16",
     {.method = MULTILEVEL, .shortcuts_off = PAPER, .initial_tile_size = 128, .minimum_tile_size = 8}},
    {"the paper's, 8 alone",
     {.method = MULTILEVEL, .shortcuts_off = PAPER, .initial_tile_size = 8, .minimum_tile_size = 8}},
    {"whole tiles", {.method = MULTILEVEL, .shortcuts_off = NO_LISTS}},
    {"lists", {.method = MULTILEVEL, .shortcuts_off = MLRT_SHORTCUT_WHOLE_TILES}},
    {"all shortcuts", {.method = MULTILEVEL}},
    {"all shortcuts, 128 to 8", {.method = MULTILEVEL, .initial_tile_size = 128, .minimum_tile_size = 8}},
};
enum { WAY_COUNT = sizeof ways / sizeof *ways, COUNT_COUNT = 7 };

static void counts_are_golden(void **state)
{
    (void)state;
    /* packets, beams, cells, of these of the search, tests of triangles, tiles missed, tiles covered */
    static const uint64_t expected[SCENE_COUNT][WAY_COUNT][COUNT_COUNT] = {
        {
            {16384, 0, 519332, 0, 36905, 0, 0},        /* room: 2x2 packets */
            {4096, 0, 161502, 0, 16210, 0, 0},         /* room: 4x4 packets */
            {4096, 58, 146784, 2244, 16210, 0, 0},     /* room: the paper's */
            {4096, 58, 149072, 2343, 16210, 0, 0},     /* room: the paper's, direct */
            {4096, 58, 146784, 2244, 16210, 0, 0},     /* room: the paper's, direct, checked */
            {4096, 58, 146784, 2244, 16210, 0, 0},     /* room: the paper's, checked */
            {4096, 288, 134043, 9869, 15922, 0, 0},    /* room: the paper's, 64 to 16 by 4 */
            {4096, 1002, 129555, 31432, 14725, 0, 0},  /* room: the paper's, 128 to 8 by 16 */
            {4096, 1024, 131692, 33569, 14725, 0, 0},  /* room: the paper's, 8 alone */
            {3904, 58, 146592, 2244, 15890, 0, 3},     /* room: whole tiles */
            {4096, 58, 106183, 3999, 15978, 0, 0},     /* room: lists */
            {3904, 58, 105991, 3999, 15658, 0, 3},     /* room: all shortcuts */
            {2636, 1002, 65271, 44779, 11057, 0, 320}, /* room: all shortcuts, 128 to 8 */
        },
        {
            {15825, 0, 715424, 0, 85785, 0, 0},        /* scan:20000: 2x2 packets */
            {4148, 0, 363175, 0, 27694, 0, 0},         /* scan:20000: 4x4 packets */
            {3636, 57, 350148, 4161, 27694, 8, 0},     /* scan:20000: the paper's */
            {3636, 57, 351731, 4282, 27694, 8, 0},     /* scan:20000: the paper's, direct */
            {3636, 57, 350148, 4161, 27694, 8, 0},     /* scan:20000: the paper's, direct, checked */
            {3636, 57, 350148, 4161, 27694, 8, 0},     /* scan:20000: the paper's, checked */
            {3140, 274, 347058, 18219, 27694, 39, 0},  /* scan:20000: the paper's, 64 to 16 by 4 */
            {2708, 923, 364118, 54597, 27694, 240, 0}, /* scan:20000: the paper's, 128 to 8 by 16 */
            {2708, 994, 364973, 55452, 27694, 360, 0}, /* scan:20000: the paper's, 8 alone */
            {3636, 57, 350148, 4161, 27694, 8, 0},     /* scan:20000: whole tiles */
            {3636, 57, 384325, 6393, 27676, 8, 0},     /* scan:20000: lists */
            {3636, 57, 384325, 6393, 27676, 8, 0},     /* scan:20000: all shortcuts */
            {2708, 923, 306728, 89735, 27418, 240, 0}, /* scan:20000: all shortcuts, 128 to 8 */
        },
        {
            {16384, 0, 1193804, 0, 110087, 0, 0},      /* doubled: 2x2 packets */
            {4096, 0, 443851, 0, 64014, 0, 0},         /* doubled: 4x4 packets */
            {4096, 58, 430825, 3652, 64014, 0, 0},     /* doubled: the paper's */
            {4096, 58, 431031, 3794, 64014, 0, 0},     /* doubled: the paper's, direct */
            {4096, 58, 430825, 3652, 64014, 0, 0},     /* doubled: the paper's, direct, checked */
            {4096, 58, 430825, 3652, 64014, 0, 0},     /* doubled: the paper's, checked */
            {4096, 324, 435158, 20268, 64014, 0, 0},   /* doubled: the paper's, 64 to 16 by 4 */
            {4096, 1082, 465932, 68038, 63958, 0, 0},  /* doubled: the paper's, 128 to 8 by 16 */
            {4096, 1024, 466493, 68599, 63958, 0, 0},  /* doubled: the paper's, 8 alone */
            {4096, 58, 430825, 3652, 64014, 0, 0},     /* doubled: whole tiles */
            {4096, 58, 378090, 6101, 63838, 0, 0},     /* doubled: lists */
            {4096, 58, 378090, 6101, 63838, 0, 0},     /* doubled: all shortcuts */
            {4092, 1082, 284498, 119382, 62432, 0, 1}, /* doubled: all shortcuts, 128 to 8 */
        },
    };
    int failed = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        for (int w = 0; w < WAY_COUNT; w++) {
            const mlrt_counters c = count_picture(&subject, &ways[w].options);
            const uint64_t counts[COUNT_COUNT] = {c.packet_count,           c.beam_count,          c.cell_count,
                                                  c.entry_point_cell_count, c.triangle_test_count, c.missed_beam_count,
                                                  c.covered_beam_count};
            if (memcmp(counts, expected[s][w], sizeof counts) == 0) continue;
            failed = 1;
            printf("{%llu, %llu, %llu, %llu, %llu, %llu, %llu}, /* %s: %s */\n", (unsigned long long)counts[0],
                   (unsigned long long)counts[1], (unsigned long long)counts[2], (unsigned long long)counts[3],
                   (unsigned long long)counts[4], (unsigned long long)counts[5], (unsigned long long)counts[6],
                   names[s], ways[w].title);
        }
        free_subject(&subject);
    }
    assert_false(failed);
}

/* The same room from its other end: rays whose components have the other signs, so that covers end regions upward. */
static void counts_looking_back_are_golden(void **state)
{
    (void)state;
    static const uint64_t expected[4] = {171664, 165692, 1580, 7209};
    struct subject subject = make_subject("room");
    struct view back = subject.scene.view;
    for (int k = 0; k < 3; k++) {
        back.eye[k] = subject.scene.view.look[k] - 0.25 * (subject.scene.view.eye[k] - subject.scene.view.look[k]);
        back.look[k] = subject.scene.view.eye[k];
    }
    assert_int_equal(camera_of_view(&back, SIDE, SIDE, &subject.camera), 0);
    const mlrt_trace_options fine = {.method = MULTILEVEL, .initial_tile_size = 16, .minimum_tile_size = 4};
    const mlrt_counters c = count_picture(&subject, &fine);
    const uint64_t counts[4] = {c.cell_count, c.entry_point_cell_count, c.covered_beam_count, c.triangle_test_count};
    const int differ = memcmp(counts, expected, sizeof counts) != 0;
    if (differ) {
        printf("{%llu, %llu, %llu, %llu}\n", (unsigned long long)counts[0], (unsigned long long)counts[1],
               (unsigned long long)counts[2], (unsigned long long)counts[3]);
    }
    free_subject(&subject);
    assert_false(differ);
}

/* The point of it all, whatever the numbers: fewer cells than from the root, and fewer tests with covered tiles. */
static void beams_save_steps(void **state)
{
    (void)state;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        const mlrt_trace_options from_root = {.method = MLRT_METHOD_PACKET4};
        const mlrt_trace_options paper = {.method = MULTILEVEL, .shortcuts_off = PAPER};
        const mlrt_trace_options direct = {
            .method = MULTILEVEL, .shortcuts_off = PAPER, .culling = MLRT_CULLING_DIRECT};
        const mlrt_trace_options lists = {.method = MULTILEVEL, .shortcuts_off = MLRT_SHORTCUT_WHOLE_TILES};
        const mlrt_trace_options all = {.method = MULTILEVEL};
        const mlrt_counters root = count_picture(&subject, &from_root), one = count_picture(&subject, &paper),
                            many = count_picture(&subject, &lists), whole = count_picture(&subject, &all);
        assert_true(one.cell_count < root.cell_count);
        assert_true(s == 1 || many.cell_count < one.cell_count); /* a scan's lists are too long to pay */
        assert_true(whole.cell_count <= many.cell_count && whole.packet_count <= many.packet_count);
        assert_true(one.triangle_test_count <= root.triangle_test_count);
        assert_true(count_picture(&subject, &direct).cell_count >= one.cell_count);
        free_subject(&subject);
    }
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

/* Packets whose rays differ in direction, or in origin, are several groups. */
static void packets_are_cut_into_groups(void **state)
{
    (void)state;
    enum { COUNT = 4096 };
    static float origins[COUNT][3], directions[COUNT][3];
    static const uint64_t expected[4][3] = {
        {1337, 73636, 5833},
        {4095, 50694, 7965},
        {3963, 132044, 9627},
        {4096, 41420, 6509},
    };
    struct subject subject = make_subject("room");
    int failed = 0;
    for (int kind = 0; kind < 4; kind++) {
        struct random random = {7};
        for (int i = 0; i < COUNT; i++) {
            for (int k = 0; k < 3; k++) {
                /* From the eye, or from anywhere near; within a few degrees, or everywhere. */
                const float spread = kind & 1 ? 1 : 0.02f, off = kind & 2 ? 0.5f : 0;
                const float middle = (float)(subject.scene.view.look[k] - subject.scene.view.eye[k]);
                origins[i][k] = subject.view.eye[k] + draw_range(&random, -off, off);
                directions[i][k] = middle * (kind & 1 ? 0 : 0.2f) + draw_range(&random, -spread, spread);
            }
        }
        mlrt_rays rays = {.struct_size = sizeof rays, .count = COUNT};
        rays.origins.data = origins;
        rays.directions.data = directions;
        static float t[COUNT];
        mlrt_hits hits = {.struct_size = sizeof hits, .t = {t, 0, 0}};
        mlrt_counters counters = {.struct_size = sizeof counters};
        mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_PACKET4};
        options.counters = &counters;
        assert_int_equal(mlrt_trace_packet(subject.tree, &rays, &options, &hits), MLRT_OK);
        const uint64_t counts[3] = {counters.packet_count, counters.cell_count, counters.triangle_test_count};
        if (memcmp(counts, expected[kind], sizeof counts) == 0) continue;
        failed = 1;
        printf("{%llu, %llu, %llu},\n", (unsigned long long)counts[0], (unsigned long long)counts[1],
               (unsigned long long)counts[2]);
    }
    free_subject(&subject);
    assert_false(failed);
}

/* ---- trees ------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *title;
    mlrt_kdtree_options options;
} builds[] = {
    {"preset paper", {.preset = MLRT_KDTREE_PAPER}},
    {"without empty sides first", {.rules_off = MLRT_RULE_EMPTY_SPACE}},
    {"without covered planes", {.rules_off = MLRT_RULE_COPLANAR}},
    {"without a minimum cell", {.rules_off = MLRT_RULE_MINIMUM_CELL}},
    {"without clipping", {.rules_off = MLRT_RULE_CLIPPED_SPLITS}},
    {"without retraction", {.rules_off = MLRT_RULE_RETRACTION}},
    {"without any rule", {.rules_off = 31}},
    {"steps that cost more", {.traversal_cost = 4}},
    {"tests that cost more", {.intersection_cost = 10}},
    {"few levels", {.max_depth = 9}},
    {"few references", {.max_references = 1000}},
    {"preset tuned", {.preset = MLRT_KDTREE_TUNED}},
};
enum { BUILD_COUNT = sizeof builds / sizeof *builds, TREE_COUNT = 6 };

static void trees_are_golden(void **state)
{
    (void)state;
    /* nodes, empty leaves, references, depth, subtrees retracted, hash */
    static const uint64_t expected[SCENE_COUNT][BUILD_COUNT][TREE_COUNT] = {
        {
            {3383, 540, 2343, 32, 149, 0xC745A4D090500062}, /* room: preset paper */
            {3405, 566, 2266, 30, 155, 0x757F95C5BE7FAACB}, /* room: without empty sides first */
            {4359, 609, 3133, 26, 222, 0xC1512DC5FDA73342}, /* room: without covered planes */
            {3765, 617, 2444, 32, 182, 0x5E7D1D59ABBCBEFF}, /* room: without a minimum cell */
            {2697, 460, 2133, 32, 103, 0x61F3CE9B727A3AF0}, /* room: without clipping */
            {3733, 690, 2357, 32, 0, 0xAD9C5D63116D6EA9},   /* room: without retraction */
            {3637, 710, 2858, 23, 0, 0x4724E133CB2AB02B},   /* room: without any rule */
            {1287, 223, 1665, 32, 329, 0x4353BBB382A2121C}, /* room: steps that cost more */
            {4565, 807, 2701, 32, 97, 0x53BE78CB0F39FCCC},  /* room: tests that cost more */
            {129, 2, 914, 9, 0, 0x37FB49EAADDF014D},        /* room: few levels */
            {383, 94, 920, 29, 7, 0xB6EAB43C3A1CCF6E},      /* room: few references */
            {2051, 333, 1831, 32, 278, 0x98E968F976C61798}, /* room: preset tuned */
        },
        {
            {174539, 47331, 102182, 33, 12727, 0xD1B5D3A15B0FA78},  /* scan:20000: preset paper */
            {171245, 45569, 102296, 28, 10990, 0x64C2E157A0E608EB}, /* scan:20000: without empty sides first */
            {174539, 47331, 102182, 33, 12727, 0xD1B5D3A15B0FA78},  /* scan:20000: without covered planes */
            {198075, 55763, 107228, 36, 15064, 0x4AF67864EA49A21D}, /* scan:20000: without a minimum cell */
            {167089, 34823, 115959, 30, 11007, 0x7382F15FDFBE67CF}, /* scan:20000: without clipping */
            {201921, 60294, 103093, 33, 0, 0x24E460057E43C48D},     /* scan:20000: without retraction */
            {181437, 41304, 116984, 27, 0, 0x6E94C9F4EFB9CA1C},     /* scan:20000: without any rule */
            {40925, 10251, 57646, 28, 10599, 0xEE18C91555E0D76B},   /* scan:20000: steps that cost more */
            {252977, 74461, 118094, 37, 11413, 0x6711EE8524486E3D}, /* scan:20000: tests that cost more */
            {395, 84, 24429, 9, 0, 0x46D5760522F5F808},             /* scan:20000: few levels */
            {1, 0, 19998, 0, 0, 0x3D0E545AB6A18012},                /* scan:20000: few references */
            {83843, 21406, 75897, 33, 14301, 0x200457023159B1E9},   /* scan:20000: preset tuned */
        },
        {
            {78095, 10496, 83129, 36, 3374, 0x567ACDFF22925DC5},  /* doubled: preset paper */
            {77053, 9561, 83135, 32, 2050, 0x328355839EB4AE63},   /* doubled: without empty sides first */
            {66535, 9612, 106300, 28, 4426, 0x55DD1508CEB9F26},   /* doubled: without covered planes */
            {109159, 16996, 94589, 38, 5910, 0x1987DE8C59A1A527}, /* doubled: without a minimum cell */
            {53409, 5507, 84445, 34, 1688, 0xCC7A55B2130CFDC7},   /* doubled: without clipping */
            {85955, 13787, 83638, 38, 0, 0xC75B65C83E48AD6B},     /* doubled: without retraction */
            {66903, 12828, 110958, 27, 0, 0x5C31FCAA6A4999F6},    /* doubled: without any rule */
            {33739, 3007, 61976, 33, 5759, 0xE7F51E6D484978F6},   /* doubled: steps that cost more */
            {91081, 13704, 87903, 38, 4443, 0xB4FC53A326F9BCD0},  /* doubled: tests that cost more */
            {785, 24, 22225, 9, 7, 0x238761869A8882E9},           /* doubled: few levels */
            {1, 0, 18740, 0, 0, 0x3B3183C0AA36FDD7},              /* doubled: few references */
            {50835, 5879, 70387, 38, 6491, 0x7F0CF15BB996E652},   /* doubled: preset tuned */
        },
    };
    int failed = 0;
    for (int s = 0; s < SCENE_COUNT; s++) {
        struct subject subject = make_subject(names[s]);
        for (int b = 0; b < BUILD_COUNT; b++) {
            mlrt_kdtree_options options = builds[b].options;
            mlrt_tree_info info = {.struct_size = sizeof info};
            options.struct_size = sizeof options;
            mlrt_tree *tree = build_tree(&subject, &options);
            assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
            mlrt_destroy_tree(tree);
            const uint64_t counts[TREE_COUNT] = {info.node_count, info.empty_leaf_count, info.reference_count,
                                                 info.depth,      info.retracted_count,  info.tree_hash};
            if (memcmp(counts, expected[s][b], sizeof counts) == 0) continue;
            failed = 1;
            printf("{%llu, %llu, %llu, %llu, %llu, 0x%llX}, /* %s: %s */\n", (unsigned long long)counts[0],
                   (unsigned long long)counts[1], (unsigned long long)counts[2], (unsigned long long)counts[3],
                   (unsigned long long)counts[4], (unsigned long long)counts[5], names[s], builds[b].title);
        }
        free_subject(&subject);
    }
    assert_false(failed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(entry_points_are_the_deepest_common_nodes),
        cmocka_unit_test(direct_culling_loses_no_ray_either),
        cmocka_unit_test(culling_loses_no_ray_and_is_seldom_idle),
        cmocka_unit_test(counts_are_golden),
        cmocka_unit_test(counts_looking_back_are_golden),
        cmocka_unit_test(beams_save_steps),
        cmocka_unit_test(packets_are_cut_into_groups),
        cmocka_unit_test(trees_are_golden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
