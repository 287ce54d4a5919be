/* SPDX-License-Identifier: MIT */
/*
 * Gathers and orders all hits of one ray. A triangle can lie in several leaves and is then gathered from each. When the
 * list is full, repetitions are removed first, and it grows only if half of it or more remains: so its capacity stays
 * within four times the number of different hits, or FIRST_CAPACITY.
 */
#include "exact/hit_list.h"

#include "base/platform.h"
#include "exact/nearest.h"

#define FIRST_CAPACITY 64

void mlrt_free_hit_list(struct mlrt_hit_list *list)
{
    mlrt_free(&list->memory, list->hits, list->capacity, sizeof *list->hits);
    list->hits = NULL;
    list->count = list->capacity = 0;
}

static void swap(struct mlrt_nearest *a, struct mlrt_nearest *b)
{
    const struct mlrt_nearest kept = *a;
    *a = *b;
    *b = kept;
}

/* The arguments of comparisons: the triangles, the ray, and its counters. */
struct order {
    const struct mlrt_triangles *triangles;
    const struct mlrt_ray_segment *ray;
    mlrt_counters *counters;
};

static int is_before(const struct order *order, const struct mlrt_nearest *first, const struct mlrt_nearest *second)
{
    if (first->hi < second->lo) return 1;
    if (second->hi < first->lo) return 0;
    const struct mlrt_triangle triangles[2] = {mlrt_triangle_at(order->triangles, first->triangle),
                                               mlrt_triangle_at(order->triangles, second->triangle)};
    const int sign = mlrt_compare_distance(order->ray, &triangles[0], &triangles[1], order->counters);
    return sign < 0 || (sign == 0 && first->triangle < second->triangle);
}

static int has_greater_number(const struct order *order, const struct mlrt_nearest *first,
                              const struct mlrt_nearest *second)
{
    (void)order;
    return first->triangle > second->triangle;
}

typedef int comparison(const struct order *order, const struct mlrt_nearest *first, const struct mlrt_nearest *second);

/*
 * Moves hit i of `count` down to its place in a heap, where each hit comes before its children, 2 i + 1 and 2 i + 2.
 * No qsort: it may take memory that is not the host's.
 */
MLRT_INLINE void sift_down(comparison *is_first, const struct order *order, struct mlrt_nearest *heap, uint32_t i,
                           uint32_t count)
{
    const struct mlrt_nearest sifted = heap[i];
    for (uint32_t child; (child = 2 * i + 1) < count; i = child) {
        if (child + 1 < count && is_first(order, &heap[child + 1], &heap[child])) ++child;
        if (!is_first(order, &heap[child], &sifted)) break;
        heap[i] = heap[child];
    }
    heap[i] = sifted;
}

/*
 * Makes a heap of `count` hits and moves the first `wanted` hits, one after the other, to the end of the array: the
 * very first hit becomes the last element.
 */
MLRT_INLINE void move_to_end(comparison *is_first, const struct order *order, uint32_t wanted,
                             struct mlrt_nearest *heap, uint32_t count)
{
    for (uint32_t i = count / 2; i-- > 0;) sift_down(is_first, order, heap, i, count);
    for (; wanted > 0 && count > 1; --wanted) {
        swap(&heap[0], &heap[--count]);
        sift_down(is_first, order, heap, 0, count);
    }
}

MLRT_NOINLINE void mlrt_remove_repetitions(struct mlrt_hit_list *list)
{
    if (list->count < 2) return;
    move_to_end(has_greater_number, NULL, list->count, list->hits, list->count); /* sorts them */
    uint32_t kept = 1;
    for (uint32_t i = 1; i < list->count; ++i)
        if (list->hits[i].triangle != list->hits[kept - 1].triangle) list->hits[kept++] = list->hits[i];
    list->count = kept;
}

/* Makes room for one more hit. Returns 0 if there is no memory for it. */
static int make_room(struct mlrt_hit_list *list)
{
    if (list->count < list->capacity) return 1;
    mlrt_remove_repetitions(list);
    if (list->count < list->capacity / 2) return 1;
    const uint32_t capacity = list->capacity ? 2 * list->capacity : FIRST_CAPACITY;
    struct mlrt_nearest *hits = mlrt_resize(&list->memory, list->hits, list->capacity, capacity, sizeof *hits);
    if (!hits) return 0;
    list->hits = hits;
    list->capacity = capacity;
    return 1;
}

void mlrt_gather_hit(const struct mlrt_triangles *triangles, const struct mlrt_ray_segment *ray, uint32_t number,
                     struct mlrt_hit_list *list, mlrt_counters *counters)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(triangles, number);
    if (!mlrt_hits_triangle(ray, &triangle, counters)) return;
    if (!make_room(list)) {
        list->failed = 1;
        return;
    }
    struct mlrt_nearest *hit = &list->hits[list->count++];
    hit->triangle = number;
    mlrt_bound_distance(ray, &triangle, &hit->lo, &hit->hi);
}

void mlrt_order_hits(const struct mlrt_triangles *triangles, const struct mlrt_ray_segment *ray, uint32_t wanted,
                     struct mlrt_hit_list *list, mlrt_counters *counters)
{
    const struct order order = {triangles, ray, counters};
    if (wanted > list->count) wanted = list->count;
    if (wanted == 0) return;
    move_to_end(is_before, &order, wanted, list->hits, list->count);
    for (uint32_t i = 0; i < list->count / 2; ++i) swap(&list->hits[i], &list->hits[list->count - 1 - i]);
}
