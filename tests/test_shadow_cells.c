/* SPDX-License-Identifier: MIT */
/*
 * What a point light sees of cells that one triangle covers (src/trace/shadow_cells.c), against the shadow rays of such
 * cells: their slopes and depths lie within the bounds, and cells that are dark have none. By a search for the worst
 * input, and in sixteen cells at once.
 *
 * The search measures what is used of the slack: by how much a ray is beyond the extremes of the hits of the cell's
 * corners, without rounding, over by how much the bound is.
 *
 *     test_shadow_cells        a second
 *     test_shadow_cells 100    100 times the search
 */
#include "search.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "exact/nearest.h"
#include "hits/shadow_ray.h"
#include "trace/ray_tile.h"
#include "trace/shadow_cells.h"

/*
 * No more of the slack than this may be used, or a constant is not what it was: searches a hundred times as long find
 * half of it or more, but not all. The last is that of slopes where rays nearly lie in the plane.
 */
#define SLOPE_PART   0.2
#define DEPTH_PART   0.25
#define GRAZING_PART 0.0125

/* ---- cells ------------------------------------------------------------------------------------------------------- */

struct scene {
    struct mlrt_triangle triangles[MLRT_BUNDLE_PACKETS];
    struct mlrt_tree tree;
    struct mlrt_source light;
    float eye[3];
    struct mlrt_bundle seen; /* the camera's cells: the waist is the eye */
    /* What the light sees. */
    uint32_t known, dark;
    struct mlrt_bundle lit;
};

static void make_cells(struct scene *scene, uint32_t among)
{
    scene->tree.triangles = scene->triangles;
    mlrt_find_triangles(&scene->tree);
    scene->light.kind = MLRT_SOURCE_POINT_LIGHT;
    memcpy(scene->seen.waist.point, scene->eye, sizeof scene->eye);
    memset(&scene->lit, 0x77, sizeof scene->lit);
    scene->lit.waist = (struct mlrt_waist){.sign = 1}; /* not set where all cells are dark */
    scene->known = mlrt_make_shadow_cells(&scene->light, &scene->tree, &scene->seen, among, &scene->lit, &scene->dark);
    assert_int_equal((scene->known | scene->dark) & ~among, 0);
    assert_int_equal(scene->known & scene->dark, 0);
}

struct place {
    double x[3];           /* relative to the light */
    double z;              /* in units of the direction */
    double z_by_steepness; /* over direction . normal, whose greatest component is 1 */
    double greatest_p;     /* the greatest |p_k| of hits/shadow_ray.h */
};

/* Where a ray of this direction from the eye hits the plane of a cell's cover. Returns 0 if nowhere. */
static int find_place(const struct scene *scene, uint32_t place, const double d[3], struct place *found)
{
    const struct mlrt_triangle *triangle = &scene->triangles[scene->seen.hulls.closed.cover[place]];
    double ab[3], ac[3], n = 0, greatest = 0, steepness = 0, size = 0, roundness = 0;
    found->greatest_p = 0;
    for (int k = 0; k < 3; ++k) {
        ab[k] = (double)triangle->v[1][k] - (double)triangle->v[0][k];
        ac[k] = (double)triangle->v[2][k] - (double)triangle->v[0][k];
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double m = ab[i] * ac[j] - ab[j] * ac[i];
        const double p = (double)triangle->v[0][k] - (double)scene->eye[k];
        found->greatest_p = fmax(found->greatest_p, fabs(p));
        greatest = fmax(greatest, fabs(m));
        n += p * m;
        steepness += m * d[k];
        size += fabs(m * d[k]);
        roundness += fabs(ab[i] * ac[j] * d[k]) + fabs(ab[j] * ac[i] * d[k]);
    }
    /* Nearly in the plane: its side is not certain, and of such cells nothing is known anyway. */
    if (!(fabs(steepness) > 0x1p-40 * size + 0x1p-48 * roundness) || (n > 0) != (steepness > 0) || n == 0) return 0;
    found->z = n / steepness;
    found->z_by_steepness = found->z * greatest / fabs(steepness);
    for (int k = 0; k < 3; ++k) {
        found->x[k] = ((double)scene->eye[k] - (double)scene->light.light[k]) + found->z * d[k];
    }
    return 1;
}

struct extremes {
    double lo[2], hi[2], shortest, farthest;
    int is_grazing; /* what is off along the rays is most of it */
};

/* Without rounding, at the corners. 0 if the cover's plane does not reach over the cell. */
static int find_extremes(const struct scene *scene, uint32_t place, struct extremes *of)
{
    const int a = scene->seen.waist.main_axis, b = scene->lit.waist.main_axis;
    *of = (struct extremes){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, INFINITY, -INFINITY, 0};
    for (int corner = 0; corner < 4; ++corner) {
        struct place at;
        double d[3], away = 0;
        d[a] = (double)scene->seen.waist.sign;
        for (int side = 0; side < 2; ++side) {
            const struct mlrt_hull_row *slopes = &scene->seen.hulls.term[side];
            d[(a + 1 + side) % 3] = (double)(corner >> side & 1 ? slopes->hi : slopes->lo)[place];
        }
        if (!find_place(scene, place, d, &at)) return 0;
        for (int k = 0; k < 3; ++k) away = fmax(away, fabs((double)scene->eye[k] - (double)scene->light.light[k]));
        of->is_grazing |= at.z_by_steepness > 4 * (away + 2 * at.z + at.greatest_p);
        const double depth = at.x[b] * (double)scene->lit.waist.sign;
        of->shortest = fmin(depth, of->shortest);
        of->farthest = fmax(depth, of->farthest);
        for (int side = 0; side < 2; ++side) {
            const double slope = at.x[(b + 1 + side) % 3] / depth;
            of->lo[side] = fmin(slope, of->lo[side]);
            of->hi[side] = fmax(slope, of->hi[side]);
        }
    }
    return 1;
}

/* By how much a value is beyond the extreme, over by how much the bound is. */
static double part_of(double value, double extreme, double bound)
{
    if (value > bound || !(bound > extreme)) return 10;
    return value > extreme ? (value - extreme) / (bound - extreme) : 0;
}

struct parts {
    double slope, depth; /* used of the slack; 10: more than there is */
    int is_grazing;
};

static void check_ray(const struct scene *scene, uint32_t place, const struct extremes *of, const float direction[3],
                      struct parts *parts)
{
    struct mlrt_ray_segment ray, shadow;
    struct place at;
    double d[3];
    int faces = -1;
    for (int k = 0; k < 3; ++k) d[k] = (double)direction[k];
    if (!mlrt_make_segment(scene->eye, direction, 0, INFINITY, &ray) || !find_place(scene, place, d, &at)) return;
    const int is_ray = mlrt_make_shadow_ray(&scene->light, &scene->triangles[scene->seen.hulls.closed.cover[place]],
                                            &ray, &faces, &shadow);
    if (scene->dark >> place & 1) {
        if (faces) parts->slope = 10;
        return;
    }
    const int b = scene->lit.waist.main_axis;
    const double depth = is_ray ? (double)shadow.direction[b] * (double)scene->lit.waist.sign : -1;
    if (!faces || !(depth > 0)) {
        parts->depth = 10;
        return;
    }
    parts->depth = fmax(parts->depth, part_of(depth, of->farthest, (double)scene->lit.hulls.last[place]));
    parts->depth =
        fmax(parts->depth, part_of(-depth, -of->shortest, -(double)scene->lit.hulls.closed.common_last[place]));
    for (int side = 0; side < 2; ++side) {
        const struct mlrt_hull_row *slopes = &scene->lit.hulls.term[side];
        const double slope = (double)shadow.direction[(b + 1 + side) % 3] / depth;
        parts->slope = fmax(parts->slope, part_of(slope, of->hi[side], (double)slopes->hi[place]));
        parts->slope = fmax(parts->slope, part_of(-slope, -of->lo[side], -(double)slopes->lo[place]));
    }
}

/* The float nearest to slope * length whose slope is within a cell's. 0 if there is none. */
static int set_component(float slope, float lo, float hi, float length, float *component)
{
    float c = slope * length;
    if ((double)c > (double)hi * (double)length) c = next_float(c, -1);
    if ((double)c < (double)lo * (double)length) c = next_float(c, 1);
    *component = c;
    return (double)c >= (double)lo * (double)length && (double)c <= (double)hi * (double)length;
}

/* `at`: 0 .. 1 for each side. */
static void check_direction(const struct scene *scene, uint32_t place, const struct extremes *of, const float at[2],
                            float length, struct parts *parts)
{
    const int a = scene->seen.waist.main_axis;
    float direction[3];
    direction[a] = scene->seen.waist.sign * length;
    for (int side = 0; side < 2; ++side) {
        const float lo = scene->seen.hulls.term[side].lo[place], hi = scene->seen.hulls.term[side].hi[place];
        const float slope = at[side] <= 0 ? lo : at[side] >= 1 ? hi : lo + at[side] * (hi - lo);
        if (!set_component(slope, lo, hi, length, &direction[(a + 1 + side) % 3])) return;
    }
    check_ray(scene, place, of, direction, parts);
}

/* The corners, and one ray between. 0 if nothing is known of the cell. */
static int check_cell(const struct scene *scene, uint32_t place, const float at[2], float length, struct parts *parts)
{
    struct extremes of;
    *parts = (struct parts){0, 0, 0};
    if (!((scene->known | scene->dark) >> place & 1) || !find_extremes(scene, place, &of)) return 0;
    parts->is_grazing = of.is_grazing && scene->known >> place & 1;
    for (int corner = 0; corner < 4; ++corner) {
        const float there[2] = {(float)(corner & 1), (float)(corner >> 1)};
        check_direction(scene, place, &of, there, length, parts);
    }
    check_direction(scene, place, &of, at, length, parts);
    return 1;
}

/* ---- the search -------------------------------------------------------------------------------------------------- */

/* Inputs: three corners, the eye, the light, lower and upper slopes, bits, a place in the cell, the rays' depth. */
enum { EYE = 9, LIGHT = 12, SLOPES = 15, BITS = 19, AT = 20, LENGTH = 22, INPUT_COUNT };

static int attack(const float *input, struct parts *parts)
{
    static struct scene scene;
    const uint32_t bits = bits_of_float(input[BITS]), place = bits >> 3 & 15;
    const float length = fabsf(input[LENGTH]), at[2] = {fabsf(input[AT]), fabsf(input[AT + 1])};
    memcpy(scene.triangles[0].v, input, sizeof scene.triangles[0].v);
    memcpy(scene.eye, input + EYE, sizeof scene.eye);
    memcpy(scene.light.light, input + LIGHT, sizeof scene.light.light);
    scene.seen.waist.main_axis = (int)(bits & 3) % 3;
    scene.seen.waist.sign = bits & 4 ? -1.0f : 1.0f;
    scene.seen.hulls.closed.cover[place] = 0;
    for (int side = 0; side < 2; ++side) {
        const float s = input[SLOPES + 2 * side], t = input[SLOPES + 2 * side + 1];
        if (fabsf(s) > 2 || fabsf(t) > 2) return 0;
        scene.seen.hulls.term[side].lo[place] = fminf(s, t);
        scene.seen.hulls.term[side].hi[place] = fmaxf(s, t);
    }
    make_cells(&scene, 1u << place);
    return check_cell(&scene, place, at, length, parts);
}

static double attack_slopes(const float *input)
{
    struct parts parts;
    return attack(input, &parts) ? parts.slope / SLOPE_PART : -1;
}

static double attack_depths(const float *input)
{
    struct parts parts;
    return attack(input, &parts) ? parts.depth / DEPTH_PART : -1;
}

static double attack_grazing(const float *input)
{
    struct parts parts;
    return attack(input, &parts) && parts.is_grazing ? parts.slope / GRAZING_PART : -1;
}

static float draw_sign(struct random *random)
{
    return draw_below(random, 2) ? -1.0f : 1.0f;
}

/* A triangle around what the middle of a cell sees: large or small, or a sliver; square to the ray, or oblique. */
static void draw_cover(struct random *random, const float eye[3], const float d[3], float corners[9], float normal[3])
{
    const int power = (int)draw_below(random, 12) - 6;
    const float depth = ldexpf(draw_range(random, 1, 2), power);
    const float width = ldexpf(depth, (int)draw_below(random, 12) - 5);
    const float height = draw_below(random, 3) ? width : ldexpf(width, -(int)draw_below(random, 14));
    float u[3], v[3];
    draw_point(random, -1, 1, u);
    draw_point(random, -1, 1, v);
    if (!draw_below(random, 3)) {
        const float lift = ldexpf(1, -(int)draw_below(random, 8)); /* grazing: nearly along the ray */
        for (int k = 0; k < 3; ++k) u[k] = d[k] + lift * u[k];
    }
    if (!draw_below(random, 3)) {
        v[draw_below(random, 3)] = 0;
        u[draw_below(random, 3)] = 0;
    }
    for (int k = 0; k < 3; ++k) {
        const float hit = eye[k] + depth * d[k];
        corners[k] = hit - width * u[k] - height * v[k];
        corners[3 + k] = hit + 2 * width * u[k] - height * v[k];
        corners[6 + k] = hit - width * u[k] + 2 * height * v[k];
    }
    for (int k = 0; k < 3; ++k) normal[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    if (normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2] > 0) {
        for (int k = 0; k < 3; ++k) normal[k] = -normal[k];
    }
}

/* Lower and upper slopes of a cell. */
static void draw_slopes(struct random *random, float slopes[2])
{
    const float width = draw_below(random, 4) ? ldexpf(1, -(int)draw_below(random, 20)) : 0;
    const float middle = draw_below(random, 8) ? draw_range(random, -2, 2) : draw_sign(random) * 2;
    slopes[0] = fmaxf(middle - width * 0.5f, -2);
    slopes[1] = fminf(middle + width * 0.5f, 2);
}

static void draw_input(struct random *random, const struct bound *bound, float *input)
{
    float d[3], normal[3];
    input[BITS] = float_of_bits(0x3F800000u | draw_below(random, 128));
    const int a = (int)(bits_of_float(input[BITS]) & 3) % 3;
    d[a] = bits_of_float(input[BITS]) & 4 ? -1.0f : 1.0f;
    for (int side = 0; side < 2; ++side) {
        draw_slopes(random, input + SLOPES + 2 * side);
        d[(a + 1 + side) % 3] = 0.5f * (input[SLOPES + 2 * side] + input[SLOPES + 2 * side + 1]);
    }
    draw_point(random, -1, 1, input + EYE);
    draw_cover(random, input + EYE, d, input, normal);
    const int power = (int)draw_below(random, 16) - 8;
    const float far = ldexpf(draw_range(random, 1, 2), power);
    const float near = ldexpf(1, (int)draw_below(random, 12) - 6) * (draw_below(random, 8) ? 1.0f : -1.0f);
    draw_point(random, -far, far, input + LIGHT);
    for (int k = 0; k < 3; ++k) {
        input[LIGHT + k] += (input[k] + input[3 + k] + input[6 + k]) / 3 + near * normal[k];
    }
    for (int i = 0; i < 2; ++i) input[AT + i] = draw_range(random, 0, 1);
    input[LENGTH] = draw_below(random, 2) ? 1 : draw_range(random, 0.01f, 1000);
    for (int i = 0; i < INPUT_COUNT; ++i) input[i] = clamp_input(input[i], (int)(bound->safe >> i & 1));
}

#define SAFE_INPUTS (((1u << INPUT_COUNT) - 1) & ~((1u << EYE) - 1))

static void shadow_rays_lie_within(void **state)
{
    (void)state;
    static const struct bound slopes = {"slopes", INPUT_COUNT, SAFE_INPUTS, attack_slopes, 0.5, NULL};
    static const struct bound depths = {"depths", INPUT_COUNT, SAFE_INPUTS, attack_depths, 0.5, NULL};
    static const struct bound grazing = {"slopes of grazing rays", INPUT_COUNT, SAFE_INPUTS, attack_grazing, 0.5, NULL};
    attack_bound(&slopes, draw_input, CLIMB_COUNT, STEP_COUNT);
    attack_bound(&depths, draw_input, CLIMB_COUNT, STEP_COUNT);
    attack_bound(&grazing, draw_input, CLIMB_COUNT, STEP_COUNT);
}

/* ---- many cells -------------------------------------------------------------------------------------------------- */

/* Neighbours, with a cover of their own or in common, on both sides of the light; at any scale. */
static void draw_scene(struct random *random, struct scene *scene)
{
    const float scale = ldexpf(1, (int)draw_below(random, 81) - 40);
    const float width = ldexpf(1, -(int)draw_below(random, 16));
    const float first[2] = {draw_range(random, -2, 2 - width), draw_range(random, -2, 2 - width)};
    float normal[3], d[3], corners[9];
    scene->seen.waist.main_axis = (int)draw_below(random, 3);
    scene->seen.waist.sign = draw_sign(random);
    draw_point(random, -1, 1, scene->eye);
    for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
        d[scene->seen.waist.main_axis] = scene->seen.waist.sign;
        for (uint32_t side = 0; side < 2; ++side) {
            const float lo = first[side] + 0.25f * width * (float)(side ? place / 4 : place % 4);
            scene->seen.hulls.term[side].lo[place] = lo;
            scene->seen.hulls.term[side].hi[place] = lo + 0.25f * width;
            d[(scene->seen.waist.main_axis + 1 + (int)side) % 3] = lo + 0.125f * width;
        }
        scene->seen.hulls.closed.cover[place] = place;
        if (place && draw_below(random, 4)) {
            scene->seen.hulls.closed.cover[place] = scene->seen.hulls.closed.cover[place - 1];
            continue;
        }
        draw_cover(random, scene->eye, d, corners, normal);
        for (int i = 0; i < 9; ++i) scene->triangles[place].v[i / 3][i % 3] = scale * corners[i];
    }
    const float far = ldexpf(4, (int)draw_below(random, 6));
    draw_point(random, -far, far, scene->light.light);
    for (int k = 0; k < 3; ++k) {
        scene->eye[k] *= scale;
        scene->light.light[k] *= scale;
    }
}

static void sixteen_cells(void **state)
{
    (void)state;
    static struct scene scene;
    struct random random = {78};
    struct parts parts;
    size_t known = 0, dark = 0;
    for (size_t i = 0; i < scaled(20000); ++i) {
        draw_scene(&random, &scene);
        make_cells(&scene, draw_below(&random, 2) ? 0xFFFF : draw_below(&random, 0xFFFF) + 1);
        for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
            const float at[2] = {draw_range(&random, 0, 1), draw_range(&random, 0, 1)};
            if (!check_cell(&scene, place, at, draw_range(&random, 0.1f, 10), &parts)) continue;
            known += scene.known >> place & 1;
            dark += scene.dark >> place & 1;
            if (!(parts.slope <= SLOPE_PART && parts.depth <= DEPTH_PART)) {
                fail_msg("scene %u, cell %u: slopes %g, depths %g", (unsigned)i, (unsigned)place, parts.slope,
                         parts.depth);
            }
        }
    }
    print_message("%zu cells known, %zu dark\n", known, dark);
    assert_true(known > scaled(20000) && dark > scaled(20000));
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shadow_rays_lie_within),
        cmocka_unit_test(sixteen_cells),
    };
    if (argc > 1 && atoi(argv[1]) > 0) search_effort = (size_t)atoi(argv[1]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
