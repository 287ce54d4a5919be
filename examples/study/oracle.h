/* SPDX-License-Identifier: MIT */
/*
 * oracle.h - the right answers, in exact arithmetic, and the errors of others
 *
 * The right answer for a ray is the triangle that tests/reference.c finds with GMP integers: the nearest one hit, of
 * several at exactly the same distance the first of the mesh; or a miss. It shares no code with the library.
 */
#ifndef ORACLE_H
#define ORACLE_H

#include "generator.h"

/* How many answers of a method were what. A wrong decision is a hole, a ghost or a wrong triangle. */
struct verdict {
    size_t ray_count;
    size_t hole_count;           // a miss where the ray hits
    size_t ghost_count;          // a hit where the ray misses
    size_t wrong_triangle_count; // a hit of a triangle that is not the nearest: behind it, or not hit at all
    size_t tie_count;            // not wrong: another triangle, hit by the ray at exactly the same distance
};

double wrong_per_million(const struct verdict *verdict);

/* Writes the right triangle of each ray, MLRT_NONE for a miss. The first call for a subject takes longer. */
void ask_oracle(struct subject *subject, const struct ray_set *rays, uint32_t *triangles);

/* The same, and t of each hit, correctly rounded. */
void ask_oracle_for_t(struct subject *subject, const struct ray_set *rays, uint32_t *triangles, float *t);

/* What an answer can be. */
enum error_kind { RIGHT, HOLE, GHOST, WRONG_TRIANGLE, WRONG_ORDER, ROUNDED_T, ERROR_KIND_COUNT };

/*
 * Sorts the answer to ray i: WRONG_ORDER is a triangle that the ray hits behind the nearest, WRONG_TRIANGLE one that it
 * does not hit; ROUNDED_T the right triangle, or one at the same distance, with another t than the correctly rounded
 * one.
 */
enum error_kind sort_answer(const struct subject *subject, const struct ray_set *rays, size_t i, uint32_t right,
                            float right_t, uint32_t answer, float t);

/*
 * Compares answers with the right ones. With `accused` not NULL, each answer that differs from the right one (a tie,
 * too) is printed on stderr with its ray in hexadecimal, the first few of them, as what `accused` said.
 */
struct verdict judge_answers(const struct subject *subject, const struct ray_set *rays, const uint32_t *right,
                             const uint32_t *answers, const char *accused);

void destroy_oracle(struct subject *subject);

#endif
