/* SPDX-License-Identifier: MIT */
/*
 * reproduce.c - repeats the measurements of the paper, and prints them beside the paper's numbers as Markdown tables
 *
 * For each scene it builds the kd-trees of both presets, from which all tables take their numbers. The answers of each
 * picture whose work is counted are compared with those of method ray. Counters are those of one thread. Times are
 * medians of runs that take turns, so that a machine that slows down or speeds up does so for all of them: processor
 * time of one thread, also to build, and elapsed time of several. Where runs would take too long there are fewer, but
 * at least three.
 *
 * Exit codes: 0, 1 if something failed or an answer differed, 2 for a mistake on the command line.
 *
 * Based on: A. Reshetov, A. Soupikov, J. Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005, tables 1 and 2.
 */
#define _POSIX_C_SOURCE 200112L

#include "bench/peer_frame.h"
#include "common/hash.h"
#include "common/interior.h"
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/terminal.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

enum { NAME_SIZE = 64, PATH_SIZE = 4096 };

struct settings {
    struct word_list scenes;
    const char *views;
    uint32_t size, runs, threads, tables; // tables: a bit for each
    mlrt_trace_options tiles;             // only the tile sizes
};

/* ---- the paper's numbers ------------------------------------------------------------------------------------- */

/* The rows of its table 2, per 4x4 packet. With shadows: primary rays and one shadow ray for each of their hits. */
enum {
    PRIMARY_CELLS,
    PRIMARY_CELLS_FROM_ROOT,
    PRIMARY_ENTRY_CELLS,
    PRIMARY_TESTS,
    PRIMARY_TESTS_FROM_ROOT,
    SHADOW_CELLS,
    SHADOW_CELLS_FROM_ROOT,
    SHADOW_ENTRY_CELLS, // not in the paper
    SHADOW_TESTS,
    SHADOW_TESTS_FROM_ROOT,
    PRIMARY_CELLS_OF_LISTS, // from here on: from lists of entry points, not in the paper
    PRIMARY_ENTRY_CELLS_OF_LISTS,
    PRIMARY_TESTS_OF_LISTS,
    SHADOW_CELLS_OF_LISTS,
    SHADOW_ENTRY_CELLS_OF_LISTS,
    SHADOW_TESTS_OF_LISTS,
    QUANTITY_COUNT
};

// What is left of the multi-level method without these shortcuts is the paper's algorithm, or that with entry lists.
// Set-ups of triangles stay shared, here and in method packet4, as the paper's packets share what it computes in
// advance.
enum { PAPER = MLRT_SHORTCUT_WHOLE_TILES | MLRT_SHORTCUT_ENTRY_LISTS, ENTRY_LISTS_ONLY = MLRT_SHORTCUT_WHOLE_TILES };

enum { PLAIN, SHADED, SHADING_COUNT };
enum { ONE_THREAD, ALL_THREADS, THREADING_COUNT };

struct published {
    const char *name; // of the scene beside which the numbers appear
    const char *title;
    double quantities[QUANTITY_COUNT];                 // table 2; 0 = not published
    double open_rt[SHADING_COUNT];                     // table 1, frames per second: 2.5 GHz Pentium 4
    double multilevel[SHADING_COUNT][THREADING_COUNT]; // 2.4 GHz Pentium 4, and two hyper-threads of a 3.2 GHz one
};

static const struct published published[] = {
    {.name = "erw6",
     .title = "Erw6",
     .quantities = {3.98, 13.00, 0.51, 1.09, 1.09, 10.07, 24.83, 0, 1.25, 1.22},
     .open_rt = {7.1, 2.3},
     .multilevel = {{70.2, 109.8}, {37.8, 50.7}}},
    {.name = "conference_mgf",
     .title = "Conference",
     .quantities = {20.87, 49.98, 2.30, 2.48, 2.55, 53.73, 101.06, 0, 3.71, 3.75},
     .open_rt = {4.55, 1.93},
     .multilevel = {{11.2, 19.5}, {9.5, 15.6}}},
    {.name = "cruiser_mgf",
     .title = "Soda Hall",
     .quantities = {32.52, 71.37, 4.44, 1.59, 1.52, 69.07, 117.22, 0, 2.17, 2.09},
     .open_rt = {4.12, 1.8},
     .multilevel = {{21.1, 35.5}, {15.3, 24.1}}},
    {.name = "dragon_x9",
     .title = "Asian Dragon",
     .quantities = {32.65, 42.18, 2.72, 19.97, 19.94, 45.01, 58.41, 0, 23.51, 23.48}},
};

static const struct published *find_published(const char *name)
{
    for (size_t i = 0; i < LENGTH(published); i++) {
        if (strcmp(published[i].name, name) == 0) return &published[i];
    }
    return NULL;
}

/* ---- what is varied ------------------------------------------------------------------------------------------ */

static const struct {
    const char *title;
    uint32_t off;
} rules[] = {
    {"none: all rules on", 0},
    {"empty space is cut off first", MLRT_RULE_EMPTY_SPACE},
    {"planes covered by triangles are splits", MLRT_RULE_COPLANAR},
    {"no cells under a minimum size", MLRT_RULE_MINIMUM_CELL},
    {"these three, the paper's", MLRT_RULE_EMPTY_SPACE | MLRT_RULE_COPLANAR | MLRT_RULE_MINIMUM_CELL},
    {"candidates are clipped to the cell", MLRT_RULE_CLIPPED_SPLITS},
    {"subtrees that do not pay become leaves", MLRT_RULE_RETRACTION},
};

static const struct {
    const char *title;
    int32_t culling;
    uint32_t check;
} cullings[] = {
    {"inverse", MLRT_CULLING_INVERSE, 0},
    {"inverse, extra check", MLRT_CULLING_INVERSE, 1},
    {"direct", MLRT_CULLING_DIRECT, 0},
    {"direct, extra check", MLRT_CULLING_DIRECT, 1},
};

static const uint32_t split_factors[] = {4, 16};
static const uint32_t initial_sizes[] = {16, 32, 64, 128, 256};
static const uint32_t minimum_sizes[] = {4, 8, 16, 32, 64};

// In place of a method of the library.
enum { PEER_FAST = -1, PEER_ROBUST = -2 };

static const struct {
    const char *title;
    int32_t method;
    uint32_t shortcuts_off;
} methods[] = {
    {"ray", MLRT_METHOD_RAY, 0},
    {"packet2", MLRT_METHOD_PACKET2, 0},
    {"packet4", MLRT_METHOD_PACKET4, 0},
    {"multilevel as in the paper", MLRT_METHOD_MULTILEVEL, PAPER},
    {"multilevel", MLRT_METHOD_MULTILEVEL, 0},
    {"tile (boxes), what replaced it", MLRT_METHOD_TILE, 0},
    {"Embree 3.13, fast", PEER_FAST, 0},
    {"Embree 3.13, robust", PEER_ROBUST, 0},
};

/* Positions in `methods`: those that the ratios of table 5 divide by, and those that are divided. */
enum { PACKET2 = 1, PACKET4 = 2, FIRST_MULTILEVEL = 3, TILE = 5, FIRST_PEER = 6 };

// What the answers must not depend on besides method, instruction set and threads. Sizes 0: the default.
static const mlrt_trace_options variations[] = {
    {.initial_tile_size = 0},
    {.shortcuts_off = PAPER},
    {.shortcuts_off = ENTRY_LISTS_ONLY},
    {.shortcuts_off = MLRT_SHORTCUT_ENTRY_LISTS},
    {.culling = MLRT_CULLING_DIRECT},
    {.culling_check = 1},
    {.initial_tile_size = 16, .minimum_tile_size = 4, .split_factor = 4},
    {.initial_tile_size = 64, .minimum_tile_size = 8, .split_factor = 4},
    {.initial_tile_size = 128, .minimum_tile_size = 32, .split_factor = 16, .shortcuts_off = PAPER},
    {.initial_tile_size = 256, .minimum_tile_size = 4, .split_factor = 16},
};

static const int32_t isas[] = {MLRT_ISA_SCALAR, MLRT_ISA_SSE, MLRT_ISA_AUTO};

static const struct {
    const char *title;
    int32_t kind;
} presets[] = {{"tuned", TREE_KDTREE_TUNED}, {"paper", TREE_KDTREE}};

/* ---- results ------------------------------------------------------------------------------------------------- */

/* Counts are per 4x4 packet of the picture. */
struct measured {
    double cells, entry_cells, tests, undecided, still_undecided;
    double seconds; // for a frame
};

struct rule_result {
    struct measured multilevel, from_root;
    double time_ratio, from_root_time_ratio; // to the tree with all rules on
    double sah_cost;
    uint64_t node_count;
};

struct check_result {
    uint64_t hit_hash, shadow_hash;                     // of the plain method
    uint64_t hit_count, shadow_count, difference_count; // pictures compared
};

struct results {
    char name[NAME_SIZE];
    const struct published *published; // NULL = nothing
    double quantities[QUANTITY_COUNT];
    struct rule_result rules[LENGTH(rules)];
    struct measured cullings[LENGTH(cullings)];
    struct measured sweep[LENGTH(split_factors)][LENGTH(initial_sizes)][LENGTH(minimum_sizes)]; // seconds 0: not one
    double frame_seconds[SHADING_COUNT][THREADING_COUNT][LENGTH(methods)];                      // 0 = not measured
    struct check_result check;
    mlrt_tree_info trees[LENGTH(presets)];
    double build_seconds[LENGTH(presets)]; // of the thread
};

/* ---- one scene ----------------------------------------------------------------------------------------------- */

/* Where shadow rays end, one for each pixel, and the triangle that each passes. */
struct shadow_points {
    float (*positions)[3];
    uint32_t (*skip)[2];
};

/* All the answers of a picture, and what becomes of them. */
struct picture {
    float *t, *u, *v;
    uint32_t *mesh, *triangle;
    int32_t *facing;
    uint8_t *occluded, *rgba;
    struct shadow_points shadow_points;
};

struct subject {
    const struct settings *settings;
    mlrt_pool *pool; // of all the threads asked for
    struct scene scene;
    mlrt_camera camera;
    size_t pixel_count;
    struct picture picture;
    size_t preset; // a position in `presets`: the tree's
    mlrt_tree *tree;
    mlrt_tree *boxes;        // for method tile
    struct peer_frame *peer; // for pictures by Embree, and for normals
    struct results *results;
};

static int succeeded(int32_t status)
{
    if (status != MLRT_OK) fprintf(stderr, "cannot trace: %s\n", mlrt_status_string(status));
    return status == MLRT_OK;
}

static int allocate_picture(struct picture *picture, size_t n)
{
    struct shadow_points *points = &picture->shadow_points;
    int good = (picture->t = malloc(n * sizeof(float))) && (picture->u = malloc(n * sizeof(float))) &&
               (picture->v = malloc(n * sizeof(float))) && (picture->mesh = malloc(n * sizeof(uint32_t))) &&
               (picture->triangle = malloc(n * sizeof(uint32_t))) && (picture->facing = malloc(n * sizeof(int32_t))) &&
               (picture->occluded = malloc(n)) && (picture->rgba = malloc(4 * n)) &&
               (points->positions = malloc(n * sizeof *points->positions)) &&
               (points->skip = malloc(n * sizeof *points->skip));
    if (!good) fprintf(stderr, "not enough memory for %zu pixels\n", n);
    return !good;
}

static void free_picture(struct picture *picture)
{
    free(picture->t);
    free(picture->u);
    free(picture->v);
    free(picture->mesh);
    free(picture->triangle);
    free(picture->facing);
    free(picture->occluded);
    free(picture->rgba);
    free(picture->shadow_points.positions);
    free(picture->shadow_points.skip);
}

// With the tile sizes of the command line.
static mlrt_trace_options options_for(const struct subject *subject, int32_t method)
{
    mlrt_trace_options options = subject->settings->tiles;
    options.struct_size = sizeof options;
    options.method = method;
    return options;
}

// As the paper traces, so that its counts compare.
static mlrt_trace_options paper_options_for(const struct subject *subject, int32_t method)
{
    mlrt_trace_options options = options_for(subject, method);
    options.shortcuts_off = PAPER;
    return options;
}

static double per_packet(const struct subject *subject, uint64_t count)
{
    uint64_t side = (subject->settings->size + 3) / 4;
    return (double)count / (double)(side * side);
}

/* ---- answers ------------------------------------------------------------------------------------------------- */

// Finds all hits of the picture. *hash receives the number that stands for them.
static int32_t find_hits(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options,
                         uint64_t *hash)
{
    struct picture *p = &subject->picture;
    const mlrt_hits hits = {.struct_size = sizeof hits,
                            .t = {p->t, 0, 0},
                            .u = {p->u, 0, 0},
                            .v = {p->v, 0, 0},
                            .mesh = {p->mesh, 0, 0},
                            .triangle = {p->triangle, 0, 0},
                            .facing = {p->facing, 0, 0}};
    // The last picture's answers would hide a pixel that this one forgets.
    memset(p->t, 0xFF, subject->pixel_count * sizeof *p->t);
    int32_t status = mlrt_render_tiles(tree, &subject->camera, options, &hits, NULL, NULL);
    *hash = hash_hits(p->mesh, p->triangle, p->t, p->u, p->v, subject->pixel_count);
    return status;
}

// The same for the shadow rays to the hits of the plain method.
static int32_t find_shadows(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options,
                            uint64_t *hash)
{
    struct picture *p = &subject->picture;
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = subject->camera.width,
                                .count = subject->pixel_count,
                                .positions = {p->shadow_points.positions, 0},
                                .skip = {p->shadow_points.skip, 0}};
    const mlrt_light light = light_of_view(&subject->scene.view);
    const mlrt_array occluded = {p->occluded, 0, 0};
    memset(p->occluded, 0xFF, subject->pixel_count);
    int32_t status = mlrt_occluded_points(tree, &points, &light, options, &occluded);
    *hash = hash_bytes(p->occluded, subject->pixel_count);
    return status;
}

static int32_t check_hits(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options)
{
    struct check_result *check = &subject->results->check;
    uint64_t hash;
    int32_t status = find_hits(subject, tree, options, &hash);
    if (status != MLRT_OK) return status;
    check->hit_count++;
    check->difference_count += hash != check->hit_hash;
    return MLRT_OK;
}

static int32_t check_shadows(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options)
{
    struct check_result *check = &subject->results->check;
    uint64_t hash;
    int32_t status = find_shadows(subject, tree, options, &hash);
    if (status != MLRT_OK) return status;
    check->shadow_count++;
    check->difference_count += hash != check->shadow_hash;
    return MLRT_OK;
}

// Points just off the surface, on the side that the ray came from. A miss gets one that is nowhere, and never occluded.
static void place_shadow_points(const mlrt_tree *tree, const mlrt_tile *hits, const struct shadow_points *points)
{
    size_t count = (size_t)hits->width * hits->height;
    for (size_t i = 0; i < count; i++) {
        float *position = points->positions[i];
        points->skip[i][0] = hits->mesh[i], points->skip[i][1] = hits->triangle[i];
        int32_t status = MLRT_ERROR_ARGUMENT;
        if (hits->facing[i] != 0) {
            status = mlrt_offset_point(tree, hits->mesh[i], hits->triangle[i], hits->u[i], hits->v[i], -hits->facing[i],
                                       position);
        }
        if (status != MLRT_OK) position[0] = position[1] = position[2] = NAN;
    }
}

// The answers that all others are compared with: one ray at a time, in plain C.
static int find_reference(struct subject *subject)
{
    struct check_result *check = &subject->results->check;
    struct picture *p = &subject->picture;
    const mlrt_trace_options plain = {.struct_size = sizeof plain, .method = MLRT_METHOD_RAY, .pool = subject->pool};
    const mlrt_tile all = {.struct_size = sizeof all,
                           .width = subject->camera.width,
                           .height = subject->camera.height,
                           .u = p->u,
                           .v = p->v,
                           .mesh = p->mesh,
                           .triangle = p->triangle,
                           .facing = p->facing};
    if (!succeeded(find_hits(subject, subject->tree, &plain, &check->hit_hash))) return 1;
    place_shadow_points(subject->tree, &all, &p->shadow_points);
    return !succeeded(find_shadows(subject, subject->tree, &plain, &check->shadow_hash));
}

/* ---- counts and times ---------------------------------------------------------------------------------------- */

static void add_counters(const struct subject *subject, const mlrt_counters *counters, struct measured *measured)
{
    measured->cells += per_packet(subject, counters->cell_count);
    measured->entry_cells += per_packet(subject, counters->entry_point_cell_count);
    measured->tests += per_packet(subject, counters->triangle_test_count);
    measured->undecided += per_packet(subject, counters->undecided_cull_count);
    measured->still_undecided += per_packet(subject, counters->undecided_checked_count);
}

typedef int32_t (*checked_trace)(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options);

// Adds what a picture of hits or of shadows counts, by one thread.
static int count_picture(struct subject *subject, const mlrt_tree *tree, const mlrt_trace_options *options,
                         checked_trace trace, struct measured *measured)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_trace_options counting = *options;
    counting.counters = &counters;
    if (!succeeded(trace(subject, tree, &counting))) return 1;
    add_counters(subject, &counters, measured);
    return 0;
}

/* One of those whose times are compared. */
struct contender {
    const mlrt_tree *tree;
    mlrt_trace_options options;
    int shaded;
    double seconds; // the result
};

// A frame without colours stores which triangles were hit; one with them stores nothing else.
static int render_frame(struct subject *subject, const struct contender *contender)
{
    const mlrt_hits ids = {.struct_size = sizeof ids, .triangle = {subject->picture.triangle, 0, 0}};
    uint32_t *rgba = (uint32_t *)(void *)subject->picture.rgba;
    mlrt_trace_options options = contender->options;
    if (options.method < 0) {
        render_peer_frame(subject->peer, options.method == PEER_ROBUST, subject->picture.triangle,
                          contender->shaded ? rgba : NULL);
        return 0;
    }
    if (!contender->shaded)
        return !succeeded(mlrt_render_tiles(contender->tree, &subject->camera, &options, &ids, NULL, NULL));
    struct shade_job job = shade_job_of(subject->peer, rgba);
    options.outputs = MLRT_OUTPUT_TRIANGLE;
    return !succeeded(mlrt_render_tiles(contender->tree, &subject->camera, &options, NULL, shade_tile_of_ids, &job));
}

// The time that counts: of one thread its own.
static double clock_of(const struct contender *contender)
{
    return contender->options.pool ? seconds_now() : thread_seconds_now();
}

/*
 * Lets the contenders take turns, after a turn each that does not count. If all turns would take longer than
 * TURNS_LIMIT seconds by the first, there are fewer runs, but at least three.
 */
#define TURNS_LIMIT 15.0

static int time_frames(struct subject *subject, struct contender *contenders, size_t count)
{
    size_t run_count = subject->settings->runs;
    double *seconds = malloc(count * run_count * sizeof *seconds);
    const double begin = seconds_now();
    int failed = !seconds;
    if (failed) fprintf(stderr, "not enough memory for %zu times\n", count * run_count);
    for (size_t i = 0; i < count && !failed; i++) failed = render_frame(subject, &contenders[i]);
    while (run_count > 3 && (double)run_count * (seconds_now() - begin) > TURNS_LIMIT) run_count--;
    for (size_t turn = 0; turn < run_count * count && !failed; turn++) {
        const size_t run = turn / count, i = turn % count;
        const double start = clock_of(&contenders[i]);
        failed = render_frame(subject, &contenders[i]);
        seconds[i * run_count + run] = clock_of(&contenders[i]) - start;
    }
    for (size_t i = 0; i < count && !failed; i++) contenders[i].seconds = median(seconds + i * run_count, run_count);
    free(seconds);
    return failed;
}

/* ---- measuring, table by table ------------------------------------------------------------------------------- */

static int measure_quantities(struct subject *subject)
{
    double *quantities = subject->results->quantities;
    const struct {
        int32_t method;
        uint32_t shortcuts_off;
        checked_trace trace;
        int cells, entry_cells, tests; // -1 = none
    } pictures[] = {
        {MLRT_METHOD_MULTILEVEL, PAPER, check_hits, PRIMARY_CELLS, PRIMARY_ENTRY_CELLS, PRIMARY_TESTS},
        {MLRT_METHOD_MULTILEVEL, PAPER, check_shadows, SHADOW_CELLS, SHADOW_ENTRY_CELLS, SHADOW_TESTS},
        {MLRT_METHOD_PACKET4, PAPER, check_hits, PRIMARY_CELLS_FROM_ROOT, -1, PRIMARY_TESTS_FROM_ROOT},
        {MLRT_METHOD_PACKET4, PAPER, check_shadows, SHADOW_CELLS_FROM_ROOT, -1, SHADOW_TESTS_FROM_ROOT},
        {MLRT_METHOD_MULTILEVEL, ENTRY_LISTS_ONLY, check_hits, PRIMARY_CELLS_OF_LISTS, PRIMARY_ENTRY_CELLS_OF_LISTS,
         PRIMARY_TESTS_OF_LISTS},
        {MLRT_METHOD_MULTILEVEL, ENTRY_LISTS_ONLY, check_shadows, SHADOW_CELLS_OF_LISTS, SHADOW_ENTRY_CELLS_OF_LISTS,
         SHADOW_TESTS_OF_LISTS},
    };
    struct measured sum = {.cells = 0};
    for (size_t i = 0; i < LENGTH(pictures); i++) {
        mlrt_trace_options options = options_for(subject, pictures[i].method);
        options.shortcuts_off = pictures[i].shortcuts_off;
        // The shadows' numbers include those of the primary rays before them.
        if (pictures[i].trace == check_hits) memset(&sum, 0, sizeof sum);
        if (count_picture(subject, subject->tree, &options, pictures[i].trace, &sum)) return 1;
        quantities[pictures[i].cells] = sum.cells;
        quantities[pictures[i].tests] = sum.tests;
        if (pictures[i].entry_cells >= 0) quantities[pictures[i].entry_cells] = sum.entry_cells;
    }
    return 0;
}

// `tree` lacks some rule; the times are compared with the subject's, which has them all.
static int measure_tree(struct subject *subject, const mlrt_tree *tree, struct rule_result *result)
{
    const mlrt_trace_options multilevel = paper_options_for(subject, MLRT_METHOD_MULTILEVEL);
    const mlrt_trace_options from_root = paper_options_for(subject, MLRT_METHOD_PACKET4);
    struct contender contenders[] = {{tree, multilevel, 0, 0},
                                     {subject->tree, multilevel, 0, 0},
                                     {tree, from_root, 0, 0},
                                     {subject->tree, from_root, 0, 0}};
    mlrt_tree_info info = {.struct_size = sizeof info};
    must_succeed(mlrt_get_tree_info(tree, &info));
    result->sah_cost = info.sah_cost;
    result->node_count = info.node_count;
    if (count_picture(subject, tree, &multilevel, check_hits, &result->multilevel) ||
        count_picture(subject, tree, &from_root, check_hits, &result->from_root) ||
        time_frames(subject, contenders, LENGTH(contenders)))
        return 1;
    result->time_ratio = contenders[0].seconds / contenders[1].seconds;
    result->from_root_time_ratio = contenders[2].seconds / contenders[3].seconds;
    return 0;
}

static int measure_rules(struct subject *subject)
{
    for (size_t i = 0; i < LENGTH(rules); i++) {
        const struct tree_settings build = {.kind = presets[subject->preset].kind, .rules_off = rules[i].off};
        mlrt_tree *tree = NULL;
        double seconds;
        int failed = rules[i].off && build_tree(&subject->scene, &build, &tree, &seconds);
        failed = failed || measure_tree(subject, tree ? tree : subject->tree, &subject->results->rules[i]);
        mlrt_destroy_tree(tree);
        if (failed) return 1;
    }
    return 0;
}

static int measure_cullings(struct subject *subject)
{
    struct measured *measured = subject->results->cullings;
    struct contender contenders[LENGTH(cullings)] = {{.shaded = 0}};
    for (size_t i = 0; i < LENGTH(cullings); i++) {
        mlrt_trace_options *options = &contenders[i].options;
        contenders[i].tree = subject->tree;
        *options = paper_options_for(subject, MLRT_METHOD_MULTILEVEL);
        options->culling = cullings[i].culling;
        options->culling_check = cullings[i].check;
        if (count_picture(subject, subject->tree, options, check_hits, &measured[i])) return 1;
    }
    if (time_frames(subject, contenders, LENGTH(contenders))) return 1;
    for (size_t i = 0; i < LENGTH(cullings); i++) measured[i].seconds = contenders[i].seconds;
    return 0;
}

enum { SWEEP_LIMIT = LENGTH(split_factors) * LENGTH(initial_sizes) * LENGTH(minimum_sizes) };

static int measure_sweep(struct subject *subject)
{
    struct contender contenders[SWEEP_LIMIT] = {{.shaded = 0}};
    struct measured *measured[SWEEP_LIMIT];
    size_t count = 0;
    for (size_t i = 0; i < SWEEP_LIMIT; i++) {
        size_t minimum = i % LENGTH(minimum_sizes), rest = i / LENGTH(minimum_sizes);
        size_t initial = rest % LENGTH(initial_sizes), split = rest / LENGTH(initial_sizes);
        if (minimum_sizes[minimum] > initial_sizes[initial]) continue;
        mlrt_trace_options *options = &contenders[count].options;
        *options = paper_options_for(subject, MLRT_METHOD_MULTILEVEL);
        options->split_factor = split_factors[split];
        options->initial_tile_size = initial_sizes[initial];
        options->minimum_tile_size = minimum_sizes[minimum];
        contenders[count].tree = subject->tree;
        measured[count] = &subject->results->sweep[split][initial][minimum];
        if (count_picture(subject, subject->tree, options, check_hits, measured[count])) return 1;
        count++;
    }
    if (time_frames(subject, contenders, count)) return 1;
    for (size_t i = 0; i < count; i++) measured[i]->seconds = contenders[i].seconds;
    return 0;
}

// Embree takes part with one thread.
static int measure_methods(struct subject *subject)
{
    for (int column = 0; column < SHADING_COUNT * THREADING_COUNT; column++) {
        const int shading = column / THREADING_COUNT, threading = column % THREADING_COUNT;
        const size_t count = threading == ONE_THREAD && have_peer() ? LENGTH(methods) : FIRST_PEER;
        struct contender contenders[LENGTH(methods)];
        for (size_t i = 0; i < count; i++) {
            mlrt_trace_options options = options_for(subject, methods[i].method);
            options.shortcuts_off = methods[i].shortcuts_off;
            options.pool = threading == ALL_THREADS ? subject->pool : NULL;
            contenders[i] =
                (struct contender){i == TILE ? subject->boxes : subject->tree, options, shading == SHADED, 0};
        }
        if (time_frames(subject, contenders, count)) return 1;
        for (size_t i = 0; i < count; i++) {
            subject->results->frame_seconds[shading][threading][i] = contenders[i].seconds;
        }
    }
    return 0;
}

// By one thread and by all, hits and shadows. What this machine cannot do is left out.
static int check_setting(struct subject *subject, const mlrt_trace_options *setting)
{
    for (int threading = 0; threading < THREADING_COUNT; threading++) {
        mlrt_trace_options options = *setting;
        options.pool = threading == ALL_THREADS ? subject->pool : NULL;
        int32_t status = check_hits(subject, subject->tree, &options);
        if (status == MLRT_ERROR_UNSUPPORTED) return 0;
        if (status == MLRT_OK) status = check_shadows(subject, subject->tree, &options);
        if (!succeeded(status)) return 1;
    }
    return 0;
}

// Method tile from the camera and for points.
static int check_boxes(struct subject *subject)
{
    const mlrt_trace_options options = {.struct_size = sizeof options};
    return !succeeded(check_hits(subject, subject->boxes, &options)) ||
           !succeeded(check_shadows(subject, subject->boxes, &options));
}

static int check_answers(struct subject *subject)
{
    static const int32_t all_methods[] = {MLRT_METHOD_RAY, MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4,
                                          MLRT_METHOD_MULTILEVEL};
    for (size_t i = 0; i < LENGTH(all_methods) * LENGTH(isas); i++) {
        int32_t method = all_methods[i / LENGTH(isas)];
        size_t variation_count = method == MLRT_METHOD_MULTILEVEL ? LENGTH(variations) : 1;
        for (size_t k = 0; k < variation_count; k++) {
            mlrt_trace_options setting = variations[k];
            setting.struct_size = sizeof setting;
            setting.method = method;
            setting.isa = isas[i % LENGTH(isas)];
            if (check_setting(subject, &setting)) return 1;
        }
    }
    return check_boxes(subject);
}

static int describe_tree(struct subject *subject)
{
    mlrt_tree_info *info = &subject->results->trees[subject->preset];
    info->struct_size = sizeof *info;
    return !succeeded(mlrt_get_tree_info(subject->tree, info));
}

/* ---- Markdown ------------------------------------------------------------------------------------------------ */

// The head of a table from its column names, parted by |. All columns but the first hold numbers.
static void print_head(const char *columns)
{
    printf("\n| %s |\n| --- |", columns);
    for (const char *c = columns; *c; c++) {
        if (*c == '|') printf(" ---: |");
    }
    putchar('\n');
}

static void print_label(const char *label)
{
    printf("| %s |", label);
}

// NaN and infinity are left empty: there was nothing to measure or to divide by.
static void print_cell(int decimals, double value)
{
    if (isfinite(value))
        printf(" %.*f |", decimals, value);
    else
        printf("  |");
}

// A whole number, its digits in groups of three.
static void print_whole(uint64_t value)
{
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%" PRIu64, value);
    putchar(' ');
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0) putchar(',');
        putchar(digits[i]);
    }
    printf(" |");
}

static void print_title(const char *title, const struct results *results)
{
    printf("\n%s: %s", title, results->name);
    if (results->published) printf(" (the paper: %s)", results->published->title);
    putchar('\n');
}

/* ---- printing, table by table -------------------------------------------------------------------------------- */

static void print_paper_cell(const struct published *paper, int quantity, int divisor)
{
    double value = paper->quantities[quantity];
    if (divisor >= 0) value /= paper->quantities[divisor];
    print_cell(2, value != 0 ? value : NAN);
}

static void print_quantities(const struct settings *settings, const struct results *results, size_t count)
{
    static const struct {
        const char *label;
        int quantity, divisor; // -1 = none
    } rows[] = {
        {"primary: cells, multilevel", PRIMARY_CELLS, -1},
        {"primary: cells, from the root", PRIMARY_CELLS_FROM_ROOT, -1},
        {"primary: of the multilevel cells, entry-point search", PRIMARY_ENTRY_CELLS, -1},
        {"primary: unmasked triangle tests, multilevel", PRIMARY_TESTS, -1},
        {"primary: unmasked triangle tests, from the root", PRIMARY_TESTS_FROM_ROOT, -1},
        {"with shadows: cells, multilevel", SHADOW_CELLS, -1},
        {"with shadows: cells, from the root", SHADOW_CELLS_FROM_ROOT, -1},
        {"with shadows: of the multilevel cells, entry-point search", SHADOW_ENTRY_CELLS, -1},
        {"with shadows: unmasked triangle tests, multilevel", SHADOW_TESTS, -1},
        {"with shadows: unmasked triangle tests, from the root", SHADOW_TESTS_FROM_ROOT, -1},
        {"ratio: cells from the root / multilevel, primary", PRIMARY_CELLS_FROM_ROOT, PRIMARY_CELLS},
        {"ratio: cells from the root / multilevel, with shadows", SHADOW_CELLS_FROM_ROOT, SHADOW_CELLS},
        {"ratio: entry-point search / all multilevel cells, primary", PRIMARY_ENTRY_CELLS, PRIMARY_CELLS},
        {"entry lists, primary: cells", PRIMARY_CELLS_OF_LISTS, -1},
        {"entry lists, primary: of these, search", PRIMARY_ENTRY_CELLS_OF_LISTS, -1},
        {"entry lists, primary: unmasked triangle tests", PRIMARY_TESTS_OF_LISTS, -1},
        {"entry lists, with shadows: cells", SHADOW_CELLS_OF_LISTS, -1},
        {"entry lists, with shadows: unmasked triangle tests", SHADOW_TESTS_OF_LISTS, -1},
        {"ratio: cells from the root / entry lists, primary", PRIMARY_CELLS_FROM_ROOT, PRIMARY_CELLS_OF_LISTS},
        {"ratio: cells from the root / entry lists, with shadows", SHADOW_CELLS_FROM_ROOT, SHADOW_CELLS_OF_LISTS},
    };
    (void)settings;
    char columns[MAXIMUM_WORDS * 3 * NAME_SIZE] = "";
    size_t length = 0;
    for (size_t i = 0; i < count; i++) {
        const struct published *paper = results[i].published;
        if (paper) length += (size_t)snprintf(columns + length, sizeof columns - length, " | paper: %s", paper->title);
        length += (size_t)snprintf(columns + length, sizeof columns - length, " | %s", results[i].name);
    }
    print_head(columns);
    for (size_t row = 0; row < LENGTH(rows); row++) {
        int quantity = rows[row].quantity, divisor = rows[row].divisor;
        print_label(rows[row].label);
        for (size_t i = 0; i < count; i++) {
            const double *ours = results[i].quantities;
            if (results[i].published) print_paper_cell(results[i].published, quantity, divisor);
            print_cell(2, divisor >= 0 ? ours[quantity] / ours[divisor] : ours[quantity]);
        }
        putchar('\n');
    }
}

static void print_rules(const struct settings *settings, const struct results *results, size_t count)
{
    (void)settings;
    for (size_t i = 0; i < count; i++) {
        print_title("Rules", &results[i]);
        print_head("left out | cells, multilevel | cells, from the root | tests, multilevel | time, multilevel "
                   "| time, from the root | SAH cost | nodes");
        for (size_t k = 0; k < LENGTH(rules); k++) {
            const struct rule_result *rule = &results[i].rules[k];
            print_label(rules[k].title);
            print_cell(2, rule->multilevel.cells);
            print_cell(2, rule->from_root.cells);
            print_cell(2, rule->multilevel.tests);
            print_cell(2, rule->time_ratio);
            print_cell(2, rule->from_root_time_ratio);
            print_cell(1, rule->sah_cost);
            print_whole(rule->node_count);
            putchar('\n');
        }
    }
}

static void print_cullings(const struct settings *settings, const struct results *results, size_t count)
{
    (void)settings;
    for (size_t i = 0; i < count; i++) {
        print_title("Culling", &results[i]);
        print_head("test | entry-point cells | all cells | undecided | after the check | ms");
        for (size_t k = 0; k < LENGTH(cullings); k++) {
            const struct measured *measured = &results[i].cullings[k];
            print_label(cullings[k].title);
            print_cell(3, measured->entry_cells);
            print_cell(3, measured->cells);
            print_cell(3, measured->undecided);
            print_cell(3, cullings[k].check ? measured->still_undecided : NAN);
            print_cell(2, 1e3 * measured->seconds);
            putchar('\n');
        }
    }
}

struct sweep_bounds {
    double fewest_cells, fewest_entry_cells, fastest, slowest;
};

static struct sweep_bounds bounds_of_sweep(const struct results *results)
{
    const struct measured *all = &results->sweep[0][0][0];
    struct sweep_bounds bounds = {INFINITY, INFINITY, INFINITY, 0};
    for (size_t i = 0; i < SWEEP_LIMIT; i++) {
        if (all[i].seconds == 0) continue;
        bounds.fewest_cells = fmin(bounds.fewest_cells, all[i].cells);
        bounds.fewest_entry_cells = fmin(bounds.fewest_entry_cells, all[i].entry_cells);
        bounds.fastest = fmin(bounds.fastest, all[i].seconds);
        bounds.slowest = fmax(bounds.slowest, all[i].seconds);
    }
    return bounds;
}

static void print_marked(int decimals, double value, int marked)
{
    printf(marked ? " **%.*f**" : " %.*f", decimals, value);
}

static void print_sweep_cell(const struct measured *measured, const struct sweep_bounds *bounds)
{
    if (measured->seconds == 0) {
        print_cell(0, NAN);
        return;
    }
    print_marked(2, measured->cells, measured->cells == bounds->fewest_cells);
    printf(" /");
    print_marked(2, measured->entry_cells, measured->entry_cells == bounds->fewest_entry_cells);
    printf(" /");
    print_marked(1, 1e3 * measured->seconds, measured->seconds == bounds->fastest);
    printf(" |");
}

static void print_sweep(const struct settings *settings, const struct results *results, size_t count)
{
    (void)settings;
    for (size_t i = 0; i < count; i++) {
        const struct sweep_bounds bounds = bounds_of_sweep(&results[i]);
        print_title("Tile sizes", &results[i]);
        print_head("split factor, initial size | minimum 4 | 8 | 16 | 32 | 64");
        for (size_t row = 0; row < LENGTH(split_factors) * LENGTH(initial_sizes); row++) {
            size_t split = row / LENGTH(initial_sizes), initial = row % LENGTH(initial_sizes);
            printf("| SF %lu, ITS %lu |", (unsigned long)split_factors[split], (unsigned long)initial_sizes[initial]);
            for (size_t k = 0; k < LENGTH(minimum_sizes); k++) {
                print_sweep_cell(&results[i].sweep[split][initial][k], &bounds);
            }
            putchar('\n');
        }
        printf("\nThe slowest takes %.0f %% longer than the fastest.\n", 100 * (bounds.slowest / bounds.fastest - 1));
    }
}

// A row of table 5: what of a column's times, as frames per second or as a ratio, is up to `divisor` (-1: the former).
static void print_method_row(const struct results *results, const char *label, size_t method, int divisor)
{
    print_label(label);
    for (int column = 0; column < SHADING_COUNT * THREADING_COUNT; column++) {
        const double *seconds = results->frame_seconds[column / THREADING_COUNT][column % THREADING_COUNT];
        const int is_measured = seconds[method] > 0;
        print_cell(divisor < 0 ? 1 : 2, is_measured ? (divisor < 0 ? 1 : seconds[divisor]) / seconds[method] : NAN);
    }
    putchar('\n');
}

// How many times as fast method tile is as Embree, by one thread.
static void print_peer_ratio(const struct results *results, const char *label, size_t peer)
{
    print_label(label);
    for (int shading = 0; shading < SHADING_COUNT; shading++) {
        const double *seconds = results->frame_seconds[shading][ONE_THREAD];
        print_cell(2, seconds[peer] / seconds[TILE]);
        print_cell(2, NAN);
    }
    putchar('\n');
}

static void print_published_methods(const struct published *paper)
{
    if (!paper || paper->open_rt[PLAIN] == 0) return;
    print_label("the paper's OpenRT, 2.5 GHz Pentium 4, 1 thread");
    for (int shading = 0; shading < SHADING_COUNT; shading++) {
        print_cell(1, paper->open_rt[shading]);
        print_cell(1, NAN);
    }
    printf("\n| the paper's MLRTA, Pentium 4, 1 thread 2.4 GHz, 2 hyper-threads 3.2 GHz |");
    for (int shading = 0; shading < SHADING_COUNT; shading++) {
        for (int threading = 0; threading < THREADING_COUNT; threading++) {
            print_cell(1, paper->multilevel[shading][threading]);
        }
    }
    putchar('\n');
}

static void print_methods(const struct settings *settings, const struct results *results, size_t count)
{
    char columns[256], label[128];
    unsigned long threads = settings->threads;
    snprintf(columns, sizeof columns,
             "method | no shader, 1 thread | no shader, %lu threads | shader, 1 thread | shader, %lu threads", threads,
             threads);
    for (size_t i = 0; i < count; i++) {
        print_title("Frames per second", &results[i]);
        print_head(columns);
        for (size_t k = 0; k < LENGTH(methods); k++) print_method_row(&results[i], methods[k].title, k, -1);
        for (size_t k = FIRST_MULTILEVEL; k <= TILE; k++) {
            for (int divisor = PACKET4; divisor >= PACKET2; divisor--) {
                snprintf(label, sizeof label, "ratio: %s / %s", methods[k].title, methods[divisor].title);
                print_method_row(&results[i], label, k, divisor);
            }
        }
        if (have_peer()) {
            for (size_t k = FIRST_PEER; k < LENGTH(methods); k++) {
                snprintf(label, sizeof label, "ratio: tile / %s", methods[k].title);
                print_peer_ratio(&results[i], label, k);
            }
        }
        print_published_methods(results[i].published);
    }
}

static void print_check(const struct settings *settings, const struct results *results, size_t count)
{
    uint64_t differences = 0;
    (void)settings;
    print_head("scene | pictures of hits | pictures of shadows | different | hash of hits | hash of shadows");
    for (size_t i = 0; i < count; i++) {
        const struct check_result *check = &results[i].check;
        print_label(results[i].name);
        print_whole(check->hit_count);
        print_whole(check->shadow_count);
        print_whole(check->difference_count);
        printf(" `%016" PRIx64 "` | `%016" PRIx64 "` |\n", check->hit_hash, check->shadow_hash);
        differences += check->difference_count;
    }
    printf("\ndifferences: %" PRIu64 "\n", differences);
}

static void print_builds(const struct settings *settings, const struct results *results, size_t count)
{
    (void)settings;
    print_head("scene, tree | triangles | seconds | nodes | leaves | empty leaves | references | depth | SAH cost "
               "| bytes per triangle | peak bytes per triangle | peak bytes");
    for (size_t i = 0; i < count * LENGTH(presets); i++) {
        const struct results *scene = &results[i / LENGTH(presets)];
        size_t preset = i % LENGTH(presets);
        const mlrt_tree_info *info = &scene->trees[preset];
        double triangles = (double)info->triangle_count;
        printf("| %s, %s |", scene->name, presets[preset].title);
        print_whole(info->triangle_count);
        print_cell(3, scene->build_seconds[preset]);
        print_whole(info->node_count);
        print_whole(info->leaf_count);
        print_whole(info->empty_leaf_count);
        print_whole(info->reference_count);
        print_whole(info->depth);
        print_cell(1, info->sah_cost);
        print_cell(1, (double)info->memory_size / triangles);
        print_cell(1, (double)info->peak_memory_size / triangles);
        print_whole(info->peak_memory_size);
        putchar('\n');
    }
}

/* ---- all tables ---------------------------------------------------------------------------------------------- */

enum { ON_DEFAULT_TREE = 1 << 0, ON_PAPER_TREE = 1 << 1 }; // a bit for each of `presets`

static const struct table {
    const char *title, *text;
    unsigned trees; // ON_*: those it is measured on
    int (*measure)(struct subject *subject);
    void (*print)(const struct settings *settings, const struct results *results, size_t count);
} tables[] = {
    {"Cells and tests per 4x4 packet",
     "The paper's table 2, with its kind of tree (preset `paper`). Multilevel: the paper's algorithm, from one entry "
     "point per tile; entry lists: from the list of leaves that a tile's beam reaches; from the root: method "
     "`packet4`. "
     "Sums over the picture, divided by its 4x4 packets; with shadows, they are those of the primary rays and of a "
     "shadow ray from the light to each of their hits. Every node that is descended into, popped or, in a list, looked "
     "at is a cell.",
     ON_PAPER_TREE, measure_quantities, print_quantities},
    {"Rules of the tree",
     "Each rule of preset `paper` left out. Cells and tests are per 4x4 packet, of primary rays by the paper's "
     "algorithm; "
     "times are relative to the tree with all rules, of one thread without shader.",
     ON_PAPER_TREE, measure_rules, print_rules},
    {"Inverse and direct culling",
     "Per 4x4 packet, primary rays, preset `paper`, the paper's algorithm. Undecided: inner nodes where the culling "
     "test "
     "could "
     "exclude no child. Times are of one thread without shader.",
     ON_PAPER_TREE, measure_cullings, print_cullings},
    {"Tile sizes",
     "Each entry: all cells / entry-point cells / milliseconds. Cells are per 4x4 packet, primary rays, preset "
     "`paper`, the paper's algorithm; times are of one thread without shader. ITS: initial tile size, SF: split "
     "factor. The best of "
     "each "
     "is bold.",
     ON_PAPER_TREE, measure_sweep, print_sweep},
    {"Frames per second",
     "The paper's table 1. The tree is the kd-tree of preset `tuned`; method tile goes through the boxes of "
     "mlrt_build_tree, with the widest instruction set, and Embree through its own hierarchy, in its fastest way. The "
     "shader is a dot product with the "
     "triangle's normal, "
     "stored as 8-bit RGBA; without it, the numbers of the triangles hit are stored.",
     ON_DEFAULT_TREE, measure_methods, print_methods},
    {"Same answers",
     "Pictures compared with those of method `ray` in plain C, by a hash over ids and the bits of t, u and v of all "
     "hits, and over the answers of all shadow rays: each method, instruction set, one thread and several, several "
     "tile "
     "sizes and culling tests, and what was counted for other tables, on the trees of both presets; and method tile.",
     ON_DEFAULT_TREE | ON_PAPER_TREE, check_answers, print_check},
    {"Building", "Processor time of one thread. The kd-tree of each scene is built once with each preset.",
     ON_DEFAULT_TREE | ON_PAPER_TREE, describe_tree, print_builds},
};

static int is_wanted(const struct settings *settings, size_t table)
{
    return settings->tables >> table & 1;
}

// A size of the command line, after what it is.
static void print_setting(const char *name, uint32_t value)
{
    if (value)
        printf("%s %lu", name, (unsigned long)value);
    else
        printf("%s default", name);
}

static void print_introduction(const struct settings *settings)
{
    unsigned long size = settings->size;
    printf("Pictures have %lu x %lu pixels; times are medians of %lu runs that take turns. ", size, size,
           (unsigned long)settings->runs);
    print_setting("Tile sizes where nothing else is said: initial", settings->tiles.initial_tile_size);
    print_setting(", minimum", settings->tiles.minimum_tile_size);
    print_setting(", split factor", settings->tiles.split_factor);
    printf(
        ". \"The paper\" is A. Reshetov, A. Soupikov, J. Hurley, \"Multi-Level Ray Tracing Algorithm\", SIGGRAPH 2005: "
        "its tables 1 and 2.\n");
}

static void print_tables(const struct settings *settings, const struct results *results, size_t count)
{
    print_introduction(settings);
    for (size_t i = 0; i < LENGTH(tables); i++) {
        if (!is_wanted(settings, i)) continue;
        printf("\n## %zu. %s\n\n%s\n", i + 1, tables[i].title, tables[i].text);
        tables[i].print(settings, results, count);
    }
}

/* ---- from the start to the end ------------------------------------------------------------------------------- */

static int measure_preset(struct subject *subject, size_t preset)
{
    const char *name = subject->results->name;
    const struct tree_settings build = {.kind = presets[preset].kind};
    double seconds;
    show_work("%s: building a tree ...", name);
    subject->preset = preset;
    const double start = thread_seconds_now();
    if (build_tree(&subject->scene, &build, &subject->tree, &seconds)) return 1;
    subject->results->build_seconds[preset] = thread_seconds_now() - start;
    if (subject->results->check.hit_hash == 0 && find_reference(subject)) return 1; // 0: not found yet
    for (size_t i = 0; i < LENGTH(tables); i++) {
        if (!is_wanted(subject->settings, i) || !(tables[i].trees >> preset & 1)) continue;
        show_work("%s: %s ...", name, tables[i].title);
        if (tables[i].measure(subject)) return 1;
    }
    return 0;
}

static unsigned trees_needed(const struct settings *settings)
{
    unsigned trees = 0;
    for (size_t i = 0; i < LENGTH(tables); i++) trees |= is_wanted(settings, i) ? tables[i].trees : 0;
    return trees;
}

// A word of the list as a path, and the scene's name: of a file, without folder and extension.
static int name_scene(const char *word, char path[PATH_SIZE], char name[NAME_SIZE])
{
    size_t length = strcspn(word, ",");
    int fits = snprintf(path, PATH_SIZE, "%.*s", (int)length, word) < PATH_SIZE;
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    fits = fits && snprintf(name, NAME_SIZE, "%.*s", dot ? (int)(dot - base) : PATH_SIZE, base) < NAME_SIZE;
    if (!fits) fprintf(stderr, "%s: the name is too long\n", path);
    return !fits;
}

static int load_subject(struct subject *subject, const char *word)
{
    const struct settings *settings = subject->settings;
    char path[PATH_SIZE], specification[2 * PATH_SIZE], *name = subject->results->name;
    if (name_scene(word, path, name)) return 1;
    show_work("%s: loading ...", name);
    if (load_scene(path, &subject->scene)) return 1;
    if (!settings->views) look_from_inside(&subject->scene);
    snprintf(specification, sizeof specification, "%.*s:%s/view1", PATH_SIZE, settings->views ? settings->views : "",
             name);
    if (subject->scene.is_imported && settings->views && read_view(specification, &subject->scene.view)) return 1;
    subject->results->published = find_published(name);
    subject->pixel_count = (size_t)settings->size * settings->size;
    return camera_of_view(&subject->scene.view, settings->size, settings->size, &subject->camera) ||
           allocate_picture(&subject->picture, subject->pixel_count);
}

static int measure_scene(const struct settings *settings, mlrt_pool *pool, const char *word, struct results *results)
{
    static struct subject subject;
    memset(&subject, 0, sizeof subject);
    subject.settings = settings;
    subject.pool = pool;
    subject.results = results;
    int failed = load_subject(&subject, word);
    const double start = seconds_now();
    const struct tree_settings boxes = {.kind = TREE_DEFAULT};
    double seconds;
    failed = failed || build_tree(&subject.scene, &boxes, &subject.boxes, &seconds);
    if (!failed) subject.peer = open_peer_frame(&subject.scene, &subject.camera);
    failed = failed || !subject.peer;
    for (size_t preset = 0; preset < LENGTH(presets) && !failed; preset++) {
        if (!(trees_needed(settings) >> preset & 1)) continue;
        failed = measure_preset(&subject, preset);
        mlrt_destroy_tree(subject.tree);
        subject.tree = NULL;
    }
    clear_work();
    tell("%s: measured for %.1f s", results->name, seconds_now() - start);
    close_peer_frame(subject.peer);
    mlrt_destroy_tree(subject.boxes);
    free_picture(&subject.picture);
    free_scene(&subject.scene);
    return failed;
}

// What was measured before a failure is printed all the same.
static int measure_scenes(const struct settings *settings, mlrt_pool *pool)
{
    size_t count = 0;
    int failed = 0;
    struct results *results = calloc(settings->scenes.count, sizeof *results);
    if (!results) fprintf(stderr, "not enough memory for the results of %zu scenes\n", settings->scenes.count);
    while (results && count < settings->scenes.count && !failed) {
        failed = measure_scene(settings, pool, settings->scenes.words[count], &results[count]);
        count += !failed;
    }
    if (count > 0) print_tables(settings, results, count);
    uint64_t differences = 0;
    for (size_t i = 0; i < count; i++) differences += results[i].check.difference_count;
    if (differences) fprintf(stderr, "%" PRIu64 " pictures differ from those of method ray\n", differences);
    failed |= !results || differences > 0;
    free(results);
    return failed;
}

static int read_settings(struct settings *s, int argc, char **argv, int *exit_code)
{
    static const struct word_list procedural = {4, {"room", "office", "building", "scan"}};
    const struct option options[] = {
        {OPTION_LIST, "--scene", &s->scenes, "NAME|FILE,...",
         "room, office, building, doubled, scan, scan:N (about N triangles), or mesh files\n(default: "
         "room,office,building,scan)",
         0, 0},
        {OPTION_TEXT, "--views", &s->views, "FILE.json", "views of mesh files: view1 of the scene named like the file",
         0, 0},
        {OPTION_COUNT, "--size", &s->size, "N", "pixels along each side, a multiple of 64 (default: 1024)", 64, 8192},
        {OPTION_SET, "--only", &s->tables, "1,2,3,4,5,6,7", "the tables to make, a list (default: all)", 0, 0},
        {OPTION_COUNT, "--runs", &s->runs, "N", "times are medians of this many runs (default: 5)", 1, 1000},
        {OPTION_COUNT, "--threads", &s->threads, "N", "threads of what is not measured with one (default: 2)", 1, 1024},
        {OPTION_HEADING, 0, 0, 0, "Tile sizes, where they are not what is varied:", 0, 0},
        {OPTION_POWER_OF_TWO, "--its", &s->tiles.initial_tile_size, "N", "initial tile size in pixels, a power of two",
         4, 1024},
        {OPTION_POWER_OF_TWO, "--mts", &s->tiles.minimum_tile_size, "N", "minimum tile size in pixels, a power of two",
         4, 1024},
        {OPTION_COUNT, "--sf", &s->tiles.split_factor, "4|16", "split factor: pieces that a tile is cut into", 4, 16},
    };
    if (!parse_options("reproduce - the paper's measurements, as Markdown tables", options, LENGTH(options), argc, argv,
                       exit_code))
        return 0;
    if (s->scenes.count == 0) s->scenes = procedural;
    const char *mistake = NULL;
    if (s->tiles.split_factor && s->tiles.split_factor != 4 && s->tiles.split_factor != 16)
        mistake = "--sf: either 4 or 16";
    if (s->tiles.initial_tile_size && s->tiles.minimum_tile_size > s->tiles.initial_tile_size)
        mistake = "--mts: larger than --its";
    if (s->size % 64) mistake = "--size: a multiple of 64, so that tiles are whole";
    if (mistake) fprintf(stderr, "%s\n", mistake);
    *exit_code = 2;
    return !mistake;
}

int main(int argc, char **argv)
{
    struct settings settings = {.size = 1024, .runs = 5, .threads = 2, .tables = (1u << LENGTH(tables)) - 1};
    int exit_code;
    if (!read_settings(&settings, argc, argv, &exit_code)) return exit_code;
    setvbuf(stdout, NULL, _IOLBF, 0);
    mlrt_pool *pool;
    if (has_failed(mlrt_create_pool(settings.threads, &pool), "start threads")) return 1;
    int failed = measure_scenes(&settings, pool);
    mlrt_destroy_pool(pool);
    return end_output(failed);
}
