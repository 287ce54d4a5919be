/* SPDX-License-Identifier: MIT */
/* contest.c - turns, speeds and comparisons: see contest.h */
#include "contest.h"

#include "common/timer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLE_SIZE = 4096, TRIALS = 3 };

#define HOPELESS 1.25 // times as long as the best so far

/* ---- the spin loop ------------------------------------------------------------------------------------------- */

// Independent integer work: how two threads fare that share nothing but the machine.
enum { SPIN_ITEMS = 16, SPIN_STEPS = 1 << 20 };

static volatile uint64_t spin_result;

static void spin(void *user, size_t item)
{
    uint64_t state = item + 1;
    (void)user;
    for (int i = 0; i < SPIN_STEPS; i++) state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    if (state == 0) spin_result = state;
}

/* ---- one run ------------------------------------------------------------------------------------------------- */

static mlrt_trace_options options_of(const struct contest *contest, const struct contender *contender)
{
    return (mlrt_trace_options){.struct_size = sizeof(mlrt_trace_options),
                                .method = contender->method,
                                .isa = contender->isa,
                                .pool = contender->threads == 1         ? NULL
                                        : contender->who == OLD_LIBRARY ? contest->old_pool
                                                                        : contest->pool};
}

static int32_t run_once(const struct contest *contest, const struct contender *contender, const struct task *task,
                        const struct answers *answers)
{
    struct crew *crew = contender->threads > 1 ? contest->crew : NULL;
    const mlrt_trace_options options = options_of(contest, contender);
    const mlrt_tree *tree = contender->tree ? contender->tree : contest->tree;
    if (contender->who == LIBRARY) return run_library(&this_library, tree, &options, task, answers);
    if (contender->who == OLD_LIBRARY) return run_library(contest->old, contest->old_tree, &options, task, answers);
    if (contender->who == SPIN_LOOP)
        run_crew(crew, SPIN_ITEMS, spin, NULL);
    else
        run_peer(contender->who == PEER_FAST ? contest->fast : contest->robust, contender->variant, task, crew,
                 answers);
    return MLRT_OK;
}

// One thread alone is timed by its own clock, so that other programs on the machine matter less.
static double time_once(const struct contest *contest, const struct contender *contender, const struct answers *answers)
{
    double (*const now)(void) = contest->crew ? seconds_now : thread_seconds_now;
    const double start = now();
    run_once(contest, contender, contest->task, answers);
    return now() - start;
}

// The best of the ways to call the peer, by one thread. What is far behind at first has no second chance.
static void choose_variant(const struct contest *contest, struct contender *contender, const struct answers *answers)
{
    double best = INFINITY;
    int best_variant = 0;
    for (int i = 0; i < PEER_VARIANT_COUNT; i++) {
        if (!peer_variant_name(contest->task->kind, i)) continue;
        contender->variant = i;
        for (int trial = 0; trial < TRIALS; trial++) {
            const double seconds = time_once(contest, contender, answers);
            if (seconds < best) best = seconds, best_variant = i;
            if (seconds > HOPELESS * best) break;
        }
    }
    contender->variant = best_variant;
}

/* ---- comparing ----------------------------------------------------------------------------------------------- */

// What everybody says. Pictures that are shaded are asked for what they were shaded by as well.
static int32_t answer(const struct contest *contest, const struct contender *contender, const struct answers *answers)
{
    const int32_t status = run_once(contest, contender, contest->task, answers);
    if (!answers->rgba || status != MLRT_OK) return status;
    struct task unshaded = *contest->task;
    struct answers others = *answers;
    struct contender again = *contender;
    others.rgba = NULL;
    if (unshaded.kind == FRAME) {
        unshaded.kind = PRIMARY;
        if (contender->who != LIBRARY) again.variant = 0;
    }
    return run_once(contest, &again, &unshaded, &others);
}

// The peer's answers to a stream, in the order of the elements.
static int sort_answers(const struct task *task, struct answers *answers)
{
    const struct stream *stream = &task->stream;
    if (!stream->elements) return 0;
    struct answers sorted;
    int failed = make_answers(task, &sorted);
    for (size_t i = 0; i < task->element_count && !failed; i++) {
        if (sorted.occluded) sorted.occluded[i] = 0;
        if (sorted.triangles) sorted.triangles[i] = MLRT_NONE;
    }
    for (size_t i = 0; i < stream->count && !failed; i++) {
        const uint32_t element = stream->elements[i];
        if (sorted.occluded) sorted.occluded[element] = answers->occluded[i];
        if (sorted.triangles) sorted.triangles[element] = answers->triangles[i];
        if (sorted.t) sorted.t[element] = answers->t[i];
        if (sorted.u) sorted.u[element] = answers->u[i], sorted.v[element] = answers->v[i];
        if (sorted.mesh) sorted.mesh[element] = answers->mesh[i];
    }
    struct answers *old = failed ? &sorted : answers;
    free_answers(old);
    if (!failed) *answers = sorted;
    return failed;
}

static size_t count_differences(const struct task *task, const struct answers *a, const struct answers *b)
{
    size_t count = 0;
    for (size_t i = 0; i < task->element_count; i++) {
        count += a->occluded ? a->occluded[i] != b->occluded[i] : a->triangles[i] != b->triangles[i];
    }
    return count;
}

// Pictures may differ by rounding, and where the triangles or shadows do. Normals of slivers are nothing but rounding:
// of dragon_x9 five pixels in a million differ by more than a level.
#define SLIVERS 1e-5

static int compare_pictures(const struct task *task, const struct answers *a, const struct answers *b, const char *who)
{
    size_t wrong = 0;
    for (size_t i = 0; i < task->element_count && a->rgba; i++) {
        const int difference = (int)(a->rgba[i] & 255) - (int)(b->rgba[i] & 255);
        const int is_same = a->triangles[i] == b->triangles[i] && (!a->occluded || a->occluded[i] == b->occluded[i]);
        wrong += is_same && abs(difference) > 1;
    }
    if (wrong)
        fprintf(stderr, "%s: %zu pixels of the picture differ from those of %s\n", task->subject->name, wrong, who);
    return (double)wrong > SLIVERS * (double)task->element_count;
}

/* Some rays, or points, of a task, and what is said about them. */
struct sample {
    size_t count;
    uint32_t elements[SAMPLE_SIZE], skip[SAMPLE_SIZE][2], triangles[SAMPLE_SIZE];
    float origins[SAMPLE_SIZE][3], directions[SAMPLE_SIZE][3], t[SAMPLE_SIZE], u[SAMPLE_SIZE], v[SAMPLE_SIZE];
    struct ray_record records[SAMPLE_SIZE];
    uint8_t occluded[SAMPLE_SIZE];
};

static void copy_element(const struct task *task, uint32_t element, struct sample *sample)
{
    const size_t n = sample->count++;
    const mlrt_camera *camera = &task->subject->camera;
    sample->elements[n] = element;
    if (task->kind >= REACH) {
        get_ray(task, element, &sample->records[n]);
        return;
    }
    if (task->skip) memcpy(sample->skip[n], task->skip[element], sizeof sample->skip[n]);
    if (task->directions) memcpy(sample->directions[n], task->directions[element], sizeof sample->directions[n]);
    if (task->origins) {
        memcpy(sample->origins[n], task->origins[element], sizeof sample->origins[n]);
    } else {
        memcpy(sample->origins[n], camera->eye, sizeof sample->origins[n]);
        camera_direction(camera, element % camera->width, element / camera->width, sample->directions[n]);
    }
}

// A pixel of a lit picture, ray by ray: what it sees, and whether something lies between that and the light.
static int32_t ask_pixel(const struct contest *contest, const mlrt_trace_options *options, size_t i,
                         struct sample *sample)
{
    const mlrt_light light = light_of(contest->task->subject);
    const float *o = sample->origins[i], *d = sample->directions[i];
    const mlrt_ray ray = {.struct_size = sizeof ray, .origin = {o[0], o[1], o[2]}, .direction = {d[0], d[1], d[2]}};
    mlrt_trace_options any = *options;
    mlrt_ray shadow = {.struct_size = sizeof shadow};
    mlrt_hit hit = {.struct_size = sizeof hit}, between = {.struct_size = sizeof between};
    int32_t faces = 0;
    int32_t status = mlrt_trace_ray(contest->tree, &ray, options, &hit);
    sample->triangles[i] = hit.triangle;
    sample->occluded[i] = 0;
    if (status != MLRT_OK || hit.triangle == MLRT_NONE) return status;
    status = mlrt_shadow_ray(contest->tree, &ray, &hit, &light, &shadow, &faces);
    any.query = MLRT_QUERY_ANY;
    if (status == MLRT_OK && faces) status = mlrt_trace_ray(contest->tree, &shadow, &any, &between);
    sample->occluded[i] = !faces || between.occluded;
    return status;
}

static int32_t ask_pixels(const struct contest *contest, const mlrt_trace_options *options, struct sample *sample)
{
    int32_t status = MLRT_OK;
    for (size_t i = 0; i < sample->count && status == MLRT_OK; i++) status = ask_pixel(contest, options, i, sample);
    return status;
}

static int32_t ask_other_method(const struct contest *contest, int32_t method, struct sample *sample)
{
    const enum kind kind = contest->task->kind;
    struct task task = {.kind = is_yes_or_no(kind) ? kind : LIST,
                        .row_length = is_shadow(kind) ? contest->task->row_length : 0,
                        .subject = contest->task->subject,
                        .element_count = sample->count,
                        .origins = sample->origins,
                        .directions = sample->directions,
                        .records = kind >= REACH ? sample->records : NULL,
                        .skip = sample->skip};
    memcpy(task.sun, contest->task->sun, sizeof task.sun);
    struct answers answers = {.triangles = sample->triangles, .t = sample->t, .u = sample->u, .v = sample->v};
    const mlrt_trace_options options = {.struct_size = sizeof options,
                                        .method = method == MLRT_METHOD_RAY ? MLRT_METHOD_DEFAULT : MLRT_METHOD_RAY};
    if (kind == LIT) return ask_pixels(contest, &options, sample);
    if (is_yes_or_no(kind)) answers = (struct answers){.occluded = sample->occluded};
    return run_library(&this_library, contest->tree, &options, &task, &answers);
}

static int sample_differs(const struct sample *sample, const struct answers *answers, size_t i)
{
    const uint32_t element = sample->elements[i];
    if (answers->occluded && answers->occluded[element] != sample->occluded[i]) return 1;
    if (!answers->triangles) return 0;
    return answers->triangles[element] != sample->triangles[i] ||
           (answers->t && memcmp(&answers->t[element], &sample->t[i], sizeof sample->t[i]) != 0) ||
           (answers->u && memcmp(&answers->u[element], &sample->u[i], sizeof sample->u[i]) != 0) ||
           (answers->v && memcmp(&answers->v[element], &sample->v[i], sizeof sample->v[i]) != 0);
}

// Returns 1 after saying so if the answers of one contender are not those of the library's other methods.
static int check_sample(const struct contest *contest, const struct contender *contender, const struct answers *answers)
{
    const struct task *task = contest->task;
    struct sample *sample = calloc(1, sizeof *sample);
    if (!sample) return 1;
    const size_t step = task->element_count / SAMPLE_SIZE + 1;
    for (size_t i = 0; i < task->element_count; i += step) copy_element(task, (uint32_t)i, sample);
    int32_t status = ask_other_method(contest, contender->method, sample);
    size_t wrong = 0;
    for (size_t i = 0; i < sample->count && status == MLRT_OK; i++) wrong += (size_t)sample_differs(sample, answers, i);
    if (status != MLRT_OK) fprintf(stderr, "cannot check: %s\n", mlrt_status_string(status));
    if (wrong) {
        fprintf(stderr, "%s, %s, method %d: %zu answers of %zu are not those of another method\n", task->subject->name,
                kind_names[task->kind], (int)contender->method, wrong, sample->count);
    }
    free(sample);
    return status != MLRT_OK || wrong;
}

static int check_library(const struct contest *contest, struct contender *contender, const struct answers *answers)
{
    const int32_t status = answer(contest, contender, answers);
    const int unknown_method = status == MLRT_ERROR_ARGUMENT && contender->method > MLRT_METHOD_MULTILEVEL;
    contender->unsupported = status == MLRT_ERROR_UNSUPPORTED || unknown_method;
    if (contender->unsupported) return 0;
    if (status == MLRT_OK) return check_sample(contest, contender, answers);
    fprintf(stderr, "cannot trace: %s\n", mlrt_status_string(status));
    return 1;
}

static size_t count_other_bits(const struct task *task, const struct answers *a, const struct answers *b)
{
    size_t count = 0;
    for (size_t i = 0; i < task->element_count; i++) {
        count += (a->occluded && a->occluded[i] != b->occluded[i]) ||
                 (a->triangles && a->triangles[i] != b->triangles[i]) || (a->mesh && a->mesh[i] != b->mesh[i]) ||
                 (a->rgba && a->rgba[i] != b->rgba[i]) || (a->t && memcmp(&a->t[i], &b->t[i], sizeof *a->t) != 0) ||
                 (a->u && memcmp(&a->u[i], &b->u[i], sizeof *a->u) != 0) ||
                 (a->v && memcmp(&a->v[i], &b->v[i], sizeof *a->v) != 0);
    }
    return count;
}

// No answer that there can be, so that what is not written shows.
static void spoil_answers(const struct task *task, const struct answers *answers)
{
    const size_t n = task->element_count;
    if (answers->occluded) memset(answers->occluded, 0xA5, n);
    if (answers->triangles) memset(answers->triangles, 0xA5, n * sizeof *answers->triangles);
    if (answers->mesh) memset(answers->mesh, 0xA5, n * sizeof *answers->mesh);
    if (answers->t) memset(answers->t, 0xA5, n * sizeof *answers->t);
    if (answers->u) memset(answers->u, 0xA5, n * sizeof *answers->u);
    if (answers->v) memset(answers->v, 0xA5, n * sizeof *answers->v);
    if (answers->rgba) memset(answers->rgba, 0xA5, n * sizeof *answers->rgba);
}

// Whatever status but MLRT_OK the old library has for it: it cannot do this.
static int check_old(const struct contest *contest, struct contender *contender, const struct answers *answers)
{
    struct answers ours;
    struct contender library = *contender;
    library.who = LIBRARY;
    spoil_answers(contest->task, answers);
    contender->unsupported = contender->unsupported || answer(contest, contender, answers) != MLRT_OK;
    if (contender->unsupported) return 0;
    int failed = make_answers(contest->task, &ours);
    if (!failed && answer(contest, &library, &ours) == MLRT_OK) {
        contender->different = count_other_bits(contest->task, answers, &ours);
        if (contender->different) {
            fprintf(stderr, "%s, %s: %zu answers of the old library are not those of this one\n",
                    contest->task->subject->name, kind_names[contest->task->kind], contender->different);
        }
    }
    free_answers(&ours);
    return failed;
}

static int answer_of(struct contest *contest, enum who who, struct answers *answers)
{
    const struct contender *contender = find_contender(contest, who, 1);
    if (!contender) return 0;
    return answer(contest, contender, answers) != MLRT_OK || sort_answers(contest->task, answers);
}

// `peers` holds the answers of the fast and the robust one.
static int check_contender(struct contest *contest, struct contender *contender, const struct answers peers[2],
                           struct answers *answers)
{
    if (contender->who == PEER_FAST) contender->different = count_differences(contest->task, &peers[0], &peers[1]);
    if (contender->who == OLD_LIBRARY) return check_old(contest, contender, answers);
    if (contender->who != LIBRARY) return 0;
    if (check_library(contest, contender, answers)) return 1;
    if (!contest->robust || contender->unsupported) return 0;
    contender->different = count_differences(contest->task, answers, &peers[1]);
    return compare_pictures(contest->task, answers, &peers[0], "Embree fast") ||
           compare_pictures(contest->task, answers, &peers[1], "Embree robust");
}

static int check_answers(struct contest *contest, struct answers *answers)
{
    struct answers peers[2] = {{.triangles = NULL}};
    int failed = 0;
    for (int i = 0; i < 2 && contest->robust && !failed; i++) failed = make_answers(contest->task, &peers[i]);
    failed = failed || answer_of(contest, PEER_FAST, &peers[0]) || answer_of(contest, PEER_ROBUST, &peers[1]);
    for (size_t i = 0; i < contest->count && !failed; i++) {
        failed = check_contender(contest, &contest->contenders[i], peers, answers);
    }
    for (int i = 0; i < 2; i++) free_answers(&peers[i]);
    return failed;
}

/* ---- turns --------------------------------------------------------------------------------------------------- */

const struct contender *find_contender(const struct contest *contest, enum who who, uint32_t threads)
{
    for (size_t i = 0; i < contest->count; i++) {
        const struct contender *contender = &contest->contenders[i];
        if (contender->who == who && contender->threads == threads) return contender;
    }
    return NULL;
}

const struct contender *find_old(const struct contest *contest, const struct contender *contender)
{
    for (size_t i = 0; i < contest->count; i++) {
        const struct contender *c = &contest->contenders[i];
        if (c->who == OLD_LIBRARY && c->method == contender->method && c->isa == contender->isa &&
            c->threads == contender->threads)
            return c;
    }
    return NULL;
}

static void choose_variants(struct contest *contest, const struct answers *answers)
{
    for (size_t i = 0; i < contest->count; i++) {
        struct contender *contender = &contest->contenders[i];
        if (contender->who != PEER_FAST && contender->who != PEER_ROBUST) continue;
        const struct contender *alone = find_contender(contest, contender->who, 1);
        if (alone == contender)
            choose_variant(contest, contender, answers);
        else
            contender->variant = alone->variant;
    }
}

// Whoever runs this program says when. A program that says "turn" has nothing to do until it is told to run.
static double time_paced(const struct contest *contest, const struct contender *contender,
                         const struct answers *answers)
{
    int letter;
    printf("turn %s\n", kind_names[contest->task->kind]);
    fflush(stdout);
    do letter = getchar();
    while (letter != '\n' && letter != EOF);
    const double seconds = time_once(contest, contender, answers);
    printf("%.9f\n", seconds);
    fflush(stdout);
    return seconds;
}

// Whose turn it is. In every second run the library and the old one change places: what ran before shows in the caches.
static size_t turn_of(const struct contest *contest, uint32_t run, size_t place)
{
    const struct contender *contender = &contest->contenders[place];
    const size_t distance = contest->crew ? 2 : 1; // with more threads there are two contenders of each
    if (!contest->old || run % 2 == 0) return place;
    return contender->who == LIBRARY ? place + distance : contender->who == OLD_LIBRARY ? place - distance : place;
}

static void take_turns(struct contest *contest, const struct answers *answers, double *seconds)
{
    for (uint32_t run = 0; run < contest->runs; run++) {
        for (size_t place = 0; place < contest->count; place++) {
            const size_t i = turn_of(contest, run, place);
            if (contest->contenders[i].unsupported) continue;
            seconds[i * contest->runs + run] =
                (contest->paced ? time_paced : time_once)(contest, &contest->contenders[i], answers);
        }
    }
    for (size_t i = 0; i < contest->count; i++) {
        struct contender *contender = &contest->contenders[i];
        if (contender->unsupported) continue;
        const double count =
            contender->who == SPIN_LOOP ? (double)SPIN_ITEMS * SPIN_STEPS : (double)contest->task->ray_count;
        contender->mrays = 1e-6 * count / least(seconds + i * contest->runs, contest->runs);
    }
}

int hold_contest(struct contest *contest)
{
    struct answers answers;
    double *seconds = malloc(contest->count * contest->runs * sizeof *seconds);
    int failed = make_answers(contest->task, &answers) || !seconds;
    if (!failed) choose_variants(contest, &answers);
    failed = failed || check_answers(contest, &answers);
    if (!failed) take_turns(contest, &answers, seconds);
    free_answers(&answers);
    free(seconds);
    return failed;
}
