/* SPDX-License-Identifier: MIT */
/*
 * What the tests share: random numbers, triangles and rays that hurt, every way to trace them, and the comparison with
 * the reference, bit for bit. The first difference ends the test and prints what is needed to repeat it: the seed, the
 * way of tracing, the ray and the triangles in %a format.
 */
#ifndef TESTS_SUPPORT_H
#define TESTS_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mlrt.h"
#include "reference.h"

/*
 * 1 in a build with sanitizers. Pictures, scenes and numbers of cases are smaller there, since what is found depends on
 * which code runs, not on how often.
 */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

/* `count` as it is, or a sixteenth of it (at least 1) in a build with sanitizers. */
size_t scaled(size_t count);

/* ---- random numbers ---------------------------------------------------------------------------------------------- */

struct random {
    uint64_t state;
};

uint32_t draw_bits(struct random *random);
uint32_t draw_below(struct random *random, uint32_t limit);
float draw_range(struct random *random, float lo, float hi);
float draw_finite(struct random *random); /* any finite float: all bit patterns are equally likely */
void draw_point(struct random *random, float lo, float hi, float point[3]);
float float_of_bits(uint32_t bits);
uint32_t bits_of_float(float value);
float next_float(float value, int steps); /* `steps` floats up (or down); finite values only */

/* ---- triangles --------------------------------------------------------------------------------------------------- */

struct soup {
    float *corners; /* 9 per triangle */
    size_t count;
    size_t capacity;
};

void soup_add_triangle(struct soup *soup, const float a[3], const float b[3], const float c[3]);
void soup_add_quad(struct soup *soup, const float corner[3], const float side[3], const float other_side[3]);
void soup_add_grid(struct soup *soup, int axis, float level, int cells); /* cells^2 quads over [0, cells]^2 */
void soup_add_box(struct soup *soup, const float lo[3], const float hi[3]);
void soup_add_random(struct soup *soup, struct random *random, size_t count, float extent, float size);
void soup_add_needles(struct soup *soup, struct random *random, size_t count, float aspect);
void soup_add_icosphere(struct soup *soup, int subdivisions, float radius);
void soup_add_torus(struct soup *soup, int around, int across, float radius, float tube);
void move_soup(struct soup *soup, float scale, const float offset[3]); /* rounded to float */
void swap_axes(struct soup *soup, int turns);                          /* x -> y -> z -> x, `turns` times */
void free_soup(struct soup *soup);

/* A mesh of the soup's triangles, without indices. */
mlrt_mesh soup_mesh(const struct soup *soup);

/* ---- fixtures ---------------------------------------------------------------------------------------------------- */

struct fixture {
    const char *name;
    uint64_t seed;
    mlrt_tree *tree; /* boxes */
    struct reference_scene *reference;
    mlrt_tree *kdtree; /* may be NULL in a fixture that a test makes itself */
};

/* A tree of a structure (MLRT_STRUCTURE_*), by defaults; a kd-tree is the tuned one. */
mlrt_tree *build_structure(const mlrt_mesh *meshes, size_t count, uint32_t structure);
/* Trees and reference of the same meshes. Options are the kd-tree's; boxes have the same costs. */
struct fixture make_fixture(const char *name, uint64_t seed, const mlrt_mesh *meshes, size_t count);
struct fixture make_fixture_with(const char *name, uint64_t seed, const mlrt_mesh *meshes, size_t count,
                                 const mlrt_kdtree_options *options);
/* Of one soup, which it frees. */
struct fixture fixture_of_soup(const char *name, uint64_t seed, struct soup *soup);
/* Of a procedural scene of the examples: room, office, building, doubled, scan:N. */
struct fixture fixture_of_example(const char *scene_name);
void free_fixture(struct fixture *fixture);

/* ---- rays -------------------------------------------------------------------------------------------------------- */

struct ray_list {
    struct reference_ray *rays;
    size_t count;
    size_t capacity;
    uint32_t row_length;
};

struct reference_ray *add_ray(struct ray_list *list, const float origin[3], const float direction[3]);
struct reference_ray *add_ray_towards(struct ray_list *list, const float origin[3], const float target[3]);
/* Towards vertices, points on edges and inner points of random triangles, from random points in [lo, hi]^3. */
void add_aimed_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count, float lo,
                    float hi);
void add_random_rays(struct ray_list *list, struct random *random, size_t count, float lo, float hi);
/* Axis-parallel ones whose origins share coordinates with vertices; zeros of both signs. */
void add_axis_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count);
/* From vertices and points on edges, in random directions and along edges. */
void add_surface_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count);
/* The ray of mlrt_occluded_points for a point. */
void add_shadow_ray(struct ray_list *list, const float point[3], const uint32_t *skip, const mlrt_light *light);
/* Everything above, a few hundred of each, and then some with t ranges and skips. The box of the rays is [lo, hi]^3. */
void add_mixed_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t count, float lo,
                    float hi);
void free_rays(struct ray_list *list);
mlrt_rays public_rays(const struct ray_list *list);
/* Results into an array of struct reference_hit, with `row` of them per row of pixels (0 = plain). */
mlrt_hits public_hits(struct reference_hit *hits, size_t row);

/* One of all hits of a ray, as the library writes it. */
struct list_element {
    struct reference_hit hit;
    uint8_t crossing;
    uint8_t unused[3];
};

struct list_totals {
    uint32_t total;
    uint32_t crossing_total;
};

/* Results of all hits into these arrays: `capacity` elements and one struct of totals for each ray. */
mlrt_hit_lists public_lists(struct list_element *elements, struct list_totals *totals, uint32_t capacity);

/* ---- ways of tracing --------------------------------------------------------------------------------------------- */

struct variant {
    mlrt_trace_options options;
    uint32_t threads; /* 0 = no pool */
    int probe;        /* 1 = one of the few that small tests use */
    int on_kdtree;    /* 1 = in the kd-tree */
};

size_t variant_count(void);
/*
 * A check that is called often begins at first_variant() and goes on by variant_step(): it takes all variants, or in a
 * build with sanitizers a fifth of them, in turn.
 */
size_t first_variant(void);
size_t variant_step(void);
const struct variant *variant_at(size_t index);
const mlrt_tree *variant_tree(const struct variant *variant, const struct fixture *fixture);
/* The one that a method goes through, MLRT_METHOD_*; boxes if it can go through both. */
const mlrt_tree *method_tree(int32_t method, const struct fixture *fixture);
int is_kdtree_method(int32_t method);
int isa_is_supported(int32_t isa);
int32_t narrowest_isa(void); /* SSE2, or plain C where there is none */

/* The pool of that many threads, made when it is first asked for. NULL for 0. */
mlrt_pool *shared_pool(uint32_t threads);

/* ---- checks ------------------------------------------------------------------------------------------------------ */

void trace_reference(const struct fixture *fixture, const struct ray_list *list, struct reference_hit *hits);

/* trace_packet and trace_ray, closest and any hit, by every variant. */
void check_rays(const struct fixture *fixture, const struct ray_list *list);
/* Only the variants with `probe`. */
void check_rays_quickly(const struct fixture *fixture, const struct ray_list *list);

/* camera_rays, and render_tiles into a frame and a callback at once, closest and any hit, by every variant. */
void check_camera(const struct fixture *fixture, const mlrt_camera *camera);
void check_camera_quickly(const struct fixture *fixture, const mlrt_camera *camera);

/* occluded_points by every variant. `skip` may be NULL: two per point. */
void check_points(const struct fixture *fixture, const float *positions, const uint32_t *skip, size_t count,
                  uint32_t row_length, const mlrt_light *light);

/* Where a camera's crop lies, with the zeros replaced by what they mean. */
void camera_crop(const mlrt_camera *camera, uint32_t *width, uint32_t *height);

/* The rays of the camera by the reference's arithmetic. */
void add_camera_rays(struct ray_list *list, const mlrt_camera *camera);

/* A pinhole camera at `eye` that looks at `target`; `field` is the picture's width at distance 1. */
mlrt_camera look_at(const float eye[3], const float target[3], float field, uint32_t width, uint32_t height);

/* A parallel camera with a picture of `extent` length units around `centre`. */
mlrt_camera look_along(const float centre[3], const float direction[3], float extent, uint32_t width, uint32_t height);

/* One hit against another, for tests that trace by themselves. `what` tells the ways of tracing apart. */
void check_hit(const struct fixture *fixture, const char *what, size_t index, const struct reference_ray *ray,
               const struct reference_hit *expected, const struct reference_hit *got);

/* All six fields, bit for bit. */
int same_hit(const struct reference_hit *a, const struct reference_hit *b);

/* What check_hit says before it ends the test. */
void print_difference(const struct fixture *fixture, const char *what, size_t index, const struct reference_ray *ray,
                      const struct reference_hit *expected, const struct reference_hit *got);

/* A way of tracing in words. */
void describe(const char *call, const mlrt_trace_options *options, uint32_t threads, char *text, size_t size);

/* mlrt_trace_ray with default options, as a reference_hit. */
struct reference_hit trace_one(const mlrt_tree *tree, const struct reference_ray *ray,
                               const mlrt_trace_options *options);

/* `size` bytes, the last of which is followed by a page that must not be touched. Free with free_guarded. */
void *allocate_guarded(size_t size);
void free_guarded(void *block, size_t size);

void *allocate_or_fail(size_t count, size_t size);

/* A point light at (x, y, z), and a directional light that lies in that direction. */
mlrt_light light_at(float x, float y, float z);
mlrt_light light_from(float x, float y, float z);

#endif
