/* SPDX-License-Identifier: MIT */
/*
 * accuracy.c - speed and wrong decisions of ray tracing methods, the library's and those of others, on the same rays
 *
 * Three studies: `methods` compares them on scenes; `stability` varies one parameter after the other until methods
 * fail; `stages` counts the rays that each stage of the library decides. The right answers are those of an oracle in
 * exact arithmetic, which shares no code with the library.
 *
 * Exit codes: 0, 1 if something failed or a method of the library decided wrongly, 2 for a mistake on the command line.
 */
#include "common/options.h"
#include "common/report.h"
#include "common/terminal.h"
#include "common/timer.h"
#include "study/guess.h"
#include "study/measure.h"
#include "study/stability.h"
#include "study/stages.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

enum study { STUDY_METHODS, STUDY_STABILITY, STUDY_STAGES };

struct settings {
    struct word_list scenes, generators, methods, sweeps;
    const char *views, *guess;
    int32_t study;
    uint32_t rays, runs; // rays 0: the study's default
    int csv;
    struct selection selection;
    size_t generator_count;
    enum generator chosen[GENERATOR_COUNT];
};

/* ---- printing ------------------------------------------------------------------------------------------------ */

struct report {
    const struct settings *settings;
    const char *scene;
    const char *const *conditions; // what is printed as the generator, one for each set of rays
    int guilty;                    // 1 = a method of the library decided wrongly
};

static void print_csv(const struct report *report, size_t set, const struct selection *selection,
                      const struct measurement *measurements)
{
    for (size_t i = 0; i < selection->count; i++) {
        if (!measurements[i].verdict.ray_count) continue;
        printf("%s,%s,%s,%zu,%.4f,%.4f\n", report->scene, report->conditions[set], selection->methods[i]->name,
               measurements[i].verdict.ray_count, wrong_per_million(&measurements[i].verdict), measurements[i].mrays);
    }
}

static void print_table(const struct report *report, size_t set, const struct selection *selection,
                        const struct measurement *measurements)
{
    size_t ray_count = 0;
    for (size_t i = 0; i < selection->count; i++) ray_count |= measurements[i].verdict.ray_count;
    printf("\n%s, %s, %zu rays\n%-38s %8s %12s %9s %9s %9s %9s\n", report->scene, report->conditions[set], ray_count,
           "method", "Mray/s", "wrong/1e6", "holes", "ghosts", "wrong tri", "ties");
    for (size_t i = 0; i < selection->count; i++) {
        const struct verdict *verdict = &measurements[i].verdict;
        if (!verdict->ray_count) continue;
        printf("%-38s %8.3f %12.1f %9zu %9zu %9zu %9zu\n", selection->methods[i]->title, measurements[i].mrays,
               wrong_per_million(verdict), verdict->hole_count, verdict->ghost_count, verdict->wrong_triangle_count,
               verdict->tie_count);
    }
}

static void take_measurements(void *user, size_t set, const struct selection *selection,
                              const struct measurement *measurements)
{
    struct report *report = user;
    clear_work();
    (report->settings->csv ? print_csv : print_table)(report, set, selection, measurements);
    fflush(stdout);
    show_work("%s: rays after %s ...", report->scene, report->conditions[set]);
    for (size_t i = 0; i < selection->count; i++) {
        const struct verdict *verdict = &measurements[i].verdict;
        int differs = wrong_per_million(verdict) > 0 || verdict->tie_count > 0;
        if (selection->methods[i]->is_ours && differs) report->guilty = 1;
    }
}

static void explain_table(void)
{
    puts("Mray/s: millions of rays per second on one thread.  wrong/1e6: wrong decisions per million rays, which are\n"
         "holes (a miss where the ray hits), ghosts (a hit where it misses) and wrong triangles (not the nearest one "
         "hit).\n"
         "ties: another triangle, hit at exactly the same distance; not counted as wrong.\n"
         "Triangle tests by name walk the library's tree one ray at a time, in plain C; Embree has its own hierarchy.");
    if (!embree_methods[0].name || !tinybvh_methods[0].name)
        printf("Not there to build with (make deps-study):%s%s\n", embree_methods[0].name ? "" : " Embree",
               tinybvh_methods[0].name ? "" : " tinybvh");
}

static const char *csv_head(int32_t study)
{
    return study == STUDY_STAGES ? "scene,generator,method,rays,float,tie,double,exact"
                                 : "scene,generator,method,rays,wrong_per_million,mrays";
}

static void explain_stages(void)
{
    puts("Of a million (ray, triangle) pairs, this many were decided by: the float filter; as an exact tie that is "
         "cheap\n"
         "to recognise; double precision; exact integers. Last: per cent of the (packet, triangle) tests where the "
         "filter\n"
         "left at least one ray undecided.\n");
    printf("%-20s %-12s %12s %12s %12s %12s %10s\n", "scene", "rays", "float", "tie", "double", "exact", "undecided");
}

static double share_of(uint64_t part, uint64_t whole, double unit)
{
    return whole ? unit * (double)part / (double)whole : 0;
}

static void print_stages(const struct settings *settings, const char *scene, enum generator generator,
                         const struct ray_set *rays, const struct stages *s)
{
    const char *name = generator_name(generator);
    uint64_t all = s->float_count + s->tie_count + s->double_count + s->exact_count;
    if (settings->csv)
        printf("%s,%s,%s,%zu,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 "\n", scene, name,
               rays->is_picture ? "mlrt_tile_camera" : "mlrt_tile", rays->count, s->float_count, s->tie_count,
               s->double_count, s->exact_count);
    else
        printf("%-20s %-12s %12.2f %12.2f %12.2f %12.2f %8.3f %%\n", scene, name, share_of(s->float_count, all, 1e6),
               share_of(s->tie_count, all, 1e6), share_of(s->double_count, all, 1e6),
               share_of(s->exact_count, all, 1e6), share_of(s->undecided_test_count, s->test_count, 100));
    fflush(stdout);
}

/* ---- studies ------------------------------------------------------------------------------------------------- */

static int study_scene(const struct settings *settings, const char *word, int *guilty)
{
    struct subject subject;
    struct ray_set sets[GENERATOR_COUNT] = {{.count = 0}};
    const char *conditions[GENERATOR_COUNT];
    show_work("%.*s: loading and building ...", (int)strcspn(word, ","), word);
    int failed = load_subject(word, settings->views, &subject);
    for (size_t i = 0; i < settings->generator_count && !failed; i++) {
        conditions[i] = generator_name(settings->chosen[i]);
        failed = generate_rays(settings->chosen[i], &subject, settings->rays, &sets[i]);
    }
    struct report report = {settings, subject.name, conditions, 0};
    failed = failed || measure_methods(&subject, sets, settings->generator_count, &settings->selection, settings->runs,
                                       take_measurements, &report);
    for (size_t i = 0; i < GENERATOR_COUNT; i++) free_rays(&sets[i]);
    free_subject(&subject);
    *guilty |= report.guilty;
    return failed;
}

static int study_methods(const struct settings *settings, int *guilty)
{
    int failed = 0;
    for (size_t i = 0; i < settings->scenes.count; i++)
        failed |= study_scene(settings, settings->scenes.words[i], guilty);
    return failed;
}

static void take_case(void *user, const struct stability_case *which, const struct selection *selection,
                      const struct measurement *measurements)
{
    struct report *report = user;
    const char *condition = which->condition;
    report->scene = which->scene;
    report->conditions = &condition;
    take_measurements(report, 0, selection, measurements);
}

static int study_stability(const struct settings *settings, int *guilty)
{
    struct report report = {settings, NULL, NULL, 0};
    int failed = run_sweeps(&settings->sweeps, settings->rays, &settings->selection, take_case, &report);
    *guilty |= report.guilty;
    return failed;
}

static int study_stages_of(const struct settings *settings, const struct subject *subject, enum generator generator)
{
    struct ray_set rays = {.count = 0};
    struct stages stages;
    int32_t status = MLRT_OK;
    int failed = generate_rays(generator, subject, settings->rays, &rays);
    if (!failed) status = count_stages(subject, &rays, &stages);
    if (status != MLRT_OK) fprintf(stderr, "cannot trace: %s\n", mlrt_status_string(status));
    failed = failed || status != MLRT_OK;
    if (!failed) print_stages(settings, subject->name, generator, &rays, &stages);
    free_rays(&rays);
    return failed;
}

static int study_stages(const struct settings *settings, int *guilty)
{
    (void)guilty;
    int failed = 0;
    for (size_t i = 0; i < settings->scenes.count; i++) {
        struct subject subject;
        int missing = load_subject(settings->scenes.words[i], settings->views, &subject);
        for (size_t g = 0; g < settings->generator_count && !missing; g++) {
            failed |= study_stages_of(settings, &subject, settings->chosen[g]);
        }
        failed |= missing;
        free_subject(&subject);
    }
    return failed;
}

/* ---- command line -------------------------------------------------------------------------------------------- */

static int word_length(const char *word)
{
    return (int)strcspn(word, ",");
}

static int is_word(const char *word, const char *name)
{
    return strlen(name) == strcspn(word, ",") && strncmp(name, word, strlen(name)) == 0;
}

static int select_methods(struct settings *settings)
{
    struct selection *selection = &settings->selection;
    for (size_t i = 0; i < settings->methods.count; i++) {
        const char *word = settings->methods.words[i];
        const struct method *method = find_method(word);
        if (!method || selection->count == MAXIMUM_METHODS) {
            fprintf(stderr, "--method %.*s: there is none of this name; they are", word_length(word), word);
            for (size_t m = 0; m < method_count(); m++) fprintf(stderr, " %s", method_at(m)->name);
            fprintf(stderr, "\n");
            return 1;
        }
        selection->methods[selection->count++] = method;
    }
    for (size_t m = 0; settings->methods.count == 0 && m < method_count(); m++) {
        const int guesses = strncmp(method_at(m)->name, "guess", 5) == 0;
        if (!guesses || settings->guess) selection->methods[selection->count++] = method_at(m);
    }
    return 0;
}

static int select_generators(struct settings *settings)
{
    for (size_t i = 0; i < settings->generators.count; i++) {
        const char *word = settings->generators.words[i];
        int g = 0;
        while (g < GENERATOR_COUNT && !is_word(word, generator_name((enum generator)g))) g++;
        if (g == GENERATOR_COUNT || settings->generator_count == GENERATOR_COUNT) {
            fprintf(stderr, "--generator %.*s: there is none of this name; they are", word_length(word), word);
            for (g = 0; g < GENERATOR_COUNT; g++) fprintf(stderr, " %s", generator_name((enum generator)g));
            fprintf(stderr, "\n");
            return 1;
        }
        settings->chosen[settings->generator_count++] = (enum generator)g;
    }
    for (int g = 0; settings->generators.count == 0 && g < GENERATOR_COUNT; g++) {
        settings->chosen[settings->generator_count++] = (enum generator)g;
    }
    return 0;
}

static int read_settings(struct settings *s, int argc, char **argv, int *exit_code)
{
    static const struct word_list procedural = {5, {"room", "office", "building", "scan", "sphere"}};
    static const uint32_t default_rays[] = {1u << 20, 1u << 14, 1u << 20};
    const struct option options[] = {
        {OPTION_CHOICE, "--study", &s->study, "methods|stability|stages",
         "methods on scenes, swept parameters on small meshes, or which stage of the\nlibrary decides (default: "
         "methods)",
         0, 0},
        {OPTION_LIST, "--scene", &s->scenes, "NAME|FILE,...",
         "room, office, building, doubled, scan, scan:N (about N triangles), sphere (20,480), or\nmesh files (default: "
         "room,office,building,scan,sphere)",
         0, 0},
        {OPTION_TEXT, "--views", &s->views, "FILE.json[:SCENE/VIEW]",
         "views of mesh files: view1 of the scene named like the file, or the one named", 0, 0},
        {OPTION_LIST, "--generator", &s->generators, "NAME,...",
         "rays of scenes: camera, random, surface, edge, vertex, axis, split_plane\n(default: all)", 0, 0},
        {OPTION_LIST, "--sweep", &s->sweeps, "NAME,...",
         "what --study stability sweeps: aim, shift, scale, length, sliver, grazing\n(default: all)", 0, 0},
        {OPTION_LIST, "--method", &s->methods, "NAME,...", "methods, by their names in CSV (default: all)", 0, 0},
        {OPTION_TEXT, "--guess", &s->guess, "FILE.so",
         "the library as `make GUESS=1 library` builds it: two more methods, without exactness", 0, 0},
        {OPTION_COUNT, "--rays", &s->rays, "N",
         "rays of each generator or value (default: 1048576, for stability 16384)", 16, 1u << 26},
        {OPTION_COUNT, "--runs", &s->runs, "N", "speeds of scenes are medians of this many runs (default: 5)", 1, 1000},
        {OPTION_FLAG, "--csv", &s->csv, NULL, "print scene,generator,method,rays,wrong_per_million,mrays", 0, 0},
    };
    if (!parse_options("accuracy - speed and wrong decisions of ray tracing methods", options, LENGTH(options), argc,
                       argv, exit_code))
        return 0;
    if (s->scenes.count == 0) s->scenes = procedural;
    if (s->rays == 0) s->rays = default_rays[s->study];
    *exit_code = 2;
    if (s->guess && load_guess(s->guess)) return 0;
    return !select_methods(s) && !select_generators(s);
}

int main(int argc, char **argv)
{
    static int (*const studies[])(const struct settings *settings, int *guilty) = {study_methods, study_stability,
                                                                                   study_stages};
    struct settings settings = {.runs = 5};
    int exit_code, guilty = 0;
    if (!read_settings(&settings, argc, argv, &exit_code)) return exit_code;
    if (settings.csv) {
        puts(csv_head(settings.study));
        if (!embree_methods[0].name) fputs("Embree's rows are missing: make deps-study installs it\n", stderr);
    } else if (settings.study == STUDY_STAGES) {
        explain_stages();
    } else {
        explain_table();
    }
    const double start = seconds_now();
    int failed = studies[settings.study](&settings, &guilty);
    clear_work();
    tell("measured for %.1f s", seconds_now() - start);
    if (guilty) fputs("a method of the library decided wrongly: see above\n", stderr);
    return end_output(failed || guilty);
}
