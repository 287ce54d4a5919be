/* SPDX-License-Identifier: MIT */
/* oracle.c - the right answers, and the errors of others: see oracle.h */
#include "oracle.h"

#include "reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PRINTED_COUNT = 10 };

double wrong_per_million(const struct verdict *verdict)
{
    size_t wrong = verdict->hole_count + verdict->ghost_count + verdict->wrong_triangle_count;
    return verdict->ray_count ? 1e6 * (double)wrong / (double)verdict->ray_count : 0;
}

static struct reference_triangle triangle_of(const struct scene *scene, uint32_t number)
{
    struct reference_triangle triangle = {.triangle = number};
    for (int i = 0; i < 3; i++) {
        memcpy(triangle.corner[i], scene->vertices + 3 * (size_t)scene->indices[3 * (size_t)number + (size_t)i],
               sizeof triangle.corner[i]);
    }
    return triangle;
}

static struct reference_ray ray_of(const struct ray_set *rays, size_t i)
{
    struct reference_ray ray = {.t_max = INFINITY, .skip = {REFERENCE_NONE, REFERENCE_NONE}};
    memcpy(ray.origin, rays->origins[i], sizeof ray.origin);
    memcpy(ray.direction, rays->directions[i], sizeof ray.direction);
    return ray;
}

static void create_oracle(struct subject *subject)
{
    size_t count = subject->scene.triangle_count;
    struct reference_triangle *triangles = malloc((count ? count : 1) * sizeof *triangles);
    if (!triangles) {
        fprintf(stderr, "not enough memory for %zu triangles\n", count);
        exit(1);
    }
    for (size_t i = 0; i < count; i++) triangles[i] = triangle_of(&subject->scene, (uint32_t)i);
    subject->oracle = reference_create(triangles, count);
    free(triangles);
}

void ask_oracle_for_t(struct subject *subject, const struct ray_set *rays, uint32_t *triangles, float *t)
{
    if (!subject->oracle) create_oracle(subject);
    for (size_t i = 0; i < rays->count; i++) {
        const struct reference_ray ray = ray_of(rays, i);
        struct reference_hit hit;
        reference_trace(subject->oracle, &ray, &hit);
        triangles[i] = hit.triangle;
        if (t) t[i] = hit.t;
    }
}

void ask_oracle(struct subject *subject, const struct ray_set *rays, uint32_t *triangles)
{
    ask_oracle_for_t(subject, rays, triangles, NULL);
}

/*
 * Is `answer` hit at exactly the distance of `right`, the nearest hit? In a scene of these two alone, the answer first,
 * the oracle prefers the answer just then.
 */
static int is_tie(const struct subject *subject, const struct reference_ray *ray, uint32_t right, uint32_t answer)
{
    const struct reference_triangle pair[2] = {triangle_of(&subject->scene, answer),
                                               triangle_of(&subject->scene, right)};
    struct reference_scene *scene = reference_create(pair, 2);
    struct reference_hit hit;
    reference_trace_plain(scene, ray, &hit);
    reference_destroy(scene);
    return hit.triangle == answer;
}

static void print_accusation(const char *accused, const struct reference_ray *ray, uint32_t right, uint32_t answer)
{
    const float *o = ray->origin, *d = ray->direction;
    fprintf(stderr, "%s: triangle %ld instead of %ld: origin %a %a %a direction %a %a %a\n", accused,
            answer == MLRT_NONE ? -1L : (long)answer, right == MLRT_NONE ? -1L : (long)right, (double)o[0],
            (double)o[1], (double)o[2], (double)d[0], (double)d[1], (double)d[2]);
}

struct verdict judge_answers(const struct subject *subject, const struct ray_set *rays, const uint32_t *right,
                             const uint32_t *answers, const char *accused)
{
    struct verdict verdict = {.ray_count = rays->count};
    size_t printed = 0;
    for (size_t i = 0; i < rays->count; i++) {
        if (answers[i] == right[i]) continue;
        const struct reference_ray ray = ray_of(rays, i);
        if (answers[i] == MLRT_NONE)
            verdict.hole_count++;
        else if (right[i] == MLRT_NONE)
            verdict.ghost_count++;
        else if (is_tie(subject, &ray, right[i], answers[i]))
            verdict.tie_count++;
        else
            verdict.wrong_triangle_count++;
        if (accused && printed++ < PRINTED_COUNT) print_accusation(accused, &ray, right[i], answers[i]);
    }
    return verdict;
}

static int is_hit(const struct subject *subject, const struct reference_ray *ray, uint32_t number)
{
    const struct reference_triangle triangle = triangle_of(&subject->scene, number);
    struct reference_scene *scene = reference_create(&triangle, 1);
    struct reference_hit hit;
    reference_trace_plain(scene, ray, &hit);
    reference_destroy(scene);
    return hit.triangle == number;
}

enum error_kind sort_answer(const struct subject *subject, const struct ray_set *rays, size_t i, uint32_t right,
                            float right_t, uint32_t answer, float t)
{
    const struct reference_ray ray = ray_of(rays, i);
    if (answer == right) return right == MLRT_NONE || t == right_t ? RIGHT : ROUNDED_T;
    if (answer == MLRT_NONE) return HOLE;
    if (right == MLRT_NONE) return GHOST;
    if (!is_hit(subject, &ray, answer)) return WRONG_TRIANGLE;
    if (!is_tie(subject, &ray, right, answer)) return WRONG_ORDER;
    return t == right_t ? RIGHT : ROUNDED_T;
}

void destroy_oracle(struct subject *subject)
{
    reference_destroy(subject->oracle);
    subject->oracle = NULL;
}
