/* SPDX-License-Identifier: MIT */
/*
 * Rows of pixels in a list of rays: see rows.h.
 *
 * In a row, rays go away from the first one; the row below begins close to it again. So a length is guessed where a ray
 * is far closer to an earlier one than those in between. That is also true of rows that go to and fro, of a panorama,
 * of several samples for each pixel, and of a part of a picture that begins in the middle of a row. Whether the guess
 * is right, and whether rows help, is found by trying: with the right rows, packets and tiles from all over the list
 * are narrower than they are without.
 */
#include "rays/rows.h"

#include <math.h>
#include <string.h>

/* Lists of fewer rays remain lists, and fewer or shorter rows are not looked for. */
#define FEWEST_RAYS  256
#define FEWEST_ROWS  4
#define SHORTEST_ROW 8

/* A ray is close to another one if those in between are more than this many times as far away. */
#define CLOSER 4

/* At most this many lengths are tried. */
#define MOST_GUESSES 6

/* Lists are looked at in so many places, and in one more for each so many rays, up to so many. */
#define FEWEST_PLACES  4
#define RAYS_PER_PLACE 512
#define MOST_PLACES    8

/* Up to so many rows apart, rays tell how long rows are. */
#define MOST_ROWS_APART 16

/* Rows must be narrower than this share of what a list is, as a list is read faster. */
#define ROWS_PAY 0.9f

/* The greater of two numbers; b if a is a NaN. */
static float greater(float a, float b)
{
    return a > b ? a : b;
}

/*
 * A list of rays, and the distance from a ray's origin at which its end is compared with others. Of both ends, `term`
 * tells those that change less from ray to ray, 0 or 3 of ray_ends: rays to a light with an extent end at random, those
 * of a lens begin at random.
 */
struct ray_list {
    const struct mlrt_source *rays;
    uint32_t place_count;
    float reach;
    uint32_t term;
};

/* Where a ray begins, and where it ends or is as far away as the list's reach. */
struct ray_ends {
    float at[6];
};

static struct ray_ends ends_of(const struct ray_list *list, uint32_t i)
{
    const struct mlrt_ray_arrays *arrays = &list->rays->arrays;
    const float *origin = mlrt_element(&arrays->points, i);
    struct ray_ends ends;
    float pace = 0, scale = 0;
    if (!mlrt_is_light(list->rays)) {
        const float *d = mlrt_element(&arrays->directions, i);
        for (int k = 0; k < 3; ++k) pace = greater(fabsf(d[k]), pace);
        scale = list->reach / pace;
        if (arrays->t_max.data && *mlrt_element(&arrays->t_max, i) < scale) scale = *mlrt_element(&arrays->t_max, i);
        for (int k = 0; k < 3; ++k) ends.at[3 + k] = origin[k] + scale * d[k];
    } else {
        memcpy(ends.at + 3, origin, 3 * sizeof *origin);
    }
    memcpy(ends.at, origin, 3 * sizeof *origin);
    return ends;
}

/* How far one end is from another, as a sum over the axes. It can be a NaN: comparisons with that are false. */
static float distance(const float a[3], const float b[3])
{
    return fabsf(a[0] - b[0]) + fabsf(a[1] - b[1]) + fabsf(a[2] - b[2]);
}

static float distance_between(const struct ray_list *list, uint32_t i, uint32_t j)
{
    const struct ray_ends a = ends_of(list, i), b = ends_of(list, j);
    return distance(a.at + list->term, b.at + list->term);
}

/* The box of both ends of some rays. */
struct box_of_ends {
    struct ray_ends lo, hi;
};

static void begin_box(struct box_of_ends *box)
{
    for (int k = 0; k < 6; ++k) box->lo.at[k] = INFINITY, box->hi.at[k] = -INFINITY;
}

static void extend_box(const struct ray_list *list, uint32_t i, struct box_of_ends *box)
{
    const struct ray_ends ends = ends_of(list, i);
    for (int k = 0; k < 6; ++k) { /* a NaN changes nothing */
        if (ends.at[k] < box->lo.at[k]) box->lo.at[k] = ends.at[k];
        if (ends.at[k] > box->hi.at[k]) box->hi.at[k] = ends.at[k];
    }
}

static float width_of(const struct box_of_ends *box)
{
    const float width = distance(box->lo.at, box->hi.at) + distance(box->lo.at + 3, box->hi.at + 3);
    return box->lo.at[0] <= box->hi.at[0] ? width : 0;
}

/* A ray at random in part i of `count` rays, which have as many parts as the list has places to look at. */
static uint32_t random_place(const struct ray_list *list, uint32_t i, uint32_t count)
{
    uint32_t bits = (i + 1) * 2654435769u; /* always the same ones: not in step with any rows */
    bits = (bits ^ bits >> 15) * 2246822519u;
    bits ^= bits >> 13;
    return (uint32_t)((((uint64_t)i << 32 | bits) / list->place_count * count) >> 32);
}

/*
 * The width of the tile that has ray `i`, and of one of its packets, if rows have this length (4 = a list). Tiles that
 * rows cut off count as wide as those of as many packets would be.
 */
static float width_around(const struct ray_list *list, uint32_t i, uint32_t row_length)
{
    const uint32_t count = list->rays->count, columns = row_length == 4 ? 4 : 16, rows = 256 / columns;
    const uint32_t x = i % row_length / columns * columns, y = i / row_length / rows * rows;
    struct box_of_ends tile, packet;
    uint32_t packet_count = 0;
    begin_box(&tile);
    begin_box(&packet);
    for (uint32_t block = 0; block < 16; ++block) {
        const uint32_t left = x + 4 * block % columns, top = y + 4 * block / columns * 4;
        const uint64_t first = (uint64_t)top * row_length + left;
        if (left >= row_length || first >= count) continue;
        ++packet_count;
        extend_box(list, (uint32_t)first, &tile);
        for (uint32_t lane = 0; packet_count == 1 && lane < 16; ++lane) {
            const uint64_t at = first + (uint64_t)(lane / 4) * row_length + lane % 4;
            if (left + lane % 4 < row_length && at < count) extend_box(list, (uint32_t)at, &packet);
        }
    }
    return width_of(&packet) + width_of(&tile) * 4 / (float)packet_count;
}

/*
 * The sum of widths all over the list with rows of this length, or infinity if packets and tiles are mostly not
 * narrower than without.
 */
static float width_of_rows(const struct ray_list *list, uint32_t row_length)
{
    uint32_t narrower = 0;
    float sum = 0;
    for (uint32_t i = 0; i < list->place_count; ++i) {
        const uint32_t place = random_place(list, i, list->rays->count);
        const float width = width_around(list, place, row_length);
        narrower += width < ROWS_PAY * width_around(list, place, 4);
        sum += width;
    }
    return 2 * narrower > list->place_count ? sum : INFINITY;
}

/* The sum of how far rays from all over the list are from those `step` after them. */
static float distance_over(const struct ray_list *list, uint32_t step)
{
    float sum = 0;
    for (uint32_t i = 0; i < list->place_count; ++i) {
        const uint32_t from = random_place(list, i, list->rays->count - step);
        sum += distance_between(list, from, from + step);
    }
    return sum;
}

/*
 * 1 if in most places rays that are `step` apart are closer than those `other` apart, by more than this factor. (In
 * some places, one of them is in another row.)
 */
static int are_closer(const struct ray_list *list, uint32_t step, uint32_t other, float factor)
{
    const uint32_t room = list->rays->count - (step > other ? step : other);
    uint32_t closer = 0;
    for (uint32_t i = 0; i < list->place_count; ++i) {
        const uint32_t from = random_place(list, i, room);
        closer += factor * distance_between(list, from, from + step) < distance_between(list, from, from + other);
    }
    return 2 * closer > list->place_count;
}

/*
 * Improves a length that is right within a few times `step`. Rays that are some rows apart are the closer, the better
 * the length is. The more rows, the more this tells; but another length may fit a greater number of rows.
 */
static uint32_t refine_length(const struct ray_list *list, uint32_t length, uint32_t step)
{
    for (uint32_t rows = 1; rows <= MOST_ROWS_APART; rows *= 2) {
        const uint32_t most = length / (4 * rows), steps = most / step < 4 ? most / step : 4, center = length;
        float least = INFINITY;
        if ((uint64_t)rows * (center + steps * step) >= list->rays->count) return length;
        for (uint32_t at = center - steps * step; at <= center + steps * step; at += step) {
            const float d = distance_over(list, rows * at);
            if (d < least) least = d, length = at;
        }
        step = (step + 1) / 2;
    }
    return length;
}

/*
 * The best of the lengths that two guesses lead to, both right within a few times `step`; 0 if rows do not pay. To
 * improve a guess is not always right: rays of a wall that is seen from the side are closest along its slope.
 */
static uint32_t choose_length(const struct ray_list *list, uint32_t first, uint32_t second, uint32_t step)
{
    const uint32_t guesses[2] = {first, second};
    uint32_t best = 0;
    float least = INFINITY;
    for (uint32_t i = 0; i < (first == second ? 1 : 2); ++i) {
        const uint32_t guess = guesses[i];
        if (!are_closer(list, guess, guess / 2, 2)) continue;
        const uint32_t lengths[2] = {guess, refine_length(list, guess, step)};
        for (uint32_t k = 0; k < (lengths[1] == guess ? 1 : 2); ++k) {
            const float width = width_of_rows(list, lengths[k]);
            if (width < least) least = width, best = lengths[k];
        }
    }
    return best;
}

/* A search for lengths of rows from one ray on. */
struct row_search {
    const struct ray_list *list;
    uint32_t start;
    struct ray_ends first;
    float greatest;       /* distance from it to a ray that was passed */
    uint32_t guess_count; /* lengths that were tried */
};

static float distance_after(const struct row_search *search, uint32_t length)
{
    const struct ray_ends ends = ends_of(search->list, search->start + length);
    return distance(search->first.at + search->list->term, ends.at + search->list->term);
}

/* The first length above `far` at which a ray is close. At `close` one is. */
static uint32_t find_first(const struct row_search *search, uint32_t far, uint32_t close)
{
    while (close - far > 1) {
        const uint32_t middle = far + (close - far) / 2;
        if (CLOSER * distance_after(search, middle) < search->greatest)
            close = middle;
        else
            far = middle;
    }
    return close;
}

/*
 * The length at which a ray is closest, among every step-th from `first` on. Stops at `most`, or where rays are not
 * close any more, and sets *end to that.
 */
static uint32_t find_closest(const struct row_search *search, uint32_t first, uint32_t step, uint32_t most,
                             uint32_t *end)
{
    uint32_t closest = first, length = first;
    float least = INFINITY;
    for (; length <= most && length <= first + first / 2; length += step) {
        const float d = distance_after(search, length);
        if (!(2 * d < search->greatest)) break;
        if (d < least) least = d, closest = length;
    }
    *end = length;
    return closest;
}

/* Searches from ray `start` on, in the first half of the list. Returns a length with which rows pay, or 0. */
static uint32_t search_rows(struct row_search *search, uint32_t start)
{
    const uint32_t most = search->list->rays->count / FEWEST_ROWS;
    uint32_t before = SHORTEST_ROW - 1;
    search->start = start;
    search->first = ends_of(search->list, start);
    search->greatest = 0;
    for (uint32_t length = 1; length < SHORTEST_ROW; ++length)
        search->greatest = greater(distance_after(search, length), search->greatest);
    for (uint32_t length = SHORTEST_ROW; length <= most && search->guess_count < MOST_GUESSES;) {
        const float d = distance_after(search, length);
        uint32_t at = length; /* where the search goes on from */
        if (CLOSER * d < search->greatest) {
            const uint32_t first = find_first(search, before, length), step = first / 64 + 1;
            const uint32_t closest = find_closest(search, first, step, most, &at);
            ++search->guess_count;
            const uint32_t best = choose_length(search->list, first, closest, step);
            if (best) return best;
        } else {
            search->greatest = greater(d, search->greatest);
        }
        before = at;
        length = at + (at < 16 ? 1 : at / 8);
    }
    return 0;
}

/*
 * Sets list->term to the ends that change less from ray to ray, compared with how they change over a third of the list.
 * Ends that hardly change at all tell nothing. Returns 0 if neighbours have nothing in common.
 */
static int choose_term(struct ray_list *list)
{
    float near[2], far[2];
    for (uint32_t i = 0; i < 2; ++i) {
        list->term = 3 * i;
        near[i] = distance_over(list, 1);
        far[i] = distance_over(list, list->rays->count / 3);
    }
    if (!(8 * far[0] < far[1]) && near[0] * far[1] <= near[1] * far[0]) list->term = 0;
    return are_closer(list, 1, list->rays->count / 3, CLOSER);
}

static MLRT_NOINLINE uint32_t find_row_length(const struct mlrt_source *rays)
{
    const struct mlrt_box *bounds = &rays->tree->bounds;
    struct ray_list list = {rays, FEWEST_PLACES + rays->count / RAYS_PER_PLACE, 0, 0};
    if (list.place_count > MOST_PLACES) list.place_count = MOST_PLACES;
    for (int k = 0; k < 3; ++k) list.reach = greater(bounds->hi[k] - bounds->lo[k], list.reach);
    list.reach *= 0.25f;
    struct row_search search = {.list = &list};
    if (!choose_term(&list)) return 0;
    const uint32_t length = search_rows(&search, 0);
    return length ? length : search_rows(&search, rays->count / 2); /* the first row of a panorama is a point */
}

uint32_t mlrt_find_row_length(const struct mlrt_source *rays)
{
    if (rays->count < FEWEST_RAYS || rays->arrays.rays_per_origin > 1) return 0;
    uint32_t length;
    MLRT_COMPUTE(length = find_row_length(rays));
    return length;
}
