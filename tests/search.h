/* SPDX-License-Identifier: MIT */
/* search.h - looks for inputs that break a bound, by hill climbing on their bits */
#ifndef SEARCH_H
#define SEARCH_H

#include "support.h"

#define INPUT_LIMIT 32
#define CLIMB_COUNT 5
#define STEP_COUNT  (SANITIZED ? 3000 : 12000)

/*
 * `attack` returns the error over the bound, or less than 0 if the input is none that it is about. The inputs in the
 * mask `safe` are what rays are made of, 0 or of magnitude 2^-60 .. 2^60; all others are corners of triangles, up to
 * 2^60.
 */
struct bound {
    const char *name;
    int input_count;
    uint32_t safe;
    double (*attack)(const float *input);
    double needed;      /* the search must get so far, or it is too weak to say anything */
    const float *known; /* the worst input of a longer search, or NULL */
};

/* Draws the inputs that a climb begins with. */
typedef void (*draw_function)(struct random *random, const struct bound *bound, float *input);

/* So many times as many climbs as else. */
extern size_t search_effort;

/* The nearest number that an input may be. */
float clamp_input(float a, int is_safe);

/* Climbs so often, so many steps. Fails if an input breaks the bound, or if the search does not get near. */
void attack_bound(const struct bound *bound, draw_function draw, size_t climb_count, size_t step_count);

#endif
