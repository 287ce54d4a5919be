/* SPDX-License-Identifier: MIT */
/*
 * Clipped bounds against clipping in rational numbers: no point of a triangle may be outside of them.
 */
#include <stdio.h>
#include <string.h>

#include <gmp.h>
#include <math.h>

#include "scene/clip.h"
#include "support.h"

/* ---- random cases -------------------------------------------------------------------------------------------- */

static uint64_t next_random(uint64_t *seed)
{
    uint64_t x = *seed += 0x9E3779B97F4A7C15u;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    return x ^ x >> 31;
}

enum kind { GRID, PLAIN, MIXED_SCALES, SLIVER, FAR_AWAY, KIND_COUNT };

static float random_coordinate(enum kind kind, uint64_t *seed)
{
    uint64_t bits = next_random(seed);
    double unit = (double)(bits >> 11) * 0x1p-53 - 0.5;
    switch (kind) {
    case GRID:
        return (float)(int)(bits % 7) - 3;
    case MIXED_SCALES:
        return (float)ldexp(unit, (int)(next_random(seed) % 277) - 148);
    case FAR_AWAY:
        return (float)(1e6 + unit);
    default:
        return (float)unit;
    }
}

static void random_triangle(enum kind kind, uint64_t *seed, struct mlrt_triangle *triangle)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) triangle->v[i][k] = random_coordinate(kind, seed);
    if (kind != SLIVER) return;
    for (int k = 0; k < 3; k++) {
        float middle = 0.5f * (triangle->v[0][k] + triangle->v[1][k]);
        triangle->v[2][k] = next_random(seed) % 2 ? middle : nextafterf(middle, 1);
    }
}

/* A box with faces between the vertices, on them, and in each other. */
static void random_box(const struct mlrt_triangle *triangle, uint64_t *seed, struct mlrt_box *box)
{
    for (int k = 0; k < 3; k++) {
        float face[2];
        for (int i = 0; i < 2; i++) {
            double t = (double)(next_random(seed) % 9) / 8;
            uint64_t a = next_random(seed) % 3, b = next_random(seed) % 3;
            face[i] = (float)(triangle->v[a][k] + t * ((double)triangle->v[b][k] - triangle->v[a][k])) + 0.0f;
        }
        box->lo[k] = face[0] < face[1] ? face[0] : face[1];
        box->hi[k] = face[0] < face[1] ? face[1] : face[0];
    }
}

/* ---- clipping without rounding ------------------------------------------------------------------------------- */

struct exact_polygon {
    int count;
    mpq_t vertex[12][3];
};

static void init_polygon(struct exact_polygon *polygon)
{
    polygon->count = 0;
    for (int i = 0; i < 12; i++)
        for (int k = 0; k < 3; k++) mpq_init(polygon->vertex[i][k]);
}

static void clear_polygon(struct exact_polygon *polygon)
{
    for (int i = 0; i < 12; i++)
        for (int k = 0; k < 3; k++) mpq_clear(polygon->vertex[i][k]);
}

/* What of `in` is above (sign = 1) or below (sign = -1) a plane. */
static void cut_exactly(const struct exact_polygon *in, int axis, int sign, float position, struct exact_polygon *out)
{
    mpq_t plane, p, q, t, difference;
    mpq_inits(plane, p, q, t, difference, NULL);
    mpq_set_d(plane, position);
    out->count = 0;
    for (int i = 0; i < in->count; i++) {
        int next = (i + 1) % in->count;
        mpq_sub(p, in->vertex[i][axis], plane);
        mpq_sub(q, in->vertex[next][axis], plane);
        int side = sign * mpq_sgn(p), next_side = sign * mpq_sgn(q);
        if (side >= 0) {
            for (int k = 0; k < 3; k++) mpq_set(out->vertex[out->count][k], in->vertex[i][k]);
            out->count++;
        }
        if (side * next_side < 0) {
            mpq_sub(difference, p, q);
            mpq_div(t, p, difference);
            for (int k = 0; k < 3; k++) {
                mpq_sub(difference, in->vertex[next][k], in->vertex[i][k]);
                mpq_mul(difference, difference, t);
                mpq_add(out->vertex[out->count][k], in->vertex[i][k], difference);
            }
            out->count++;
        }
    }
    mpq_clears(plane, p, q, t, difference, NULL);
}

static void clip_exactly(const struct mlrt_triangle *triangle, const struct mlrt_box *box,
                         struct exact_polygon polygon[2])
{
    polygon[0].count = 3;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) mpq_set_d(polygon[0].vertex[i][k], triangle->v[i][k]);
    for (int k = 0; k < 3; k++) {
        cut_exactly(&polygon[0], k, 1, box->lo[k], &polygon[1]);
        cut_exactly(&polygon[1], k, -1, box->hi[k], &polygon[0]);
    }
}

static int compare(const mpq_t a, double b)
{
    mpq_t rational;
    mpq_init(rational);
    mpq_set_d(rational, b);
    int result = mpq_cmp(a, rational);
    mpq_clear(rational);
    return result;
}

static int holds_all(const struct mlrt_box *box, const struct exact_polygon *polygon)
{
    for (int i = 0; i < polygon->count; i++)
        for (int k = 0; k < 3; k++)
            if (compare(polygon->vertex[i][k], box->lo[k]) < 0 || compare(polygon->vertex[i][k], box->hi[k]) > 0)
                return 0;
    return 1;
}

/* Whether a box that may reach farther by `slack` in each direction has a vertex at each of its faces. */
static int is_tight(const struct mlrt_box *box, const struct exact_polygon *polygon, double slack)
{
    for (int k = 0; k < 3; k++) {
        int near_lo = 0, near_hi = 0;
        for (int i = 0; i < polygon->count; i++) {
            near_lo = near_lo || compare(polygon->vertex[i][k], box->lo[k] + slack) <= 0;
            near_hi = near_hi || compare(polygon->vertex[i][k], box->hi[k] - slack) >= 0;
        }
        if (!near_lo || !near_hi) return 0;
    }
    return 1;
}

static int is_in(const struct mlrt_box *inner, const struct mlrt_box *outer)
{
    for (int k = 0; k < 3; k++)
        if (!(outer->lo[k] <= inner->lo[k] && inner->lo[k] <= inner->hi[k] && inner->hi[k] <= outer->hi[k])) return 0;
    return 1;
}

static void check_case(enum kind kind, uint64_t start)
{
    uint64_t seed = start;
    struct mlrt_triangle triangle;
    struct mlrt_box box;
    struct mlrt_halves halves;
    random_triangle(kind, &seed, &triangle);
    random_box(&triangle, &seed, &box);
    uint32_t axis = (uint32_t)(next_random(&seed) % 3);
    double t = (double)(next_random(&seed) % 9) / 8;
    float position = (float)(box.lo[axis] + t * ((double)box.hi[axis] - box.lo[axis])) + 0.0f;
    position = fminf(fmaxf(position, box.lo[axis]), box.hi[axis]);
    mlrt_clip_halves(&triangle, &box, axis, position, 0, &halves);
    for (int side = 0; side < 2; side++) {
        struct mlrt_box half = box;
        struct exact_polygon polygon[2];
        init_polygon(&polygon[0]);
        init_polygon(&polygon[1]);
        (side == 0 ? half.hi : half.lo)[axis] = position;
        clip_exactly(&triangle, &half, polygon);
        if (polygon[0].count > 0) {
            if (!halves.touched[side] || !holds_all(&halves.box[side], &polygon[0]))
                fail_msg("kind %d seed %llu side %d: points were lost", (int)kind, (unsigned long long)start, side);
            if (kind == PLAIN && !is_tight(&halves.box[side], &polygon[0], 0x1p-22))
                fail_msg("kind %d seed %llu side %d: bounds are loose", (int)kind, (unsigned long long)start, side);
        }
        if (halves.touched[side] && !is_in(&halves.box[side], &half))
            fail_msg("kind %d seed %llu side %d: bounds leave the box", (int)kind, (unsigned long long)start, side);
        clear_polygon(&polygon[0]);
        clear_polygon(&polygon[1]);
    }
}

static void check_kind(enum kind kind, size_t case_count)
{
    for (size_t i = 0; i < scaled(case_count); i++) check_case(kind, (uint64_t)i * 1000003);
}

static void test_no_point_is_lost_on_a_grid(void **state)
{
    (void)state;
    check_kind(GRID, 4000);
}

static void test_no_point_is_lost_and_bounds_are_tight(void **state)
{
    (void)state;
    check_kind(PLAIN, 4000);
}

static void test_no_point_is_lost_at_mixed_scales(void **state)
{
    (void)state;
    check_kind(MIXED_SCALES, 2000);
}

static void test_no_point_is_lost_of_slivers(void **state)
{
    (void)state;
    check_kind(SLIVER, 4000);
}

static void test_no_point_is_lost_far_away(void **state)
{
    (void)state;
    check_kind(FAR_AWAY, 3000);
}

/* ---- single facts -------------------------------------------------------------------------------------------- */

static const struct mlrt_box UNIT_BOX = {{0, 0, 0}, {1, 1, 1}};

static void test_vertices_inside_are_exact(void **state)
{
    (void)state;
    const struct mlrt_triangle triangle = {{{0.1f, 0.2f, 0.3f}, {0.9f, 0.2f, 0.3f}, {0.1f, 0.7f, 0.8f}}};
    const struct mlrt_box box = {{0.1f, 0.2f, 0.3f}, {0.9f, 0.7f, 0.8f}};
    struct mlrt_halves halves;
    mlrt_clip_halves(&triangle, &box, 0, 0.5f, 0, &halves);
    assert_true(halves.touched[0] && halves.touched[1]);
    assert_true(halves.box[0].lo[0] == 0.1f && halves.box[0].hi[0] == 0.5f);
    assert_true(halves.box[0].lo[1] == 0.2f && halves.box[0].hi[1] == 0.7f);
    assert_true(halves.box[1].lo[0] == 0.5f && halves.box[1].hi[0] == 0.9f);
    assert_true(halves.box[1].hi[1] < 0.46f);
}

static void test_a_corner_that_is_passed_by_is_not_touched(void **state)
{
    (void)state;
    const struct mlrt_triangle triangle = {{{1.5f, 0, 0}, {0, 1.5f, 0}, {1.5f, 1.5f, 0}}};
    struct mlrt_halves halves;
    const struct mlrt_box box = {{0, 0, 0}, {1, 0.4f, 0}};
    mlrt_clip_halves(&triangle, &box, 0, 0.5f, 0, &halves);
    assert_false(halves.touched[0]);
    assert_false(halves.touched[1]);
}

static void test_a_flat_triangle_stays_flat(void **state)
{
    (void)state;
    const struct mlrt_triangle triangle = {{{-5, 0.3f, -5}, {7, 0.3f, -5}, {0, 0.3f, 7}}};
    struct mlrt_halves halves;
    const struct mlrt_box box = {{0, 0.3f, 0}, {1, 0.3f, 1}};
    mlrt_clip_halves(&triangle, &box, 2, 0.25f, 0, &halves);
    assert_true(halves.box[1].lo[1] == 0.3f && halves.box[1].hi[1] == 0.3f);
}

static void test_tiny_bounds_move_outward(void **state)
{
    (void)state;
    const float tiny = 0x1p-60f;
    const struct mlrt_triangle triangle = {{{-1, -1e-25f, 0}, {1, 1e-25f, 0}, {0, 1e-20f, 1}}};
    const struct mlrt_box box = {{-1, -tiny, 0}, {1, tiny, 1}};
    struct mlrt_halves halves;
    mlrt_clip_halves(&triangle, &box, 0, 0.5f, tiny, &halves);
    assert_true(halves.box[0].lo[1] == -tiny);
    assert_true(halves.box[1].lo[1] == 0);
}

static void test_the_largest_floats_do_not_overflow(void **state)
{
    (void)state;
    const float most = 3.4e38f;
    const struct mlrt_triangle triangle = {{{-most, -most, -most}, {most, most, -most}, {0, most, most}}};
    const struct mlrt_box box = {{-most, -most, -most}, {most, most, most}};
    struct mlrt_halves halves;
    mlrt_clip_halves(&triangle, &box, 1, 1, 0, &halves);
    assert_true(halves.touched[0] && is_in(&halves.box[0], &box));
    assert_true(halves.touched[1] && is_in(&halves.box[1], &box));
}

static void test_area_is_that_inside_the_box(void **state)
{
    (void)state;
    const struct mlrt_triangle triangle = {{{0, 0, 0.5f}, {2, 0, 0.5f}, {0, 2, 0.5f}}};
    assert_true(fabs(mlrt_clipped_area(&triangle, &UNIT_BOX, 2) - 1) < 1e-12);
    const struct mlrt_box half = {{0, 0, 0}, {1, 0.5f, 1}};
    assert_true(fabs(mlrt_clipped_area(&triangle, &half, 2) - 0.5) < 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_point_is_lost_on_a_grid),
        cmocka_unit_test(test_no_point_is_lost_and_bounds_are_tight),
        cmocka_unit_test(test_no_point_is_lost_at_mixed_scales),
        cmocka_unit_test(test_no_point_is_lost_of_slivers),
        cmocka_unit_test(test_no_point_is_lost_far_away),
        cmocka_unit_test(test_vertices_inside_are_exact),
        cmocka_unit_test(test_a_corner_that_is_passed_by_is_not_touched),
        cmocka_unit_test(test_a_flat_triangle_stays_flat),
        cmocka_unit_test(test_tiny_bounds_move_outward),
        cmocka_unit_test(test_the_largest_floats_do_not_overflow),
        cmocka_unit_test(test_area_is_that_inside_the_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
