/* SPDX-License-Identifier: MIT */
/* search.c - see search.h */
#include "search.h"

#include <math.h>
#include <string.h>

#include "exact/triangle.h"

size_t search_effort = 1;

float clamp_input(float a, int is_safe)
{
    if (!(fabsf(a) <= MLRT_SAFE_MAX)) return copysignf(MLRT_SAFE_MAX, a);
    return is_safe && a != 0 && fabsf(a) < MLRT_SAFE_MIN ? copysignf(MLRT_SAFE_MIN, a) : a;
}

/* Changes up to three inputs. */
static void mutate(struct random *random, const struct bound *bound, float *input)
{
    for (uint32_t i = draw_below(random, 3); i < 3; ++i) {
        const uint32_t n = draw_below(random, (uint32_t)bound->input_count);
        const uint32_t m = draw_below(random, (uint32_t)bound->input_count);
        uint32_t bits = bits_of_float(input[n]);
        switch (draw_below(random, 12)) {
        case 0:
            bits ^= 0x80000000u;
            break;
        case 1:
            bits += draw_below(random, 2) ? 0x00800000u : 0xFF800000u;
            break;
        case 2:
            bits += draw_below(random, 2) ? 0x06000000u : 0xFA000000u;
            break;
        case 3:
            bits = bits_of_float(input[m]) ^ (draw_bits(random) & 0x80000000u);
            break;
        case 4:
            bits = (bits & 0xFF800000u) | draw_below(random, 16);
            break;
        case 5:
        case 6:
        case 7:
            bits += draw_below(random, 7) - 3;
            break;
        default:
            bits ^= 1u << draw_below(random, draw_below(random, 2) ? 8 : 23);
        }
        if ((bits & 0x7F800000u) == 0x7F800000u) continue;
        input[n] = clamp_input(float_of_bits(bits), (int)(bound->safe >> n & 1));
    }
}

struct search {
    double worst;
    float input[INPUT_LIMIT];
    size_t count;
};

static double try_input(const struct bound *bound, const float *input, struct search *search)
{
    const double ratio = bound->attack(input);
    ++search->count;
    if (!(ratio <= search->worst)) {
        search->worst = ratio;
        memcpy(search->input, input, sizeof search->input);
    }
    return ratio;
}

/* From the best of some random inputs uphill; at first a step may lead down a little. */
static void climb(struct random *random, const struct bound *bound, draw_function draw, size_t step_count,
                  struct search *search)
{
    float here[INPUT_LIMIT] = {0}, next[INPUT_LIMIT] = {0};
    double height = -1;
    for (int i = 0; i < 60 || (i < 2000 && height < 0); ++i) {
        draw(random, bound, next);
        const double ratio = try_input(bound, next, search);
        if (ratio <= height) continue;
        height = ratio;
        memcpy(here, next, sizeof here);
    }
    for (size_t i = 0; i < step_count && height >= 0; ++i) {
        const double cooling = 0.06 * (1 - (double)i / (double)step_count);
        memcpy(next, here, sizeof next);
        mutate(random, bound, next);
        const double ratio = try_input(bound, next, search);
        if (!(ratio >= height * (1 - cooling)) || ratio < 0) continue;
        height = ratio;
        memcpy(here, next, sizeof here);
    }
}

static struct search search_for_worst(const struct bound *bound, draw_function draw, size_t climb_count,
                                      size_t step_count)
{
    struct random random = {77};
    struct search search = {.worst = 0};
    if (bound->known) try_input(bound, bound->known, &search);
    for (size_t i = 0; i < scaled(climb_count * search_effort); ++i) climb(&random, bound, draw, step_count, &search);
    return search;
}

void attack_bound(const struct bound *bound, draw_function draw, size_t climb_count, size_t step_count)
{
    const struct search search = search_for_worst(bound, draw, climb_count, step_count);
    print_message("%-34s %.3f found, %zu tries\n", bound->name, search.worst, search.count);
    if (!(search.worst <= 1)) {
        for (int i = 0; i < bound->input_count; ++i) print_error("input %d: %a\n", i, search.input[i]);
    }
    assert_true(search.worst <= 1);
    /* A search as short as that of a build with sanitizers need not get near. */
    if (scaled(8) == 8) assert_true(search.worst >= bound->needed);
}
