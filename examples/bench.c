/* SPDX-License-Identifier: MIT */
/*
 * bench.c - measures the library's speed, beside Embree 3 if that is installed
 *
 *     bench                                          procedural scenes, all kinds of rays
 *     bench --scene FILE,... --views cameras.json    mesh files, each from the first view that cameras.json has for it
 *     bench --threads 2                              one thread and two, and the gain of a loop of integers by two
 *     bench --against OLD.so --alone                 beside another build of the library
 *     bench --study build                            seconds and bytes per triangle
 *     bench --study calls --alone                    nanoseconds and instructions of calls of 1 to 16 rays
 *     bench --study costs                            the speed of trees by other costs, and of other builds
 *
 * The kinds of rays are those of bench/task.h, the rules those of bench/contest.h and bench/peer.h. The table has
 * millions of rays per second in the fastest run (of pictures, lit ones too, millions of pixels), the fastest way to
 * call Embree, ratios, and the number of the library's answers that differ from Embree robust. Those are no errors:
 * where two triangles are equally near, either may be named. If both `frame` and `lit` were measured, a line
 * `lit-frame` has the speed of the shadows alone: pixels by the difference of the two times, for each contender.
 *
 * Exit codes: 0, 1 if something failed or answers are wrong, 2 for a mistake on the command line.
 */
#include "bench/contest.h"
#include "bench/study.h"
#include "common/options.h"
#include "common/report.h"
#include "common/terminal.h"
#include "common/timer.h"
#include "common/tree.h"

#include <stdio.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof *(array))

static const char *const default_scenes[] = {"room", "office", "building", "scan", "sphere"};

/* ---- output -------------------------------------------------------------------------------------------------- */

// Where the table has a column: what two threads can gain here.
static void report_spin(const struct contest *contest)
{
    for (size_t i = 1; i < contest->count; i++) {
        const struct contender *c = &contest->contenders[i];
        if (c->who != SPIN_LOOP || c->threads == 1) continue;
        fprintf(stderr, "%s, %s: a loop of integers does %.2f times as much on %u threads\n",
                contest->task->subject->name, kind_names[contest->task->kind], c->mrays / c[-1].mrays,
                (unsigned)c->threads);
    }
}

static void print_csv_lines(const struct contest *contest)
{
    for (size_t i = 0; i < contest->count; i++) {
        const struct contender *c = &contest->contenders[i];
        if (c->who != LIBRARY || c->unsupported) continue;
        print_csv_line(contest, c);
        end_csv_line(contest, c);
    }
    fflush(stdout);
}

static void print_csv(const struct contest *contest)
{
    print_csv_lines(contest);
    report_spin(contest);
}

static double ratio_of(double value, const struct contender *other)
{
    return other && other->mrays > 0 ? value / other->mrays : 0;
}

static void print_gains(const struct contest *contest, const struct contender *contender)
{
    const struct contender *fast[2] = {find_contender(contest, PEER_FAST, 1),
                                       find_contender(contest, PEER_FAST, contender->threads)};
    const struct contender *spin[2] = {find_contender(contest, SPIN_LOOP, 1),
                                       find_contender(contest, SPIN_LOOP, contender->threads)};
    // One thread of the same contender stands just before.
    printf("   x%.2f", ratio_of(contender->mrays, contender - 1));
    if (fast[0] && fast[1]) printf(" (Embree x%.2f", ratio_of(fast[1]->mrays, fast[0]));
    if (spin[0] && spin[1]) printf("%s integers x%.2f)", fast[0] ? "," : " (", ratio_of(spin[1]->mrays, spin[0]));
}

static void print_old(const struct contest *contest, const struct contender *contender)
{
    const struct contender *old = find_old(contest, contender);
    if (!old || old->unsupported)
        printf(" %8s %7s %9s", "unsupp.", "", "");
    else
        printf(" %8.2f %7.2f %9zu", old->mrays, ratio_of(contender->mrays, old), old->different);
}

static void print_row(const struct contest *contest, const struct contender *contender)
{
    const struct contender *fast = find_contender(contest, PEER_FAST, contender->threads);
    const struct contender *robust = find_contender(contest, PEER_ROBUST, contender->threads);
    printf("%-10s %-10s %-7s %3u ", kind_names[contest->task->kind], method_names[contender->method],
           isa_names[contender->isa], (unsigned)contender->threads);
    if (contender->unsupported) {
        printf("unsupported\n");
        return;
    }
    printf("%8.2f", contender->mrays);
    if (fast && robust) {
        printf(" %8.2f %-3s %8.2f %-3s %7.2f %7.2f %9zu %9zu", fast->mrays,
               peer_variant_name(contest->task->kind, fast->variant), robust->mrays,
               peer_variant_name(contest->task->kind, robust->variant), ratio_of(contender->mrays, fast),
               ratio_of(contender->mrays, robust), contender->different, fast->different);
    }
    if (contest->old) print_old(contest, contender);
    if (contender->threads > 1) print_gains(contest, contender);
    putchar('\n');
    fflush(stdout);
}

static void print_table(const struct contest *contest)
{
    for (size_t i = 0; i < contest->count; i++) {
        if (contest->contenders[i].who == LIBRARY) print_row(contest, &contest->contenders[i]);
    }
}

// What shadows alone cost everyone: one over the time of a lit frame less that of a frame. 0 where chance leaves no
// time.
static void print_difference(const struct contest *lit, const struct contest *frame, int csv)
{
    struct contest difference = *lit;
    struct task task = *lit->task;
    task.kind = LIT_LESS_FRAME;
    difference.task = &task;
    for (size_t i = 0; i < difference.count; i++) {
        struct contender *c = &difference.contenders[i];
        if (c->unsupported || c->who == SPIN_LOOP) continue;
        const double microseconds = 1 / c->mrays - 1 / frame->contenders[i].mrays;
        c->mrays = microseconds > 0 ? 1 / microseconds : 0;
    }
    (csv ? print_csv_lines : print_table)(&difference);
}

static void print_head(const struct arena *arena, uint32_t size)
{
    printf("\n%s: %zu triangles, %lu x %lu pixels, tree built in %.2f s\n", arena->subject.name,
           arena->subject.scene.triangle_count, (unsigned long)size, (unsigned long)size, arena->build_seconds);
    printf("%-10s %-10s %-7s %3s %8s", "kind", "method", "isa", "thr", "Mray/s");
    if (arena->robust) {
        printf(" %8s %-3s %8s %-3s %7s %7s %9s %9s", "E. fast", "by", "E.robust", "by", "/ fast", "/robust", "differ",
               "fast diff");
    }
    if (arena->old) printf(" %8s %7s %9s", "old", "/ old", "old diff");
    putchar('\n');
}

/* ---- scenes -------------------------------------------------------------------------------------------------- */

static int bench_scene(const struct bench_settings *settings, const char *word)
{
    struct arena arena;
    struct contest contest, frame = {.count = 0};
    show_work("%.*s: building trees ...", (int)strcspn(word, ","), word);
    int failed = open_arena(settings, word, &arena) || set_size(&arena.subject, settings->size);
    clear_work();
    if (!failed && !settings->csv) print_head(&arena, settings->size);
    for (int kind = 0; kind < KIND_COUNT && !failed; kind++) {
        if (!(settings->kinds & 1u << kind)) continue;
        struct task task;
        show_work("%s: %s rays ...", arena.subject.name, kind_names[kind]);
        failed = start_contest(settings, &arena, (enum kind)kind, &task, &contest) || hold_contest(&contest);
        clear_work();
        if (!failed) (settings->csv ? print_csv : print_table)(&contest);
        if (!failed && kind == FRAME) frame = contest;
        if (!failed && kind == LIT && frame.count) print_difference(&contest, &frame, settings->csv);
        free_task(&task);
    }
    close_arena(&arena);
    return failed;
}

static int bench_scenes(const struct bench_settings *settings)
{
    if (settings->csv) {
        fputs("scene,kind,method,isa,threads,mrays,embree_fast_mrays,embree_robust_mrays", stdout);
        end_csv_head(settings);
    }
    if (!settings->csv && !have_peer()) puts("Embree 3 is not installed (make deps-study): the library alone");
    int failed = 0;
    for (size_t i = 0; i < settings->scenes.count; i++) failed |= bench_scene(settings, settings->scenes.words[i]);
    return failed;
}

/* ---- command line -------------------------------------------------------------------------------------------- */

// The kinds of the command line: "array" asks for rows and for lists.
static uint32_t kinds_of(uint32_t words)
{
    static const uint32_t kinds[] = {
        1u << FRAME,      1u << LIT,       1u << PRIMARY, 1u << SHADOW, 1u << SUN,      1u << ARRAY | 1u << LIST,
        1u << PARALLEL,   1u << BOUNCE,    1u << REACH,   1u << MIRROR, 1u << LENS,     1u << ONE_WAY,
        1u << HEMISPHERE, 1u << RECORD,    1u << SAMPLES, 1u << CURVE,  1u << PANORAMA, 1u << AREA,
        1u << SINGLE,     1u << SINGLE_ANY};
    uint32_t result = 0;
    for (size_t i = 0; i < LENGTH(kinds); i++) result |= words & 1u << i ? kinds[i] : 0;
    return result;
}

static int complete_settings(struct bench_settings *settings, uint32_t kind_words)
{
    const int is_resolution = settings->study == STUDY_RESOLUTION;
    settings->kinds = kind_words ? kinds_of(kind_words) : default_kinds(settings->study);
    if (settings->size == 0) settings->size = is_resolution ? 8192 : 1024;
    if (settings->runs == 0) settings->runs = settings->study == STUDY_BUILD ? 3 : 11;
    if (settings->methods == 0) settings->methods = 1;
    if (settings->isas == 0) settings->isas = 1;
    for (size_t i = 0; settings->scenes.count == 0 && settings->study != STUDY_TRIANGLES && i < LENGTH(default_scenes);
         i++) {
        settings->default_scenes.words[settings->default_scenes.count++] = default_scenes[i];
    }
    if (settings->scenes.count == 0) settings->scenes = settings->default_scenes;
    if (settings->size % 64 == 0) return 0;
    fprintf(stderr, "--size: a multiple of 64, so that everyone's tiles are whole\n");
    return 1;
}

int main(int argc, char **argv)
{
    struct bench_settings settings = {.threads = 1};
    uint32_t kind_words = 0;
    const struct option options[] = {
        {OPTION_HEADING, NULL, NULL, NULL, "What:", 0, 0},
        {OPTION_LIST, "--scene", &settings.scenes, "NAME|FILE,...",
         "scenes (default: room,office,building,scan,sphere)\nalso doubled, and scan:N and sphere:N, of about N "
         "triangles",
         0, 0},
        {OPTION_TEXT, "--views", &settings.views, "FILE.json", "views of scenes that are files", 0, 0},
        {OPTION_TEXT, "--view", &settings.view, "FILE.json:SCENE/VIEW", "one view for all scenes", 0, 0},
        {OPTION_COUNT, "--size", &settings.size, "N", "pixels per side (default: 1024; the study's largest: 8192)", 64,
         16384},
        {OPTION_SET, "--kind", &kind_words,
         "frame,lit,primary,shadow,sun,array,parallel,bounce,reach,mirror,lens,one-way,hemisphere,record,samples,curve,"
         "panorama,area,single,single-any",
         "kinds of rays, a list (default: all; some of studies);\nlit is a frame with shadows, after frame also the "
         "difference, "
         "lit-frame",
         0, 0},
        {OPTION_CHOICE, "--study", &settings.study, "none|triangles|resolution|build|calls|costs",
         "time against the number of triangles or pixels; building; calls of few rays; costs of the builder. CSV",
         STUDY_NONE, 0},
        {OPTION_HEADING, NULL, NULL, NULL, "How:", 0, 0},
        {OPTION_SET, "--method", &settings.methods, "default,ray,packet2,packet4,multilevel,tile",
         "methods, a list (default: default)", 0, 0},
        {OPTION_SET, "--isa", &settings.isas, "auto,scalar,sse,avx2,avx512,neon",
         "instruction sets, a list (default: auto)", 0, 0},
        {OPTION_CHOICE, "--peer-isa", &settings.peer_isa, "auto|sse|avx|avx2|avx512", "the widest that Embree may use",
         0, 0},
        {OPTION_CHOICE, "--tree", &settings.tree, TREE_WORDS, "boxes, or kd-trees", TREE_DEFAULT, 0},
        {OPTION_COUNT, "--threads", &settings.threads, "N", "threads; more than 1: one as well (default: 1)", 1, 256},
        {OPTION_COUNT, "--runs", &settings.runs, "N", "runs of each (default: 11; of building 3)", 1, MAXIMUM_RUNS},
        {OPTION_FLAG, "--alone", &settings.alone, NULL, "without Embree", 0, 0},
        {OPTION_TEXT, "--against", &settings.against, "FILE.so",
         "another build of the library, older, say: it takes part as well", 0, 0},
        {OPTION_LIST, "--trees", &settings.trees, "FILE.so,...",
         "for --study costs: builds of the library whose trees this one\ntraces as well, named by their folders", 0, 0},
        {OPTION_FLAG, "--paced", &settings.paced, NULL,
         "for programs: each run says \"turn KIND\", waits for a line on\nstandard input, and says how many seconds it "
         "took",
         0, 0},
        {OPTION_FLAG, "--csv", &settings.csv, NULL, "comma-separated values instead of tables", 0, 0},
    };
    int exit_code;
    if (!parse_options("bench - how fast the library is, beside Embree 3", options, LENGTH(options), argc, argv,
                       &exit_code))
        return exit_code;
    if (complete_settings(&settings, kind_words)) return 2;
    struct library old;
    if (settings.against && load_library(settings.against, &old)) return 1;
    settings.old = settings.against ? &old : NULL;
    const double start = seconds_now();
    const int failed = settings.study == STUDY_NONE ? bench_scenes(&settings) : run_study(&settings);
    tell("measured for %.1f s", seconds_now() - start);
    if (settings.old) close_library(&old);
    return end_output(failed);
}
