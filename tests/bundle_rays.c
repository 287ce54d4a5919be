/* SPDX-License-Identifier: MIT */
/*
 * See bundle_rays.h. As in hostile_rays.c, everything is computed in double and rounded to finite floats.
 */
#include "bundle_rays.h"

#include "hostile_rays.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* A vertex, a point of a triangle, a point with a coordinate (or two) of vertices, or any point near the scene. */
static void draw_place(struct random *random, const struct fixture *fixture, float place[3])
{
    float vertex[3];
    const uint32_t kind = draw_below(random, 8);
    if (kind < 2) {
        draw_vertex(random, fixture, place);
        return;
    }
    if (kind < 4) {
        draw_target(random, fixture, place);
        return;
    }
    draw_origin(random, fixture, place);
    for (uint32_t i = 0; kind < 6 && i <= kind % 2; i++) {
        draw_vertex(random, fixture, vertex);
        const uint32_t axis = draw_below(random, 3);
        place[axis] = vertex[axis];
    }
}

static double largest(const double v[3])
{
    return fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
}

/* What a length in the scene is like: the size of a triangle, or the distance of two. */
static double draw_length(struct random *random, const struct fixture *fixture)
{
    float a[3], b[3];
    double between[3];
    draw_target(random, fixture, a);
    draw_target(random, fixture, b);
    for (int k = 0; k < 3; k++) between[k] = (double)a[k] - (double)b[k];
    return largest(between) > 0 ? largest(between) : 1;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* An apex and a rectangle of directions: middle + x across + y down with x and y in [-1/2, 1/2]. */
struct frame {
    float eye[3];
    double middle[3];
    double across[3];
    double down[3];
};

static void cross_product(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void set_length(double v[3], double length)
{
    const double size = largest(v);
    for (int k = 0; k < 3; k++) v[k] = size > 0 ? v[k] / size * length : 0;
}

/* Fields from a 2,048th of the distance, where a pixel sees less than a float's last bit, to eight times as wide. */
static void aim_frame(struct random *random, const struct fixture *fixture, struct frame *frame)
{
    float target[3], other[3];
    double aside[3];
    draw_target(random, fixture, target);
    for (int k = 0; k < 3; k++) frame->middle[k] = (double)target[k] - (double)frame->eye[k];
    double size = largest(frame->middle);
    if (!(size > 0)) {
        size = draw_length(random, fixture);
        for (int k = 0; k < 3; k++) frame->middle[k] = size * draw_signed(random);
    }
    if (draw_below(random, 4) == 0) { // along an axis, or along a diagonal of two or three
        const uint32_t axes = 1 + draw_below(random, 7), signs = draw_below(random, 8);
        for (int k = 0; k < 3; k++) frame->middle[k] = axes >> k & 1 ? (signs >> k & 1 ? -size : size) : 0;
    }
    draw_direction(random, other);
    for (int k = 0; k < 3; k++) aside[k] = (double)other[k];
    if (draw_below(random, 3) == 0) { // across an axis
        memset(aside, 0, sizeof aside);
        aside[draw_below(random, 3)] = 1;
    }
    const double field = size * pow(2, 14 * draw_unit(random) - 11);
    cross_product(frame->middle, aside, frame->across);
    set_length(frame->across, field);
    cross_product(frame->middle, frame->across, frame->down);
    set_length(frame->down, field);
}

static struct frame draw_frame(struct random *random, const struct fixture *fixture)
{
    struct frame frame;
    if (draw_below(random, 2))
        draw_place(random, fixture, frame.eye);
    else
        draw_origin(random, fixture, frame.eye);
    aim_frame(random, fixture, &frame);
    return frame;
}

static double column_of(struct bundle_shape shape, size_t i)
{
    return ((double)(i % shape.width) - (double)(shape.width / 2)) / shape.width;
}

static double row_of(struct bundle_shape shape, size_t i)
{
    const size_t rows = (shape.count + shape.width - 1) / shape.width;
    return ((double)(i / shape.width) - (double)(rows / 2)) / (double)rows;
}

static void frame_direction(const struct frame *frame, struct bundle_shape shape, size_t i, float direction[3])
{
    const double x = column_of(shape, i), y = row_of(shape, i);
    for (int k = 0; k < 3; k++)
        direction[k] = round_finite(frame->middle[k] + x * frame->across[k] + y * frame->down[k]);
}

/* ---- triangles that blocks share --------------------------------------------------------------------------------- */

/*
 * Targets that rays of a block have in common: vertices, points on edges and inner points of one triangle for all rays,
 * or of one for each block of 4x4. So packets stay narrow and pass edges and vertices exactly, or as nearly as can be.
 */
struct shared_targets {
    uint64_t seed;
    uint32_t size; /* of a block; 0 = what rays are aimed at has nothing to do with triangles */
};

static struct shared_targets draw_shared_targets(struct random *random)
{
    static const uint32_t sizes[] = {0, 0, 4, 4, 16, UINT32_MAX};
    return (struct shared_targets){draw_bits(random), sizes[draw_below(random, 6)]};
}

/* 0 if there is no target. */
static int draw_shared_target(struct random *random, const struct fixture *fixture,
                              const struct shared_targets *targets, struct bundle_shape shape, size_t i,
                              float target[3])
{
    if (!targets->size) return 0;
    struct random own = {targets->seed + 1000 * (i / shape.width / targets->size) + i % shape.width / targets->size};
    const struct reference_triangle *triangle = draw_triangle(&own, fixture);
    if (triangle) draw_point_of_triangle(random, triangle, target);
    return triangle != NULL;
}

/* ---- what a frame sees ------------------------------------------------------------------------------------------- */

void trace_rays_singly(const mlrt_tree *tree, const struct ray_list *list, const uint32_t *masks, uint32_t common_mask,
                       struct reference_hit *hits)
{
    const mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_RAY, .mask = common_mask};
    mlrt_rays rays = public_rays(list);
    const mlrt_hits out = public_hits(hits, 0);
    rays.mask.data = masks;
    assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &out), MLRT_OK);
}

/* The rays of a frame, what they hit, and where: of rays that miss, the end of their direction. */
struct sight {
    struct ray_list list;
    struct reference_hit *hits;
    float (*points)[3];
};

static struct sight look(const struct fixture *fixture, const struct frame *frame, struct bundle_shape shape)
{
    struct sight sight = {.hits = allocate_or_fail(shape.count, sizeof *sight.hits),
                          .points = allocate_or_fail(shape.count, sizeof *sight.points)};
    for (size_t i = 0; i < shape.count; i++) {
        float direction[3];
        frame_direction(frame, shape, i, direction);
        add_ray(&sight.list, frame->eye, direction);
    }
    trace_rays_singly(fixture->tree, &sight.list, NULL, 0, sight.hits);
    for (size_t i = 0; i < shape.count; i++) {
        const struct reference_ray *ray = &sight.list.rays[i];
        const double t = isfinite(sight.hits[i].t) ? (double)sight.hits[i].t : 1;
        for (int k = 0; k < 3; k++)
            sight.points[i][k] = round_finite((double)ray->origin[k] + t * (double)ray->direction[k]);
    }
    return sight;
}

static void free_sight(struct sight *sight)
{
    free_rays(&sight->list);
    free(sight->hits);
    free(sight->points);
}

static void skip_hit(struct reference_ray *ray, const struct reference_hit *hit)
{
    ray->skip[0] = hit->mesh;
    ray->skip[1] = hit->triangle;
}

/* The normal of the triangle that was hit, of largest component 1; 0 for a miss. */
static void normal_of_hit(const struct fixture *fixture, const struct reference_hit *hit, double normal[3])
{
    double ab[3], ac[3];
    memset(normal, 0, 3 * sizeof *normal);
    if (hit->mesh == MLRT_NONE) return;
    const struct reference_triangle *triangle = NULL;
    if (hit->triangle < reference_triangle_count(fixture->reference))
        triangle = reference_triangle_at(fixture->reference, hit->triangle);
    if (!triangle || triangle->mesh != hit->mesh || triangle->triangle != hit->triangle)
        triangle = reference_find(fixture->reference, hit->mesh, hit->triangle);
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)triangle->corner[1][k] - (double)triangle->corner[0][k];
        ac[k] = (double)triangle->corner[2][k] - (double)triangle->corner[0][k];
    }
    cross_product(ab, ac, normal);
    set_length(normal, 1);
}

/* ---- kinds ------------------------------------------------------------------------------------------------------- */

typedef void add_function(struct ray_list *list, struct random *random, const struct fixture *fixture,
                          struct bundle_shape shape);

static float draw_end(struct random *random)
{
    const float ends[] = {1, next_float(1, 1), next_float(1, -1), 0.9999f, INFINITY};
    return ends[draw_below(random, sizeof ends / sizeof ends[0])];
}

/* From what is seen to a light: d = fl(light - o), so that rays end there but for a rounding, at t = 1. */
static void add_to_light(struct ray_list *list, struct random *random, const struct fixture *fixture,
                         struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    float light[3], end = draw_end(random);
    draw_place(random, fixture, light);
    if (draw_below(random, 8) == 0) memcpy(light, sight.points[draw_below(random, (uint32_t)shape.count)], 12);
    const int each = draw_below(random, 4) == 0, skips = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        struct reference_ray *ray = add_ray_towards(list, sight.points[i], light);
        ray->t_max = each ? draw_end(random) : end;
        if (skips) skip_hit(ray, &sight.hits[i]);
    }
    free_sight(&sight);
}

/* The same segments from the light's side: one origin, and each ray ends at what it may touch. */
static void add_from_light(struct ray_list *list, struct random *random, const struct fixture *fixture,
                           struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    float light[3], end = draw_end(random);
    draw_place(random, fixture, light);
    const struct shared_targets targets = draw_shared_targets(random);
    const int skips = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        const int is_shared = draw_shared_target(random, fixture, &targets, shape, i, sight.points[i]);
        struct reference_ray *ray = add_ray_towards(list, light, sight.points[i]);
        ray->t_max = end;
        if (skips && !is_shared) skip_hit(ray, &sight.hits[i]);
    }
    free_sight(&sight);
}

/* From what is seen to what is seen elsewhere: rays begin and end on surfaces, and may skip one of both. */
static void add_between_surfaces(struct ray_list *list, struct random *random, const struct fixture *fixture,
                                 struct bundle_shape shape)
{
    const struct frame near_frame = draw_frame(random, fixture), far_frame = draw_frame(random, fixture);
    struct sight near = look(fixture, &near_frame, shape), far = look(fixture, &far_frame, shape);
    const float end = draw_end(random);
    const uint32_t skips = draw_below(random, 3);
    for (size_t i = 0; i < shape.count; i++) {
        struct reference_ray *ray = add_ray_towards(list, near.points[i], far.points[i]);
        ray->t_max = end;
        if (skips) skip_hit(ray, skips == 1 ? &near.hits[i] : &far.hits[i]);
    }
    free_sight(&near);
    free_sight(&far);
}

/* From vertices, edges and planes of the scene to one point. */
static void add_scattered_to_light(struct ray_list *list, struct random *random, const struct fixture *fixture,
                                   struct bundle_shape shape)
{
    float light[3], point[3], end = draw_end(random);
    draw_place(random, fixture, light);
    for (size_t i = 0; i < shape.count; i++) {
        draw_place(random, fixture, point);
        add_ray_towards(list, point, light)->t_max = end;
    }
}

/* To, or from, a light that is far outside: rays that are nearly parallel. */
static void add_far_apex(struct ray_list *list, struct random *random, const struct fixture *fixture,
                         struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    const double distance = draw_length(random, fixture) * pow(2, 6 + 30 * draw_unit(random));
    float apex[3];
    draw_direction(random, apex);
    for (int k = 0; k < 3; k++) apex[k] = round_finite((double)apex[k] * distance);
    const int from = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        struct reference_ray *ray =
            from ? add_ray_towards(list, apex, sight.points[i]) : add_ray_towards(list, sight.points[i], apex);
        if (draw_below(random, 8) == 0) ray->t_max = 1;
    }
    free_sight(&sight);
}

/* A fan whose apex lies behind where its rays begin: on a sphere around it, in a plane, or anywhere. */
static void add_apex_behind(struct ray_list *list, struct random *random, const struct fixture *fixture,
                            struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    const uint32_t kind = draw_below(random, 4), axis = draw_below(random, 3);
    const int halvings = (int)draw_below(random, 10);
    const double start = ldexp(1 + draw_unit(random), -halvings);
    float plane[3];
    draw_vertex(random, fixture, plane);
    for (size_t i = 0; i < shape.count; i++) {
        float direction[3], origin[3];
        frame_direction(&frame, shape, i, direction);
        double s = start;
        if (kind == 1) s *= draw_unit(random);
        if (kind == 2 && direction[axis] != 0)
            s = ((double)plane[axis] - (double)frame.eye[axis]) / (double)direction[axis];
        if (kind == 3) s = s < 0.5 ? 0.5 : 0.25; // exact, where the apex has few bits
        for (int k = 0; k < 3; k++) origin[k] = round_finite((double)frame.eye[k] + s * (double)direction[k]);
        if (kind == 2 && direction[axis] != 0) origin[axis] = plane[axis];
        add_ray(list, origin, direction);
    }
}

/* The numbers of `v` to so few bits of the largest that sums with short numbers are exact. */
static void shorten(float v[3], int bits)
{
    int exponent;
    frexp(fmax(fabs((double)v[0]), fmax(fabs((double)v[1]), fabs((double)v[2]))), &exponent);
    for (int k = 0; k < 3; k++) v[k] = round_finite(ldexp(rint(ldexp((double)v[k], bits - exponent)), exponent - bits));
}

/* All rays pass one point of the scene: a vertex, a point on an edge, in a triangle or in its plane. */
static void add_waist(struct ray_list *list, struct random *random, const struct fixture *fixture,
                      struct bundle_shape shape)
{
    struct frame frame;
    draw_place(random, fixture, frame.eye);
    aim_frame(random, fixture, &frame);
    const int is_short = draw_below(random, 2) != 0, is_uneven = draw_below(random, 4) == 0;
    const int ulps = draw_below(random, 3) ? 0 : (int)draw_below(random, 3);
    const double before = ldexp(1, (int)draw_below(random, 4) - 2);
    const struct shared_targets targets = draw_shared_targets(random);
    for (size_t i = 0; i < shape.count; i++) {
        float direction[3], origin[3];
        if (draw_shared_target(random, fixture, &targets, shape, i, origin))
            reference_difference(origin, frame.eye, direction);
        else
            frame_direction(&frame, shape, i, direction);
        if (is_short) shorten(direction, 8);
        const double s = is_uneven ? before * (1 + draw_unit(random)) : before;
        for (int k = 0; k < 3; k++) origin[k] = round_finite((double)frame.eye[k] - s * (double)direction[k]);
        if (ulps) {
            const uint32_t k = draw_below(random, 3);
            const int step = (int)draw_below(random, 2 * (uint32_t)ulps + 1) - ulps;
            origin[k] = round_finite((double)next_float(origin[k], step));
        }
        add_ray(list, origin, direction);
    }
}

/* A thin lens: origins on a disc, towards points in focus, 1 ray or 16 for each. */
static void add_lens(struct ray_list *list, struct random *random, const struct fixture *fixture,
                     struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    const double size = largest(frame.middle), radius = size * pow(2, -10 * draw_unit(random));
    const double focus = 2 * draw_unit(random);
    const size_t samples = draw_below(random, 2) ? 1 : 16;
    double right[3], down[3];
    memcpy(right, frame.across, sizeof right);
    memcpy(down, frame.down, sizeof down);
    set_length(right, radius);
    set_length(down, radius);
    for (size_t i = 0; i < shape.count; i++) {
        float direction[3], origin[3], target[3];
        frame_direction(&frame, shape, i - i % samples, direction);
        const double x = draw_signed(random), y = draw_signed(random);
        for (int k = 0; k < 3; k++) {
            origin[k] = round_finite((double)frame.eye[k] + x * right[k] + y * down[k]);
            target[k] = round_finite((double)frame.eye[k] + focus * (double)direction[k]);
        }
        add_ray_towards(list, origin, target);
    }
}

/* Columns meet in one line, rows in another: the waist is a segment. Their ends are places of the scene. */
static void add_two_lines(struct ray_list *list, struct random *random, const struct fixture *fixture,
                          struct bundle_shape shape)
{
    float ends[4][3];
    for (int i = 0; i < 4; i++) draw_place(random, fixture, ends[i]);
    for (size_t i = 0; i < shape.count; i++) {
        const double x = 0.5 + column_of(shape, i), y = 0.5 + row_of(shape, i);
        float origin[3], target[3];
        for (int k = 0; k < 3; k++) {
            origin[k] = round_finite((double)ends[0][k] + x * ((double)ends[1][k] - (double)ends[0][k]));
            target[k] = round_finite((double)ends[2][k] + y * ((double)ends[3][k] - (double)ends[2][k]));
        }
        struct reference_ray *ray = add_ray_towards(list, origin, target);
        if (shape.count % 2) ray->t_max = 1;
    }
}

/* A direction: along an axis with zeros of both signs, in a plane across one, from vertex to vertex, or any. */
static void draw_common_direction(struct random *random, const struct fixture *fixture, float direction[3])
{
    float from[3], to[3];
    const uint32_t kind = draw_below(random, 4), axis = draw_below(random, 3);
    draw_direction(random, direction);
    if (kind == 0) {
        const float one = direction[axis] < 0 ? -1.0f : 1.0f;
        for (uint32_t k = 0; k < 3; k++) direction[k] = k == axis ? one : signed_zero(random);
    } else if (kind == 1) {
        direction[axis] = signed_zero(random);
    } else if (kind == 2) {
        draw_vertex(random, fixture, from);
        draw_vertex(random, fixture, to);
        reference_difference(to, from, direction);
    }
}

/* Origins in a grid across the direction, some of whose coordinates are those of vertices. */
static void add_grid(struct ray_list *list, struct random *random, const struct fixture *fixture,
                     struct bundle_shape shape, uint32_t one_in)
{
    float direction[3], place[3], snap[3];
    double middle[3], across[3], down[3], aside[3] = {0, 0, 0};
    draw_common_direction(random, fixture, direction);
    draw_place(random, fixture, place);
    draw_vertex(random, fixture, snap);
    for (int k = 0; k < 3; k++) middle[k] = (double)direction[k];
    const double extent = draw_length(random, fixture) * pow(2, 2 - 10 * draw_unit(random));
    const double back = draw_below(random, 2) ? draw_length(random, fixture) : 0;
    aside[draw_below(random, 3)] = 1;
    cross_product(middle, aside, across);
    set_length(across, extent);
    cross_product(middle, across, down);
    set_length(down, extent);
    set_length(middle, back);
    const uint32_t snapped = draw_below(random, 8);
    const struct shared_targets targets = draw_shared_targets(random);
    for (size_t i = 0; i < shape.count; i++) {
        float origin[3], own[3];
        for (int k = 0; k < 3; k++) {
            origin[k] = round_finite((double)place[k] + column_of(shape, i) * across[k] + row_of(shape, i) * down[k] -
                                     middle[k]);
            own[k] = direction[k];
        }
        if (draw_shared_target(random, fixture, &targets, shape, i, origin)) {
            for (int k = 0; k < 3; k++) origin[k] = round_finite((double)origin[k] - middle[k]);
        } else if (snapped < 3) {
            origin[snapped] = snap[snapped];
        }
        if (one_in && draw_below(random, one_in) == 0) {
            const uint32_t k = draw_below(random, 3);
            own[k] = next_float(own[k], draw_below(random, 2) ? 1 : -1);
        }
        add_ray(list, origin, own);
    }
}

static void add_parallel(struct ray_list *list, struct random *random, const struct fixture *fixture,
                         struct bundle_shape shape)
{
    add_grid(list, random, fixture, shape, 0);
}

/* Parallel but for a last bit: of all rays, or of few. */
static void add_nearly_parallel(struct ray_list *list, struct random *random, const struct fixture *fixture,
                                struct bundle_shape shape)
{
    add_grid(list, random, fixture, shape, draw_below(random, 2) ? 1 : 40);
}

/* One direction, from what is seen. */
static void add_one_way(struct ray_list *list, struct random *random, const struct fixture *fixture,
                        struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    float direction[3];
    draw_common_direction(random, fixture, direction);
    const int skips = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        struct reference_ray *ray = add_ray(list, sight.points[i], direction);
        if (skips) skip_hit(ray, &sight.hits[i]);
    }
    free_sight(&sight);
}

/* An ordinary camera, whose eye may be on a vertex, an edge or in a plane. */
static void add_one_origin(struct ray_list *list, struct random *random, const struct fixture *fixture,
                           struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    const struct shared_targets targets = draw_shared_targets(random);
    for (size_t i = 0; i < shape.count; i++) {
        float direction[3], target[3];
        frame_direction(&frame, shape, i, direction);
        if (draw_shared_target(random, fixture, &targets, shape, i, target))
            reference_difference(target, frame.eye, direction);
        add_ray(list, frame.eye, direction);
    }
}

/* Some rays begin at the eye, others just before or behind what it sees: by rays, packets, or columns of tiles. */
static void add_jump_in_depth(struct ray_list *list, struct random *random, const struct fixture *fixture,
                              struct bundle_shape shape)
{
    static const uint32_t widths[] = {1, 2, 4, 7, 16};
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    const uint32_t width = widths[draw_below(random, 5)], down = draw_below(random, 2) ? width : UINT32_MAX;
    const double share = draw_below(random, 2) ? 1 + 0x1p-12 * draw_signed(random) : 2 * draw_unit(random);
    for (size_t i = 0; i < shape.count; i++) {
        struct reference_ray ray = sight.list.rays[i];
        if ((i % shape.width / width + i / shape.width / down) % 2) {
            for (int k = 0; k < 3; k++)
                ray.origin[k] =
                    round_finite((double)ray.origin[k] + share * ((double)sight.points[i][k] - (double)ray.origin[k]));
        }
        add_ray(list, ray.origin, ray.direction);
    }
    free_sight(&sight);
}

/* Turns axes and signs of a view's rays from lane to lane, packet to packet, or tile to tile. */
static void add_axes_that_differ(struct ray_list *list, struct random *random, const struct fixture *fixture,
                                 struct bundle_shape shape)
{
    static const uint32_t widths[] = {1, 2, 4, 5, 16, 64};
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    const uint32_t turn = widths[draw_below(random, 6)], flip = widths[draw_below(random, 6)];
    const uint32_t turned = draw_below(random, 4), flipped = draw_below(random, 8), from = draw_below(random, 3);
    for (size_t i = 0; i < shape.count; i++) {
        const size_t column = i % shape.width, row = i / shape.width;
        const uint32_t turns = turned ? (uint32_t)(column / turn + row / turn) % 3 : 0;
        const int is_flipped = (column / flip + row / flip) % 2 != 0;
        const float *d = sight.list.rays[i].direction;
        float direction[3];
        for (uint32_t k = 0; k < 3; k++) {
            direction[k] = d[(k + turns) % 3];
            if (is_flipped && flipped >> k & 1) direction[k] = -direction[k];
        }
        add_ray(list, from == 0 ? sight.points[i] : frame.eye, direction);
    }
    free_sight(&sight);
}

/* A mirror: from what is seen, d - 2 (d . n) n. */
static void add_reflections(struct ray_list *list, struct random *random, const struct fixture *fixture,
                            struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    const int skips = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        const float *d = sight.list.rays[i].direction;
        double n[3], along = 0, square = 0;
        float direction[3];
        normal_of_hit(fixture, &sight.hits[i], n);
        for (int k = 0; k < 3; k++) {
            along += (double)d[k] * n[k];
            square += n[k] * n[k];
        }
        for (int k = 0; k < 3; k++)
            direction[k] = square > 0 ? round_finite((double)d[k] - 2 * along / square * n[k]) : d[k];
        struct reference_ray *ray = add_ray(list, sight.points[i], direction);
        if (skips) skip_hit(ray, &sight.hits[i]);
    }
    free_sight(&sight);
}

/*
 * Sixteen rays from each of the points that are seen, to the side that they are seen from. Those of some points have
 * one direction, and all of them end at a vertex's plane across an axis, or a float beside it.
 */
static void add_hemispheres(struct ray_list *list, struct random *random, const struct fixture *fixture,
                            struct bundle_shape shape)
{
    const struct frame frame = draw_frame(random, fixture);
    struct sight sight = look(fixture, &frame, shape);
    const int skips = draw_below(random, 2) != 0;
    const float reach = draw_below(random, 2) ? round_finite(0.1 * draw_length(random, fixture)) : INFINITY;
    float vertex[3], direction[3];
    uint32_t axis = 0;
    int is_one_way = 0;
    for (size_t i = 0; i < shape.count; i++) {
        const size_t from = i - i % 16;
        double n[3], along = 0;
        normal_of_hit(fixture, &sight.hits[from], n);
        if (i == from) {
            is_one_way = draw_below(random, 4) == 0;
            axis = draw_below(random, 3);
            draw_vertex(random, fixture, vertex);
        }
        if (i == from || !is_one_way) draw_direction(random, direction);
        for (int k = 0; k < 3; k++) along += (double)direction[k] * n[k];
        const int is_behind = (along > 0) == (sight.hits[from].facing > 0);
        for (int k = 0; k < 3; k++) direction[k] = is_behind ? -direction[k] : direction[k];
        struct reference_ray *ray = add_ray(list, sight.points[from], direction);
        ray->t_max = reach;
        if (is_one_way && direction[axis] != 0) {
            const double t = fabs(((double)vertex[axis] - sight.points[from][axis]) / (double)direction[axis]);
            ray->t_max = next_float(round_finite(t), draw_below(random, 2) ? 1 : -1);
        }
        if (skips) skip_hit(ray, &sight.hits[from]);
    }
    free_sight(&sight);
}

/* In the planes of triangles that lie across an axis, or of any: rays that graze, or have a coordinate of 0. */
static void add_in_plane(struct ray_list *list, struct random *random, const struct fixture *fixture,
                         struct bundle_shape shape)
{
    float apex[3], target[3], plane[3];
    const uint32_t axis = draw_below(random, 3);
    draw_vertex(random, fixture, plane);
    draw_place(random, fixture, apex);
    apex[axis] = plane[axis];
    const int is_common = draw_below(random, 2) != 0;
    for (size_t i = 0; i < shape.count; i++) {
        if (!is_common) {
            draw_place(random, fixture, apex);
            apex[axis] = plane[axis];
        }
        draw_place(random, fixture, target);
        if (draw_below(random, 8)) target[axis] = plane[axis];
        struct reference_ray *ray = add_ray_towards(list, apex, target);
        if (ray->direction[axis] == 0) ray->direction[axis] = signed_zero(random);
    }
}

/* A point of the plane of a triangle, as far as floats go: around it, or on one of its edges' lines. */
static void draw_point_in_plane(struct random *random, const struct reference_triangle *triangle, float point[3])
{
    const float *a = triangle->corner[0], *b = triangle->corner[1], *c = triangle->corner[2];
    const double u = 6 * draw_unit(random) - 3, v = draw_below(random, 3) ? 6 * draw_unit(random) - 3 : 0;
    for (int k = 0; k < 3; k++)
        point[k] = round_finite((double)a[k] + u * ((double)b[k] - (double)a[k]) + v * ((double)c[k] - (double)a[k]));
}

/*
 * Along the plane of one triangle, whatever its tilt: from one point of it, to one, or neither. Origins lie in the
 * plane, or up to 2^20 floats aside, where the direction is surely not in it, and t is still badly conditioned.
 */
static void add_grazing(struct ray_list *list, struct random *random, const struct fixture *fixture,
                        struct bundle_shape shape)
{
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    const struct frame frame = draw_frame(random, fixture);
    const uint32_t common = draw_below(random, 3), axis = draw_below(random, 3);
    const int steps = draw_below(random, 4) ? 1 << draw_below(random, 21) : 0;
    float origin[3], target[3], fixed[3];
    if (triangle) draw_point_in_plane(random, triangle, fixed);
    if (triangle) fixed[axis] = round_finite((double)next_float(fixed[axis], steps));
    for (size_t i = 0; i < shape.count; i++) {
        if (!triangle) {
            frame_direction(&frame, shape, i, target);
            add_ray(list, frame.eye, target);
            continue;
        }
        draw_point_in_plane(random, triangle, origin);
        draw_point_of_triangle(random, triangle, target);
        if (common == 0) memcpy(origin, fixed, sizeof origin);
        if (common == 1) memcpy(target, fixed, sizeof target);
        if (common) origin[axis] = round_finite((double)next_float(origin[axis], steps));
        add_ray_towards(list, origin, target);
    }
}

static void add_copies(struct ray_list *list, struct random *random, const struct fixture *fixture,
                       struct bundle_shape shape)
{
    float origin[3], target[3];
    draw_place(random, fixture, origin);
    draw_target(random, fixture, target);
    for (size_t i = 0; i < shape.count; i++) add_ray_towards(list, origin, target);
}

/* From anywhere to vertices, edges and inner points. */
static void add_aimed(struct ray_list *list, struct random *random, const struct fixture *fixture,
                      struct bundle_shape shape)
{
    float origin[3], target[3];
    for (size_t i = 0; i < shape.count; i++) {
        draw_origin(random, fixture, origin);
        draw_target(random, fixture, target);
        add_ray_towards(list, origin, target);
    }
}

static void add_random(struct ray_list *list, struct random *random, const struct fixture *fixture,
                       struct bundle_shape shape)
{
    float origin[3], direction[3];
    for (size_t i = 0; i < shape.count; i++) {
        draw_origin(random, fixture, origin);
        draw_direction(random, direction);
        add_ray(list, origin, direction);
    }
}

/* Bundles of a few rays each, one after the other, where blocks of 16 and of 256 do not begin. */
static void add_several(struct ray_list *list, struct random *random, const struct fixture *fixture,
                        struct bundle_shape shape);

static const struct {
    const char *name;
    add_function *add;
} kinds[] = {
    {"meet_at_their_ends", add_to_light},
    {"meet_at_their_ends_from_anywhere", add_scattered_to_light},
    {"end_at_what_they_may_touch", add_from_light},
    {"go_between_surfaces", add_between_surfaces},
    {"meet_far_away", add_far_apex},
    {"meet_behind_their_origins", add_apex_behind},
    {"cross_at_a_waist", add_waist},
    {"cross_in_a_lens", add_lens},
    {"cross_in_two_lines", add_two_lines},
    {"are_parallel", add_parallel},
    {"are_parallel_but_for_one_bit", add_nearly_parallel},
    {"go_one_way_from_surfaces", add_one_way},
    {"leave_one_origin", add_one_origin},
    {"jump_in_depth", add_jump_in_depth},
    {"differ_in_main_axis_and_signs", add_axes_that_differ},
    {"are_reflected", add_reflections},
    {"leave_origins_by_sixteen", add_hemispheres},
    {"lie_in_planes", add_in_plane},
    {"graze_triangles", add_grazing},
    {"are_all_the_same", add_copies},
    {"are_aimed_from_anywhere", add_aimed},
    {"are_wholly_random", add_random},
    {"change_kind_on_the_way", add_several},
};

enum { KIND_COUNT = sizeof kinds / sizeof kinds[0] };

static void add_several(struct ray_list *list, struct random *random, const struct fixture *fixture,
                        struct bundle_shape shape)
{
    for (size_t left = shape.count; left > 0;) {
        const size_t limit = left < 300 ? left : 300;
        const struct bundle_shape part = {1 + draw_below(random, (uint32_t)limit), 4 + draw_below(random, 30)};
        kinds[draw_below(random, KIND_COUNT - 1)].add(list, random, fixture, part);
        left -= part.count;
    }
}

size_t bundle_kind_count(void)
{
    return KIND_COUNT;
}

const char *bundle_kind_name(size_t kind)
{
    return kinds[kind].name;
}

void add_bundle_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t kind,
                     struct bundle_shape shape)
{
    const size_t first = list->count;
    kinds[kind].add(list, random, fixture, shape);
    assert_int_equal(list->count - first, shape.count);
}

/* ---- changes ----------------------------------------------------------------------------------------------------- */

static void scale_ray(struct reference_ray *ray, int power)
{
    for (int k = 0; k < 3; k++) ray->direction[k] = round_finite(ldexp((double)ray->direction[k], power));
    if (isfinite(ray->t_max)) ray->t_max = round_finite(ldexp((double)ray->t_max, -power));
}

void stretch_directions(struct ray_list *list, struct random *random)
{
    static const int limits[] = {2, 10, 40, 90};
    const uint32_t kind = draw_below(random, 6);
    const int limit = limits[draw_below(random, 4)], power = (int)draw_below(random, 2 * (uint32_t)limit + 1) - limit;
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        const double d[3] = {(double)ray->direction[0], (double)ray->direction[1], (double)ray->direction[2]};
        if (kind == 0) scale_ray(ray, power);
        if (kind == 1) scale_ray(ray, (int)draw_below(random, 2 * (uint32_t)limit + 1) - limit);
        if (kind == 2 && largest(d) > 0) {
            const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (int k = 0; k < 3; k++) ray->direction[k] = (float)(d[k] / length);
        }
    }
}

static void make_odd(struct reference_ray *ray, struct random *random, const struct fixture *fixture)
{
    static const float numbers[] = {NAN,       INFINITY,   -INFINITY, 1e30f,    -1e30f,   FLT_MAX,  -FLT_MAX, 0x1p-140f,
                                    0x1p-149f, -0x1p-140f, 0x1p60f,   -0x1p61f, 0x1p-60f, 0x1p-61f, 0.0f,     -0.0f};
    const float number = numbers[draw_below(random, sizeof numbers / sizeof numbers[0])];
    const uint32_t k = draw_below(random, 3);
    float old[3];
    memcpy(old, ray->direction, sizeof old);
    switch (draw_below(random, 12)) {
    case 0:
        ray->direction[k] = number;
        break;
    case 1:
        ray->origin[k] = number;
        break;
    case 2:
        for (int j = 0; j < 3; j++) ray->direction[j] = signed_zero(random);
        break;
    case 3:
        for (int j = 0; j < 3; j++) ray->direction[j] = 0x1p-140f * (draw_below(random, 2) ? 1.0f : -3.0f);
        break;
    case 4:
        for (int j = 0; j < 3; j++) ray->direction[j] = -old[j];
        break;
    case 5:
        for (uint32_t j = 0; j < 3; j++) ray->direction[j] = old[(j + 1 + k % 2) % 3];
        break;
    case 6:
        ray->direction[k] = -old[k];
        break;
    case 7:
        draw_place(random, fixture, ray->origin);
        break;
    case 8:
        draw_direction(random, ray->direction);
        break;
    case 9:
        scale_ray(ray, (int)draw_below(random, 200) - 100);
        break;
    case 10:
        ray->direction[k] = isfinite(old[k]) ? next_float(old[k], draw_below(random, 2) ? 1 : -1) : 0;
        break;
    default:
        ray->direction[k] = signed_zero(random);
    }
}

void spoil_bundle(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    const uint32_t kind = draw_below(random, 8), rarity = 2 + draw_below(random, 60);
    const size_t position = draw_below(random, (uint32_t)list->count);
    for (size_t i = 0; i < list->count; i++) {
        const int is_odd = kind < 2    ? i == position
                           : kind == 2 ? i % 16 == i / 16 % 16
                           : kind == 3 ? draw_below(random, rarity) == 0
                                       : 0;
        if (is_odd) make_odd(&list->rays[i], random, fixture);
    }
}
