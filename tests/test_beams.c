/* SPDX-License-Identifier: MIT */
/*
 * Beams at their edges: triangles and cells that just touch the outermost ray of a tile or of a square of rays, exactly
 * or within a few ulps, and covering triangles that just do not cover. Small scenes, many of them, each compared with
 * the reference bit for bit; the seed of a failing case is printed.
 *
 * How a triangle touches a ray exactly: for a direction d of floats and a small integer n, n d_k does not fit into a
 * float, but it is the difference of two floats, p_k = fl(n d_k) and o_k = p_k - n d_k. So the ray from o goes through
 * p exactly, and p - o, which every float test has to round, is not a float.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* ---- cases ------------------------------------------------------------------------------------------------------- */

/* A scene, and rays from one point or in one direction: those of a camera or of an array. */
struct beam_case {
    const char *name;
    uint64_t seed;
    struct random random;
    struct soup soup;
    struct ray_list list; /* of a camera too, when it is complete */
    int has_camera;
    mlrt_camera camera;
    int has_skip;
    int has_range; /* t_min and t_max of the list count */
    int has_light; /* the list's rays are those of points in its light */
    mlrt_light light;
    float *points;
};

static struct beam_case make_case(const char *name, uint64_t seed)
{
    struct beam_case the = {.name = name, .seed = seed, .random = {seed * 0x10001 + 77}};
    return the;
}

static mlrt_kdtree_options draw_build_options(struct random *random)
{
    mlrt_kdtree_options options = {.struct_size = sizeof options};
    options.preset = MLRT_KDTREE_TUNED;
    if (draw_below(random, 4) == 0) return options;
    options.preset = MLRT_KDTREE_PAPER;
    options.intersection_cost = 100; /* cells down to single triangles */
    options.traversal_cost = 0.01f;
    if (draw_below(random, 4) == 0) options.rules_off = draw_below(random, 32);
    return options;
}

static mlrt_trace_options draw_trace_options(struct random *random, char *text, size_t size)
{
    static const uint32_t tiles[][3] = {{0, 0, 0},   {4, 4, 4},   {8, 4, 4}, {8, 8, 4},
                                        {16, 4, 16}, {16, 16, 4}, {32, 4, 4}};
    static const int32_t methods[] = {MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4, MLRT_METHOD_PACKET4};
    mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_MULTILEVEL};
    const uint32_t *tile = tiles[draw_below(random, 7)];
    if (draw_below(random, 5) == 0) options.method = methods[draw_below(random, 3)];
    options.isa = draw_below(random, 2) ? narrowest_isa() : MLRT_ISA_AUTO;
    options.culling = (int32_t)draw_below(random, 2);
    options.culling_check = draw_below(random, 4) == 0;
    options.shortcuts_off = draw_below(random, 2) ? 0 : draw_below(random, 8);
    options.initial_tile_size = tile[0];
    options.minimum_tile_size = tile[1];
    options.split_factor = tile[2];
    options.query = draw_below(random, 4) == 0 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST;
    snprintf(text, size, "method %d, isa %d, culling %d, check %u, shortcuts off %u, tiles %u/%u/%u, query %d",
             (int)options.method, (int)options.isa, (int)options.culling, (unsigned)options.culling_check,
             (unsigned)options.shortcuts_off, (unsigned)tile[0], (unsigned)tile[1], (unsigned)tile[2],
             (int)options.query);
    return options;
}

struct results {
    struct reference_hit *hits;
    uint8_t *occluded;
    mlrt_hits arrays;
};

static void point_to(struct results *results, size_t row, int any)
{
    const size_t stride = sizeof *results->hits, rows = row * stride;
    struct reference_hit *hits = results->hits;
    results->arrays = (mlrt_hits){.struct_size = sizeof results->arrays};
    if (any) {
        results->arrays.occluded.data = results->occluded;
        return;
    }
    results->arrays.t = (mlrt_array){&hits->t, stride, rows};
    results->arrays.u = (mlrt_array){&hits->u, stride, rows};
    results->arrays.v = (mlrt_array){&hits->v, stride, rows};
    results->arrays.mesh = (mlrt_array){&hits->mesh, stride, rows};
    results->arrays.triangle = (mlrt_array){&hits->triangle, stride, rows};
    results->arrays.facing = (mlrt_array){&hits->facing, stride, rows};
}

static void trace_case(const struct beam_case *the, const mlrt_tree *tree, const mlrt_trace_options *options,
                       struct results *results)
{
    const int any = options->query == MLRT_QUERY_ANY;
    int32_t status;
    if (the->has_light) {
        const size_t stride = sizeof *the->list.rays;
        const mlrt_const_array points = {the->points, 0}, origins = {the->list.rays->origin, stride};
        mlrt_points receivers = {.struct_size = sizeof receivers, .row_length = the->list.row_length};
        mlrt_array occluded = {results->occluded, 0, 0};
        receivers.count = the->list.count;
        receivers.positions = the->points ? points : origins;
        if (the->has_skip) receivers.skip = (mlrt_const_array){the->list.rays->skip, stride};
        status = mlrt_occluded_points(tree, &receivers, &the->light, options, &occluded);
    } else if (the->has_camera) {
        point_to(results, the->list.row_length, any);
        status = mlrt_render_tiles(tree, &the->camera, options, &results->arrays, NULL, NULL);
    } else {
        mlrt_rays rays = public_rays(&the->list);
        if (!the->has_skip) rays.skip.data = NULL; /* with it, no beam of the array may be covered */
        if (!the->has_range) rays.t_min.data = rays.t_max.data = NULL;
        point_to(results, 0, any);
        status = mlrt_trace_packet(tree, &rays, options, &results->arrays);
    }
    assert_int_equal(status, MLRT_OK);
}

static void compare(const struct beam_case *the, const struct fixture *fixture, const struct reference_hit *expected,
                    const struct results *results, int any, const char *text)
{
    for (size_t i = 0; i < the->list.count; i++) {
        struct reference_hit got = results->hits[i];
        if (any)
            got = results->occluded[i] == (expected[i].mesh != MLRT_NONE) ? expected[i] : (struct reference_hit){0};
        check_hit(fixture, text, i, &the->list.rays[i], &expected[i], &got);
    }
}

/* Traces the case in `ways` ways drawn by lot, compares, and frees it. */
static void finish_case(struct beam_case *the, int ways)
{
    char text[200];
    mlrt_mesh mesh = soup_mesh(&the->soup);
    mlrt_kdtree_options build = draw_build_options(&the->random);
    struct fixture fixture = make_fixture_with(the->name, the->seed, &mesh, 1, &build);
    if (the->has_camera) {
        the->list.count = 0;
        add_camera_rays(&the->list, &the->camera);
    }
    const size_t count = the->list.count;
    struct reference_hit *expected = allocate_or_fail(count, sizeof *expected);
    struct results results = {allocate_or_fail(count, sizeof *results.hits), allocate_or_fail(count, 1), {0}};
    for (size_t i = 0; i < count; i++) reference_trace_filtered(fixture.reference, &the->list.rays[i], &expected[i]);
    for (int way = 0; way < ways; way++) {
        mlrt_trace_options options = draw_trace_options(&the->random, text, sizeof text);
        if (the->has_light) options.query = MLRT_QUERY_ANY;
        trace_case(the, method_tree(options.method, &fixture), &options, &results);
        compare(the, &fixture, expected, &results, options.query == MLRT_QUERY_ANY, text);
    }
    free(expected);
    free(results.hits);
    free(results.occluded);
    free(the->points);
    free_rays(&the->list);
    free_soup(&the->soup);
    free_fixture(&fixture);
}

/* ---- numbers and vectors ----------------------------------------------------------------------------------------- */

static float draw_sign(struct random *random)
{
    return draw_below(random, 2) ? 1.0f : -1.0f;
}

/* Of a random magnitude between 2^lo and 2^hi, positive. */
static float draw_magnitude(struct random *random, int lo, int hi)
{
    const int exponent = lo + (int)draw_below(random, (uint32_t)(hi - lo));
    return ldexpf(draw_range(random, 1, 2), exponent);
}

/* A few bits, or all that a float has. */
static float draw_number(struct random *random, float lo, float hi)
{
    if (draw_below(random, 2)) return draw_range(random, lo, hi);
    return lo + (hi - lo) * (float)draw_below(random, 65) / 64;
}

/* A point a little off in one coordinate, at times. */
static void nudge(struct random *random, float point[3])
{
    const uint32_t k = draw_below(random, 3);
    if (point[k] != 0) point[k] = next_float(point[k], (int)draw_below(random, 5) - 2);
}

/* ---- rays from one point ----------------------------------------------------------------------------------------- */

/* A tile of directions over a main axis, in rows along the two others. All signs are equal, mostly. */
static void add_tile(struct beam_case *the, int main_axis)
{
    struct random *random = &the->random;
    const uint32_t width = 1 + draw_below(random, 16), height = 1 + draw_below(random, 16);
    const float length = draw_below(random, 3) ? 1 : draw_magnitude(random, -20, 20), sign = draw_sign(random);
    const float span = draw_magnitude(random, -24, 0);
    float first[2], step[2];
    for (int side = 0; side < 2; side++) {
        const float turn = draw_sign(random);
        first[side] = draw_below(random, 3) ? turn * draw_number(random, 0, 1) : 0;
        step[side] = turn * (draw_below(random, 2) ? span / 16 : ldexpf(1, -4 - (int)draw_below(random, 12)));
    }
    for (uint32_t i = 0; i < width * height; i++) {
        const float zero[3] = {0, 0, 0};
        const float slopes[2] = {first[0] + (float)(i % width) * step[0], first[1] + (float)(i / width) * step[1]};
        const float scale = length * (draw_below(random, 8) ? 1 : draw_range(random, 0.5f, 2));
        float d[3];
        d[main_axis] = sign * scale;
        for (int side = 0; side < 2; side++) d[(main_axis + 1 + side) % 3] = slopes[side] * scale;
        add_ray(&the->list, zero, d);
    }
    the->list.row_length = draw_below(random, 4) ? width : 0;
}

static void draw_camera_axes(struct random *random, int main_axis, mlrt_camera *camera)
{
    const int j = (main_axis + 1) % 3, l = (main_axis + 2) % 3;
    const float length = draw_below(random, 2) ? 1 : draw_magnitude(random, -20, 20);
    const float pixel = draw_magnitude(random, -26, -4);
    camera->d00[main_axis] = draw_sign(random) * length;
    camera->d00[j] = draw_number(random, -1, 1) * length;
    camera->d00[l] = draw_number(random, -1, 1) * length;
    camera->dx[j] = draw_sign(random) * pixel * length;
    camera->dy[l] = draw_sign(random) * pixel * length;
    switch (draw_below(random, 4)) {
    case 0:
        break;
    case 1: /* turned */
        for (int k = 0; k < 3; k++) {
            camera->dx[k] = draw_range(random, -pixel, pixel) * length;
            camera->dy[k] = draw_range(random, -pixel, pixel) * length;
        }
        break;
    case 2: /* a fan in a plane */
        camera->d00[l] = camera->dy[l] = 0;
        camera->dy[main_axis] = draw_number(random, -1, 1) * pixel * length + pixel * length / 1024;
        break;
    default: /* rows and columns exchanged */
        camera->dx[l] = camera->dy[l];
        camera->dy[j] = camera->dx[j];
        camera->dx[j] = camera->dy[l] = 0;
        break;
    }
}

/*
 * A small crop, often far off: then d00 and x dx nearly cancel, and the pixels' vectors are what rounding makes them.
 */
static void add_camera(struct beam_case *the, int main_axis)
{
    struct random *random = &the->random;
    mlrt_camera camera = {.struct_size = sizeof camera, .width = 1u << 23, .height = 1u << 23};
    static const float samples[] = {0, 0.5f, 0.25f, -1000.25f};
    draw_camera_axes(random, main_axis, &camera);
    camera.crop_width = 1 + draw_below(random, 16);
    camera.crop_height = 1 + draw_below(random, 16);
    if (draw_below(random, 2)) {
        camera.crop_x = draw_below(random, 1u << (1 + draw_below(random, 20)));
        camera.crop_y = draw_below(random, 1u << (1 + draw_below(random, 20)));
    }
    camera.sample_x = samples[draw_below(random, 4)];
    camera.sample_y = draw_below(random, 4) ? samples[draw_below(random, 4)] : draw_range(random, 0, 1);
    for (int k = 0; k < 3; k++) {
        const double x = (double)camera.crop_x + (double)camera.sample_x,
                     y = (double)camera.crop_y + (double)camera.sample_y;
        camera.d00[k] = (float)((double)camera.d00[k] - x * (double)camera.dx[k] - y * (double)camera.dy[k]);
    }
    the->has_camera = 1;
    the->camera = camera;
    add_camera_rays(&the->list, &camera);
}

static void set_origin(struct beam_case *the, const float origin[3])
{
    memcpy(the->camera.eye, origin, sizeof the->camera.eye);
    for (size_t i = 0; i < the->list.count; i++) memcpy(the->list.rays[i].origin, origin, 3 * sizeof *origin);
}

/* ---- touching ---------------------------------------------------------------------------------------------------- */

/* The outermost ray of a tile, or of a square in it, on one side of one axis. */
struct limb {
    size_t ray;
    int main_axis;
    int axis;   /* the side's */
    int other;  /* neither of the two */
    float side; /* +1 or -1: outward along `axis` */
};

static double slope_of(const struct reference_ray *ray, const struct limb *limb)
{
    return (double)ray->direction[limb->axis] / fabs((double)ray->direction[limb->main_axis]);
}

static struct limb draw_limb(struct beam_case *the, int main_axis)
{
    struct random *random = &the->random;
    static const size_t sizes[] = {1024, 1024, 8, 4, 2, 1};
    const size_t size = sizes[draw_below(random, 6)], count = the->list.count;
    const size_t row = the->list.row_length ? the->list.row_length : 4;
    const size_t seed = draw_below(random, (uint32_t)count);
    const int turn = (int)draw_below(random, 2);
    struct limb limb = {seed, main_axis, (main_axis + 1 + turn) % 3, (main_axis + 2 - turn) % 3, draw_sign(random)};
    for (size_t i = 0; i < count; i++) {
        if (i % row / size != seed % row / size || i / row / size != seed / row / size) continue;
        const double gain = slope_of(&the->list.rays[i], &limb) - slope_of(&the->list.rays[limb.ray], &limb);
        if (gain * (double)limb.side > 0) limb.ray = i;
    }
    return limb;
}

/*
 * Makes the case's rays start at a point from where the limb's ray goes through p exactly, p at about the distance.
 * Returns the t of p.
 */
static double aim_exactly(struct beam_case *the, const struct limb *limb, double distance, float p[3])
{
    const float *d = the->list.rays[limb->ray].direction;
    const uint32_t n = 2 * draw_below(&the->random, 1u << (1 + draw_below(&the->random, 22))) + 1;
    int exponent;
    frexp(distance / n / fabs((double)d[limb->main_axis]), &exponent);
    const double t = ldexp(n, exponent);
    float origin[3];
    for (int k = 0; k < 3; k++) {
        p[k] = (float)(t * (double)d[k]);
        origin[k] = (float)((double)p[k] - t * (double)d[k]);
    }
    set_origin(the, origin);
    return t;
}

/* The float next to where the limb's ray is after t times its way to p. */
static void point_on_ray(const struct beam_case *the, const struct limb *limb, double t, const float p[3],
                         float point[3])
{
    const float *o = the->list.rays[limb->ray].origin;
    for (int k = 0; k < 3; k++) point[k] = (float)((double)o[k] + t * ((double)p[k] - (double)o[k]));
}

/* From a point on the ray outward by `out`, and by `along` across. */
static void step_outward(const struct limb *limb, float out, float along, const float *from, float *point)
{
    const float size = fabsf(from[limb->main_axis]);
    memcpy(point, from, 3 * sizeof *point);
    point[limb->axis] += limb->side * out * size;
    point[limb->other] += along * size;
}

static void add_vertex_touch(struct beam_case *the, const struct limb *limb, const float p[3])
{
    struct random *random = &the->random;
    float q[2][3];
    for (int i = 0; i < 2; i++) {
        const float out = draw_magnitude(random, -20, 1);
        point_on_ray(the, limb, draw_number(random, 0.25f, 2), p, q[i]);
        step_outward(limb, out, draw_sign(random) * draw_magnitude(random, -20, 1), q[i], q[i]);
    }
    const uint32_t turn = draw_below(random, 3);
    const float *corners[3] = {p, q[0], q[1]};
    soup_add_triangle(&the->soup, corners[turn], corners[(turn + 1) % 3], corners[(turn + 2) % 3]);
}

/*
 * An edge whose middle is p; exactly, unless a binade ends within it. It may lean along the rays and across the tile.
 */
static void add_edge_touch(struct beam_case *the, const struct limb *limb, const float p[3])
{
    struct random *random = &the->random;
    const float *o = the->list.rays[limb->ray].origin;
    const float reach = draw_magnitude(random, -20, -1),
                lean = draw_below(random, 2) ? draw_range(random, -0.5f, 0.5f) : 0;
    float across[3] = {0, 0, 0}, a[3], b[3], c[3];
    across[limb->other] = reach * fabsf(p[limb->main_axis]);
    across[limb->axis] = draw_below(random, 2) ? 0 : draw_number(random, -1, 1) * across[limb->other];
    for (int k = 0; k < 3; k++) {
        a[k] = (float)((double)p[k] - (double)across[k] - (double)lean * ((double)p[k] - (double)o[k]));
        b[k] = (float)(2 * (double)p[k] - (double)a[k]);
    }
    const float aside = draw_range(random, -1, 1);
    step_outward(limb, draw_magnitude(random, -20, 1), aside, p, c);
    soup_add_triangle(&the->soup, a, b, c);
}

/* A box whose corner is p: the planes of the tree go through it. Along the rays it lies before or behind p. */
static void add_box_touch(struct beam_case *the, const struct limb *limb, const float p[3])
{
    struct random *random = &the->random;
    float lo[3], hi[3], q[3];
    const float sign = draw_sign(random), aside = sign * draw_magnitude(random, -10, 1);
    step_outward(limb, draw_magnitude(random, -10, 1), aside, p, q);
    q[limb->main_axis] += draw_range(random, -0.75f, 1) * p[limb->main_axis];
    const uint32_t flat = draw_below(random, 9); /* of no thickness, at times */
    if (flat < 3) q[flat] = p[flat];
    for (int k = 0; k < 3; k++) {
        lo[k] = fminf(p[k], q[k]);
        hi[k] = fmaxf(p[k], q[k]);
    }
    soup_add_box(&the->soup, lo, hi);
}

/* Something behind it all, so that what is lost in front is not just missing. It covers the tile, mostly. */
static void add_wall(struct beam_case *the, const struct limb *limb, const float p[3], double depth)
{
    float centre[3], corners[3][3];
    point_on_ray(the, limb, depth, p, centre);
    for (int i = 0; i < 3; i++) {
        const float out = i == 0 ? -8.0f : 4.0f, along = i == 1 ? -8.0f : i == 2 ? 8.0f : 0.0f;
        step_outward(limb, out, along, centre, corners[i]);
    }
    if (draw_below(&the->random, 2)) corners[0][limb->main_axis] *= 1.5f;
    soup_add_triangle(&the->soup, corners[0], corners[1], corners[2]);
}

static void add_touch(struct beam_case *the, const struct limb *limb, const float p[3])
{
    switch (draw_below(&the->random, 3)) {
    case 0:
        add_vertex_touch(the, limb, p);
        break;
    case 1:
        add_edge_touch(the, limb, p);
        break;
    default:
        add_box_touch(the, limb, p);
        break;
    }
}

static void add_touches(struct beam_case *the, int main_axis)
{
    struct random *random = &the->random;
    struct limb limb = draw_limb(the, main_axis);
    float exact[3], p[3];
    if (draw_below(random, 2)) {
        aim_exactly(the, &limb, pow(10, (double)draw_range(random, -3, 6)), exact);
    } else { /* from anywhere, at any scale: then the rounded points next to the ray */
        const float scale = powf(10, draw_range(random, -9, 9)) / fabsf(the->list.rays[limb.ray].direction[main_axis]);
        draw_point(random, -4, 4, p);
        for (int k = 0; k < 3; k++) {
            exact[k] = p[k] * scale * fabsf(the->list.rays[limb.ray].direction[main_axis]);
        }
        set_origin(the, exact);
        for (int k = 0; k < 3; k++) exact[k] += the->list.rays[limb.ray].direction[k] * scale;
    }
    const uint32_t count = 1 + draw_below(random, 4);
    for (uint32_t i = 0; i < count; i++) {
        memcpy(p, exact, sizeof p);
        if (i > 0) {
            limb = draw_below(random, 2) ? draw_limb(the, main_axis) : limb;
            point_on_ray(the, &limb, i % 2 ? 1 : (double)draw_range(random, 0.5f, 4), exact, p);
        }
        if (i > 0 || draw_below(random, 2)) nudge(random, p);
        add_touch(the, &limb, p);
    }
    if (draw_below(random, 2)) add_wall(the, &limb, exact, 8);
}

static void rays_that_triangles_touch_from_outside(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(3500); i++) {
        struct beam_case the = make_case("touched tile", i);
        const int main_axis = (int)draw_below(&the.random, 3);
        add_tile(&the, main_axis);
        add_touches(&the, main_axis);
        finish_case(&the, 3);
    }
}

static void pixels_that_triangles_touch_from_outside(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(3500); i++) {
        struct beam_case the = make_case("touched pixels", i);
        const int main_axis = (int)draw_below(&the.random, 3);
        add_camera(&the, main_axis);
        add_touches(&the, main_axis);
        finish_case(&the, 3);
    }
}

/* ---- covering ---------------------------------------------------------------------------------------------------- */

/* Triangles that a tile is inside of, but for an edge or two that go through its outermost rays or next to them. */
static void add_tight_cover(struct beam_case *the, int main_axis, const float exact[3], double depth)
{
    struct random *random = &the->random;
    struct limb limb = draw_limb(the, main_axis);
    float p[3], a[3], b[3], c[3], across[3] = {0, 0, 0};
    point_on_ray(the, &limb, depth, exact, p);
    if (draw_below(random, 2)) nudge(random, p);
    across[limb.other] = draw_magnitude(random, 0, 4) * fabsf(p[main_axis]);
    across[limb.axis] = draw_below(random, 2) ? 0 : draw_number(random, -1, 1) * across[limb.other];
    across[main_axis] = draw_below(random, 2) ? 0 : draw_number(random, -0.05f, 0.05f) * across[limb.other];
    for (int k = 0; k < 3; k++) {
        a[k] = (float)((double)p[k] - (double)across[k]);
        b[k] = (float)(2 * (double)p[k] - (double)a[k]);
    }
    const float aside = draw_range(random, -1, 1);
    step_outward(&limb, -draw_magnitude(random, 1, 4), aside, p, c);
    if (draw_below(random, 4) == 0) nudge(random, a);
    if (draw_below(random, 2))
        soup_add_triangle(&the->soup, a, b, c);
    else
        soup_add_triangle(&the->soup, b, a, c);
}

static void add_rays(struct beam_case *the, int main_axis)
{
    if (draw_below(&the->random, 2))
        add_camera(the, main_axis);
    else
        add_tile(the, main_axis);
}

static void tiles_that_triangles_just_cover(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2500); i++) {
        struct beam_case the = make_case("tight covers", i);
        struct random *random = &the.random;
        const int main_axis = (int)draw_below(random, 3);
        float p[3];
        add_rays(&the, main_axis);
        const struct limb limb = draw_limb(&the, main_axis);
        aim_exactly(&the, &limb, pow(10, (double)draw_range(random, -3, 6)), p);
        const uint32_t count = 1 + draw_below(random, 3);
        for (uint32_t n = 0; n < count; n++)
            add_tight_cover(&the, main_axis, p, n ? (double)draw_range(random, 0.5f, 4) : 1);
        if (draw_below(random, 2)) add_edge_touch(&the, &limb, p);
        if (draw_below(random, 4)) add_wall(&the, &limb, p, 8);
        finish_case(&the, 3);
    }
}

/*
 * The one direction that a beam does not widen is that along an axis. An edge goes by it within 2^-50 or so of the
 * lengths in the determinants: too close for doubles to tell on which side.
 */
static void edges_that_pass_an_axis_too_closely_to_tell(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2000); i++) {
        struct beam_case the = make_case("edge by an axis", i);
        struct random *random = &the.random;
        const int a = (int)draw_below(random, 3), j = (a + 1) % 3, l = (a + 2) % 3;
        const float sign = draw_sign(random), tilt = (float)(1 + draw_below(random, 7));
        float origin[3] = {0, 0, 0}, corners[3][3], wall[3][3];
        for (int n = 0; n < 64; n++) {
            float d[3];
            d[a] = sign;
            d[j] = (float)(n % 8) / 1024;
            d[l] = (float)(n / 8) / 1024;
            add_ray(&the.list, origin, d);
        }
        the.list.row_length = 8;
        origin[j] = draw_sign(random) * draw_magnitude(random, -53, -49);
        origin[l] = draw_sign(random) * draw_magnitude(random, -53, -49);
        set_origin(&the, origin);
        for (int n = 0; n < 3; n++) {
            const float out = (n ? 1.0f : -1.0f) * (1 + (float)draw_below(random, 1u << 15) / 4096);
            corners[n][a] = sign * draw_range(random, 1, 8);
            corners[n][j] = n == 2 ? 100 : out;
            corners[n][l] = n == 2 ? 100 : -out * tilt / 4;
            wall[n][a] = sign * 16;
            wall[n][j] = n == 1 ? 100.0f : -50.0f;
            wall[n][l] = n == 2 ? 100.0f : -50.0f;
        }
        soup_add_triangle(&the.soup, corners[0], corners[1], corners[2]);
        soup_add_triangle(&the.soup, wall[0], wall[1], wall[2]);
        finish_case(&the, 4);
    }
}

/*
 * Plates across the tile, some in one plane, some an ulp apart, some not quite parallel, and limits of t next to them.
 */
static void plates_an_ulp_apart(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2500); i++) {
        struct beam_case the = make_case("plates", i);
        struct random *random = &the.random;
        const int main_axis = (int)draw_below(random, 3);
        const uint32_t count = 1 + draw_below(random, 5);
        float p[3];
        add_rays(&the, main_axis);
        const struct limb limb = draw_limb(&the, main_axis);
        const float t = (float)aim_exactly(&the, &limb, pow(10, (double)draw_range(random, -3, 6)), p);
        for (uint32_t n = 0; n < count; n++) {
            float corners[3][3];
            const float turn = draw_sign(random);
            for (int c = 0; c < 3; c++) {
                const float out = c == 0 ? -16.0f : 8.0f, along = c == 1 ? -16.0f : c == 2 ? 16.0f : 0.0f;
                step_outward(&limb, out * turn, along + draw_range(random, -1, 1), p, corners[c]);
            }
            const int steps = (int)draw_below(random, 3) - 1;
            for (int c = 0; c < 3; c++) {
                const int lean = draw_below(random, 4) ? 0 : (int)draw_below(random, 3) - 1;
                corners[c][main_axis] = next_float(p[main_axis], steps + lean);
            }
            soup_add_triangle(&the.soup, corners[0], corners[1], corners[2]);
        }
        the.has_skip = draw_below(random, 4) == 0;
        the.has_range = draw_below(random, 2) == 0;
        const float t_min = draw_below(random, 2) ? next_float(t, (int)draw_below(random, 5) - 3) : 0;
        const float t_max = draw_below(random, 2) ? next_float(t, (int)draw_below(random, 5) - 2) : INFINITY;
        for (size_t n = 0; n < the.list.count; n++) {
            if (the.has_range) the.list.rays[n].t_min = t_min;
            if (the.has_range) the.list.rays[n].t_max = t_max;
            if (!the.has_skip) continue;
            the.list.rays[n].skip[0] = 0;
            the.list.rays[n].skip[1] = draw_below(random, 2);
        }
        if (the.has_range) the.camera.t_min = t_min;
        if (the.has_range) the.camera.t_max = isinf(t_max) ? 0 : t_max;
        finish_case(&the, 3);
    }
}

/* Triangles in the plane that the eye is in, or all but in: what they are at cancels. */
static void eyes_in_the_plane_of_a_cover(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2000); i++) {
        struct beam_case the = make_case("eye in a plane", i);
        struct random *random = &the.random;
        const int main_axis = (int)draw_below(random, 3);
        float corners[3][3], other[3], eye[3];
        add_rays(&the, main_axis);
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++) corners[c][k] = (float)draw_below(random, 1u << 20) / 65536 - 8;
            other[k] = 2 * corners[2][k] - corners[draw_below(random, 2)][k];
            eye[k] = (corners[0][k] + corners[1][k] + 2 * corners[2][k]) / 4;
        }
        const uint32_t kind = draw_below(random, 3), axis = draw_below(random, 3);
        if (kind > 0) eye[axis] += draw_sign(random) * draw_magnitude(random, -20, -4);
        if (kind > 1) eye[axis] = next_float(eye[axis], 1);
        set_origin(&the, eye);
        const int first = (int)draw_below(random, 2);
        for (int n = 0; n < 2; n++)
            soup_add_triangle(&the.soup, corners[0], corners[1], n == first ? other : corners[2]);
        const struct limb limb = draw_limb(&the, main_axis);
        float p[3];
        for (int k = 0; k < 3; k++) p[k] = eye[k];
        p[main_axis] += the.list.rays[0].direction[main_axis] < 0 ? -64.0f : 64.0f;
        if (draw_below(random, 2)) add_wall(&the, &limb, p, 1);
        finish_case(&the, 3);
    }
}

/* ---- other rays -------------------------------------------------------------------------------------------------- */

/*
 * Rays in one direction, by a parallel camera, a list or points in a directional light. Their origins spread from the
 * first, whose ray goes through p exactly.
 */
static struct limb add_parallel_rays(struct beam_case *the, float p[3])
{
    struct random *random = &the->random;
    const int a = (int)draw_below(random, 3), turn = (int)draw_below(random, 2);
    const int j = (a + 1 + turn) % 3, l = (a + 2 - turn) % 3;
    const struct limb limb = {0, a, j, l, draw_sign(random)};
    const float zero[3] = {0, 0, 0}, length = draw_below(random, 2) ? 1 : draw_magnitude(random, -20, 20);
    mlrt_camera camera = {.struct_size = sizeof camera, .projection = MLRT_PROJECTION_PARALLEL};
    camera.direction[a] = draw_sign(random) * length;
    camera.direction[j] = draw_below(random, 4) ? draw_number(random, -1, 1) * length : 0;
    camera.direction[l] = draw_below(random, 4) ? draw_number(random, -1, 1) * length : 0;
    camera.dx[j] = -limb.side * draw_magnitude(random, -20, 0);
    camera.dy[l] = draw_sign(random) * draw_magnitude(random, -20, 0);
    camera.width = 1 + draw_below(random, 16);
    camera.height = 1 + draw_below(random, 16);
    add_ray(&the->list, zero, camera.direction);
    aim_exactly(the, &limb, pow(10, (double)draw_range(random, -1, 3)), p);
    memcpy(camera.d00, the->list.rays[0].origin, sizeof camera.d00);
    the->list.count = 0;
    add_camera_rays(&the->list, &camera);
    switch (draw_below(random, 3)) {
    case 0:
        the->has_camera = 1;
        the->camera = camera;
        break;
    case 1:
        break;
    default:
        the->has_light = 1;
        the->light = (mlrt_light){.struct_size = sizeof the->light, .kind = MLRT_LIGHT_DIRECTIONAL};
        memcpy(the->light.position, camera.direction, sizeof camera.direction);
        break;
    }
    return limb;
}

static void parallel_rays_that_triangles_touch(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2000); i++) {
        struct beam_case the = make_case("parallel rays", i);
        struct random *random = &the.random;
        float p[3];
        const struct limb limb = add_parallel_rays(&the, p);
        const uint32_t count = 1 + draw_below(random, 3);
        for (uint32_t n = 0; n < count; n++) {
            float q[3];
            point_on_ray(&the, &limb, n ? (double)draw_range(random, 0.5f, 4) : 1, p, q);
            if (n > 0 || draw_below(random, 2)) nudge(random, q);
            add_touch(&the, &limb, q);
        }
        if (draw_below(random, 2)) add_wall(&the, &limb, p, 8);
        finish_case(&the, 3);
    }
}

/* Receivers in the order of a picture. What touches their rays may be as far from the light as they are: t = 1. */
static void points_in_the_light_that_triangles_touch(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(2000); i++) {
        struct beam_case the = make_case("point light", i);
        struct random *random = &the.random;
        const int main_axis = (int)draw_below(random, 3);
        float p[3];
        add_tile(&the, main_axis);
        const struct limb limb = draw_limb(&the, main_axis);
        struct reference_ray *rays = the.list.rays;
        the.has_light = 1;
        the.has_skip = draw_below(random, 4) == 0;
        the.light = (mlrt_light){.struct_size = sizeof the.light, .kind = MLRT_LIGHT_POINT};
        the.points = allocate_or_fail(the.list.count, 12);
        for (size_t n = 0; n < the.list.count; n++) memcpy(the.points + 3 * n, rays[n].direction, 12);
        aim_exactly(&the, &limb, 0.4 * fabs((double)rays[limb.ray].direction[main_axis]), p);
        if (draw_below(random, 3) == 0) memcpy(p, rays[limb.ray].direction, sizeof p);
        memcpy(the.light.position, rays->origin, sizeof the.light.position);
        for (size_t n = 0; n < the.list.count; n++) {
            reference_difference(the.points + 3 * n, rays[n].origin, rays[n].direction);
            rays[n].t_max = 1;
            if (the.has_skip) rays[n].skip[0] = rays[n].skip[1] = draw_below(random, 2);
        }
        const uint32_t count = 1 + draw_below(random, 3);
        for (uint32_t n = 0; n < count; n++) {
            float q[3];
            point_on_ray(&the, &limb, n ? (double)draw_range(random, 0.25f, 1.75f) : 1, p, q);
            if (n > 0 || draw_below(random, 2)) nudge(random, q);
            add_touch(&the, &limb, q);
        }
        if (draw_below(random, 4) == 0) add_wall(&the, &limb, p, (double)draw_range(random, 0.5f, 2));
        finish_case(&the, 3);
    }
}

/* ---- lattices ---------------------------------------------------------------------------------------------------- */

static void add_lattice(struct beam_case *the)
{
    struct random *random = &the->random;
    for (uint32_t left = 1 + draw_below(random, 6); left > 0; left--) {
        float lo[3], hi[3], far[3];
        for (int k = 0; k < 3; k++) {
            lo[k] = (float)draw_below(random, 4);
            hi[k] = lo[k] + (float)draw_below(random, 3);
            far[k] = (float)draw_below(random, 5);
        }
        if (draw_below(random, 2))
            soup_add_box(&the->soup, lo, hi);
        else
            soup_add_triangle(&the->soup, lo, hi, far);
    }
}

/*
 * Small integers: origins in planes of the tree and on vertices, rays along cells without thickness and through edges.
 */
static void boxes_and_eyes_on_a_lattice(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(1000); i++) {
        struct beam_case the = make_case("lattice", i);
        struct random *random = &the.random;
        float eye[3], first[3], dx[3], dy[3];
        const uint32_t spread = draw_below(random, 4);
        add_lattice(&the);
        for (int k = 0; k < 3; k++) {
            eye[k] = (float)draw_below(random, 13) / 2 - 1;
            first[k] = (float)draw_below(random, 17) / 8 - 1;
            dx[k] = (float)draw_below(random, 5) / 64 - 1.0f / 32;
            dy[k] = (float)draw_below(random, 5) / 64 - 1.0f / 32;
            if (draw_below(random, 3) == 0) dx[k] = 0;
            if (draw_below(random, 3) == 0) dy[k] = 0;
        }
        for (int n = 0; n < 256; n++) {
            float d[3], o[3];
            for (int k = 0; k < 3; k++) {
                d[k] = first[k] + (float)(n % 16) * dx[k] + (float)(n / 16) * dy[k];
                o[k] = eye[k];
                if (spread == 0) o[k] += (float)(n % 3) * dx[k] * 16;
                if (spread == 1)
                    o[k] += (float)(n / 64) * first[k]; /* one eye for some packets, another for the next */
            }
            struct reference_ray *ray = add_ray(&the.list, o, d);
            ray->t_min = (float)draw_below(random, 3);
            ray->t_max = draw_below(random, 3) ? INFINITY : (float)draw_below(random, 8);
        }
        the.list.row_length = 16;
        the.has_range = draw_below(random, 4) == 0;
        for (int n = 0; n < 256 && !the.has_range; n++) {
            the.list.rays[n].t_min = 0;
            the.list.rays[n].t_max = INFINITY;
        }
        finish_case(&the, 3);
    }
}

static void pictures_of_a_lattice(void **state)
{
    (void)state;
    for (size_t i = 0; i < scaled(1000); i++) {
        struct beam_case the = make_case("picture of a lattice", i);
        struct random *random = &the.random;
        mlrt_camera camera = {.struct_size = sizeof camera, .width = 20, .height = 20};
        const int a = (int)draw_below(random, 3), j = (a + 1) % 3, l = (a + 2) % 3;
        add_lattice(&the);
        camera.projection = (int32_t)draw_below(random, 2);
        for (int k = 0; k < 3; k++) {
            camera.eye[k] = (float)draw_below(random, 13) / 2 - 1;
            camera.direction[k] = (float)draw_below(random, 3) - 1;
            camera.d00[k] = (float)draw_below(random, 17) / 4 - 2;
        }
        if (camera.direction[a] == 0) camera.direction[a] = 1;
        camera.d00[a] = camera.d00[a] < 0 ? -1 : 1;
        camera.dx[j] = (camera.projection ? 0.25f : 0.0625f) * draw_sign(random);
        camera.dy[l] = (camera.projection ? 0.25f : 0.0625f) * draw_sign(random);
        camera.sample_x = draw_below(random, 2) ? 0.5f : 0;
        camera.sample_y = draw_below(random, 2) ? 0.5f : 0;
        camera.t_min = draw_below(random, 4) ? 0 : (float)draw_below(random, 4);
        camera.t_max = draw_below(random, 4) ? 0 : camera.t_min + (float)(1 + draw_below(random, 4));
        the.has_camera = 1;
        the.camera = camera;
        finish_case(&the, 3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_that_triangles_touch_from_outside),
        cmocka_unit_test(pixels_that_triangles_touch_from_outside),
        cmocka_unit_test(tiles_that_triangles_just_cover),
        cmocka_unit_test(edges_that_pass_an_axis_too_closely_to_tell),
        cmocka_unit_test(plates_an_ulp_apart),
        cmocka_unit_test(eyes_in_the_plane_of_a_cover),
        cmocka_unit_test(parallel_rays_that_triangles_touch),
        cmocka_unit_test(points_in_the_light_that_triangles_touch),
        cmocka_unit_test(boxes_and_eyes_on_a_lattice),
        cmocka_unit_test(pictures_of_a_lattice),
    };
    return cmocka_run_group_tests_name("beams", tests, NULL, NULL);
}
