/* SPDX-License-Identifier: MIT */
/*
 * See hostile_rays.h. Everything is drawn in double and rounded to finite floats, so that no scale needs a case of its
 * own.
 */
#include "hostile_rays.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- points ------------------------------------------------------------------------------------------------------ */

float round_finite(double value)
{
    if (value > (double)FLT_MAX) return FLT_MAX;
    if (value < -(double)FLT_MAX) return -FLT_MAX;
    return (float)value;
}

double draw_unit(struct random *random)
{
    return (double)draw_bits(random) / 4294967296.0;
}

double draw_signed(struct random *random)
{
    return 2 * draw_unit(random) - 1;
}

const struct reference_triangle *draw_triangle(struct random *random, const struct fixture *fixture)
{
    size_t count = reference_triangle_count(fixture->reference);
    for (int attempt = 0; count > 0 && attempt < 20; attempt++) {
        const struct reference_triangle *triangle =
            reference_triangle_at(fixture->reference, draw_below(random, (uint32_t)count));
        int finite = 1;
        for (int n = 0; n < 9; n++) finite &= isfinite(triangle->corner[n / 3][n % 3]) != 0;
        if (finite) return triangle;
    }
    return NULL;
}

void draw_vertex(struct random *random, const struct fixture *fixture, float vertex[3])
{
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    memset(vertex, 0, 3 * sizeof(float));
    if (triangle) memcpy(vertex, triangle->corner[draw_below(random, 3)], 3 * sizeof(float));
}

static double triangle_size(const struct reference_triangle *triangle)
{
    double size = 0;
    for (int n = 0; n < 9; n++) {
        double length = fabs((double)triangle->corner[n / 3][n % 3] - (double)triangle->corner[0][n % 3]);
        if (length > size) size = length;
    }
    return size;
}

void draw_point_of_triangle(struct random *random, const struct reference_triangle *triangle, float point[3])
{
    uint32_t kind = draw_below(random, 3), first = draw_below(random, 3);
    double u = kind >= 1 ? draw_unit(random) : 0, v = kind >= 2 ? draw_unit(random) * (1 - u) : 0;
    if (kind == 1 && draw_below(random, 4) == 0) u = 0.5;
    const float *a = triangle->corner[first], *b = triangle->corner[(first + 1) % 3];
    const float *c = triangle->corner[(first + 2) % 3];
    for (int k = 0; k < 3; k++)
        point[k] = kind == 0 ? a[k] : round_finite((double)a[k] * (1 - u - v) + (double)b[k] * u + (double)c[k] * v);
}

void draw_target(struct random *random, const struct fixture *fixture, float target[3])
{
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    memset(target, 0, 3 * sizeof(float));
    if (triangle) draw_point_of_triangle(random, triangle, target);
}

void draw_origin(struct random *random, const struct fixture *fixture, float origin[3])
{
    float a[3], b[3];
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    draw_vertex(random, fixture, a);
    draw_vertex(random, fixture, b);
    double distance = triangle ? triangle_size(triangle) * pow(10, 3 * draw_unit(random) - 1) : 1;
    uint32_t kind = draw_below(random, 4);
    for (int k = 0; k < 3; k++) {
        if (kind < 2)
            origin[k] = round_finite((double)a[k] + distance * draw_signed(random));
        else
            origin[k] = round_finite((double)a[k] + ((double)b[k] - (double)a[k]) * (4 * draw_unit(random) - 1.5));
    }
}

void draw_direction(struct random *random, float direction[3])
{
    for (int k = 0; k < 3; k++) direction[k] = (float)draw_signed(random);
}

float signed_zero(struct random *random)
{
    return draw_below(random, 2) ? 0.0f : -0.0f;
}

#define SCATTERED_LIMIT 2000

/* ---- kinds of rays ----------------------------------------------------------------------------------------------- */

typedef void add_function(struct ray_list *list, struct random *random, const struct fixture *fixture);

static void add_random(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], direction[3];
    draw_origin(random, fixture, origin);
    draw_direction(random, direction);
    add_ray(list, origin, direction);
}

static void add_aimed(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], target[3];
    draw_origin(random, fixture, origin);
    draw_target(random, fixture, target);
    add_ray_towards(list, origin, target);
}

static void add_from_vertex_to_vertex(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], target[3];
    draw_vertex(random, fixture, origin);
    draw_vertex(random, fixture, target);
    if (draw_below(random, 2)) {
        for (int k = 0; k < 3; k++) origin[k] = round_finite(2 * (double)origin[k] - (double)target[k]);
    }
    add_ray_towards(list, origin, target);
}

/* 256 rays that leave one point in a square of directions, one of which is aimed exactly. */
static void add_bundle(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], target[3], middle[3];
    draw_origin(random, fixture, origin);
    draw_target(random, fixture, target);
    reference_difference(target, origin, middle);
    double size = fmax(fabs((double)middle[0]), fmax(fabs((double)middle[1]), fabs((double)middle[2])));
    double step = size * pow(10, -6 * draw_unit(random) - 0.5);
    float across[3], down[3];
    draw_direction(random, across);
    draw_direction(random, down);
    for (int i = 0; i < 256; i++) {
        float direction[3];
        for (int k = 0; k < 3; k++) {
            double offset = (double)across[k] * (i % 16 - 8) + (double)down[k] * (i / 16 - 8);
            direction[k] = round_finite((double)middle[k] + step * offset);
        }
        add_ray(list, origin, direction);
    }
}

/*
 * A block of one direction. Its origins are about one triangle, or anywhere in scenes that are small: packets of such
 * rays visit most of the tree.
 */
static void add_axis_parallel(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    float other[3], direction[3];
    draw_origin(random, fixture, other);
    int axis = (int)draw_below(random, 3), back = (int)draw_below(random, 2);
    int scattered = reference_triangle_count(fixture->reference) <= SCATTERED_LIMIT && draw_below(random, 16) == 0;
    for (int i = 0; i < 16 && triangle; i++) {
        float from[3];
        if (scattered)
            draw_vertex(random, fixture, from);
        else
            memcpy(from, triangle->corner[i % 3], sizeof from);
        int moved = (int)draw_below(random, 3);
        from[moved] = next_float(from[moved], (int)draw_below(random, 3) - 1);
        from[axis] = i % 4 ? other[axis] : triangle->corner[i % 3][axis];
        for (int k = 0; k < 3; k++) direction[k] = signed_zero(random);
        direction[axis] = back ? -1.0f : 1.0f;
        add_ray(list, from, direction);
    }
    if (!triangle) add_random(list, random, fixture);
}

/* The coordinates of vertices are where split planes are. */
static void add_in_plane(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], vertex[3], target[3];
    draw_origin(random, fixture, origin);
    draw_vertex(random, fixture, vertex);
    draw_target(random, fixture, target);
    int axis = (int)draw_below(random, 3), second = (int)draw_below(random, 3);
    origin[axis] = vertex[axis];
    if (draw_below(random, 3) == 0) origin[second] = vertex[second];
    struct reference_ray *ray = add_ray_towards(list, origin, target);
    if (draw_below(random, 4)) ray->direction[axis] = signed_zero(random);
}

static void add_from_surface(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], direction[3];
    draw_target(random, fixture, origin);
    draw_direction(random, direction);
    int axis = (int)draw_below(random, 3);
    origin[axis] = next_float(origin[axis], (int)draw_below(random, 3) - 1);
    if (isfinite(origin[axis])) add_ray(list, origin, direction);
}

/* Along the plane of a triangle, or next to it. */
static void add_grazing(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    const struct reference_triangle *triangle = draw_triangle(random, fixture);
    float origin[3] = {0, 0, 0}, direction[3] = {1, 0, 0};
    if (triangle) {
        const float *a = triangle->corner[draw_below(random, 3)], *b = triangle->corner[draw_below(random, 3)];
        const float *c = triangle->corner[draw_below(random, 3)];
        double u = draw_signed(random), back = 4 * draw_unit(random);
        for (int k = 0; k < 3; k++) {
            double along = ((double)b[k] - (double)a[k]) + u * ((double)c[k] - (double)a[k]);
            direction[k] = round_finite(along);
            origin[k] = round_finite((double)a[k] - back * along);
        }
    }
    int axis = (int)draw_below(random, 3);
    float moved = next_float(origin[axis], (int)draw_below(random, 5) - 2);
    if (isfinite(moved)) origin[axis] = moved;
    add_ray(list, origin, direction);
}

static void add_any_length(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], target[3], direction[3];
    draw_origin(random, fixture, origin);
    draw_target(random, fixture, target);
    double size = 0;
    for (int k = 0; k < 3; k++) size = fmax(size, fabs((double)target[k] - (double)origin[k]));
    double scale = pow(10, 60 * draw_unit(random) - 30) / (size > 0 ? size : 1);
    for (int k = 0; k < 3; k++) direction[k] = round_finite(((double)target[k] - (double)origin[k]) * scale);
    add_ray(list, origin, direction);
}

/* A direction so long or short that t is about a limit of floats. */
static void add_with_t_at_a_limit(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    static const float limits[] = {0x1p-149f, 0x1p-140f, FLT_MIN, FLT_MIN, FLT_MAX};
    struct reference_hit hit;
    add_aimed(list, random, fixture);
    struct reference_ray *ray = &list->rays[list->count - 1];
    reference_trace(fixture->reference, ray, &hit);
    const double t = isfinite(hit.t) && hit.t > 0 ? (double)hit.t : 1;
    const double limit = (double)limits[draw_below(random, 5)] * (1 + 0x1p-22 * draw_signed(random));
    for (int k = 0; k < 3; k++) ray->direction[k] = round_finite((double)ray->direction[k] * t / limit);
}

/* A range whose end is the exact distance, a float more or less; or one that skips what would be hit. */
static void add_with_range(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    struct reference_hit hit;
    add_aimed(list, random, fixture);
    struct reference_ray *ray = &list->rays[list->count - 1];
    reference_trace(fixture->reference, ray, &hit);
    float t = isfinite(hit.t) ? hit.t : 1, near = next_float(t, (int)draw_below(random, 3) - 1);
    switch (draw_below(random, 6)) {
    case 0:
        ray->t_max = near;
        break;
    case 1:
        ray->t_min = near;
        break;
    case 2:
        ray->skip[0] = hit.mesh;
        ray->skip[1] = hit.triangle;
        break;
    case 3:
        ray->t_min = near;
        ray->t_max = next_float(t, (int)draw_below(random, 3) - 1);
        break;
    case 4:
        ray->t_min = -near;
        break;
    default:
        ray->t_max = t * 0.5f;
        break;
    }
}

/* From a light to a point of a surface, which lies at t = 1. */
static void add_shadow(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float light[3], point[3];
    draw_origin(random, fixture, light);
    for (int i = 0; i < 16; i++) {
        draw_target(random, fixture, point);
        add_ray_towards(list, light, point)->t_max = 1;
    }
}

/* Good rays, one of which is spoiled. */
static void add_spoiled(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.4e-45f, 0};
    size_t first = list->count;
    add_bundle(list, random, fixture);
    for (int i = 0; i < 40; i++) {
        struct reference_ray *ray = &list->rays[first + draw_below(random, 256)];
        float value = bad[draw_below(random, sizeof bad / sizeof bad[0])];
        switch (draw_below(random, 6)) {
        case 0:
            ray->origin[draw_below(random, 3)] = value;
            break;
        case 1:
            ray->direction[draw_below(random, 3)] = value;
            break;
        case 2:
            ray->t_min = value;
            break;
        case 3:
            ray->t_max = value;
            break;
        case 4:
            memset(ray->direction, 0, sizeof ray->direction);
            break;
        default:
            ray->direction[0] = ray->direction[1] = ray->direction[2] = signed_zero(random);
            break;
        }
    }
}

static void add_any_bits(struct ray_list *list, struct random *random, const struct fixture *fixture)
{
    float origin[3], direction[3];
    draw_origin(random, fixture, origin);
    for (int k = 0; k < 3; k++) {
        direction[k] = draw_finite(random);
        if (draw_below(random, 4) == 0) origin[k] = draw_finite(random);
    }
    add_ray(list, origin, direction);
}

static const struct {
    struct hostile_kind kind;
    add_function *add;
} kinds[] = {
    {{"random", "14 17 45", 16}, add_random},
    {{"aimed at vertices, edges, inner points", "1 2 3 4 6 20 33 39 40", 20}, add_aimed},
    {{"bundles of one origin", "35 36 37 38 41 42 45", 20}, add_bundle},
    {{"from vertex to vertex", "1 2 19 23 24 31 41", 6}, add_from_vertex_to_vertex},
    {{"from surfaces, a float off", "8 24 32", 6}, add_from_surface},
    {{"grazing, in planes of triangles", "5 7 8 25", 6}, add_grazing},
    {{"directions of length 1e-30 to 1e30", "14 16", 6}, add_any_length},
    {{"t about the least or the greatest float", "14 16", 4}, add_with_t_at_a_limit},
    {{"ranges that end at the exact t; skips", "6 9 18", 8}, add_with_range},
    {{"shadow rays", "9 43", 6}, add_shadow},
    {{"good rays with bad neighbours", "17 18 42", 4}, add_spoiled},
    {{"any finite bits", "14 15 16", 2}, add_any_bits},
    {{"axis-parallel, through vertices", "21 22 23 36", 1}, add_axis_parallel},
    {{"in split planes", "21 22 24 26", 1}, add_in_plane},
};

size_t hostile_kind_count(void)
{
    return sizeof kinds / sizeof kinds[0];
}

const struct hostile_kind *hostile_kind_at(size_t kind)
{
    return &kinds[kind].kind;
}

size_t draw_hostile_kind(struct random *random)
{
    uint32_t total = 0;
    for (size_t i = 0; i < hostile_kind_count(); i++) total += kinds[i].kind.weight;
    uint32_t drawn = draw_below(random, total);
    size_t kind = 0;
    while (drawn >= kinds[kind].kind.weight) drawn -= kinds[kind++].kind.weight;
    return kind;
}

void add_hostile_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t kind,
                      size_t count)
{
    for (size_t end = list->count + count; list->count < end;) kinds[kind].add(list, random, fixture);
}

/* ---- cameras and lights ------------------------------------------------------------------------------------------ */

mlrt_camera draw_hostile_camera(struct random *random, const struct fixture *fixture, uint32_t size)
{
    mlrt_camera camera = {.struct_size = sizeof camera, .width = size, .height = size};
    float origin[3], target[3], middle[3], across[3], down[3];
    uint32_t column = draw_below(random, size), row = draw_below(random, size);
    camera.projection = draw_below(random, 3) ? MLRT_PROJECTION_PINHOLE : MLRT_PROJECTION_PARALLEL;
    if (draw_below(random, 8))
        draw_origin(random, fixture, origin);
    else
        draw_vertex(random, fixture, origin);
    if (draw_below(random, 2))
        draw_vertex(random, fixture, target);
    else
        draw_target(random, fixture, target);
    draw_direction(random, across);
    draw_direction(random, down);
    reference_difference(target, origin, middle);
    double distance = fmax(fabs((double)middle[0]), fmax(fabs((double)middle[1]), fabs((double)middle[2])));
    if (!(distance > 0)) distance = 1;
    double pixel = distance * pow(10, -4 * draw_unit(random)) / size;
    if (draw_below(random, 4) == 0) { // along axes
        int axis = (int)draw_below(random, 3);
        for (int k = 0; k < 3; k++) across[k] = k == axis, down[k] = k == (axis + 1) % 3;
    }
    memcpy(camera.eye, origin, sizeof camera.eye);
    for (int k = 0; k < 3; k++) {
        double start = camera.projection == MLRT_PROJECTION_PINHOLE ? (double)middle[k] : (double)origin[k];
        camera.direction[k] = middle[k];
        camera.dx[k] = round_finite(pixel * (double)across[k]);
        camera.dy[k] = round_finite(pixel * (double)down[k]);
        camera.d00[k] = round_finite(start - column * (double)camera.dx[k] - row * (double)camera.dy[k]);
    }
    return camera;
}

mlrt_light draw_hostile_light(struct random *random, const struct fixture *fixture)
{
    mlrt_light light = {.struct_size = sizeof light};
    light.kind = draw_below(random, 3) ? MLRT_LIGHT_POINT : MLRT_LIGHT_DIRECTIONAL;
    if (light.kind == MLRT_LIGHT_DIRECTIONAL)
        draw_direction(random, light.position);
    else if (draw_below(random, 2))
        draw_origin(random, fixture, light.position);
    else
        draw_target(random, fixture, light.position);
    return light;
}

void draw_hostile_points(struct random *random, const struct fixture *fixture, const mlrt_light *light, size_t count,
                         float *points, uint32_t *skip)
{
    for (size_t i = 0; i < count; i++, points += 3, skip += 2) {
        const struct reference_triangle *triangle = draw_triangle(random, fixture);
        skip[0] = skip[1] = MLRT_NONE;
        draw_target(random, fixture, points);
        if (draw_below(random, 64) == 0) memcpy(points, light->position, 3 * sizeof *points);
        if (!triangle || draw_below(random, 2)) continue;
        float u = (float)draw_unit(random), v = (float)draw_unit(random) * (1 - u), point[3];
        int32_t side = draw_below(random, 2) ? 1 : -1;
        if (mlrt_offset_point(fixture->tree, triangle->mesh, triangle->triangle, u, v, side, point) != MLRT_OK)
            continue;
        memcpy(points, point, sizeof point);
        if (draw_below(random, 4) == 0) continue;
        skip[0] = triangle->mesh;
        skip[1] = triangle->triangle;
    }
}
