/* SPDX-License-Identifier: MIT */
/*
 * The paper's method does what it is for: beams find the deepest entry point, culling decides rightly, steps are saved,
 * and each rule of the builder shapes the tree. Answers are the same without any of that, so other tests would not see
 * it go. What is compared here is therefore the work: with brute force over all rays of a beam, and with golden counts
 * on procedural scenes, which are the same on every machine.
 *
 * tests/mutants.txt has changes that break one rule each, and the test that then fails; `make test-mutants` shows it.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job/job.h"
#include "mlrta/beam.h"
#include "mlrta/beam_culling.h"
#include "mlrta/covering.h"
#include "mlrta/entry_point.h"
#include "mlrta/kdtree.h"
#include "rays/camera.h"
#include "rays/source.h"
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
    struct mlrt_source source; /* its rays */
};

static mlrt_tree *build_tree(const struct subject *subject, const mlrt_kdtree_options *options)
{
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_kdtree(&subject->mesh, 1, options, &tree), MLRT_OK);
    return tree;
}

static struct subject make_subject(const char *name)
{
    struct subject subject = {.name = name, .source = {.kind = MLRT_SOURCE_CAMERA, .common_mask = MLRT_MASK_ALL}};
    assert_int_equal(load_scene(name, &subject.scene), 0);
    subject.mesh = (mlrt_mesh){.struct_size = sizeof subject.mesh};
    subject.mesh.vertices = (const void *)subject.scene.vertices;
    subject.mesh.vertex_count = (uint32_t)subject.scene.vertex_count;
    subject.mesh.indices = subject.scene.indices;
    subject.mesh.triangle_count = (uint32_t)subject.scene.triangle_count;
    subject.tree = build_tree(&subject, NULL);
    assert_int_equal(camera_of_view(&subject.scene.view, SIDE, SIDE, &subject.camera), 0);
    assert_int_equal(mlrt_make_view(&subject.camera, &subject.source.view), MLRT_OK);
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
    mlrt_view_point(&subject->source.view, x, y, d);
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = subject->source.view.eye[k];
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
    if (!mlrt_get_beam(&subject->source, x, y, side, side, &beam)) return;
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
    if (!found) {
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
enum { SCENE_COUNT = 3, SCENE_STEP = SANITIZED ? SCENE_COUNT : 1 };

/* A test takes all scenes from first_scene() on by SCENE_STEP: in a build with sanitizers one of them, in turn. */
static int first_scene(void)
{
    static int call_count;
    return call_count++ % SCENE_STEP;
}

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
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
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
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
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

static int cull_directly(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    return cull_direct(beam, cell, a, c, 0);
}

static int cull_with_check(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const int children = cull_inverse(beam, cell, a, c);
    return children == BOTH_CHILDREN ? cull_direct(beam, cell, a, c, 1) : children;
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
    static const culling_test culls[] = {cull_inverse, cull_directly, cull_with_check};
    static const char *const titles[] = {"inverse", "direct", "inverse, checked"};
    static const unsigned expected[SCENE_COUNT][3][2] = {
        {{2529, 58}, {2529, 209}, {2529, 58}},
        {{25996, 2436}, {25996, 2719}, {25996, 2436}},
        {{13951, 1876}, {13951, 2309}, {13951, 1862}},
    };
    static struct plain_ray rays[16 * 16];
    int failed = 0;
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
        struct subject subject = make_subject(names[s]);
        for (int c = 0; c < 3; c++) {
            struct decisions decisions = {0};
            for (uint32_t tile = 0; tile < 256; tile += 5) {
                const uint32_t x = tile % 16 * 16, y = tile / 16 * 16;
                struct mlrt_beam beam;
                if (!mlrt_get_beam(&subject.source, x, y, 16, 16, &beam)) continue;
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

/*
 * A beam of one ray, and a box of a few floats around a point of it, far nearer to 0 than to the ray's origin: the
 * roundings of what culling computes are larger than the box. Only slopes that are moved outward keep it.
 */
static void boxes_that_rays_just_touch_are_not_missed(void **state)
{
    (void)state;
    struct random random = {11};
    for (int i = 0; i < 20000; i++) {
        float origin[3], direction[3];
        struct mlrt_box box;
        struct mlrt_source source = {0};
        struct mlrt_beam beam;
        const double t = draw_range(&random, 1, 2);
        for (int k = 0; k < 3; k++) {
            direction[k] = draw_range(&random, 0.25f, 1);
            origin[k] = (float)(-t * direction[k]);
            const double point = origin[k] + t * direction[k];
            box.lo[k] = next_float((float)(point - 1e-14), -1);
            box.hi[k] = next_float((float)(point + 1e-14), 1);
        }
        mlrt_rays rays = {.struct_size = sizeof rays, .count = 1};
        rays.origins.data = origin;
        rays.directions.data = direction;
        mlrt_make_ray_source(NULL, &rays, &source);
        assert_true(mlrt_get_beam(&source, 0, 0, 1, 1, &beam));
        assert_false(misses_box(&beam, &box, 1));
        for (int a = 0; a < 3; a++) {
            struct mlrt_box cell = box;
            cell.hi[a] = 1;
            assert_true(cull_inverse(&beam, &cell, a, box.hi[a]) & NEAR_CHILD);
            cell = box;
            cell.lo[a] = -1;
            assert_true(cull_inverse(&beam, &cell, a, box.lo[a]) & FAR_CHILD);
        }
    }
}

static void signs_within_twice_their_errors_are_uncertain(void **state)
{
    (void)state;
    static const struct corner_terms terms = {.value = {{2e-9, 3e-9, 4e-9, 5e-9},
                                                        {2.1e-9, 3e-9, 4e-9, 5e-9},
                                                        {-5e-9, -2.1e-9, -4e-9, -3e-9},
                                                        {3e-9, -3e-9, 3e-9, 3e-9}},
                                              .bound = {1e-9, 1e-9, 1e-9, 1e-9}};
    static const int signs[4] = {0, 1, -1, 0};
    for (int i = 0; i < 4; i++) assert_int_equal(certain_sign(&terms, i), signs[i]);
}

/* A beam around the z axis, from (0, 0, 1), with slopes from -1/8 to 1/4. */
static struct mlrt_beam beam_along_z(void)
{
    struct mlrt_beam beam = {.main_axis = 2, .has_apex = 1, .may_cover = 1};
    beam.origin_lo[2] = beam.origin_hi[2] = 1;
    for (int k = 0; k < 3; k++) {
        beam.region.lo[k] = -INFINITY;
        beam.region.hi[k] = INFINITY;
        beam.slope_lo[2][k] = -0.125f;
        beam.slope_hi[2][k] = 0.25f;
    }
    return beam;
}

static void triangles_cover_a_beam_or_miss_it_or_lie_behind(void **state)
{
    (void)state;
    static const struct mlrt_triangle triangles[] = {
        {{{-9, -9, 3}, {9, -9, 3}, {0, 20, 3}}},       /* covers the beam */
        {{{-9, -9, 5}, {0, 20, 5}, {9, -9, 5}}},       /* behind it, the other way around */
        {{{-9, -9, 2.5f}, {9, -9, 2.5f}, {0, 20, 4}}}, /* covers it too, but cuts through the first */
        {{{1, -9, 3}, {9, -9, 3}, {1, 20, 3}}},        /* beside the beam */
        {{{0, -9, 3}, {9, -9, 3}, {0, 20, 3}}},        /* half of the beam */
        {{{-9, -9, -3}, {9, -9, -3}, {0, 20, -3}}},    /* behind the origin */
    };
    static const int covers[] = {1, 1, 1, 0, 0, 0}, misses[] = {0, 0, 0, 1, 0, 1}, behind[] = {0, 1, 0, 0, 0, 0};
    struct mlrt_beam beam = beam_along_z();
    struct corner_directions corners;
    struct corner_terms terms[6];
    set_corner_directions(&beam, &corners);
    for (int i = 0; i < 6; i++) {
        set_corner_terms(&triangles[i], &beam, &corners, &terms[i]);
        assert_int_equal(covers_beam(&terms[i]), covers[i]);
        assert_int_equal(misses_beam(&terms[i]), misses[i]);
        if (i != 3 && i != 4) assert_int_equal(is_behind(&terms[i], &terms[0]), behind[i]);
    }
    end_region_at_cover(&terms[0], &corners, &beam);
    const float end[3] = {0.5f, 0.5f, 3};
    for (int k = 0; k < 3; k++) {
        assert_true(isinf(beam.region.lo[k]));
        assert_true(beam.region.hi[k] >= end[k] && beam.region.hi[k] < end[k] + 1e-6f);
    }
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
    {"single rays", {.method = MLRT_METHOD_RAY}},
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
    {"the paper's, 32 to 16 by 16",
     {.method = MULTILEVEL, .shortcuts_off = PAPER, .initial_tile_size = 32, .minimum_tile_size = 16}},
    {"whole tiles", {.method = MULTILEVEL, .shortcuts_off = NO_LISTS}},
    {"lists", {.method = MULTILEVEL, .shortcuts_off = MLRT_SHORTCUT_WHOLE_TILES}},
    {"all shortcuts", {.method = MULTILEVEL}},
    {"all shortcuts, 128 to 8", {.method = MULTILEVEL, .initial_tile_size = 128, .minimum_tile_size = 8}},
};
enum { WAY_COUNT = sizeof ways / sizeof *ways, COUNT_COUNT = 11 };

/*
 * 0 if these are the counts; else prints them. In this order: packets, beams, cells, of these of the search, tests of
 * triangles, tiles missed, tiles covered, entry points, their depths, cells where culling was undecided, still so after
 * the check.
 */
static int counts_differ(const mlrt_counters *c, const uint64_t expected[COUNT_COUNT], const char *name,
                         const char *title)
{
    const uint64_t counts[COUNT_COUNT] = {c->packet_count,
                                          c->beam_count,
                                          c->cell_count,
                                          c->entry_point_cell_count,
                                          c->triangle_test_count,
                                          c->missed_beam_count,
                                          c->covered_beam_count,
                                          c->entry_point_count,
                                          c->entry_point_depth_sum,
                                          c->undecided_cull_count,
                                          c->undecided_checked_count};
    if (memcmp(counts, expected, sizeof counts) == 0) return 0;
    printf("%s:\n", name);
    for (int i = 0; i < COUNT_COUNT; i++) printf("%s%llu", i ? ", " : "{", (unsigned long long)counts[i]);
    printf("}, /* %s */\n", title);
    return 1;
}

static void counts_are_golden(void **state)
{
    (void)state;
    static const uint64_t expected[SCENE_COUNT][WAY_COUNT][COUNT_COUNT] = {
        {
            {65536, 0, 1975760, 0, 123126, 0, 0, 0, 0, 0, 0},                     /* single rays */
            {16384, 0, 519332, 0, 36905, 0, 0, 0, 0, 0, 0},                       /* 2x2 packets */
            {4096, 0, 161502, 0, 16210, 0, 0, 0, 0, 0, 0},                        /* 4x4 packets */
            {4096, 58, 146784, 2244, 16210, 0, 0, 64, 121, 836, 836},             /* the paper's */
            {4096, 58, 149072, 2343, 16210, 0, 0, 64, 118, 936, 936},             /* the paper's, direct */
            {4096, 58, 146784, 2244, 16210, 0, 0, 64, 121, 936, 836},             /* the paper's, direct, checked */
            {4096, 58, 146784, 2244, 16210, 0, 0, 64, 121, 836, 836},             /* the paper's, checked */
            {4096, 288, 134043, 9869, 15922, 0, 0, 241, 712, 3309, 3309},         /* the paper's, 64 to 16 by 4 */
            {4096, 1002, 129555, 31432, 14725, 0, 0, 949, 4584, 8649, 8649},      /* the paper's, 128 to 8 by 16 */
            {4096, 1024, 131692, 33569, 14725, 0, 0, 1024, 4839, 8434, 8434},     /* the paper's, 8 alone */
            {4096, 276, 133610, 9436, 15922, 0, 0, 241, 712, 3074, 3074},         /* the paper's, 32 to 16 by 16 */
            {3904, 58, 146592, 2244, 15890, 0, 3, 61, 112, 836, 836},             /* whole tiles */
            {4096, 58, 106183, 3999, 15978, 0, 0, 834, 16833, 1501, 1501},        /* lists */
            {3904, 58, 105991, 3999, 15658, 0, 3, 831, 16824, 1501, 1501},        /* all shortcuts */
            {2636, 1002, 65271, 44779, 11057, 0, 320, 4325, 87246, 12363, 12363}, /* all shortcuts, 128 to 8 */
        },
        {
            {65536, 0, 2235539, 0, 154113, 0, 0, 0, 0, 0, 0},                       /* single rays */
            {15825, 0, 715424, 0, 85785, 0, 0, 0, 0, 0, 0},                         /* 2x2 packets */
            {4148, 0, 363175, 0, 27694, 0, 0, 0, 0, 0, 0},                          /* 4x4 packets */
            {3636, 57, 350148, 4161, 27694, 8, 0, 56, 133, 1812, 1812},             /* the paper's */
            {3636, 57, 351731, 4282, 27694, 8, 0, 56, 129, 1882, 1882},             /* the paper's, direct */
            {3636, 57, 350148, 4161, 27694, 8, 0, 56, 133, 1913, 1812},             /* the paper's, direct, checked */
            {3636, 57, 350148, 4161, 27694, 8, 0, 56, 133, 1812, 1812},             /* the paper's, checked */
            {3140, 274, 347058, 18219, 27694, 39, 0, 193, 730, 7588, 7588},         /* the paper's, 64 to 16 by 4 */
            {2708, 923, 364118, 54597, 27694, 240, 0, 664, 2927, 20041, 20041},     /* the paper's, 128 to 8 by 16 */
            {2708, 994, 364973, 55452, 27694, 360, 0, 664, 2927, 19003, 19003},     /* the paper's, 8 alone */
            {3140, 263, 346310, 17471, 27694, 39, 0, 193, 730, 7187, 7187},         /* the paper's, 32 to 16 by 16 */
            {3636, 57, 350148, 4161, 27694, 8, 0, 56, 133, 1812, 1812},             /* whole tiles */
            {3636, 57, 384325, 6393, 27676, 8, 0, 1233, 25054, 2735, 2735},         /* lists */
            {3636, 57, 384325, 6393, 27676, 8, 0, 1233, 25054, 2735, 2735},         /* all shortcuts */
            {2708, 923, 306728, 89735, 27418, 240, 0, 14746, 315093, 35321, 35321}, /* all shortcuts, 128 to 8 */
        },
        {
            {65536, 0, 4082630, 0, 253037, 0, 0, 0, 0, 0, 0},                       /* single rays */
            {16384, 0, 1193804, 0, 110087, 0, 0, 0, 0, 0, 0},                       /* 2x2 packets */
            {4096, 0, 443851, 0, 64014, 0, 0, 0, 0, 0, 0},                          /* 4x4 packets */
            {4096, 58, 430825, 3652, 64014, 0, 0, 64, 203, 1310, 1310},             /* the paper's */
            {4096, 58, 431031, 3794, 64014, 0, 0, 64, 202, 1373, 1373},             /* the paper's, direct */
            {4096, 58, 430825, 3652, 64014, 0, 0, 64, 203, 1462, 1310},             /* the paper's, direct, checked */
            {4096, 58, 430825, 3652, 64014, 0, 0, 64, 203, 1310, 1310},             /* the paper's, checked */
            {4096, 324, 435158, 20268, 64014, 0, 0, 256, 1010, 6688, 6688},         /* the paper's, 64 to 16 by 4 */
            {4096, 1082, 465932, 68038, 63958, 0, 0, 1024, 4734, 18728, 18728},     /* the paper's, 128 to 8 by 16 */
            {4096, 1024, 466493, 68599, 63958, 0, 0, 1024, 4734, 17600, 17600},     /* the paper's, 8 alone */
            {4096, 312, 434546, 19656, 64014, 0, 0, 256, 1010, 6385, 6385},         /* the paper's, 32 to 16 by 16 */
            {4096, 58, 430825, 3652, 64014, 0, 0, 64, 203, 1310, 1310},             /* whole tiles */
            {4096, 58, 378090, 6101, 63838, 0, 0, 1371, 29341, 2322, 2322},         /* lists */
            {4096, 58, 378090, 6101, 63838, 0, 0, 1371, 29341, 2322, 2322},         /* all shortcuts */
            {4092, 1082, 284498, 119382, 62432, 0, 1, 17282, 365310, 33976, 33976}, /* all shortcuts, 128 to 8 */
        },
    };
    int failed = 0;
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
        struct subject subject = make_subject(names[s]);
        for (int w = 0; w < WAY_COUNT; w++) {
            const mlrt_counters c = count_picture(&subject, &ways[w].options);
            failed |= counts_differ(&c, expected[s][w], names[s], ways[w].title);
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

/* Rays of arrays that are those of the subject's camera. */
static float eye_origins[SIDE * SIDE][3], eye_directions[SIDE * SIDE][3];

static mlrt_rays rays_of_camera(const struct subject *subject)
{
    const mlrt_array origins = {eye_origins, 0, 0}, directions = {eye_directions, 0, 0};
    assert_int_equal(mlrt_camera_rays(&subject->camera, &origins, &directions), MLRT_OK);
    mlrt_rays rays = {.struct_size = sizeof rays, .count = SIDE * SIDE, .row_length = SIDE};
    rays.origins.data = eye_origins;
    rays.directions.data = eye_directions;
    return rays;
}

static mlrt_counters count_rays(const struct subject *subject, const mlrt_rays *rays)
{
    static uint32_t ids[SIDE * SIDE];
    mlrt_counters counters = {.struct_size = sizeof counters};
    const mlrt_trace_options options = {
        .struct_size = sizeof options, .method = MULTILEVEL, .minimum_tile_size = 8, .counters = &counters};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
    assert_int_equal(mlrt_trace_packet(subject->tree, rays, &options, &hits), MLRT_OK);
    return counters;
}

/* The way to where the subject's camera looks, in lengths of the middle ray. */
static float way_to_middle(const struct subject *subject)
{
    double way = 0, length = 0;
    const struct plain_ray middle = pixel_ray(subject, SIDE / 2, SIDE / 2);
    for (int k = 0; k < 3; k++) {
        const double to = subject->scene.view.look[k] - subject->scene.view.eye[k];
        way += to * to;
        length += middle.direction[k] * middle.direction[k];
    }
    return (float)sqrt(way / length);
}

/* Rays that end or begin on their way, parallel rays, and rays of arrays, from one origin and from many. */
static void counts_from_other_rays_are_golden(void **state)
{
    (void)state;
    static const uint64_t expected[SCENE_COUNT][7][COUNT_COUNT] = {
        {
            {2264, 826, 41625, 28798, 6730, 278, 0, 2771, 60961, 7665, 7665},    /* up to the middle */
            {4096, 1002, 72728, 48079, 16112, 0, 0, 5286, 97753, 12888, 12888},  /* from half way */
            {4096, 804, 72841, 56557, 12030, 0, 0, 3801, 75434, 14977, 14977},   /* parallel */
            {4096, 1016, 70402, 46580, 15558, 0, 0, 4926, 95728, 13019, 13019},  /* arrays */
            {2276, 824, 43670, 29619, 8313, 275, 0, 2928, 64864, 7945, 7945},    /* arrays, up to the middle */
            {4096, 1016, 76176, 49709, 18495, 0, 0, 5537, 103581, 13513, 13513}, /* arrays, from half way */
            {4096, 1016, 76176, 49709, 18495, 0, 0, 5537, 103581, 13513, 13513}, /* arrays, many origins */
        },
        {
            {2412, 875, 219216, 74441, 20170, 284, 0, 11901, 259149, 28794, 28794}, /* up to the middle */
            {2708, 923, 306728, 89735, 27418, 240, 0, 14746, 315093, 35321, 35321}, /* from half way */
            {2328, 804, 151259, 99989, 15839, 172, 0, 10120, 228657, 30343, 30343}, /* parallel */
            {2724, 921, 314492, 89570, 40393, 236, 0, 14922, 318053, 35452, 35452}, /* arrays */
            {2376, 889, 225312, 74849, 29107, 293, 0, 12046, 261775, 29030, 29030}, /* arrays, up to the middle */
            {2724, 921, 314492, 89570, 40393, 236, 0, 14922, 318053, 35452, 35452}, /* arrays, from half way */
            {2724, 921, 314629, 89719, 40391, 236, 0, 14922, 318053, 35478, 35478}, /* arrays, many origins */
        },
        {
            {3052, 1002, 182144, 91161, 37793, 186, 0, 11965, 263472, 25139, 25139}, /* up to the middle */
            {4096, 1082, 298468, 121036, 59512, 0, 0, 17686, 372637, 34500, 34500},  /* from half way */
            {4096, 1092, 228675, 148318, 40716, 0, 0, 16884, 380635, 38325, 38325},  /* parallel */
            {4096, 1080, 293587, 119377, 81163, 0, 0, 17775, 374686, 34465, 34465},  /* arrays */
            {3072, 1000, 188152, 91680, 48415, 181, 0, 12360, 271586, 25607, 25607}, /* arrays, up to the middle */
            {4096, 1080, 307442, 120750, 76992, 0, 0, 18133, 381069, 34912, 34912},  /* arrays, from half way */
            {4096, 1080, 296471, 120808, 81223, 0, 0, 18134, 381100, 34924, 34924},  /* arrays, many origins */
        },
    };
    const mlrt_trace_options options = {.method = MULTILEVEL, .minimum_tile_size = 8};
    int failed = 0;
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
        struct subject subject = make_subject(names[s]);
        const float way = way_to_middle(&subject), half = 0.5f * way;
        const mlrt_camera camera = subject.camera;
        mlrt_counters c[7];
        subject.camera.t_max = way;
        c[0] = count_picture(&subject, &options);
        subject.camera.t_max = 0;
        subject.camera.t_min = half;
        c[1] = count_picture(&subject, &options);
        subject.camera = camera;
        subject.camera.projection = MLRT_PROJECTION_PARALLEL;
        for (int k = 0; k < 3; k++) {
            subject.camera.direction[k] = (float)(subject.scene.view.look[k] - subject.scene.view.eye[k]);
            subject.camera.d00[k] += camera.eye[k];
        }
        c[2] = count_picture(&subject, &options);
        subject.camera = camera;
        mlrt_rays rays = rays_of_camera(&subject);
        c[3] = count_rays(&subject, &rays);
        rays.t_max = (mlrt_const_array){&way, MLRT_STRIDE_ALL};
        c[4] = count_rays(&subject, &rays);
        rays.t_max.data = NULL;
        rays.t_min = (mlrt_const_array){&half, MLRT_STRIDE_ALL};
        c[5] = count_rays(&subject, &rays);
        rays.t_min.data = NULL;
        for (int i = 0; i < SIDE * SIDE; i++) {
            for (int k = 0; k < 3; k++) eye_origins[i][k] += 0.125f * eye_directions[i][k];
        }
        c[6] = count_rays(&subject, &rays);
        static const char *const titles[] = {
            "up to the middle",      "from half way",       "parallel", "arrays", "arrays, up to the middle",
            "arrays, from half way", "arrays, many origins"};
        for (int i = 0; i < 7; i++) failed |= counts_differ(&c[i], expected[s][i], names[s], titles[i]);
        free_subject(&subject);
    }
    assert_false(failed);
}

/* Whether the rays of a picture hit anything, by each method: cells and tests. */
static void counts_of_shadows_are_golden(void **state)
{
    (void)state;
    static const int32_t methods[] = {MLRT_METHOD_RAY, MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4, MULTILEVEL};
    static const uint64_t expected[SCENE_COUNT][4][3] = {
        {
            {1915281, 97810, 0},    /* room: method 1 */
            {502314, 30003, 97810}, /* room: method 2 */
            {147260, 9871, 113128}, /* room: method 3 */
            {95943, 9514, 107755},  /* room: method 4 */
        },
        {
            {2175374, 103811, 0},    /* scan:20000: method 1 */
            {694683, 63654, 103811}, /* scan:20000: method 2 */
            {333762, 20177, 71049},  /* scan:20000: method 3 */
            {355002, 20161, 71088},  /* scan:20000: method 4 */
        },
        {
            {3757868, 119572, 0},     /* doubled: method 1 */
            {1023910, 50488, 119577}, /* doubled: method 2 */
            {331947, 23389, 183713},  /* doubled: method 3 */
            {267342, 23391, 183658},  /* doubled: method 4 */
        },
    };
    static uint8_t occluded[SIDE * SIDE];
    int failed = 0;
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
        struct subject subject = make_subject(names[s]);
        for (int m = 0; m < 4; m++) {
            mlrt_counters counters = {.struct_size = sizeof counters};
            const mlrt_trace_options options = {
                .struct_size = sizeof options, .query = MLRT_QUERY_ANY, .method = methods[m], .counters = &counters};
            const mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
            assert_int_equal(mlrt_render_tiles(subject.tree, &subject.camera, &options, &hits, NULL, NULL), MLRT_OK);
            const uint64_t counts[3] = {counters.cell_count, counters.triangle_test_count, counters.lane_test_count};
            if (memcmp(counts, expected[s][m], sizeof counts) == 0) continue;
            failed = 1;
            printf("{%llu, %llu, %llu}, /* %s: method %d */\n", (unsigned long long)counts[0],
                   (unsigned long long)counts[1], (unsigned long long)counts[2], names[s], (int)methods[m]);
        }
        free_subject(&subject);
    }
    assert_false(failed);
}

/*
 * A slanted floor, in whose plane the eye lies, is in a leaf with a triangle beside the picture. No ray can hit it, so
 * the other triangle alone is tested, and by 4x4 packets neither.
 */
static void triangles_in_a_plane_with_the_apex_are_not_tested(void **state)
{
    (void)state;
    static uint32_t ids[64 * 64];
    static const float corner[3] = {1, -1, -1}, along[3] = {2, 0, 0}, across[3] = {0, 2, 2};
    static const float beside[3][3] = {{3, -1, 2}, {3, -1, 2.1f}, {3, -0.9f, 2}}; /* z / x > 1 / 2 */
    static const float eye[3] = {0, 0, 0}, target[3] = {2, 0, 0};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, along, across);
    soup_add_triangle(&soup, beside[0], beside[1], beside[2]);
    const mlrt_mesh mesh = soup_mesh(&soup);
    const mlrt_kdtree_options one_leaf = {.struct_size = sizeof one_leaf, .traversal_cost = 1e6f, .rules_off = 31};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_kdtree(&mesh, 1, &one_leaf, &tree), MLRT_OK);
    const mlrt_camera camera = look_at(eye, target, 1, 64, 64);
    for (int32_t method = MLRT_METHOD_PACKET2; method <= MLRT_METHOD_PACKET4; method++) {
        mlrt_counters counters = {.struct_size = sizeof counters};
        const mlrt_trace_options options = {.struct_size = sizeof options, .method = method, .counters = &counters};
        const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {ids, 0, 0}};
        assert_int_equal(mlrt_render_tiles(tree, &camera, &options, &hits, NULL, NULL), MLRT_OK);
        assert_true(counters.packet_count > 0);
        assert_int_equal(counters.triangle_test_count, method == MLRT_METHOD_PACKET2 ? counters.packet_count : 0);
    }
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

/* The point of it all, whatever the numbers: fewer cells than from the root, and fewer tests with covered tiles. */
static void beams_save_steps(void **state)
{
    (void)state;
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
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

/* ---- answers ----------------------------------------------------------------------------------------------------- */

enum { ARRAY_SIDE = 64, ARRAY_COUNT = ARRAY_SIDE * ARRAY_SIDE };

/* Traces rays by each method, which must all find what single rays find. `title` says which rays they are. */
static void compare_with_single_rays(const mlrt_tree *tree, const mlrt_rays *rays, const char *title)
{
    static const int32_t methods[] = {MLRT_METHOD_RAY, MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4, MULTILEVEL};
    static uint32_t ids[4][2][ARRAY_COUNT];
    static float t[4][ARRAY_COUNT];
    for (int m = 0; m < 4; m++) {
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .method = methods[m], .minimum_tile_size = m == 3 ? 8 : 0};
        const mlrt_hits hits = {
            .struct_size = sizeof hits, .t = {t[m], 0, 0}, .mesh = {ids[m][0], 0, 0}, .triangle = {ids[m][1], 0, 0}};
        assert_int_equal(mlrt_trace_packet(tree, rays, &options, &hits), MLRT_OK);
        if (memcmp(ids[m], ids[0], sizeof ids[m]) == 0 && memcmp(t[m], t[0], sizeof t[m]) == 0) continue;
        fail_msg("%s: method %d differs", title, (int)methods[m]);
    }
}

/* Rays in rows whose tiles and packets have several origins, signs and main axes. */
static void rays_of_arrays_get_their_hits(void **state)
{
    (void)state;
    static const char *const titles[] = {"around an axis", "from many origins", "from an origin for each block",
                                         "along another axis in each block"};
    static float origins[ARRAY_COUNT][3], directions[ARRAY_COUNT][3];
    struct subject subject = make_subject("room");
    for (int kind = 0; kind < 4; kind++) {
        for (int i = 0; i < ARRAY_COUNT; i++) {
            const float x = (float)(i % ARRAY_SIDE - ARRAY_SIDE / 2 + 2) / ARRAY_SIDE;
            const float y = (float)(i / ARRAY_SIDE - ARRAY_SIDE / 2 + 2) / ARRAY_SIDE;
            const int column = i % ARRAY_SIDE / 4, row = i / ARRAY_SIDE / 4;
            const int axis = kind == 3 ? (column + row) % 3 : 0;
            for (int k = 0; k < 3; k++)
                origins[i][k] = 0.5f * (subject.source.view.eye[k] + (float)subject.scene.view.look[k]);
            directions[i][axis] = kind == 3 ? 0.25f + 0.01f * (float)axis : 1;
            directions[i][(axis + 1) % 3] = kind == 0 ? x : kind == 3 ? 0.2f + x * 0.1f : 0.6f + 0.5f * x;
            directions[i][(axis + 2) % 3] = kind == 0 ? y : kind == 3 ? -0.2f + y * 0.1f : -0.6f + 0.5f * y;
            if (kind == 1) origins[i][1] += x, origins[i][2] += 0.5f * y;
            if (kind == 2) origins[i][1] += 0.1f * (float)(column - 8), origins[i][2] += 0.05f * (float)(row - 8);
        }
        mlrt_rays rays = {.struct_size = sizeof rays, .count = ARRAY_COUNT, .row_length = ARRAY_SIDE};
        rays.origins.data = origins;
        rays.directions.data = directions;
        compare_with_single_rays(subject.tree, &rays, titles[kind]);
    }
    free_subject(&subject);
}

/*
 * Two triangles that meet at z = 0, each in a leaf of its own, at 5 along x. Of each two neighbouring rays one lies in
 * the plane between them and hits the upper one's edge. The other comes from below, and would cross that plane at 20.
 */
static void rays_in_a_plane_beside_rays_that_cross_it_get_their_hits(void **state)
{
    (void)state;
    static const float corners[2][3][3] = {{{5, -1, 0}, {5, 1, 0}, {5, 0, 2}}, {{5, -1, 0}, {5, 0.5f, 0}, {5, 0, -2}}};
    static float origins[ARRAY_COUNT][3], directions[ARRAY_COUNT][3];
    const mlrt_kdtree_options options = {.struct_size = sizeof options,
                                         .intersection_cost = 1e4f,
                                         .rules_off = MLRT_RULE_EMPTY_SPACE | MLRT_RULE_COPLANAR};
    struct soup soup = {0};
    mlrt_tree *tree = NULL;
    for (int i = 0; i < 2; i++) soup_add_triangle(&soup, corners[i][0], corners[i][1], corners[i][2]);
    const mlrt_mesh mesh = soup_mesh(&soup);
    assert_int_equal(mlrt_build_kdtree(&mesh, 1, &options, &tree), MLRT_OK);
    for (int i = 0; i < ARRAY_COUNT; i++) {
        origins[i][1] = 0.75f;
        origins[i][2] = i % 2 ? -0.01f : 0;
        directions[i][0] = 1;
        directions[i][2] = i % 2 ? 0.0005f : 0;
    }
    mlrt_rays rays = {.struct_size = sizeof rays, .count = ARRAY_COUNT, .row_length = ARRAY_SIDE};
    rays.origins.data = origins;
    rays.directions.data = directions;
    compare_with_single_rays(tree, &rays, "in a plane");
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

/*
 * Renders by each method, which must all find what single rays find. Returns what is counted in the last, multi-level.
 */
static mlrt_counters compare_picture(const mlrt_tree *tree, const mlrt_camera *camera, uint32_t mask, const char *title)
{
    static const int32_t methods[] = {MLRT_METHOD_RAY, MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4, MULTILEVEL};
    static uint32_t ids[4][2][ARRAY_COUNT];
    mlrt_counters counters = {.struct_size = sizeof counters};
    for (int m = 0; m < 4; m++) {
        const mlrt_trace_options options = {.struct_size = sizeof options,
                                            .method = methods[m],
                                            .mask = mask,
                                            .minimum_tile_size = m == 3 ? 8 : 0,
                                            .counters = m == 3 ? &counters : NULL};
        const mlrt_hits hits = {.struct_size = sizeof hits, .mesh = {ids[m][0], 0, 0}, .triangle = {ids[m][1], 0, 0}};
        assert_int_equal(mlrt_render_tiles(tree, camera, &options, &hits, NULL, NULL), MLRT_OK);
        if (memcmp(ids[m], ids[0], sizeof ids[m])) fail_msg("%s: method %d differs", title, (int)methods[m]);
    }
    return counters;
}

/* In a wide picture of a room, the rays of neighbouring packets have several main axes. */
static void pictures_along_several_axes_get_their_hits(void **state)
{
    (void)state;
    struct subject subject = make_subject("room");
    float eye[3], target[3];
    for (int k = 0; k < 3; k++) {
        eye[k] = 0.5f * (subject.source.view.eye[k] + (float)subject.scene.view.look[k]);
        target[k] = eye[k] + (k == 2 ? -0.9f : 1);
    }
    const mlrt_camera camera = look_at(eye, target, 2, ARRAY_SIDE, ARRAY_SIDE);
    compare_picture(subject.tree, &camera, 0, "several axes");
    free_subject(&subject);
}

/*
 * Two walls that fill the picture, the nearer one slanted. Each is a mesh of two triangles with its own bit of the
 * mask.
 */
struct walls {
    struct soup soups[2];
    mlrt_mesh meshes[2];
    mlrt_camera camera;
};

static struct walls make_walls(void)
{
    static const float eye[3] = {0.1f, 0.2f, 0}, target[3] = {0.1f, 0.2f, 1};
    static const float other_side[3] = {0, 12, 0};
    struct walls walls;
    memset(&walls, 0, sizeof walls);
    for (int wall = 0; wall < 2; wall++) {
        const float corner[3] = {-3.5f, -3.5f, wall ? 4.5f : 1.6f}; /* at 2.3 and 4.5 along the z axis */
        const float side[3] = {12, 0, wall ? 0 : 2.4f};
        soup_add_quad(&walls.soups[wall], corner, side, other_side);
        walls.meshes[wall] = soup_mesh(&walls.soups[wall]);
        walls.meshes[wall].id = (uint32_t)wall;
        walls.meshes[wall].mask = 1u << wall;
    }
    walls.camera = look_at(eye, target, 1, ARRAY_SIDE, ARRAY_SIDE);
    return walls;
}

/* One leaf, or leaves as small as can be. */
static mlrt_tree *build_walls(const struct walls *walls, int one_leaf)
{
    const mlrt_kdtree_options options = {.struct_size = sizeof options,
                                         .traversal_cost = one_leaf ? 1e6f : 1,
                                         .intersection_cost = one_leaf ? 1 : 1e4f,
                                         .rules_off = one_leaf ? 31 : MLRT_RULE_MINIMUM_CELL};
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_kdtree(walls->meshes, 2, &options, &tree), MLRT_OK);
    return tree;
}

static void free_walls(struct walls *walls)
{
    for (int wall = 0; wall < 2; wall++) free_soup(&walls->soups[wall]);
}

/* Rays that may not hit the nearer wall, or not so near or so far, must not be answered by its cover. */
static void rays_that_a_cover_does_not_stop(void **state)
{
    (void)state;
    static const struct {
        float t_min, t_max;
        uint32_t mask;
        const char *title;
    } pictures[] = {{0, 0, 0, "all"},
                    {2.3f, 0, 0, "from the middle of a wall"},
                    {0, 2.3f, 0, "to the middle"},
                    {3.2f, 0, 0, "between"},
                    {0, 0, 2, "mask"},
                    {0, 3.2f, 0, "up to between"}};
    static float origins[ARRAY_COUNT][3], directions[ARRAY_COUNT][3];
    static uint32_t skip[ARRAY_COUNT][2];
    struct walls walls = make_walls();
    for (int one_leaf = 0; one_leaf < 2; one_leaf++) {
        mlrt_tree *tree = build_walls(&walls, one_leaf);
        for (size_t p = 0; p < sizeof pictures / sizeof *pictures; p++) {
            mlrt_camera camera = walls.camera;
            camera.t_min = pictures[p].t_min;
            camera.t_max = pictures[p].t_max;
            compare_picture(tree, &camera, pictures[p].mask, pictures[p].title);
        }
        const mlrt_array origin_array = {origins, 0, 0}, direction_array = {directions, 0, 0};
        assert_int_equal(mlrt_camera_rays(&walls.camera, &origin_array, &direction_array), MLRT_OK);
        mlrt_rays rays = {.struct_size = sizeof rays, .count = ARRAY_COUNT, .row_length = ARRAY_SIDE};
        rays.origins.data = origins;
        rays.directions.data = directions;
        compare_with_single_rays(tree, &rays, "arrays");
        for (int i = 0; i < ARRAY_COUNT; i++) skip[i][0] = 0, skip[i][1] = (uint32_t)i % 3;
        rays.skip.data = skip;
        compare_with_single_rays(tree, &rays, "arrays with skip");
        rays.skip.data = NULL;
        const float between = 3.2f, middle = 2.3f;
        rays.t_min = (mlrt_const_array){&between, MLRT_STRIDE_ALL};
        compare_with_single_rays(tree, &rays, "arrays from t_min");
        rays.t_min.data = NULL;
        rays.t_max = (mlrt_const_array){&middle, MLRT_STRIDE_ALL};
        compare_with_single_rays(tree, &rays, "arrays up to t_max");
        rays.t_max.data = NULL;
        /* Some pass the nearer wall beyond its side, and hit the other. */
        for (int i = 0; i < ARRAY_COUNT; i++) {
            origins[i][0] += 0.2f * (float)(ARRAY_SIDE - i % ARRAY_SIDE) + 0.003f * (float)(i / ARRAY_SIDE);
        }
        compare_with_single_rays(tree, &rays, "arrays from many origins");
        mlrt_destroy_tree(tree);
    }
    free_walls(&walls);
}

/* A tile is done at once if the other triangles of the leaf are behind its cover, or beside the tile. */
static void covers_in_front_of_others_close_tiles(void **state)
{
    (void)state;
    struct walls walls = make_walls();
    mlrt_tree *tree = build_walls(&walls, 1);
    const mlrt_counters counters = compare_picture(tree, &walls.camera, 0, "one leaf");
    assert_true(counters.covered_beam_count > 0);
    mlrt_destroy_tree(tree);
    free_walls(&walls);
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

/* Packets whose rays differ in direction, or in origin, are several groups. */
static void packets_are_cut_into_groups(void **state)
{
    (void)state;
    enum { COUNT = 4096 };
    static float origins[COUNT][3], directions[COUNT][3];
    static const uint64_t expected[5][3] = {
        {1337, 73636, 5833}, {4095, 50694, 7965}, {3963, 132044, 9627}, {4096, 41420, 6509}, {1012, 9108, 2024},
    };
    struct subject subject = make_subject("room");
    int failed = 0;
    for (int kind = 0; kind < 5; kind++) {
        struct random random = {7};
        for (int i = 0; i < COUNT; i++) {
            for (int k = 0; k < 3; k++) {
                /* From the eye, or from anywhere near; within a few degrees, or everywhere. */
                const float spread = kind & 1 ? 1 : 0.02f, off = kind & 2 ? 0.5f : 0;
                const float middle = (float)(subject.scene.view.look[k] - subject.scene.view.eye[k]);
                origins[i][k] = subject.source.view.eye[k] + draw_range(&random, -off, off);
                directions[i][k] = middle * (kind & 1 ? 0 : 0.2f) + draw_range(&random, -spread, spread);
                if (kind == 4) directions[i][k] = k ? draw_range(&random, -0.01f, 0.01f) : 1; /* around an axis */
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
    for (int s = first_scene(); s < SCENE_COUNT; s += SCENE_STEP) {
        struct subject subject = make_subject(names[s]);
        for (size_t b = first_variant(); b < BUILD_COUNT; b += variant_step()) {
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
        cmocka_unit_test(boxes_that_rays_just_touch_are_not_missed),
        cmocka_unit_test(triangles_cover_a_beam_or_miss_it_or_lie_behind),
        cmocka_unit_test(signs_within_twice_their_errors_are_uncertain),
        cmocka_unit_test(counts_are_golden),
        cmocka_unit_test(counts_looking_back_are_golden),
        cmocka_unit_test(counts_from_other_rays_are_golden),
        cmocka_unit_test(counts_of_shadows_are_golden),
        cmocka_unit_test(triangles_in_a_plane_with_the_apex_are_not_tested),
        cmocka_unit_test(beams_save_steps),
        cmocka_unit_test(rays_of_arrays_get_their_hits),
        cmocka_unit_test(rays_in_a_plane_beside_rays_that_cross_it_get_their_hits),
        cmocka_unit_test(pictures_along_several_axes_get_their_hits),
        cmocka_unit_test(rays_that_a_cover_does_not_stop),
        cmocka_unit_test(covers_in_front_of_others_close_tiles),
        cmocka_unit_test(packets_are_cut_into_groups),
        cmocka_unit_test(trees_are_golden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
