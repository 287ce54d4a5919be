/* SPDX-License-Identifier: MIT */
/*
 * The oracle: the hit rule of the library decided in exact integer arithmetic (GMP), by code that shares nothing with
 * src/, not even a header. The rules R1 to R7 are those of mlrt.h, "Answers" and struct mlrt_camera.
 *
 * Three ways to the same answer, each checked against the one before it in test_reference.c:
 *
 *   reference_trace_plain     every triangle, integers only
 *   reference_trace_filtered  every triangle, doubles with a proven bound first, integers where those leave a doubt
 *   reference_trace           the same behind a box tree of its own, for large scenes
 *
 * A scene holds scratch numbers: one thread at a time. The caller's floating-point environment must be the default one.
 */
#ifndef TESTS_REFERENCE_H
#define TESTS_REFERENCE_H

#include <gmp.h>
#include <stddef.h>
#include <stdint.h>

#define REFERENCE_NONE 0xFFFFFFFFu

/* A triangle with the names it is reported by. Of two at the same distance the earlier in the array is the hit. */
struct reference_triangle {
    float corner[3][3];
    uint32_t mesh;
    uint32_t triangle;
};

struct reference_ray {
    float origin[3];
    float direction[3];
    float t_min;
    float t_max;      /* literal: 0 means 0 */
    uint32_t skip[2]; /* mesh and triangle to pass; mesh REFERENCE_NONE = none */
};

struct reference_hit {
    float t;
    float u;
    float v;
    uint32_t mesh;
    uint32_t triangle;
    int32_t facing;
};

struct reference_scene;

/* Copies the triangles. Ends the program if there is no memory. */
struct reference_scene *reference_create(const struct reference_triangle *triangles, size_t count);
void reference_destroy(struct reference_scene *scene);

void reference_trace_plain(struct reference_scene *scene, const struct reference_ray *ray, struct reference_hit *hit);
void reference_trace_filtered(struct reference_scene *scene, const struct reference_ray *ray,
                              struct reference_hit *hit);
void reference_trace(struct reference_scene *scene, const struct reference_ray *ray, struct reference_hit *hit);

/* One of all hits of a ray. */
struct reference_list_hit {
    struct reference_hit hit;
    int crossing; /* 1 = also hit if the origin moves by (eps, eps^2, eps^3), for all small eps > 0 */
};

struct reference_totals {
    size_t hit_count;
    size_t crossing_count; /* of these: odd if o is inside a closed mesh */
};

/*
 * All hits of the ray, nearest first and ties in the order of the input: rule R6. The first `capacity` of them go to
 * hits[]. The first function does it with integers only, triangle by triangle; the second has filter and tree.
 */
struct reference_totals reference_trace_all_plain(struct reference_scene *scene, const struct reference_ray *ray,
                                                  struct reference_list_hit *hits, size_t capacity);
struct reference_totals reference_trace_all(struct reference_scene *scene, const struct reference_ray *ray,
                                            struct reference_list_hit *hits, size_t capacity);

size_t reference_triangle_count(const struct reference_scene *scene);
const struct reference_triangle *reference_triangle_at(const struct reference_scene *scene, size_t position);

/* The triangle with these names, or NULL. */
const struct reference_triangle *reference_find(const struct reference_scene *scene, uint32_t mesh, uint32_t triangle);

/* Triangles with a vertex that is not finite; of the others, those whose area is exactly zero. */
size_t reference_non_finite_count(const struct reference_scene *scene);
size_t reference_zero_area_count(const struct reference_scene *scene);

/*
 * How far the point from + by is from where the ray meets the triangle's plane, per component, to the precision of
 * double. D of the hit rule must not be 0.
 */
void reference_distance_to_hit(const struct reference_triangle *triangle, const struct reference_ray *ray,
                               const float from[3], const float by[3], double distance[3]);

/* numerator / denominator rounded once to the nearest float, ties to even, denormals and infinity included. */
float reference_quotient(const mpz_t numerator, const mpz_t denominator);

/* The sign of (point - a) . n of the triangle. */
int reference_side(const struct reference_triangle *triangle, const float point[3]);

/* Likewise for the point from + by, a sum that is not rounded. */
int reference_side_of_sum(const struct reference_triangle *triangle, const float from[3], const float by[3]);

/* The sign of direction . n of the triangle. */
int reference_facing(const struct reference_triangle *triangle, const float direction[3]);

/* R7: fl(fl(d00 + fl(x dx)) + fl(y dy)) with x = fl(column + sample_x), y = fl(row + sample_y). */
void reference_pixel_vector(const float d00[3], const float dx[3], const float dy[3], uint32_t column, uint32_t row,
                            float sample_x, float sample_y, float vector[3]);

/* The component-wise difference a - b, rounded to float: the direction of a shadow ray. */
void reference_difference(const float a[3], const float b[3], float difference[3]);

#endif
