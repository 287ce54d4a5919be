/* SPDX-License-Identifier: MIT */
/*
 * Exact closest hits, three ways. Every finite float is an integer multiple of 2^-149, so all coordinates are scaled by
 * 2^149 into integers, and the expressions of the hit rule are integers too: D, N and e_ij in units of 2^-447.
 */
#include "reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCALE_BITS 149

struct exact_vector {
    mpz_t k[3];
};

/* The numbers of the hit rule for one ray and one triangle. */
struct exact_pair {
    mpz_t edge[3]; /* e_ab, e_bc, e_ca */
    mpz_t d;       /* D = d . n */
    mpz_t n;       /* N = (a - o) . n */
};

struct box_node {
    float lo[3];
    float hi[3];
    uint32_t first; /* leaf: first of `count` entries in order[]; inner: the left child, its neighbour the right one */
    uint32_t count; /* 0 = inner */
};

struct reference_scene {
    struct reference_triangle *triangles;
    size_t count;
    unsigned char *usable; /* finite and with an area */
    size_t non_finite_count;
    size_t zero_area_count;
    uint32_t *order;
    struct box_node *nodes;
    size_t node_count;
    struct exact_vector origin, direction, corner[3], p, q, normal;
    struct exact_pair candidate, best;
    mpz_t left, right;
    const struct reference_ray *ray; /* of the search under way */
    int ray_is_loaded;               /* into origin and direction */
    struct found *found;             /* all hits of a ray, in order */
    size_t found_count;
    size_t found_capacity;
    size_t candidate_position; /* whose numbers `candidate` and `best` hold, for this ray; or NOTHING */
    size_t best_position;
};

/* The best hit so far. t_lo and t_hi enclose its exact t. */
struct closest {
    size_t position;
    double t_lo;
    double t_hi;
};

#define NOTHING ((size_t)-1)

/* One of all hits of a ray. */
struct found {
    size_t position;
    int crossing;
    double t_lo; /* as in struct closest */
    double t_hi;
};

static void *allocate(size_t count, size_t size)
{
    void *block = calloc(count ? count : 1, size);
    if (!block) {
        fprintf(stderr, "reference: no memory\n");
        exit(2);
    }
    return block;
}

/* ---- integers ---------------------------------------------------------------------------------------------------- */

static void init_vector(struct exact_vector *vector)
{
    for (int k = 0; k < 3; k++) mpz_init(vector->k[k]);
}

static void clear_vector(struct exact_vector *vector)
{
    for (int k = 0; k < 3; k++) mpz_clear(vector->k[k]);
}

static void init_pair(struct exact_pair *pair)
{
    for (int k = 0; k < 3; k++) mpz_init(pair->edge[k]);
    mpz_init(pair->d);
    mpz_init(pair->n);
}

static void clear_pair(struct exact_pair *pair)
{
    for (int k = 0; k < 3; k++) mpz_clear(pair->edge[k]);
    mpz_clear(pair->d);
    mpz_clear(pair->n);
}

static void init_scratch(struct reference_scene *scene)
{
    init_vector(&scene->origin);
    init_vector(&scene->direction);
    for (int i = 0; i < 3; i++) init_vector(&scene->corner[i]);
    init_vector(&scene->p);
    init_vector(&scene->q);
    init_vector(&scene->normal);
    init_pair(&scene->candidate);
    init_pair(&scene->best);
    mpz_init(scene->left);
    mpz_init(scene->right);
}

static void clear_scratch(struct reference_scene *scene)
{
    clear_vector(&scene->origin);
    clear_vector(&scene->direction);
    for (int i = 0; i < 3; i++) clear_vector(&scene->corner[i]);
    clear_vector(&scene->p);
    clear_vector(&scene->q);
    clear_vector(&scene->normal);
    clear_pair(&scene->candidate);
    clear_pair(&scene->best);
    mpz_clear(scene->left);
    mpz_clear(scene->right);
}

/* ldexp is exact here: a finite float times 2^149 is an integer below 2^277, which a double holds. */
static void set_fixed(mpz_t out, float value)
{
    mpz_set_d(out, ldexp((double)value, SCALE_BITS));
}

static void set_vector(struct exact_vector *out, const float in[3])
{
    for (int k = 0; k < 3; k++) set_fixed(out->k[k], in[k]);
}

static void subtract(struct exact_vector *out, const struct exact_vector *a, const struct exact_vector *b)
{
    for (int k = 0; k < 3; k++) mpz_sub(out->k[k], a->k[k], b->k[k]);
}

static void add_vectors(struct exact_vector *out, const struct exact_vector *a, const struct exact_vector *b)
{
    for (int k = 0; k < 3; k++) mpz_add(out->k[k], a->k[k], b->k[k]);
}

/* out must be neither a nor b. */
static void cross(struct exact_vector *out, const struct exact_vector *a, const struct exact_vector *b)
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        mpz_mul(out->k[k], a->k[i], b->k[j]);
        mpz_submul(out->k[k], a->k[j], b->k[i]);
    }
}

static void dot(mpz_t out, const struct exact_vector *a, const struct exact_vector *b)
{
    mpz_mul(out, a->k[0], b->k[0]);
    mpz_addmul(out, a->k[1], b->k[1]);
    mpz_addmul(out, a->k[2], b->k[2]);
}

static void load_ray(struct reference_scene *scene, const struct reference_ray *ray)
{
    set_vector(&scene->origin, ray->origin);
    set_vector(&scene->direction, ray->direction);
}

/* scene->normal = (b - a) x (c - a); the corners are loaded as they are. */
static void load_triangle(struct reference_scene *scene, const struct reference_triangle *triangle)
{
    for (int i = 0; i < 3; i++) set_vector(&scene->corner[i], triangle->corner[i]);
    subtract(&scene->p, &scene->corner[1], &scene->corner[0]);
    subtract(&scene->q, &scene->corner[2], &scene->corner[0]);
    cross(&scene->normal, &scene->p, &scene->q);
}

/* The rule's numbers, for the ray last loaded. */
static void evaluate(struct reference_scene *scene, const struct reference_triangle *triangle, struct exact_pair *pair)
{
    load_triangle(scene, triangle);
    dot(pair->d, &scene->direction, &scene->normal);
    for (int i = 0; i < 3; i++) subtract(&scene->corner[i], &scene->corner[i], &scene->origin);
    dot(pair->n, &scene->corner[0], &scene->normal);
    for (int i = 0; i < 3; i++) {
        cross(&scene->p, &scene->corner[i], &scene->corner[(i + 1) % 3]);
        dot(pair->edge[i], &scene->direction, &scene->p);
    }
}

/* The sign of sgn(D) N - t |D|, for a finite t. */
static int compare_with_bound(struct reference_scene *scene, const struct exact_pair *pair, float t)
{
    set_fixed(scene->left, t);
    mpz_mul(scene->left, scene->left, pair->d);
    mpz_mul_2exp(scene->right, pair->n, SCALE_BITS);
    return mpz_cmp(scene->right, scene->left) * mpz_sgn(pair->d);
}

/* R2 */
static int pair_is_hit(struct reference_scene *scene, const struct exact_pair *pair, float t_min, float t_max)
{
    int facing = mpz_sgn(pair->d);
    if (facing == 0) return 0;
    for (int i = 0; i < 3; i++) {
        if (facing * mpz_sgn(pair->edge[i]) < 0) return 0;
    }
    return compare_with_bound(scene, pair, t_min) > 0 && (isinf(t_max) || compare_with_bound(scene, pair, t_max) <= 0);
}

/* R3: the sign of N1 / D1 - N2 / D2. */
static int compare_pairs(struct reference_scene *scene, const struct exact_pair *first, const struct exact_pair *second)
{
    mpz_mul(scene->left, first->n, second->d);
    mpz_mul(scene->right, second->n, first->d);
    return mpz_cmp(scene->left, scene->right) * mpz_sgn(first->d) * mpz_sgn(second->d);
}

/* The exponent e with 2^e <= numerator / denominator < 2^(e + 1), both positive. */
static long quotient_exponent(const mpz_t numerator, const mpz_t denominator)
{
    long exponent = (long)mpz_sizeinbase(numerator, 2) - (long)mpz_sizeinbase(denominator, 2);
    mpz_t scaled;
    mpz_init(scaled);
    int below;
    if (exponent >= 0) {
        mpz_mul_2exp(scaled, denominator, (mp_bitcnt_t)exponent);
        below = mpz_cmp(numerator, scaled) < 0;
    } else {
        mpz_mul_2exp(scaled, numerator, (mp_bitcnt_t)-exponent);
        below = mpz_cmp(scaled, denominator) < 0;
    }
    mpz_clear(scaled);
    return exponent - below;
}

static float positive_quotient(const mpz_t numerator, const mpz_t denominator)
{
    long last = quotient_exponent(numerator, denominator) - 23;
    if (last < -149) last = -149;
    if (last > 128) return INFINITY;
    mpz_t whole, rest, scaled;
    mpz_inits(whole, rest, scaled, NULL);
    mpz_mul_2exp(whole, numerator, (mp_bitcnt_t)(last < 0 ? -last : 0));
    mpz_mul_2exp(scaled, denominator, (mp_bitcnt_t)(last > 0 ? last : 0));
    mpz_fdiv_qr(whole, rest, whole, scaled);
    mpz_mul_2exp(rest, rest, 1);
    int order = mpz_cmp(rest, scaled);
    unsigned long digits = mpz_get_ui(whole);
    digits += order > 0 || (order == 0 && (digits & 1));
    mpz_clears(whole, rest, scaled, NULL);
    return (float)ldexp((double)digits, (int)last);
}

float reference_quotient(const mpz_t numerator, const mpz_t denominator)
{
    int sign = mpz_sgn(numerator) * mpz_sgn(denominator);
    if (sign == 0) return 0;
    mpz_t a, b;
    mpz_init(a);
    mpz_init(b);
    mpz_abs(a, numerator);
    mpz_abs(b, denominator);
    float quotient = positive_quotient(a, b);
    mpz_clear(a);
    mpz_clear(b);
    return sign < 0 ? -quotient : quotient;
}

/* R5 */
static void report(const struct reference_triangle *triangle, const struct exact_pair *pair, struct reference_hit *hit)
{
    hit->t = reference_quotient(pair->n, pair->d);
    hit->u = reference_quotient(pair->edge[2], pair->d);
    hit->v = reference_quotient(pair->edge[0], pair->d);
    hit->mesh = triangle->mesh;
    hit->triangle = triangle->triangle;
    hit->facing = mpz_sgn(pair->d);
}

static void report_miss(struct reference_hit *hit)
{
    hit->t = INFINITY;
    hit->u = 0;
    hit->v = 0;
    hit->mesh = REFERENCE_NONE;
    hit->triangle = REFERENCE_NONE;
    hit->facing = 0;
}

/* ---- rays and triangles that never hit --------------------------------------------------------------------------- */

static int vector_is_finite(const float v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* R1 for rays. Sets the interval that remains. */
static int ray_is_valid(const struct reference_ray *ray, float *t_min, float *t_max)
{
    if (!vector_is_finite(ray->origin) || !vector_is_finite(ray->direction)) return 0;
    if (ray->direction[0] == 0 && ray->direction[1] == 0 && ray->direction[2] == 0) return 0;
    if (isnan(ray->t_min) || isnan(ray->t_max)) return 0;
    *t_min = ray->t_min > 0 ? ray->t_min : 0;
    *t_max = ray->t_max;
    return *t_min < *t_max;
}

static int is_skipped(const struct reference_ray *ray, const struct reference_triangle *triangle)
{
    return ray->skip[0] != REFERENCE_NONE && triangle->mesh == ray->skip[0] && triangle->triangle == ray->skip[1];
}

static void classify_triangles(struct reference_scene *scene)
{
    for (size_t i = 0; i < scene->count; i++) {
        const struct reference_triangle *triangle = &scene->triangles[i];
        if (!vector_is_finite(triangle->corner[0]) || !vector_is_finite(triangle->corner[1]) ||
            !vector_is_finite(triangle->corner[2])) {
            scene->non_finite_count++;
            continue;
        }
        load_triangle(scene, triangle);
        int has_area = mpz_sgn(scene->normal.k[0]) || mpz_sgn(scene->normal.k[1]) || mpz_sgn(scene->normal.k[2]);
        scene->usable[i] = (unsigned char)has_area;
        scene->zero_area_count += !has_area;
    }
}

/* ---- doubles with a bound ---------------------------------------------------------------------------------------- */

/*
 * p . (q x r) in double, and a bound on its error.
 *
 * The components of p, q, r are floats or differences of two floats rounded to double, so each has a relative error of
 * at most w = 2^-53. The result is a sum of six terms p_i q_j r_k. On its way to the result each passes 8 roundings at
 * most: three of its factors, two multiplications, the subtraction in the cross product and two additions. So the error
 * is at most ((1 + w)^8 - 1) M with M = sum |p_i q_j r_k|, and M <= m (1 - w)^-8 where m is M as computed. That is
 * below 8.001 w m; `bound` is 16 w m, which leaves room for the roundings of the bound itself.
 *
 * Nothing underflows: factors other than 0 are at least 2^-149, products of two at least 2^-298, their computed
 * difference a multiple of 2^-298-53 or zero, so the last product is at least 2^-500. Nothing overflows: 6 * (2^129)^3
 * < 2^390.
 */
#define ROUNDING 1.1102230246251565e-16

struct estimate {
    double value;
    double bound;
};

static struct estimate estimate_triple(const double p[3], const double q[3], const double r[3])
{
    double x1 = q[1] * r[2], x2 = q[2] * r[1];
    double y1 = q[2] * r[0], y2 = q[0] * r[2];
    double z1 = q[0] * r[1], z2 = q[1] * r[0];
    double magnitude =
        fabs(p[0]) * (fabs(x1) + fabs(x2)) + fabs(p[1]) * (fabs(y1) + fabs(y2)) + fabs(p[2]) * (fabs(z1) + fabs(z2));
    struct estimate e = {p[0] * (x1 - x2) + p[1] * (y1 - y2) + p[2] * (z1 - z2), 16 * ROUNDING * magnitude};
    return e;
}

/* -1, 0 or +1; 0 = not certain. */
static int certain_sign(struct estimate e)
{
    return (e.value > e.bound) - (e.value < -e.bound);
}

/*
 * The certain sign of sgn(D) N - t |D|, `facing` being sgn(D). t D has the error t bound(D) + w |t D|, the subtraction
 * adds w (|N| + |t D|); 4 w covers both, their second order and the roundings of the sum.
 */
static int certain_range_sign(struct estimate n, struct estimate d, double t, int facing)
{
    double product = t * d.value;
    struct estimate e = {facing * (n.value - product),
                         n.bound + t * d.bound + 4 * ROUNDING * (fabs(n.value) + fabs(product))};
    return certain_sign(e);
}

enum verdict { MISS, HIT, DOUBTFUL };

struct double_ray {
    double origin[3];
    double direction[3];
    double inverse[3]; /* 1 / direction */
    double t_min;
    double t_max;
};

/* Differences of floats, rounded to double. */
struct double_triangle {
    double from_origin[3][3]; /* corner - o */
    double ab[3];             /* b - a */
    double ac[3];
};

static void widen_triangle(const struct double_ray *ray, const struct reference_triangle *triangle,
                           struct double_triangle *out)
{
    for (int k = 0; k < 3; k++) {
        double a = (double)triangle->corner[0][k], b = (double)triangle->corner[1][k],
               c = (double)triangle->corner[2][k];
        out->from_origin[0][k] = a - ray->origin[k];
        out->from_origin[1][k] = b - ray->origin[k];
        out->from_origin[2][k] = c - ray->origin[k];
        out->ab[k] = b - a;
        out->ac[k] = c - a;
    }
}

/* Encloses |N / D|, or any quotient of such estimates; what lies below zero is cut off, as only hits ask. The factors
 * cover four roundings each. */
static void enclose_distance(struct estimate n, struct estimate d, double *t_lo, double *t_hi)
{
    double n_size = fabs(n.value), d_size = fabs(d.value);
    double n_lo = n_size - n.bound, d_lo = d_size - d.bound;
    *t_lo = n_lo > 0 ? n_lo / (d_size + d.bound) * (1 - 8 * ROUNDING) : 0;
    *t_hi = d_lo > 0 ? (n_size + n.bound) / d_lo * (1 + 8 * ROUNDING) : INFINITY;
}

/* R2 as far as doubles can tell. If it is a hit after all, *t_lo <= t <= *t_hi. */
static enum verdict filter(const struct double_ray *ray, const struct reference_triangle *triangle, double *t_lo,
                           double *t_hi)
{
    struct double_triangle numbers;
    widen_triangle(ray, triangle, &numbers);
    const double(*v)[3] = (const double(*)[3])numbers.from_origin;
    int ab = certain_sign(estimate_triple(ray->direction, v[0], v[1]));
    int bc = certain_sign(estimate_triple(ray->direction, v[1], v[2]));
    if (ab * bc < 0) return MISS;
    int ca = certain_sign(estimate_triple(ray->direction, v[2], v[0]));
    if (ab * ca < 0 || bc * ca < 0) return MISS;

    struct estimate d = estimate_triple(ray->direction, numbers.ab, numbers.ac);
    struct estimate n = estimate_triple(v[0], numbers.ab, numbers.ac);
    int inside = ab && bc && ca;
    int facing = inside ? ab : certain_sign(d); // D is the sum of the three
    enclose_distance(n, d, t_lo, t_hi);
    if (facing == 0) return DOUBTFUL;
    int after = certain_range_sign(n, d, ray->t_min, facing);
    int before = isinf(ray->t_max) ? 1 : -certain_range_sign(n, d, ray->t_max, facing);
    if (after < 0 || before < 0) return MISS;
    return inside && after && before ? HIT : DOUBTFUL;
}

/* A quotient that is known not to be negative, if both ends of its enclosure round to the same float. */
static int round_enclosed(struct estimate numerator, struct estimate denominator, float *quotient)
{
    double lo, hi;
    enclose_distance(numerator, denominator, &lo, &hi);
    *quotient = (float)lo;
    return *quotient == (float)hi;
}

/* ---- one triangle after the other -------------------------------------------------------------------------------- */

/* The integers are worked out when they are first needed: most rays can do without. */
static void begin_search(struct reference_scene *scene, const struct reference_ray *ray)
{
    scene->ray = ray;
    scene->ray_is_loaded = 0;
    scene->candidate_position = NOTHING;
    scene->best_position = NOTHING;
}

static void evaluate_at(struct reference_scene *scene, size_t position, struct exact_pair *pair, size_t *pair_position)
{
    if (*pair_position == position) return;
    if (!scene->ray_is_loaded) load_ray(scene, scene->ray);
    scene->ray_is_loaded = 1;
    evaluate(scene, &scene->triangles[position], pair);
    *pair_position = position;
}

static void evaluate_candidate(struct reference_scene *scene, size_t position)
{
    evaluate_at(scene, position, &scene->candidate, &scene->candidate_position);
}

static void evaluate_best(struct reference_scene *scene, size_t position)
{
    evaluate_at(scene, position, &scene->best, &scene->best_position);
}

/* The candidate's numbers become those of the best. */
static void keep_candidate(struct reference_scene *scene)
{
    struct exact_pair old = scene->best;
    scene->best = scene->candidate;
    scene->candidate = old;
    scene->best_position = scene->candidate_position;
    scene->candidate_position = NOTHING;
}

static int exact_is_hit(struct reference_scene *scene, size_t position, float t_min, float t_max)
{
    evaluate_candidate(scene, position);
    return pair_is_hit(scene, &scene->candidate, t_min, t_max);
}

/* R3 without any short cut. */
static int plain_is_first(struct reference_scene *scene, size_t position, size_t rival)
{
    evaluate_candidate(scene, position);
    evaluate_best(scene, rival);
    int order = compare_pairs(scene, &scene->candidate, &scene->best);
    return order < 0 || (order == 0 && position < rival);
}

static int exact_is_first(struct reference_scene *scene, size_t position, size_t rival)
{
    const struct reference_triangle *one = &scene->triangles[position], *other = &scene->triangles[rival];
    if (memcmp(one->corner, other->corner, sizeof one->corner) == 0) return position < rival; // the same t
    return plain_is_first(scene, position, rival);
}

static void try_triangle(struct reference_scene *scene, const struct reference_ray *ray, const struct double_ray *wide,
                         size_t position, struct closest *closest)
{
    const struct reference_triangle *triangle = &scene->triangles[position];
    double t_lo, t_hi;
    if (!scene->usable[position] || is_skipped(ray, triangle)) return;
    enum verdict verdict = filter(wide, triangle, &t_lo, &t_hi);
    if (verdict == MISS || t_lo > closest->t_hi) return;
    if (verdict == DOUBTFUL && !exact_is_hit(scene, position, (float)wide->t_min, (float)wide->t_max)) return;
    if (closest->position != NOTHING && !(t_hi < closest->t_lo) && !exact_is_first(scene, position, closest->position))
        return;
    closest->position = position;
    closest->t_lo = t_lo;
    closest->t_hi = t_hi;
    if (scene->candidate_position == position) keep_candidate(scene);
}

/* 0 = the ray hits nothing. */
static int start(struct reference_scene *scene, const struct reference_ray *ray, struct double_ray *wide,
                 struct closest *closest)
{
    float t_min, t_max;
    if (!ray_is_valid(ray, &t_min, &t_max)) return 0;
    for (int k = 0; k < 3; k++) {
        wide->origin[k] = (double)ray->origin[k];
        wide->direction[k] = (double)ray->direction[k];
        wide->inverse[k] = ray->direction[k] == 0 ? 0 : 1 / (double)ray->direction[k];
    }
    wide->t_min = (double)t_min;
    wide->t_max = (double)t_max;
    closest->position = NOTHING;
    closest->t_lo = INFINITY;
    closest->t_hi = INFINITY;
    begin_search(scene, ray);
    return 1;
}

/* R5 of a hit: in double where that settles the rounding, else in integers. */
static void report_at(struct reference_scene *scene, const struct double_ray *wide, size_t position,
                      struct reference_hit *hit)
{
    const struct reference_triangle *triangle = &scene->triangles[position];
    struct double_triangle numbers;
    widen_triangle(wide, triangle, &numbers);
    struct estimate d = estimate_triple(wide->direction, numbers.ab, numbers.ac);
    struct estimate n = estimate_triple(numbers.from_origin[0], numbers.ab, numbers.ac);
    struct estimate ab = estimate_triple(wide->direction, numbers.from_origin[0], numbers.from_origin[1]);
    struct estimate ca = estimate_triple(wide->direction, numbers.from_origin[2], numbers.from_origin[0]);
    hit->mesh = triangle->mesh;
    hit->triangle = triangle->triangle;
    hit->facing = certain_sign(d);
    if (hit->facing && round_enclosed(n, d, &hit->t) && round_enclosed(ca, d, &hit->u) &&
        round_enclosed(ab, d, &hit->v)) {
        return;
    }
    evaluate_best(scene, position);
    report(triangle, &scene->best, hit);
}

static void finish(struct reference_scene *scene, const struct double_ray *wide, const struct closest *closest,
                   struct reference_hit *hit)
{
    if (closest->position != NOTHING) report_at(scene, wide, closest->position, hit);
}

void reference_trace_plain(struct reference_scene *scene, const struct reference_ray *ray, struct reference_hit *hit)
{
    float t_min, t_max;
    report_miss(hit);
    if (!ray_is_valid(ray, &t_min, &t_max)) return;
    begin_search(scene, ray);
    size_t best = NOTHING;
    for (size_t i = 0; i < scene->count; i++) {
        if (!scene->usable[i] || is_skipped(ray, &scene->triangles[i])) continue;
        if (!exact_is_hit(scene, i, t_min, t_max)) continue;
        if (best != NOTHING && compare_pairs(scene, &scene->candidate, &scene->best) >= 0) continue;
        best = i;
        keep_candidate(scene);
    }
    if (best != NOTHING) report(&scene->triangles[best], &scene->best, hit);
}

void reference_trace_filtered(struct reference_scene *scene, const struct reference_ray *ray, struct reference_hit *hit)
{
    struct double_ray wide;
    struct closest closest;
    report_miss(hit);
    if (!start(scene, ray, &wide, &closest)) return;
    for (size_t i = 0; i < scene->count; i++) try_triangle(scene, ray, &wide, i, &closest);
    finish(scene, &wide, &closest, hit);
}

/* ---- a tree of boxes --------------------------------------------------------------------------------------------- */

#define BOX_LEAF_SIZE 4

static double centre(const struct reference_triangle *triangle, int axis)
{
    return (double)triangle->corner[0][axis] + (double)triangle->corner[1][axis] + (double)triangle->corner[2][axis];
}

/* Rearranges order[0 .. count) so that entry `middle` is where sorting would put it (Hoare's selection). */
static void select_middle(const struct reference_triangle *triangles, uint32_t *order, size_t count, size_t middle,
                          int axis)
{
    size_t lo = 0, hi = count - 1;
    while (lo < hi) {
        double pivot = centre(&triangles[order[lo + (hi - lo) / 2]], axis);
        size_t i = lo, j = hi;
        while (i <= j) {
            while (centre(&triangles[order[i]], axis) < pivot) i++;
            while (centre(&triangles[order[j]], axis) > pivot) j--;
            if (i <= j) {
                uint32_t swapped = order[i];
                order[i++] = order[j];
                order[j] = swapped;
                if (j-- == 0) break;
            }
        }
        if (j != (size_t)-1 && middle <= j)
            hi = j;
        else if (middle >= i)
            lo = i;
        else
            return;
    }
}

/* The box of the triangles: minima and maxima of floats, exact. */
static void bound_triangles(const struct reference_scene *scene, size_t first, size_t count, struct box_node *node)
{
    for (int k = 0; k < 3; k++) {
        node->lo[k] = INFINITY;
        node->hi[k] = -INFINITY;
    }
    for (size_t i = first; i < first + count; i++) {
        const struct reference_triangle *triangle = &scene->triangles[scene->order[i]];
        for (int c = 0; c < 9; c++) {
            float x = triangle->corner[c / 3][c % 3];
            if (x < node->lo[c % 3]) node->lo[c % 3] = x;
            if (x > node->hi[c % 3]) node->hi[c % 3] = x;
        }
    }
}

static int widest_axis(const struct box_node *node)
{
    int widest = 0;
    for (int k = 1; k < 3; k++) {
        if ((double)node->hi[k] - node->lo[k] > (double)node->hi[widest] - node->lo[widest]) widest = k;
    }
    return widest;
}

/* Halves by number, so the depth is at most log2(count) + 1. */
static void build_box(struct reference_scene *scene, size_t index, size_t first, size_t count)
{
    struct box_node *node = &scene->nodes[index];
    bound_triangles(scene, first, count, node);
    if (count <= BOX_LEAF_SIZE) {
        node->first = (uint32_t)first;
        node->count = (uint32_t)count;
        return;
    }
    size_t half = count / 2;
    select_middle(scene->triangles, scene->order + first, count, half, widest_axis(node));
    node->first = (uint32_t)scene->node_count;
    node->count = 0;
    scene->node_count += 2;
    size_t left = node->first;
    build_box(scene, left, first, half);
    build_box(scene, left + 1, first + half, count - half);
}

static void build_boxes(struct reference_scene *scene)
{
    size_t used = 0;
    scene->order = allocate(scene->count, sizeof *scene->order);
    for (size_t i = 0; i < scene->count; i++) {
        if (scene->usable[i]) scene->order[used++] = (uint32_t)i;
    }
    if (used == 0) return;
    scene->nodes = allocate(2 * used, sizeof *scene->nodes);
    scene->node_count = 1;
    build_box(scene, 0, 0, used);
}

/*
 * Where the ray may be in the box: *entry is a lower bound of the t of all points in it. 0 = nowhere.
 *
 * A point of the ray inside the box has, on an axis with d = 0, o within the slab, and on another a t between (lo - o)
 * / d and (hi - o) / d. Those have three roundings each (difference, reciprocal, product) and can neither overflow nor
 * underflow (2^-277 .. 2^278): widening them by 8 w of their size covers them.
 */
static int enter_box(const struct box_node *node, const struct double_ray *ray, double *entry)
{
    double t_lo = ray->t_min, t_hi = ray->t_max;
    for (int k = 0; k < 3; k++) {
        double from = (double)node->lo[k] - ray->origin[k], to = (double)node->hi[k] - ray->origin[k];
        if (ray->direction[k] == 0) {
            if (from > 0 || to < 0) return 0;
            continue;
        }
        double near = (ray->direction[k] > 0 ? from : to) * ray->inverse[k];
        double far = (ray->direction[k] > 0 ? to : from) * ray->inverse[k];
        near -= 8 * ROUNDING * fabs(near);
        far += 8 * ROUNDING * fabs(far);
        if (near > t_lo) t_lo = near;
        if (far < t_hi) t_hi = far;
    }
    *entry = t_lo;
    return t_lo <= t_hi;
}

struct visit {
    uint32_t node;
    double entry;
};

void reference_trace(struct reference_scene *scene, const struct reference_ray *ray, struct reference_hit *hit)
{
    struct double_ray wide;
    struct closest closest;
    struct visit stack[72];
    int height = 0;
    report_miss(hit);
    if (!start(scene, ray, &wide, &closest) || scene->node_count == 0) return;
    stack[height++] = (struct visit){0, 0};
    while (height > 0) {
        struct visit visit = stack[--height];
        const struct box_node *node = &scene->nodes[visit.node];
        if (visit.entry > closest.t_hi) continue;
        for (uint32_t i = 0; i < node->count; i++)
            try_triangle(scene, ray, &wide, scene->order[node->first + i], &closest);
        if (node->count > 0) continue;
        struct visit child[2] = {{node->first, 0}, {node->first + 1, 0}};
        int in0 = enter_box(&scene->nodes[child[0].node], &wide, &child[0].entry);
        int in1 = enter_box(&scene->nodes[child[1].node], &wide, &child[1].entry);
        int second = in0 && in1 && child[0].entry <= child[1].entry;
        if (second) stack[height++] = child[1];
        if (in0) stack[height++] = child[0];
        if (in1 && !second) stack[height++] = child[1];
    }
    finish(scene, &wide, &closest, hit);
}

/* ---- all hits ---------------------------------------------------------------------------------------------------- */

/*
 * The sign of e_ij once o has moved by (eps, eps^2, eps^3): of e_ij itself, or, if that is 0, of the first component of
 * -((v_j - v_i) x d) that is not 0. For the ray last loaded, whose `candidate` is this triangle.
 */
static int moved_edge_sign(struct reference_scene *scene, const struct reference_triangle *triangle, int edge)
{
    int sign = mpz_sgn(scene->candidate.edge[edge]);
    if (sign) return sign;
    set_vector(&scene->corner[0], triangle->corner[edge]);
    set_vector(&scene->corner[1], triangle->corner[(edge + 1) % 3]);
    subtract(&scene->p, &scene->corner[1], &scene->corner[0]);
    cross(&scene->q, &scene->p, &scene->direction);
    for (int k = 0; k < 3 && !sign; k++) sign = -mpz_sgn(scene->q.k[k]);
    return sign;
}

/* R6, of a triangle that is hit. */
static int exact_is_crossing(struct reference_scene *scene, size_t position)
{
    evaluate_candidate(scene, position);
    for (int edge = 0; edge < 3; edge++) {
        if (moved_edge_sign(scene, &scene->triangles[position], edge) != mpz_sgn(scene->candidate.d)) return 0;
    }
    return 1;
}

static int found_is_first(struct reference_scene *scene, const struct found *one, const struct found *other, int plain)
{
    if (plain) return plain_is_first(scene, one->position, other->position);
    if (one->t_hi < other->t_lo) return 1;
    if (other->t_hi < one->t_lo) return 0;
    return exact_is_first(scene, one->position, other->position);
}

/* Into its place among the others. */
static void insert_found(struct reference_scene *scene, struct found found, int plain)
{
    if (scene->found_count == scene->found_capacity) {
        struct found *larger = allocate(2 * scene->found_capacity + 16, sizeof *larger);
        if (scene->found_count) memcpy(larger, scene->found, scene->found_count * sizeof *larger);
        free(scene->found);
        scene->found = larger;
        scene->found_capacity = 2 * scene->found_capacity + 16;
    }
    size_t lo = 0, hi = scene->found_count;
    while (lo < hi) {
        size_t middle = lo + (hi - lo) / 2;
        if (found_is_first(scene, &found, &scene->found[middle], plain))
            hi = middle;
        else
            lo = middle + 1;
    }
    memmove(scene->found + lo + 1, scene->found + lo, (scene->found_count - lo) * sizeof found);
    scene->found[lo] = found;
    scene->found_count++;
}

static struct reference_totals report_found(struct reference_scene *scene, const struct double_ray *wide,
                                            struct reference_list_hit *hits, size_t capacity)
{
    struct reference_totals totals = {scene->found_count, 0};
    for (size_t i = 0; i < scene->found_count; i++) {
        const struct found *found = &scene->found[i];
        totals.crossing_count += found->crossing != 0;
        if (i >= capacity) continue;
        hits[i].crossing = found->crossing;
        if (wide) {
            report_at(scene, wide, found->position, &hits[i].hit);
            continue;
        }
        evaluate_candidate(scene, found->position);
        report(&scene->triangles[found->position], &scene->candidate, &hits[i].hit);
    }
    return totals;
}

struct reference_totals reference_trace_all_plain(struct reference_scene *scene, const struct reference_ray *ray,
                                                  struct reference_list_hit *hits, size_t capacity)
{
    const struct reference_totals none = {0, 0};
    float t_min, t_max;
    if (!ray_is_valid(ray, &t_min, &t_max)) return none;
    begin_search(scene, ray);
    scene->found_count = 0;
    for (size_t i = 0; i < scene->count; i++) {
        if (!scene->usable[i] || is_skipped(ray, &scene->triangles[i])) continue;
        if (!exact_is_hit(scene, i, t_min, t_max)) continue;
        insert_found(scene, (struct found){i, exact_is_crossing(scene, i), 0, INFINITY}, 1);
    }
    return report_found(scene, NULL, hits, capacity);
}

static void find_triangle(struct reference_scene *scene, const struct reference_ray *ray, const struct double_ray *wide,
                          size_t position)
{
    struct found found = {position, 1, 0, 0};
    if (is_skipped(ray, &scene->triangles[position])) return;
    enum verdict verdict = filter(wide, &scene->triangles[position], &found.t_lo, &found.t_hi);
    if (verdict == MISS) return;
    if (verdict == DOUBTFUL) {
        if (!exact_is_hit(scene, position, (float)wide->t_min, (float)wide->t_max)) return;
        found.crossing = exact_is_crossing(scene, position);
    }
    insert_found(scene, found, 0);
}

struct reference_totals reference_trace_all(struct reference_scene *scene, const struct reference_ray *ray,
                                            struct reference_list_hit *hits, size_t capacity)
{
    const struct reference_totals none = {0, 0};
    struct double_ray wide;
    struct closest closest;
    uint32_t stack[72];
    int height = 0;
    double entry;
    if (!start(scene, ray, &wide, &closest) || scene->node_count == 0) return none;
    scene->found_count = 0;
    stack[height++] = 0;
    while (height > 0) {
        const struct box_node *node = &scene->nodes[stack[--height]];
        for (uint32_t i = 0; i < node->count; i++) find_triangle(scene, ray, &wide, scene->order[node->first + i]);
        for (uint32_t child = 0; child < 2 && node->count == 0; child++) {
            if (enter_box(&scene->nodes[node->first + child], &wide, &entry)) stack[height++] = node->first + child;
        }
    }
    return report_found(scene, &wide, hits, capacity);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

struct reference_scene *reference_create(const struct reference_triangle *triangles, size_t count)
{
    struct reference_scene *scene = allocate(1, sizeof *scene);
    scene->triangles = allocate(count, sizeof *triangles);
    scene->usable = allocate(count, 1);
    scene->count = count;
    if (count > 0) memcpy(scene->triangles, triangles, count * sizeof *triangles);
    init_scratch(scene);
    classify_triangles(scene);
    build_boxes(scene);
    return scene;
}

void reference_destroy(struct reference_scene *scene)
{
    if (!scene) return;
    clear_scratch(scene);
    free(scene->triangles);
    free(scene->usable);
    free(scene->order);
    free(scene->nodes);
    free(scene->found);
    free(scene);
}

size_t reference_triangle_count(const struct reference_scene *scene)
{
    return scene->count;
}

const struct reference_triangle *reference_triangle_at(const struct reference_scene *scene, size_t position)
{
    return &scene->triangles[position];
}

const struct reference_triangle *reference_find(const struct reference_scene *scene, uint32_t mesh, uint32_t triangle)
{
    for (size_t i = 0; i < scene->count; i++) {
        const struct reference_triangle *found = &scene->triangles[i];
        if (found->mesh == mesh && found->triangle == triangle) return found;
    }
    return NULL;
}

size_t reference_non_finite_count(const struct reference_scene *scene)
{
    return scene->non_finite_count;
}

size_t reference_zero_area_count(const struct reference_scene *scene)
{
    return scene->zero_area_count;
}

static const float zero[3] = {0, 0, 0};

/* The sign of (vector + plus - minus) . n, computed in a scene of that triangle alone. */
static int sign_along_normal(const struct reference_triangle *triangle, const float vector[3], const float plus[3],
                             const float minus[3])
{
    struct reference_scene *scene = reference_create(triangle, 1);
    load_triangle(scene, triangle);
    set_vector(&scene->p, vector);
    set_vector(&scene->q, plus);
    add_vectors(&scene->p, &scene->p, &scene->q);
    set_vector(&scene->q, minus);
    subtract(&scene->p, &scene->p, &scene->q);
    dot(scene->left, &scene->p, &scene->normal);
    int sign = mpz_sgn(scene->left);
    reference_destroy(scene);
    return sign;
}

int reference_side(const struct reference_triangle *triangle, const float point[3])
{
    return sign_along_normal(triangle, point, zero, triangle->corner[0]);
}

int reference_side_of_sum(const struct reference_triangle *triangle, const float from[3], const float by[3])
{
    return sign_along_normal(triangle, from, by, triangle->corner[0]);
}

int reference_facing(const struct reference_triangle *triangle, const float direction[3])
{
    return sign_along_normal(triangle, direction, zero, zero);
}

void reference_distance_to_hit(const struct reference_triangle *triangle, const struct reference_ray *ray,
                               const float from[3], const float by[3], double distance[3])
{
    struct reference_scene *scene = reference_create(triangle, 1);
    const struct exact_pair *pair = &scene->candidate;
    mpq_t quotient;
    mpq_init(quotient);
    load_ray(scene, ray);
    evaluate(scene, triangle, &scene->candidate);
    for (int k = 0; k < 3; k++) {
        set_fixed(scene->left, from[k]);
        set_fixed(scene->right, by[k]);
        mpz_add(scene->left, scene->left, scene->right);
        mpz_sub(scene->left, scene->left, scene->origin.k[k]);
        mpz_mul(scene->left, scene->left, pair->d);
        mpz_submul(scene->left, pair->n, scene->direction.k[k]);
        mpq_set_num(quotient, scene->left);
        mpq_set_den(quotient, pair->d);
        mpq_canonicalize(quotient);
        distance[k] = ldexp(mpq_get_d(quotient), -SCALE_BITS);
    }
    mpq_clear(quotient);
    reference_destroy(scene);
}

/* ---- rays of cameras and lights ---------------------------------------------------------------------------------- */

/*
 * One operation on floats, rounded once: the product is exact in double; the sum may round there too, but 53 >= 2 * 24
 * + 2 digits make the second rounding harmless (S. Figueroa, "When is double rounding innocuous?", 1995).
 */
static float add(float a, float b)
{
    return (float)((double)a + (double)b);
}

static float multiply(float a, float b)
{
    return (float)((double)a * (double)b);
}

void reference_pixel_vector(const float d00[3], const float dx[3], const float dy[3], uint32_t column, uint32_t row,
                            float sample_x, float sample_y, float vector[3])
{
    float x = add((float)column, sample_x), y = add((float)row, sample_y);
    for (int k = 0; k < 3; k++) vector[k] = add(add(d00[k], multiply(x, dx[k])), multiply(y, dy[k]));
}

void reference_difference(const float a[3], const float b[3], float difference[3])
{
    for (int k = 0; k < 3; k++) difference[k] = add(a[k], -b[k]);
}
