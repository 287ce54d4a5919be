/* SPDX-License-Identifier: MIT */
/* stages.c - how many pairs each stage of the library decides: see stages.h */
#include "stages.h"

#include <stdlib.h>

static int32_t trace_counting(const struct subject *subject, const struct ray_set *rays, mlrt_counters *counters)
{
    uint32_t *triangles = malloc((rays->count ? rays->count : 1) * sizeof *triangles);
    if (!triangles) return MLRT_ERROR_OUT_OF_MEMORY;
    const mlrt_trace_options options = {.struct_size = sizeof options, .counters = counters};
    const mlrt_rays input = {.struct_size = sizeof input,
                             .count = rays->count,
                             .origins = {rays->origins, 0},
                             .directions = {rays->directions, 0}};
    const mlrt_hits output = {.struct_size = sizeof output, .triangle = {triangles, 0, 0}};
    int32_t status = rays->is_picture ? mlrt_render_tiles(subject->boxes, &rays->camera, &options, &output, NULL, NULL)
                                      : mlrt_trace_packet(subject->boxes, &input, &options, &output);
    free(triangles);
    return status;
}

// What is left of `all`. Rays beyond the range of float go to the judge without a float test, so it may be nothing.
static uint64_t rest_of(uint64_t all, uint64_t taken)
{
    return all > taken ? all - taken : 0;
}

int32_t count_stages(const struct subject *subject, const struct ray_set *rays, struct stages *stages)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    int32_t status = trace_counting(subject, rays, &counters);
    const uint64_t exact_count = counters.exact_edge_count + counters.exact_range_count + counters.exact_order_count;
    stages->float_count = rest_of(counters.lane_test_count, counters.judged_lane_count + counters.tie_lane_count);
    stages->tie_count = counters.tie_lane_count;
    stages->double_count = rest_of(counters.judged_lane_count, exact_count);
    stages->exact_count = exact_count;
    stages->test_count = counters.triangle_test_count;
    stages->undecided_test_count = counters.undecided_test_count;
    return status;
}
