/* SPDX-License-Identifier: MIT */
/*
 * Bundles: rays that are alike, as a caller's arrays bring them. Each kind is one way of being alike: a common end, a
 * common apex behind the origins, a waist inside the scene, one direction, and so on up to rays that have nothing in
 * common. Their places come from the scene's own vertices, edges and planes, at any scale. The same seed gives the same
 * rays.
 */
#ifndef TESTS_BUNDLE_RAYS_H
#define TESTS_BUNDLE_RAYS_H

#include "support.h"

/* A picture of rays: rows of `width`, the last of which may be shorter. */
struct bundle_shape {
    size_t count;
    uint32_t width;
};

size_t bundle_kind_count(void);

/* An identifier, such as meet_at_their_ends. */
const char *bundle_kind_name(size_t kind);

/* Appends shape.count rays of one kind. Some kinds set t_max and skip. */
void add_bundle_rays(struct ray_list *list, struct random *random, const struct fixture *fixture, size_t kind,
                     struct bundle_shape shape);

/*
 * Scales directions by powers of two, the same for all rays or one for each, or normalizes them, or leaves them. Where
 * a scaling is exact, t_max follows it, so that rays end where they ended.
 */
void stretch_directions(struct ray_list *list, struct random *random);

/*
 * Makes some rays odd: not finite, without direction, of extreme lengths, of another origin or axis. None, one, one in
 * each lane of 16 in turn, or one in a few.
 */
void spoil_bundle(struct ray_list *list, struct random *random, const struct fixture *fixture);

/* The answers of method ray. `masks` may be NULL. */
void trace_rays_singly(const mlrt_tree *tree, const struct ray_list *list, const uint32_t *masks, uint32_t common_mask,
                       struct reference_hit *hits);

#endif
