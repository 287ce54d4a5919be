/* SPDX-License-Identifier: MIT */
/* measure.c - speed and wrong decisions of methods: see measure.h */
#include "measure.h"

#include "common/timer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double time_run(const struct method_run *run, const struct ray_set *rays, uint32_t *triangles)
{
    double start = thread_seconds_now();
    const struct answers answers = {triangles, NULL};
    run->method->trace(run, rays, &answers);
    return thread_seconds_now() - start;
}

static double in_mrays(const struct ray_set *rays, double seconds)
{
    return seconds > 0 ? 1e-6 * (double)rays->count / seconds : 0;
}

struct buffers {
    uint32_t *right;
    uint32_t *answers;
    double *seconds; // of one method's runs after the other's
};

static int can_trace(const struct method *method, const struct ray_set *rays)
{
    return rays->is_picture || !method->needs_camera;
}

static void measure_set(struct subject *subject, const struct ray_set *rays, struct method_run *method_runs,
                        size_t method_count, uint32_t runs, const struct buffers *buffers,
                        struct measurement *measurements)
{
    float largest = largest_component(rays);
    ask_oracle(subject, rays, buffers->right);
    for (size_t i = 0; i < method_count; i++) {
        const struct method *method = method_runs[i].method;
        memset(&measurements[i], 0, sizeof measurements[i]);
        method_runs[i].largest = largest;
        if (!can_trace(method, rays)) continue;
        memset(buffers->answers, 0, rays->count * sizeof *buffers->answers);
        measurements[i].mrays = in_mrays(rays, time_run(&method_runs[i], rays, buffers->answers));
        measurements[i].verdict =
            judge_answers(subject, rays, buffers->right, buffers->answers, method->is_ours ? method->name : NULL);
    }
    for (size_t turn = 0; turn < runs * method_count; turn++) {
        size_t i = turn % method_count;
        if (!can_trace(method_runs[i].method, rays)) continue;
        buffers->seconds[i * runs + turn / method_count] = time_run(&method_runs[i], rays, buffers->answers);
    }
    for (size_t i = 0; i < method_count && runs > 0; i++) {
        if (!can_trace(method_runs[i].method, rays)) continue;
        measurements[i].mrays = in_mrays(rays, median(buffers->seconds + i * runs, runs));
    }
}

int measure_methods(struct subject *subject, const struct ray_set *sets, size_t set_count,
                    const struct selection *selection, uint32_t runs, measurement_consumer consumer, void *user)
{
    struct method_run method_runs[MAXIMUM_METHODS];
    struct measurement measurements[MAXIMUM_METHODS];
    size_t most = 1, created = 0;
    for (size_t i = 0; i < set_count; i++) most = sets[i].count > most ? sets[i].count : most;
    struct buffers buffers = {malloc(most * sizeof(uint32_t)), malloc(most * sizeof(uint32_t)),
                              malloc((runs * selection->count + 1) * sizeof(double))};
    int failed = !buffers.right || !buffers.answers || !buffers.seconds;
    if (failed) fprintf(stderr, "not enough memory for %zu rays\n", most);
    while (created < selection->count && !failed) {
        struct method_run *run = &method_runs[created];
        *run = (struct method_run){selection->methods[created], subject, NULL, 0};
        created++;
        failed = run->method->create && run->method->create(run);
    }
    for (size_t i = 0; i < set_count && !failed; i++) {
        measure_set(subject, &sets[i], method_runs, selection->count, runs, &buffers, measurements);
        consumer(user, i, selection, measurements);
    }
    for (size_t i = 0; i < created; i++) {
        if (method_runs[i].method->destroy) method_runs[i].method->destroy(&method_runs[i]);
    }
    free(buffers.right);
    free(buffers.answers);
    free(buffers.seconds);
    return failed;
}
