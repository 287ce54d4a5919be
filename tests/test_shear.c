/* SPDX-License-Identifier: MIT */
/*
 * Rays of one direction (src/shear.h): its bounds, attacked by a search for the worst input, and pictures, arrays and
 * lights of such rays against the reference.
 *
 * True values are doubles, whose roundings are 2^-29 of those that are measured. The kernels are included, one lane
 * wide.
 *
 *     test_shear        a few seconds
 *     test_shear 100    100 times the search
 */
#include "search.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels/simd_scalar.h"

/* What the terms were divided by, which true values must be divided by too. */
static int divisor_count;
static float divisors[16];

static float remembering_divide(float a, float b)
{
    divisors[divisor_count++ % 16] = b;
    return v_div(a, b);
}

/* The library has its own. */
#define mlrt_set_sheared_slopes tested_set_sheared_slopes

#include "sheared.h"
extern const struct mlrt_sheared_kernels tested_sheared;
#define v_div         remembering_divide
#define KERNELS       tested_kernels
#define SHEARED       tested_sheared
#define MAKES_SHEARED 1
#include "kernels/bvh_body.h"
#undef v_div

#define UNIT 0x1p-24

/* ---- a triangle and a ray ---------------------------------------------------------------------------------------- */

/* Inputs: three corners, the origin, the direction, one more point of the scene, t_max. */
#define INPUT_COUNT 19

struct seen {
    struct mlrt_triangle triangle;
    struct mlrt_tree tree;
    struct mlrt_job job;
    struct mlrt_ray_tile tile; /* its first packet has the ray in lane 0 */
    struct mlrt_ray_segment ray;
    /* Without rounding, in units of the size, by axis from the main one on. */
    double corner[3][3];
    double origin[3];
    double slope[2];
    double place[2]; /* of the ray */
    double reach;    /* R */
};

static double in_units(const struct mlrt_shear *shear, float a, int k)
{
    return ((double)a - (double)shear->centre[k]) * (double)shear->scale;
}

static void find_in_units(const struct mlrt_shear *shear, const float *point, double of_axis[3])
{
    for (int k = 0; k < 3; ++k) {
        const int axis = (shear->main_axis + k) % 3;
        of_axis[k] = in_units(shear, point[axis], axis) * (k == 0 ? (double)shear->sign : 1);
    }
}

/* Makes all of it; 0 if the ray is not one that the shear is for. */
static int see(const float *input, struct seen *seen)
{
    struct mlrt_cells *cells = &seen->tile.cells;
    struct mlrt_shear *shear = &cells->shear;
    struct mlrt_packet *packet = &seen->tile.packets[0];
    const float *direction = input + 12, *origin = input + 9;
    memset(&seen->job, 0, sizeof seen->job);
    memset(&seen->tile, 0, offsetof(struct mlrt_ray_tile, packets));
    memcpy(seen->triangle.v, input, sizeof seen->triangle.v);
    seen->tree.triangles = &seen->triangle;
    seen->job.tree = &seen->tree;
    seen->tree.bvh.unit = 1;
    seen->job.source.kind = MLRT_SOURCE_RAYS;
    seen->job.any = (int)(bits_of(input[0]) & 1);
    for (int k = 0; k < 3; ++k) {
        const float *v = input + k;
        seen->tree.bounds.lo[k] = fminf(fminf(v[0], v[3]), fminf(v[6], v[15]));
        seen->tree.bounds.hi[k] = fmaxf(fmaxf(v[0], v[3]), fmaxf(v[6], v[15]));
        if (!mlrt_is_float_safe(direction[k]) || !mlrt_is_float_safe(origin[k])) return 0;
    }
    if (!mlrt_make_segment(origin, direction, 0, fabsf(input[18]), &seen->ray)) return 0;
    mlrt_set_shear(&seen->job, direction, input + 15, cells);
    packet->active = 1;
    packet->single = 0;
    packet->has_apex = packet->has_skip = packet->has_masks = 0;
    packet->has_limits = 1;
    packet->shear = NULL;
    for (int lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        for (int k = 0; k < 3; ++k) {
            packet->origin[k][lane] = origin[k];
            packet->direction[k][lane] = direction[k];
        }
        packet->t_min[lane] = 0;
        packet->t_max[lane] = packet->lo[lane] = packet->hi[lane] = seen->ray.t_max;
        packet->triangle[lane] = MLRT_NONE;
    }
    for (uint32_t i = 0; i < MLRT_CELL_COUNT; ++i) mlrt_leave_out_cell(cells, i);
    cells->tile = &seen->tile;
    if (!add_packet(&seen->tile, 0)) return 0;
    sum_up_cells(cells);

    const int a = shear->main_axis;
    for (int i = 0; i < 3; ++i) find_in_units(shear, seen->triangle.v[i], seen->corner[i]);
    find_in_units(shear, origin, seen->origin);
    seen->reach = 1;
    for (int side = 0; side < 2; ++side) {
        seen->slope[side] = (double)shear->along[(a + 1 + side) % 3] / fabs((double)shear->along[a]);
        seen->place[side] = seen->origin[1 + side] - seen->slope[side] * seen->origin[0];
        seen->reach = fmax(seen->reach, 2 * fabs(seen->place[side]));
    }
    return 1;
}

static double place_of(const struct seen *seen, int corner, int side)
{
    return seen->corner[corner][1 + side] - seen->slope[side] * seen->corner[corner][0];
}

/* c . (direction of the ray), as the filter has it, but with the sign that it had before N's. */
static double find_term(const struct seen *seen, const struct mlrt_leaf_setup *leaf, int i)
{
    const struct mlrt_packet *packet = &seen->tile.packets[0];
    const float direction[3] = {packet->direction[0][0], packet->direction[1][0], packet->direction[2][0]};
    const float cross[3] = {leaf->cross[i][0][0], leaf->cross[i][1][0], leaf->cross[i][2][0]};
    const float term = dot_product(direction, cross);
    return leaf->negative & 1 ? -(double)term : (double)term;
}

/* The terms of the triangle, before anything is settled. */
static void set_up(const struct seen *seen, struct lone_triangle *lone)
{
    const float *corner = seen->triangle.v[0];
    memset(lone, 0, sizeof *lone);
    for (int i = 0; i < 9 * 4; ++i) lone->corners[i] = corner[i / 4];
    lone->leaf.numbers = &lone->number;
    lone->leaf.corners = lone->corners;
    lone->leaf.row = 4;
    lone->leaf.there = 1;
    divisor_count = 0;
    (void)set_sheared_terms(&seen->tile.cells.shear, 1, &lone->leaf);
    set_sheared_outlines(&seen->tile.cells.shear, &lone->leaf);
}

static double difference_of(const struct seen *seen, int to, int from, int k)
{
    const int axis = (seen->tile.cells.main_axis + k) % 3;
    return (double)seen->triangle.v[to][axis] - (double)seen->triangle.v[from][axis];
}

/* ---- attacks ----------------------------------------------------------------------------------------------------- */

static double attack_edges(const float *input)
{
    static struct seen seen;
    struct lone_triangle lone;
    double worst = 0;
    if (!see(input, &seen)) return -1;
    set_up(&seen, &lone);
    const double sign = (double)seen.tile.cells.sign;
    for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3;
        double x[2], g[2];
        for (int side = 0; side < 2; ++side) {
            x[side] = place_of(&seen, i, side) + place_of(&seen, next, side) - 2 * seen.place[side];
            g[side] =
                difference_of(&seen, next, i, 1 + side) - seen.slope[side] * sign * difference_of(&seen, next, i, 0);
        }
        const double edge = sign * (x[0] * g[1] - x[1] * g[0]) / (double)divisors[i]; /* depth mirrors */
        const double bound = (double)EDGE_BOUND * seen.reach;
        worst = fmax(worst, fabs(find_term(&seen, &lone.leaf, i) - edge) / bound);
    }
    return worst;
}

/* Of the scaled normal: its components, from the main one on; returns N'. */
static double find_normal(const struct seen *seen, double normal[3])
{
    const double sign = (double)seen->tile.cells.sign;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double p = difference_of(seen, 0, 2, i) * difference_of(seen, 1, 0, j);
        normal[k] = (p - difference_of(seen, 0, 2, j) * difference_of(seen, 1, 0, i)) * 0.125 / (double)divisors[3];
    }
    return normal[0] * sign + normal[1] * seen->slope[0] + normal[2] * seen->slope[1];
}

/* D' has 5 u of its bound to spare. */
static double attack_d(const float *input)
{
    static struct seen seen;
    struct lone_triangle lone;
    double normal[3];
    if (!see(input, &seen)) return -1;
    set_up(&seen, &lone);
    double d = find_normal(&seen, normal) - seen.corner[0][0] * normal[0] * (double)seen.tile.cells.sign;
    for (int side = 0; side < 2; ++side) d += (seen.place[side] - seen.corner[0][1 + side]) * normal[1 + side];
    return fabs(find_term(&seen, &lone.leaf, 3) - d) / ((double)PLANE_BOUND * seen.reach - 5 * UNIT);
}

/* N' is off by 3 u, and its bounds leave 11 u of it for where rays begin and end. */
static double attack_n(const float *input)
{
    static struct seen seen;
    struct lone_triangle lone;
    double normal[3];
    if (!see(input, &seen)) return -1;
    set_up(&seen, &lone);
    const double least = (double)lone.leaf.least_n[0], greatest = (double)lone.leaf.greatest_n[0];
    const double n = find_normal(&seen, normal) * (lone.leaf.negative & 1 ? -1 : 1);
    const double error = fabs(n - 0.5 * (least + greatest));
    return fmax(error / (3 * UNIT), (error + 11 * UNIT * fabs(n)) / (0.5 * (greatest - least)));
}

/* Where a ray begins and ends: t_max is where it does both. */
static double attack_ends(const float *input)
{
    static struct seen seen;
    if (!see(input, &seen)) return -1;
    struct mlrt_packet *packet = &seen.tile.packets[0];
    const struct mlrt_shear shear = seen.tile.cells.shear;
    const double to = remainder((double)input[18], 1.5);
    const float t = (float)((to - seen.origin[0]) / (double)shear.pace);
    if (!isfinite(t)) return -1;
    const double z = seen.origin[0] + (double)t * (double)shear.pace;
    const int axes[3] = {shear.main_axis, (shear.main_axis + 1) % 3, (shear.main_axis + 2) % 3};
    struct sheared_extremes of = {.at_hand = 0};
    packet->t_min[0] = packet->t_max[0] = t;
    shear_vector(&shear, axes, 0, packet, &of);
    if (!of.at_hand) return -1;
    const double begin = (double)packet->begin[0];
    if (begin != (double)packet->lo[0] || begin != (double)packet->hi[0]) return INFINITY;
    /* Does the ray surely begin before the scene? */
    double front = INFINITY;
    for (int i = 0; i < 3; ++i) front = fmin(front, seen.corner[i][0]);
    if (!of.within && z >= front) return INFINITY;
    if (z > 0.5) return begin >= 2 * (1 - 9 * UNIT) ? 0 : INFINITY;
    if (z < -8) return begin <= (1 + 9 * UNIT) / 9 ? 0 : INFINITY;
    return fabs(begin * (1 - z) - 1) / (9 * UNIT);
}

/* What is used of a slack of 2^-20. */
static double slack_used(double truth, double bound, int is_upper)
{
    return 1 - (is_upper ? bound - truth : truth - bound) * 0x1p20;
}

static double attack_outline(const float *input)
{
    static struct seen seen;
    struct lone_triangle lone;
    double worst = 0, least = INFINITY;
    if (!see(input, &seen)) return -1;
    set_up(&seen, &lone);
    for (int i = 0; i < 3; ++i) {
        least = fmin(least, seen.corner[i][0]);
        for (int side = 0; side < 2; ++side) {
            const double place = place_of(&seen, i, side);
            if (place < (double)lone.leaf.slope_lo[side][0] || place > (double)lone.leaf.slope_hi[side][0])
                return INFINITY;
        }
    }
    for (int side = 0; side < 2; ++side) {
        const double p[3] = {place_of(&seen, 0, side), place_of(&seen, 1, side), place_of(&seen, 2, side)};
        const double lo = fmin(fmin(p[0], p[1]), p[2]), hi = fmax(fmax(p[0], p[1]), p[2]);
        worst = fmax(worst, slack_used(lo, (double)lone.leaf.slope_lo[side][0], 0));
        worst = fmax(worst, slack_used(hi, (double)lone.leaf.slope_hi[side][0], 1));
    }
    return fmax(worst, slack_used(1, (double)lone.leaf.least_depth[0] * (1 - least), 0));
}

/* Places in the picture: of packets, */
static double attack_place(const float *input)
{
    static struct seen seen;
    double worst = 0;
    if (!see(input, &seen)) return -1;
    for (int side = 0; side < 2; ++side) {
        worst = fmax(worst, slack_used(seen.place[side], (double)seen.tile.cells.slopes[side].lo[0], 0));
        worst = fmax(worst, slack_used(seen.place[side], (double)seen.tile.cells.slopes[side].hi[0], 1));
    }
    return worst;
}

/* and of a camera's cells. Inputs: d00, dx, dy, direction, two corners of the scene. */
static double attack_camera_cell(const float *input)
{
    static struct seen seen;
    static struct mlrt_cells cells;
    struct mlrt_view view = {.parallel = 1, .width = 64, .height = 64, .sample_x = 0.5f, .t_max = INFINITY};
    double worst = 0, front = INFINITY;
    for (int k = 0; k < 3; ++k) {
        view.d00[k] = input[k];
        view.dx[k] = 0x1p-6f * input[3 + k];
        view.dy[k] = 0x1p-6f * input[6 + k];
        view.direction[k] = input[9 + k];
        seen.tree.bounds.lo[k] = fminf(input[12 + k], input[15 + k]);
        seen.tree.bounds.hi[k] = fmaxf(input[12 + k], input[15 + k]);
    }
    if (view.direction[0] == 0 && view.direction[1] == 0 && view.direction[2] == 0) return -1;
    seen.job.tree = &seen.tree;
    seen.tree.bvh.unit = 1;
    seen.job.source.kind = MLRT_SOURCE_CAMERA;
    seen.job.source.view = view;
    seen.job.any = (int)(bits_of(input[0]) & 1);
    const struct mlrt_rectangle area = {bits_of(input[18]) % 48, bits_of(input[18]) / 64 % 48, 16, 16};
    if (!gather_camera_cells(&seen.job, &area, 4, &cells)) return -1;
    const struct mlrt_shear *shear = &cells.shear;
    const int a = shear->main_axis;
    for (int i = 0; i < 2; ++i) {
        double corner[3];
        find_in_units(shear, i ? seen.tree.bounds.hi : seen.tree.bounds.lo, corner);
        front = fmin(front, corner[0]);
    }
    for (uint32_t i = 0; i < 256; ++i) {
        const uint32_t place = i % 16 / 4 + i / 64 * 4;
        double origin[3];
        float p[3];
        mlrt_view_point(&view, area.x + i % 16, area.y + i / 16, p);
        find_in_units(shear, p, origin);
        if (origin[0] >= front) return INFINITY;
        for (int side = 0; side < 2; ++side) {
            const double slope = (double)view.direction[(a + 1 + side) % 3] / fabs((double)view.direction[a]);
            const double at = origin[1 + side] - slope * origin[0];
            worst = fmax(worst, slack_used(at, (double)cells.slopes[side].lo[place], 0));
            worst = fmax(worst, slack_used(at, (double)cells.slopes[side].hi[place], 1));
        }
    }
    return worst;
}

/* Which share of the slack was needed where a box is left out: of what is missed by a lot, next to none. */
static double attack_box(const float *input)
{
    static struct seen seen;
    static struct mlrt_bvh_node node;
    float near[MLRT_BVH_WIDTH];
    double worst = -1;
    if (!see(input, &seen)) return -1;
    struct mlrt_cells *cells = &seen.tile.cells;
    const int a = cells->main_axis;
    cells->farthest[0] = INFINITY;
    set_whole_farthest(cells);
    for (int i = 0; i < MLRT_BVH_WIDTH; ++i) {
        for (int k = 0; k < 3; ++k) {
            node.lo[k][i] = i > 0 ? INFINITY : fminf(input[k], input[3 + k]);
            node.hi[k][i] = i > 0 ? -INFINITY : fmaxf(input[k], input[3 + k]);
        }
    }
    const uint32_t of_all = children_met(cells, &node, near), of_cell = cells_met(cells, &node, 0);
    if (of_all > 1 || of_cell > 1) return INFINITY;
    /* Its depths, and where it is seen: over both axes apart, as if they had nothing to do with each other. */
    const double z[2] = {fmin(seen.corner[0][0], seen.corner[1][0]), fmax(seen.corner[0][0], seen.corner[1][0])};
    if ((double)near[0] * (1 - z[0]) > 1) return INFINITY;
    for (int side = 0; side < 2; ++side) {
        const int j = (a + 1 + side) % 3;
        const double s = seen.slope[side];
        const double least = in_units(&cells->shear, node.lo[j][0], j) - fmax(s * z[0], s * z[1]);
        const double greatest = in_units(&cells->shear, node.hi[j][0], j) - fmin(s * z[0], s * z[1]);
        worst = fmax(worst, fmax(least - seen.place[side], seen.place[side] - greatest));
    }
    if (of_all && of_cell) return -1;
    if (worst <= 0) return INFINITY;
    const double share = worst * 0x1p20;
    return share < 1 ? 1 - share : 0.01 / (1 + log2(share));
}

/* All decisions about a triangle and a ray: none may be wrong. */
static double attack_decisions(const float *input)
{
    MLRT_ALIGNED(64) float depth[MLRT_CELL_COUNT];
    static struct seen seen;
    struct lone_triangle lone;
    uint32_t inside;
    if (!see(input, &seen)) return -1;
    struct mlrt_ray_tile *tile = &seen.tile;
    struct mlrt_cells *cells = &tile->cells;
    const int is_hit = mlrt_hits_triangle(&seen.ray, &seen.triangle, NULL);
    set_up_lone_triangle(&seen.tree, cells, 0, &lone);
    set_sheared_outlines(&cells->shear, &lone.leaf);
    if (!lone.leaf.there) return is_hit ? INFINITY : 0;
    struct ray_vector rays;
    load_ray_vector(&tile->packets[0], 0, &rays);
    const float reach = packet_reach(tile, 0);
    const struct filter_bounds bounds = {EDGE_BOUND * reach, PLANE_BOUND * reach};
    const float *from = tile->limits_below ? tile->packets[0].begin : NULL;
    vf least;
    find_least_edges(&lone.leaf, 0, &rays.direction, 1, &least);
    const vm candidates = v_ge(least, -bounds.edge);
    const struct leaf_verdict verdict = filter_leaf_vector(&lone.leaf, 0, &bounds, from, &rays, least, candidates);
    if (m_bits(verdict.nearer) && !is_hit) return INFINITY;
    if (!m_bits(verdict.nearer) && !m_bits(verdict.undecided) && is_hit) return INFINITY;
    if (!(seen_by_cells(cells, &lone.leaf) && seen_by_cell(cells, 0, 1, &lone.leaf)) && is_hit) return INFINITY;
    if (m_bits(verdict.nearer)) {
        /* Between the bounds of where it is, and so is what the judge makes of it. */
        struct mlrt_nearest nearest = {0, 0, 0};
        mlrt_bound_distance(&seen.ray, &seen.triangle, &nearest.lo, &nearest.hi);
        const double pace = (double)cells->shear.pace;
        const double one = seen.origin[0] + (double)nearest.lo * pace,
                     other = seen.origin[0] + (double)nearest.hi * pace;
        const double lo = 1 / (1 - fmin(one, other)), hi = 1 / (1 - fmax(one, other));
        mlrt_shear_distance(&cells->shear, &seen.ray, &nearest);
        if ((double)nearest.lo > lo || (double)nearest.hi < hi) return INFINITY;
        keep_leaf_verdict(&verdict, &lone.leaf, 0, &rays);
        store_ray_vector(&rays, 0, &tile->packets[0]);
        if ((double)tile->packets[0].lo[0] > hi || (double)tile->packets[0].hi[0] < lo) return INFINITY;
    }
    if (!(cells->closed & 1)) return 0;
    const uint32_t opened = offer_to_closed(cells, &lone.leaf, 0, 1, 0, &inside, depth);
    if (cells->cover[0] != MLRT_NONE && !is_hit) return INFINITY;
    return cells->cover[0] == MLRT_NONE && !opened && is_hit ? INFINITY : 0;
}

/* ---- the search -------------------------------------------------------------------------------------------------- */

enum kind { WHOLE, NEAR_ONE, SPREAD, NEARLY_EQUAL, FAR_OFF, KIND_COUNT };

static float draw_input(struct random *random, enum kind kind, float base)
{
    static const int steps[] = {0, 0, 0, -1, -3, -12, -24, -50};
    const float a = draw_range(random, -1, 1);
    switch (kind) {
    case WHOLE:
        return 0.25f * (float)((int)draw_below(random, 9) - 4);
    case NEAR_ONE:
        return draw_below(random, 6) ? a : 0;
    case SPREAD:
        return ldexpf(a, steps[draw_below(random, 8)]);
    case NEARLY_EQUAL:
        return next_float(base, (int)draw_below(random, 17) - 8);
    default:
        return base + a;
    }
}

/* Every scale is the same, but for underflow. */
static void draw_inputs(struct random *random, const struct bound *bound, float *input)
{
    const enum kind kind = (enum kind)draw_below(random, KIND_COUNT);
    const int scale = draw_below(random, 3) ? 0 : (int)draw_below(random, 100) - 50;
    const float offset = kind == FAR_OFF ? ldexpf(1, (int)draw_below(random, 20)) : draw_range(random, -1, 1);
    for (int i = 0; i < bound->input_count; ++i) {
        const enum kind one = draw_below(random, 8) ? kind : (enum kind)draw_below(random, KIND_COUNT);
        const int is_direction = i >= 12 && i < 15;
        const enum kind of_direction = draw_below(random, 3) ? NEAR_ONE : draw_below(random, 2) ? WHOLE : SPREAD;
        input[i] = draw_input(random, is_direction || i == 18 ? of_direction : one, offset);
        if (!is_direction && i < 18) input[i] = ldexpf(input[i], scale);
    }
    if (draw_below(random, 4) == 0) { /* the direction in the triangle's plane, or nearly so */
        const float x = draw_range(random, -1, 1), y = draw_below(random, 2) ? 0 : draw_range(random, -1, 1);
        for (int k = 0; k < 3; ++k) input[12 + k] = x * (input[3 + k] - input[k]) + y * (input[6 + k] - input[k]);
    }
    if (draw_below(random, 4) == 0) { /* towards an edge, or the inside; or from there */
        const float x = draw_range(random, 0, 1), y = draw_below(random, 2) ? 0 : draw_range(random, 0, 1 - x);
        const float t = draw_below(random, 3) ? draw_range(random, -1, 1) : 0;
        for (int k = 0; k < 3; ++k) {
            const float *v = input + k;
            input[9 + k] = v[0] + x * (v[3] - v[0]) + y * (v[6] - v[0]) - t * input[12 + k];
        }
        if (draw_below(random, 2)) input[18] = next_float(t, (int)draw_below(random, 5) - 2);
    }
    if (draw_below(random, 3) == 0) input[18] = INFINITY;
}

static void bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"shear: e", INPUT_COUNT, 0, attack_edges, 0.1, NULL},
        {"shear: D", INPUT_COUNT, 0, attack_d, 0.2, NULL},
        {"shear: N", INPUT_COUNT, 0, attack_n, 0.3, NULL},
        {"shear: begin and end", INPUT_COUNT, 0, attack_ends, 0.3, NULL},
        {"shear: outlines", INPUT_COUNT, 0, attack_outline, 0.05, NULL},
        {"shear: places of packets", INPUT_COUNT, 0, attack_place, 0.05, NULL},
        {"shear: places of a camera's cells", INPUT_COUNT, 0, attack_camera_cell, 0.02, NULL},
        {"shear: boxes", INPUT_COUNT, 0, attack_box, 0.04, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) {
        const size_t climbs = bounds[i].attack == attack_camera_cell ? CLIMB_COUNT
                              : bounds[i].attack == attack_box       ? 40
                                                                     : 20;
        attack_bound(&bounds[i], draw_inputs, climbs, STEP_COUNT);
    }
}

static void decisions_are_right(void **state)
{
    static const struct bound bound = {"shear: decisions", INPUT_COUNT, 0, attack_decisions, 0, NULL};
    (void)state;
    attack_bound(&bound, draw_inputs, 1000, 800);
}

/* ---- against the reference --------------------------------------------------------------------------------------- */

static void check_traced(const struct fixture *fixture, const struct ray_list *list, const char *text,
                         const struct reference_hit *expected, const struct reference_hit *hits,
                         const uint8_t *occluded)
{
    for (size_t i = 0; i < list->count; ++i) {
        if (hits) check_hit(fixture, text, i, &list->rays[i], &expected[i], &hits[i]);
        if (!occluded || occluded[i] == (expected[i].mesh != MLRT_NONE)) continue;
        print_difference(fixture, text, i, &list->rays[i], &expected[i], &expected[i]);
        fail_msg("occluded: %d", (int)occluded[i]);
    }
}

/* Rays of arrays; or those of a camera, or of a light, if there is one. Closest and any hit, by method tile. */
static void check_by_tiles(const struct fixture *fixture, const struct ray_list *list, const mlrt_camera *camera,
                           const mlrt_light *light)
{
    char text[200];
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    trace_reference(fixture, list, expected);
    const mlrt_hits hits = public_hits(got, camera ? list->row_length : 0);
    const mlrt_hits any = {.struct_size = sizeof any, .occluded = {occluded, 0, 0}};
    const mlrt_rays rays = public_rays(list);
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = list->row_length,
                                .count = list->count,
                                .positions = rays.origins,
                                .skip = rays.skip};
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_AVX512; ++isa) {
        if (isa != MLRT_ISA_SCALAR && !isa_is_supported(isa)) continue;
        mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_TILE, .isa = isa};
        describe(camera ? "camera" : light ? "light" : "arrays", &options, 0, text, sizeof text);
        memset(occluded, 0xA5, list->count);
        if (light) {
            assert_int_equal(mlrt_occluded_points(fixture->tree, &points, light, &options, &any.occluded), MLRT_OK);
            check_traced(fixture, list, text, expected, NULL, occluded);
            continue;
        }
        memset(got, 0xA5, list->count * sizeof *got);
        for (int32_t query = 0; query < 2; ++query) {
            options.query = query ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST;
            const mlrt_hits *out = query ? &any : &hits;
            assert_int_equal(camera ? mlrt_render_tiles(fixture->tree, camera, &options, out, NULL, NULL)
                                    : mlrt_trace_packet(fixture->tree, &rays, &options, out),
                             MLRT_OK);
        }
        check_traced(fixture, list, text, expected, got, occluded);
    }
    free(expected);
    free(got);
    free(occluded);
}

/* Scenes of small whole coordinates, where much is exactly on edges and in planes. */
#define SCENE_COUNT 7

static struct fixture draw_scene(uint32_t number)
{
    static const char *const names[SCENE_COUNT] = {"whole numbers", "quads", "needles", "soup", "tiny", "flat", "huge"};
    struct random random = {900 + number};
    struct soup soup = {0};
    const float corner[3] = {0, 0, 0}, lo[3] = {-1, -1, -1}, hi[3] = {5, 5, 5};
    switch (number) {
    case 1:
        for (int axis = 0; axis < 3; ++axis) soup_add_grid(&soup, axis, (float)axis, 3);
        soup_add_box(&soup, lo, hi);
        break;
    case 2:
        soup_add_needles(&soup, &random, 60, 0x1p-20f);
        break;
    case 3:
        soup_add_random(&soup, &random, 60, 2, 0.5f);
        break;
    case 5:
        soup_add_grid(&soup, 2, 1, 4);
        break;
    default:
        for (int i = 0; i < 60; ++i) {
            float v[3][3];
            for (int j = 0; j < 9; ++j) v[j / 3][j % 3] = (float)draw_below(&random, 5);
            soup_add_triangle(&soup, v[0], v[1], v[2]);
        }
    }
    if (number == 4) move_soup(&soup, 0x1p-57f, corner);
    if (number == 6) move_soup(&soup, 0x1p50f, corner);
    return fixture_of_soup(names[number], 900 + number, &soup);
}

static const float *draw_corner(struct random *random, const struct fixture *fixture)
{
    const size_t count = reference_triangle_count(fixture->reference);
    return reference_triangle_at(fixture->reference, draw_below(random, (uint32_t)count))
        ->corner[draw_below(random, 3)];
}

/* Along axes and diagonals, from vertex to vertex, in planes of triangles, any; short, long, and of unequal parts. */
static void draw_direction(struct random *random, const struct fixture *fixture, float direction[3])
{
    const uint32_t kind = draw_below(random, 6);
    const float *from = draw_corner(random, fixture), *to = draw_corner(random, fixture);
    const float length = draw_below(random, 4) ? 1 : ldexpf(1, (int)draw_below(random, 100) - 50);
    for (int k = 0; k < 3; ++k) {
        direction[k] = kind == 1   ? (float)((int)draw_below(random, 5) - 2)
                       : kind == 2 ? to[k] - from[k]
                                   : draw_range(random, -1, 1);
        if (kind == 3) direction[k] *= ldexpf(1, -(int)draw_below(random, 30));
        if (kind == 0) direction[k] = draw_below(random, 2) ? 0.0f : -0.0f;
        direction[k] *= kind == 2 ? 1 : length;
    }
    if (kind == 0 || (direction[0] == 0 && direction[1] == 0 && direction[2] == 0)) {
        direction[draw_below(random, 3)] = draw_below(random, 2) ? length : -length;
    }
}

static float extent_of(const struct fixture *fixture, float lo[3], float hi[3])
{
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(fixture->tree, &info), MLRT_OK);
    float extent = 0;
    for (int k = 0; k < 3; ++k) {
        lo[k] = info.bounds_min[k];
        hi[k] = info.bounds_max[k];
        extent = fmaxf(extent, hi[k] - lo[k]);
    }
    return extent;
}

static float largest_of(const float v[3])
{
    return fmaxf(fabsf(v[0]), fmaxf(fabsf(v[1]), fabsf(v[2])));
}

/* A vertex, a corner of the scene's box, a middle of an edge, or any point. */
static void draw_place(struct random *random, const struct fixture *fixture, float point[3])
{
    float lo[3], hi[3];
    const float *a = draw_corner(random, fixture), *b = draw_corner(random, fixture);
    const uint32_t kind = draw_below(random, 4);
    (void)extent_of(fixture, lo, hi);
    for (int k = 0; k < 3; ++k) {
        point[k] = kind == 0   ? a[k]
                   : kind == 1 ? 0.5f * a[k] + 0.5f * b[k]
                   : kind == 2 ? (draw_below(random, 2) ? lo[k] : hi[k])
                               : draw_range(random, lo[k], hi[k]);
    }
}

/*
 * A picture of origins, `width` wide, of which some rows or columns may lie elsewhere, and which may begin before,
 * within or behind the scene; or places all over it.
 */
static void add_origins(struct random *random, const struct fixture *fixture, size_t count, uint32_t width,
                        const float direction[3], struct ray_list *list)
{
    float lo[3], hi[3], base[3], across[3], down[3];
    const float extent = extent_of(fixture, lo, hi), back = draw_below(random, 3) ? draw_range(random, 0, 2) : 0;
    const float step = ldexpf(extent, -(int)draw_below(random, 12)), away = back * (extent / largest_of(direction));
    const int is_scattered = draw_below(random, 4) == 0, is_whole = (int)draw_below(random, 2);
    const float jump = draw_below(random, 3) ? 0 : 0.3f * extent;
    const int axis = (int)draw_below(random, 3);
    draw_place(random, fixture, base);
    for (int k = 0; k < 3; ++k) {
        across[k] = is_whole ? (k == axis ? step : 0) : step * draw_range(random, -1, 1);
        down[k] = is_whole ? (k == (axis + 1) % 3 ? step : 0) : step * draw_range(random, -1, 1);
    }
    for (size_t i = 0; i < count; ++i) {
        const float x = (float)(i % width), y = (float)(i / width);
        float origin[3];
        if (is_scattered) draw_place(random, fixture, base);
        const float beside = (i % width / 6 + i / width / 5) % 2 ? jump : 0;
        for (int k = 0; k < 3; ++k) {
            origin[k] = base[k] + beside - away * direction[k] + (is_scattered ? 0 : x * across[k] + y * down[k]);
        }
        add_ray(list, origin, direction);
    }
}

/* Ranges that end at hits, or beside them, and skips of what would be hit. */
static void add_ranges(struct random *random, const struct fixture *fixture, struct ray_list *list)
{
    const uint32_t kind = draw_below(random, 4), has_skips = draw_below(random, 2);
    float lo[3], hi[3];
    const float whole = extent_of(fixture, lo, hi) / largest_of(list->rays[0].direction);
    const float least = whole * draw_range(random, 0, 1), greatest = whole * draw_range(random, 0, 2);
    for (size_t i = 0; i < list->count; ++i) {
        struct reference_ray *ray = &list->rays[i];
        struct reference_hit hit;
        reference_trace(fixture->reference, ray, &hit);
        if (has_skips && draw_below(random, 3)) {
            ray->skip[0] = hit.mesh;
            ray->skip[1] = hit.triangle;
        }
        const float t = hit.mesh == MLRT_NONE ? whole : next_float(hit.t, (int)draw_below(random, 3) - 1);
        if (kind == 1) ray->t_min = draw_below(random, 2) ? fmaxf(t, 0) : least * draw_range(random, 0, 1);
        if (kind == 2) ray->t_max = draw_below(random, 2) ? t : greatest * draw_range(random, 0, 1);
        if (kind == 3) ray->t_min = least, ray->t_max = greatest;
    }
}

static void arrays_of_one_direction(void **state)
{
    (void)state;
    struct random random = {31};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(120); ++round) {
            struct ray_list list = {0};
            float direction[3];
            draw_direction(&random, &fixture, direction);
            list.row_length = draw_below(&random, 3) ? 4 + draw_below(&random, 40) : 0;
            const size_t count = 1 + draw_below(&random, 500);
            add_origins(&random, &fixture, count, list.row_length ? list.row_length : 4, direction, &list);
            if (draw_below(&random, 2)) add_ranges(&random, &fixture, &list);
            check_by_tiles(&fixture, &list, NULL, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* Packets of one direction beside those of others, and of the opposite one; and packets of several. */
static void several_directions_in_one_tile(void **state)
{
    (void)state;
    struct random random = {32};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(70); ++round) {
            struct ray_list list = {.row_length = 16 + 4 * draw_below(&random, 8)};
            float directions[3][3];
            const uint32_t block = draw_below(&random, 6) ? 4 : 3;
            for (int i = 0; i < 3; ++i) draw_direction(&random, &fixture, directions[i]);
            if (draw_below(&random, 2)) {
                for (int k = 0; k < 3; ++k) directions[1][k] = -directions[0][k];
            }
            add_origins(&random, &fixture, 600, list.row_length, directions[0], &list);
            for (size_t i = 0; i < list.count; ++i) {
                const size_t x = i % list.row_length / block, y = i / list.row_length / block;
                memcpy(list.rays[i].direction, directions[(x + y) % 3], sizeof directions[0]);
            }
            if (draw_below(&random, 2)) add_ranges(&random, &fixture, &list);
            check_by_tiles(&fixture, &list, NULL, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

static void directional_lights(void **state)
{
    (void)state;
    struct random random = {33};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(100); ++round) {
            struct ray_list list = {.row_length = draw_below(&random, 3) ? 20 + draw_below(&random, 40) : 0};
            mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_DIRECTIONAL};
            draw_direction(&random, &fixture, light.position);
            add_origins(&random, &fixture, 800, list.row_length ? list.row_length : 4, light.position, &list);
            for (size_t i = 0; i < list.count && round % 2; ++i) {
                struct reference_hit hit;
                reference_trace(fixture.reference, &list.rays[i], &hit);
                list.rays[i].skip[0] = hit.mesh;
                list.rays[i].skip[1] = hit.triangle;
            }
            check_by_tiles(&fixture, &list, NULL, &light);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* In front of the scene, within it and behind it; square to the direction, or oblique; with limits, too. */
static void parallel_cameras(void **state)
{
    (void)state;
    struct random random = {34};
    for (uint32_t number = 0; number < SCENE_COUNT; ++number) {
        struct fixture fixture = draw_scene(number);
        for (size_t round = 0; round < scaled(50); ++round) {
            float lo[3], hi[3], direction[3], middle[3];
            const float extent = extent_of(&fixture, lo, hi);
            draw_direction(&random, &fixture, direction);
            draw_place(&random, &fixture, middle);
            const float back = draw_below(&random, 4) ? draw_range(&random, 0, 4) : -0.5f;
            const float away = back * (extent / largest_of(direction));
            for (int k = 0; k < 3; ++k) middle[k] -= away * direction[k];
            const float width = ldexpf(extent, 1 - (int)draw_below(&random, 8));
            const uint32_t columns = 1 + draw_below(&random, 70), rows = 1 + draw_below(&random, 40);
            mlrt_camera camera = look_along(middle, direction, width, columns, rows);
            if (draw_below(&random, 2)) { /* along axes, and so oblique to the direction */
                const float step = width / (float)columns;
                int a = 0;
                for (int k = 1; k < 3; ++k) a = fabsf(direction[k]) > fabsf(direction[a]) ? k : a;
                for (int k = 0; k < 3; ++k) {
                    camera.dx[k] = k == (a + 1) % 3 ? step : 0;
                    camera.dy[k] = k == (a + 2) % 3 ? step : 0;
                    camera.d00[k] =
                        middle[k] - 0.5f * (float)columns * camera.dx[k] - 0.5f * (float)rows * camera.dy[k];
                }
                camera.sample_x = camera.sample_y = 0;
            }
            if (round % 4 == 3) camera.t_min = away > 0 ? away : 0;
            if (round % 5 == 4) camera.t_max = fabsf(away) * 1.25f;
            struct ray_list list = {0};
            const mlrt_array none = {NULL, 0, 0};
            if (mlrt_camera_rays(&camera, &none, &none) != MLRT_OK) continue; /* dx and dy underflow */
            add_camera_rays(&list, &camera);
            check_by_tiles(&fixture, &list, &camera, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* Packets so wide that they are no cells, with directions that are short, or nearly 1. */
static void small_pictures(void **state)
{
    (void)state;
    static const float lengths[] = {0x1p-20f, 0x1p-9f, 0.4375f, 0.9375f, 3};
    for (uint32_t number = 0; number < 2; ++number) {
        struct fixture fixture = draw_scene(number);
        for (uint32_t i = 0; i < 5 * 9; ++i) {
            const uint32_t size = 1 + i / 5;
            const float step = 4 / (float)size, slant = i % 2 ? 0.25f * lengths[i % 5] : 0;
            mlrt_camera camera = {.struct_size = sizeof camera,
                                  .width = size,
                                  .height = size,
                                  .projection = MLRT_PROJECTION_PARALLEL,
                                  .direction = {slant, 0, -lengths[i % 5]},
                                  .d00 = {0, 0, 5.5f},
                                  .dx = {step, 0, 0},
                                  .dy = {0, step, 0},
                                  .sample_x = 0.5f,
                                  .sample_y = 0.5f};
            struct ray_list list = {0};
            add_camera_rays(&list, &camera);
            check_by_tiles(&fixture, &list, &camera, NULL);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(decisions_are_right),
        cmocka_unit_test(arrays_of_one_direction),
        cmocka_unit_test(several_directions_in_one_tile),
        cmocka_unit_test(directional_lights),
        cmocka_unit_test(parallel_cameras),
        cmocka_unit_test(small_pictures),
    };
    if (argc > 1 && atoi(argv[1]) > 0) search_effort = (size_t)atoi(argv[1]);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
