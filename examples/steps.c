/* SPDX-License-Identifier: MIT */
/*
 * steps.c - what the parts of the paper's method cost: a step down the tree, a test, a beam, a start below the root
 *
 *     steps --study forms                 times of a picture by each form of the method, on two instruction sets
 *     steps --study views                 the same from random places in the scene: how far the official view is usual
 *     steps --study parts                 the cost of each part in cycles
 *
 * Pictures store the numbers of the triangles hit. Forms take turns; a time is the median of processor times of one
 * thread. What is counted is counted once, apart from the times. Each line is printed when it is known.
 *
 * Parts: a packet alone is measured by a picture that looks away from the scene. From random places, with tiles of
 * several sizes, the numbers of steps, tests and beams of a picture vary more or less alone. Their costs are those
 * which predict all the times best: least squares of the relative errors, and none below 0. A cycle is half the time of
 * two additions that wait for each other.
 *
 * Exit codes: 0, 1 if something failed, 2 for a mistake on the command line.
 */
#include "common/must.h"
#include "common/options.h"
#include "common/report.h"
#include "common/scene.h"
#include "common/steady_math.h"
#include "common/timer.h"
#include "common/tree.h"
#include "common/view.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

enum { MAXIMUM_RUNS = 101, MAXIMUM_VIEWS = 1000, MAXIMUM_FORMS = 12 };

struct settings {
    struct word_list scenes;
    const char *views;
    uint32_t size, runs, view_count;
    int32_t study;
};

/* ---- pictures ------------------------------------------------------------------------------------------------ */

struct subject {
    const struct settings *settings;
    char name[SCENE_NAME_SIZE];
    struct scene scene;
    mlrt_tree *tree; // a kd-tree of preset `paper`
    uint32_t *triangles;
};

/* A way to trace: a method and what it does without. */
struct form {
    const char *name;
    int32_t method;
    uint32_t shortcuts_off, initial_size, minimum_size; // sizes 0: the default
    int32_t isa;
};

enum { PAPER = MLRT_SHORTCUT_WHOLE_TILES | MLRT_SHORTCUT_ENTRY_LISTS };

static double picture(const struct subject *subject, const mlrt_camera *camera, const struct form *form,
                      mlrt_counters *counters)
{
    const mlrt_trace_options options = {.struct_size = sizeof options,
                                        .method = form->method,
                                        .isa = form->isa,
                                        .shortcuts_off = form->shortcuts_off,
                                        .initial_tile_size = form->initial_size,
                                        .minimum_tile_size = form->minimum_size,
                                        .counters = counters};
    const mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {subject->triangles, 0, 0}};
    const double start = thread_seconds_now();
    must_succeed(mlrt_render_tiles(subject->tree, camera, &options, &hits, NULL, NULL));
    return thread_seconds_now() - start;
}

struct result {
    double seconds;
    mlrt_counters counters;
};

static void measure(const struct subject *subject, const mlrt_camera *camera, const struct form *forms, size_t count,
                    struct result *results)
{
    static double times[MAXIMUM_FORMS][MAXIMUM_RUNS];
    const uint32_t runs = subject->settings->runs;
    for (size_t i = 0; i < count; i++) {
        results[i].counters = (mlrt_counters){.struct_size = sizeof(mlrt_counters)};
        picture(subject, camera, &forms[i], &results[i].counters);
    }
    for (uint32_t run = 0; run < runs; run++) {
        for (size_t i = 0; i < count; i++) times[i][run] = picture(subject, camera, &forms[i], NULL);
    }
    for (size_t i = 0; i < count; i++) results[i].seconds = median(times[i], runs);
}

static mlrt_camera official_camera(const struct subject *subject)
{
    mlrt_camera camera;
    const uint32_t size = subject->settings->size;
    if (camera_of_view(&subject->scene.view, size, size, &camera)) exit(1);
    return camera;
}

// From a point of the inner four fifths of the scene's box to any point of it.
static mlrt_camera random_camera(const struct subject *subject, uint32_t *state)
{
    float lo[3], hi[3];
    struct view view = subject->scene.view;
    mlrt_camera camera;
    const uint32_t size = subject->settings->size;
    scene_bounds(&subject->scene, lo, hi);
    for (int k = 0; k < 3; k++) {
        const double extent = (double)hi[k] - (double)lo[k];
        view.eye[k] = (double)lo[k] + extent * random_between(state, 0.1, 0.9);
        view.look[k] = (double)lo[k] + extent * random_between(state, 0, 1);
    }
    if (camera_of_view(&view, size, size, &camera)) exit(1);
    return camera;
}

static double per_packet(const struct subject *subject, uint64_t count)
{
    const double side = subject->settings->size / 4;
    return (double)count / (side * side);
}

/* ---- forms --------------------------------------------------------------------------------------------------- */

static const struct form all_forms[] = {
    {.name = "2x2 packets from the root", .method = MLRT_METHOD_PACKET2},
    {.name = "4x4 packets from the root", .method = MLRT_METHOD_PACKET4},
    {.name = "4x4 packets, each sets up its triangles",
     .method = MLRT_METHOD_PACKET4,
     .shortcuts_off = MLRT_SHORTCUT_SHARED_SETUPS},
    {.name = "the paper's: one entry point per tile", .method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = PAPER},
    {.name = "entry lists", .method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = MLRT_SHORTCUT_WHOLE_TILES},
    {.name = "all shortcuts", .method = MLRT_METHOD_MULTILEVEL},
};

static void study_forms(const struct subject *subject)
{
    static const struct {
        const char *name;
        int32_t isa;
        uint64_t capability;
    } isas[] = {{"SSE2", MLRT_ISA_SSE, MLRT_CAN_SSE}, {"AVX2", MLRT_ISA_AVX2, MLRT_CAN_AVX2}};
    enum { FORM_COUNT = LENGTH(all_forms), COUNT = LENGTH(isas) * FORM_COUNT };
    const mlrt_camera camera = official_camera(subject);
    struct form forms[COUNT];
    struct result results[COUNT];
    size_t count = 0; // this machine may have none of them, or the first alone
    while (count < COUNT && mlrt_capabilities() & isas[count / FORM_COUNT].capability) {
        forms[count] = all_forms[count % FORM_COUNT];
        forms[count].isa = isas[count / FORM_COUNT].isa;
        count++;
    }
    measure(subject, &camera, forms, count, results);
    for (size_t i = 0; i < count; i++) {
        const mlrt_counters *c = &results[i].counters;
        printf("%s,%s,\"%s\",%.2f,%.3f,%.3f,%.3f\n", subject->name, isas[i / FORM_COUNT].name, forms[i].name,
               1e3 * results[i].seconds, per_packet(subject, c->cell_count),
               per_packet(subject, c->entry_point_cell_count), per_packet(subject, c->triangle_test_count));
    }
}

/* ---- views --------------------------------------------------------------------------------------------------- */

static void study_views(const struct subject *subject)
{
    static const struct form forms[] = {
        {.method = MLRT_METHOD_PACKET2},
        {.method = MLRT_METHOD_PACKET4},
        {.method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = PAPER},
        {.method = MLRT_METHOD_MULTILEVEL},
    };
    uint32_t state = 1;
    for (uint32_t view = 0; view < subject->settings->view_count; view++) {
        const mlrt_camera camera = random_camera(subject, &state);
        struct result results[LENGTH(forms)];
        measure(subject, &camera, forms, LENGTH(forms), results);
        printf("%s,%" PRIu32, subject->name, view + 1);
        for (size_t i = 0; i < LENGTH(forms); i++) printf(",%.3f", 1e3 * results[i].seconds);
        for (size_t i = 1; i < LENGTH(forms); i++) {
            printf(",%.3f", per_packet(subject, results[i].counters.cell_count));
        }
        putchar('\n');
    }
}

/* ---- parts --------------------------------------------------------------------------------------------------- */

enum { PACKETS, STARTS, STEPS, TESTS, BEAMS, SEARCH_STEPS, PART_COUNT };

static const char *const parts[PART_COUNT] = {
    [PACKETS] = "a packet: rays made, bounded, written",
    [STARTS] = "its start below the root",
    [STEPS] = "a step of a packet",
    [TESTS] = "a test of a packet and a triangle",
    [BEAMS] = "a beam",
    [SEARCH_STEPS] = "a step of a beam's search",
};

/* A picture: how often each part comes in it, and how long it took. */
struct observation {
    double counts[PART_COUNT], seconds;
};

static const struct form fitted_forms[] = {
    {.method = MLRT_METHOD_PACKET4},
    {.method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = PAPER},
    {.method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = PAPER, .initial_size = 128, .minimum_size = 8},
    {.method = MLRT_METHOD_MULTILEVEL, .shortcuts_off = PAPER, .initial_size = 128, .minimum_size = 4},
};

static struct observation observe(const struct form *form, const struct result *result)
{
    const mlrt_counters *c = &result->counters;
    const double packets = (double)c->packet_count;
    return (struct observation){.counts = {[PACKETS] = packets,
                                           [STARTS] = form->method == MLRT_METHOD_MULTILEVEL ? packets : 0,
                                           [STEPS] = (double)(c->cell_count - c->entry_point_cell_count),
                                           [TESTS] = (double)c->triangle_test_count,
                                           [BEAMS] = (double)c->beam_count,
                                           [SEARCH_STEPS] = (double)c->entry_point_cell_count},
                                .seconds = result->seconds};
}

// Solves the equations of the parts that are in use, by elimination with pivots; the others cost nothing.
static void solve(double equations[PART_COUNT][PART_COUNT + 1], const int *used, double costs[PART_COUNT])
{
    for (int i = 0; i < PART_COUNT; i++) {
        if (used[i]) continue;
        for (int k = 0; k <= PART_COUNT; k++) equations[i][k] = 0;
        for (int k = 0; k < PART_COUNT; k++) equations[k][i] = 0;
        equations[i][i] = 1;
    }
    for (int i = 0; i < PART_COUNT; i++) { // positive definite: the diagonal serves as pivot
        for (int row = 0; row < PART_COUNT; row++) {
            const double factor = row == i ? 0 : equations[row][i] / equations[i][i];
            for (int k = 0; k <= PART_COUNT; k++) equations[row][k] -= factor * equations[i][k];
        }
    }
    for (int i = 0; i < PART_COUNT; i++) costs[i] = equations[i][PART_COUNT] / equations[i][i];
}

// Least squares of relative errors; the cost of packets is known. A part whose cost would be negative is taken out, the
// most negative first.
static void fit(const struct observation *observations, size_t count, double packet_seconds, double costs[PART_COUNT])
{
    int used[PART_COUNT] = {[STARTS] = 1, [STEPS] = 1, [TESTS] = 1, [BEAMS] = 1, [SEARCH_STEPS] = 1}, worst;
    do {
        double equations[PART_COUNT][PART_COUNT + 1] = {{0}};
        for (size_t n = 0; n < count; n++) {
            const struct observation *o = &observations[n];
            const double rest = 1 - o->counts[PACKETS] * packet_seconds / o->seconds;
            for (int i = 0; i < PART_COUNT; i++) {
                for (int k = 0; k < PART_COUNT; k++)
                    equations[i][k] += o->counts[i] / o->seconds * (o->counts[k] / o->seconds);
                equations[i][PART_COUNT] += rest * o->counts[i] / o->seconds;
            }
        }
        solve(equations, used, costs);
        worst = 0;
        for (int i = 1; i < PART_COUNT; i++) worst = costs[i] < costs[worst] ? i : worst;
        used[worst] = costs[worst] >= 0;
    } while (costs[worst] < 0);
    costs[PACKETS] = packet_seconds;
}

static double predict(const struct observation *observation, const double costs[PART_COUNT])
{
    double seconds = 0;
    for (int i = 0; i < PART_COUNT; i++) seconds += observation->counts[i] * costs[i];
    return seconds;
}

// How long a cycle takes: x ^ k and + k take one each, and wait for each other.
static double seconds_of_cycle(void)
{
    static volatile uint64_t any = 0x9E3779B97F4A7C15;
    enum { ROUNDS = 10000000 };
    double least = 1;
    for (int run = 0; run < 9; run++) {
        const uint64_t k = any;
        uint64_t x = any >> 1;
        const double start = thread_seconds_now();
        for (int i = 0; i < ROUNDS; i++) x = (x ^ k) + k;
        const double seconds = thread_seconds_now() - start;
        any = x | 1;
        least = seconds < least ? seconds : least;
    }
    return least / (2 * ROUNDS);
}

// Of a packet that meets nothing: the camera stands outside and looks away.
static double seconds_of_packet(const struct subject *subject)
{
    const struct form from_root = {.method = MLRT_METHOD_PACKET4};
    struct subject outside = *subject;
    struct result result;
    float lo[3], hi[3];
    scene_bounds(&subject->scene, lo, hi);
    for (int k = 0; k < 3; k++) {
        const double extent = (double)hi[k] - (double)lo[k];
        outside.scene.view.eye[k] = (double)hi[k] + extent + 1;
        outside.scene.view.look[k] = outside.scene.view.eye[k] + 1 + 0.1 * k;
    }
    const mlrt_camera camera = official_camera(&outside);
    measure(&outside, &camera, &from_root, 1, &result);
    return result.seconds / (double)result.counters.packet_count;
}

static void study_parts(const struct subject *subject)
{
    static struct observation observations[MAXIMUM_VIEWS * LENGTH(fitted_forms)];
    static double errors[LENGTH(observations)];
    struct result results[LENGTH(fitted_forms)];
    size_t count = 0;
    uint32_t state = 1;
    for (uint32_t view = 0; view <= subject->settings->view_count; view++) { // the first is the official one
        const mlrt_camera camera = view ? random_camera(subject, &state) : official_camera(subject);
        measure(subject, &camera, fitted_forms, LENGTH(fitted_forms), results);
        for (size_t i = 0; i < LENGTH(fitted_forms); i++)
            observations[count++] = observe(&fitted_forms[i], &results[i]);
    }
    double costs[PART_COUNT];
    const double cycle = seconds_of_cycle(), *root = observations[0].counts, *paper = observations[1].counts;
    fit(observations, count, seconds_of_packet(subject), costs);
    for (size_t n = 0; n < count; n++) errors[n] = fabs(predict(&observations[n], costs) / observations[n].seconds - 1);
    const double packets = (double)subject->settings->size * subject->settings->size / 16;
    for (int i = 0; i < PART_COUNT; i++) {
        printf("%s,\"%s\",%.1f,%.2f,%.4f,%.1f,%.4f,%.1f,%.1f\n", subject->name, parts[i], costs[i] / cycle,
               1e9 * costs[i], root[i] / packets, root[i] * costs[i] / packets / cycle, paper[i] / packets,
               paper[i] * costs[i] / packets / cycle, 100 * median(errors, count));
    }
    printf("%s,\"all, as measured\",,,,%.1f,,%.1f,\n", subject->name, observations[0].seconds / packets / cycle,
           observations[1].seconds / packets / cycle);
}

/* ---- from the start to the end ------------------------------------------------------------------------------- */

static const struct {
    const char *head;
    void (*run)(const struct subject *subject);
} studies[] = {
    {"scene,isa,form,ms,cells,search_cells,tests", study_forms},
    {"scene,view,packet2_ms,packet4_ms,paper_ms,shortcuts_ms,packet4_cells,paper_cells,shortcuts_cells", study_views},
    {"scene,part,cycles,ns,root_count,root_cycles,paper_count,paper_cycles,median_error_percent", study_parts},
};

static int study_scene(const struct settings *settings, const char *word)
{
    struct subject subject = {.settings = settings};
    const struct tree_settings build = {.kind = TREE_KDTREE};
    double seconds;
    int failed = load_scene_and_view(word, settings->views, subject.name, &subject.scene) ||
                 build_tree(&subject.scene, &build, &subject.tree, &seconds);
    subject.triangles = must_allocate((size_t)settings->size * settings->size, sizeof *subject.triangles);
    if (!failed) studies[settings->study].run(&subject);
    free(subject.triangles);
    mlrt_destroy_tree(subject.tree);
    free_scene(&subject.scene);
    return failed;
}

int main(int argc, char **argv)
{
    struct settings settings = {.size = 1024, .runs = 3, .view_count = 40};
    const struct option options[] = {
        {OPTION_LIST, "--scene", &settings.scenes, "NAME|FILE,...", "scenes (default: room,office)", 0, 0},
        {OPTION_TEXT, "--views", &settings.views, "FILE.json", "views of scenes that are files", 0, 0},
        {OPTION_CHOICE, "--study", &settings.study, "forms|views|parts",
         "times of each form of the method; the same from random places;\nthe cost of each part (default: forms)", 0,
         0},
        {OPTION_COUNT, "--size", &settings.size, "N", "pixels per side, a multiple of 64 (default: 1024)", 64, 8192},
        {OPTION_COUNT, "--runs", &settings.runs, "N", "runs of each (default: 3)", 1, MAXIMUM_RUNS},
        {OPTION_COUNT, "--places", &settings.view_count, "N", "random places (default: 40)", 1, MAXIMUM_VIEWS - 1},
    };
    int exit_code, failed = 0;
    if (!parse_options("steps - what the parts of the paper's method cost, as CSV", options, LENGTH(options), argc,
                       argv, &exit_code))
        return exit_code;
    if (settings.size % 64) {
        fprintf(stderr, "--size: a multiple of 64, so that tiles are whole\n");
        return 2;
    }
    if (settings.scenes.count == 0) settings.scenes = (struct word_list){2, {"room", "office"}};
    setvbuf(stdout, NULL, _IOLBF, 0);
    puts(studies[settings.study].head);
    for (size_t i = 0; i < settings.scenes.count && !failed; i++) {
        failed = study_scene(&settings, settings.scenes.words[i]);
    }
    return end_output(failed);
}
