/* SPDX-License-Identifier: MIT */
/*
 * The shear of rays of one direction: see shear.h.
 */
#include "shear.h"

#include <string.h>

#include "kernels/quad.h"
#include "sheared.h"
#include "source.h"

/* A power of two above `a`: at most twice, at least once as large. */
static float power_above(float a)
{
    uint32_t bits;
    memcpy(&bits, &a, sizeof bits);
    bits = (bits & 0x7F800000u) + 0x00800000u;
    memcpy(&a, &bits, sizeof bits);
    return a;
}

/* How far from `middle` a camera's rays begin at most, along axis k: at the corners of its picture, and a little more.
 */
static float reach_of_view(const struct mlrt_view *view, float middle, int k)
{
    float reach = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const float x = (float)(view->first_x + (corner & 1 ? view->width : 0)) + view->sample_x;
        const float y = (float)(view->first_y + (corner & 2 ? view->height : 0)) + view->sample_y;
        reach = fmaxf(fabsf(view->d00[k] + x * view->dx[k] + y * view->dy[k] - middle), reach);
    }
    return reach * 1.001f;
}

void mlrt_make_shear(const struct mlrt_tree *tree, const struct mlrt_source *source, const float direction[3],
                     const float origin[3], int any, struct mlrt_shear *shear)
{
    const int is_camera = source->kind == MLRT_SOURCE_CAMERA, against = any && !is_camera;
    float reach = MLRT_SAFE_MIN;
    int a = 0;
    for (int k = 0; k < 3; ++k) {
        const float lo = tree->bounds.lo[k], hi = tree->bounds.hi[k], middle = 0.5f * lo + 0.5f * hi;
        const float away = fabsf(origin[k] - middle), box = fmaxf(hi - middle, middle - lo);
        const float far = is_camera ? reach_of_view(&source->view, middle, k) : away > box ? power_above(away) : 0;
        shear->given[k] = direction[k];
        shear->along[k] = against ? 0 - direction[k] : direction[k];
        shear->centre[k] = middle;
        reach = fmaxf(fmaxf(box, far), reach);
        if (fabsf(direction[k]) > fabsf(direction[a])) a = k;
    }
    const float depth = shear->along[a], sign = shear->sign = depth < 0 ? -1.0f : 1.0f;
    shear->main_axis = a;
    shear->size = (reach < 0x1p70f ? reach : 0x1p70f) * (2 + 0x1p-16f);
    shear->scale = 1 / shear->size;
    for (int side = 0; side < 2; ++side) shear->slope[side] = shear->along[(a + 1 + side) % 3] / fabsf(depth);
    shear->pace = direction[a] * sign * shear->scale;
    const float front = sign > 0 ? tree->bounds.lo[a] : tree->bounds.hi[a];
    shear->front = (front - shear->centre[a]) * sign * shear->scale - 0x1p-18f;
}

/* 1 / (1 - z), or what is beyond all that there is. */
static double distance_at(double z)
{
    return z > 0.75 ? 4 : 1 / (1 - z);
}

void mlrt_shear_distance(const struct mlrt_shear *shear, const struct mlrt_ray_segment *ray,
                         struct mlrt_nearest *nearest)
{
    const int a = shear->main_axis;
    const double step = (double)shear->sign * shear->scale;
    const double begin = ((double)ray->origin[a] - shear->centre[a]) * step, pace = ray->direction[a] * step;
    const double one = distance_at(begin + nearest->lo * pace), other = distance_at(begin + nearest->hi * pace);
    nearest->lo = (float)((one < other ? one : other) * (1 - MLRT_SHEAR_SLACK));
    nearest->hi = (float)((one < other ? other : one) * (1 + MLRT_SHEAR_SLACK));
}

/* The bounds of a hit are positive: 1 / (1 - z) is 2/3 at least, and of what is certain N is off by a fifth.
 */
void mlrt_unshear_distance(const struct mlrt_shear *shear, const struct mlrt_ray_segment *ray,
                           struct mlrt_nearest *nearest)
{
    const int a = shear->main_axis;
    const double step = (double)shear->sign * shear->scale;
    const double begin = ((double)ray->origin[a] - shear->centre[a]) * step, pace = ray->direction[a] * step;
    const double one = (1 - (1 + MLRT_SHEAR_SLACK) / nearest->lo - begin) / pace;
    const double other = (1 - (1 - MLRT_SHEAR_SLACK) / nearest->hi - begin) / pace;
    const float lo = (float)((one < other ? one : other) * (1 - MLRT_SHEAR_SLACK));
    const float hi = (float)((one < other ? other : one) * (1 + MLRT_SHEAR_SLACK));
    nearest->lo = lo > ray->t_min ? lo : ray->t_min;
    nearest->hi = hi < ray->t_max ? hi : ray->t_max;
}

/* ---- packets and boxes ---- */

int mlrt_have_one_direction(const struct mlrt_packet *packet)
{
    const uint32_t valid = packet->active | packet->single, first = mlrt_lowest_bit(valid);
    uint32_t others = 0;
    for (int k = 0; k < 3 && !(others & valid); ++k) {
        uint32_t word;
        memcpy(&word, &packet->direction[k][first], sizeof word);
        for (int lane = 0; lane < MLRT_PACKET_RAYS; lane += 4) {
            others |= (~(uint32_t)f4_same_words(packet->direction[k] + lane, word) & 15) << lane;
        }
    }
    return !(others & valid);
}

int mlrt_has_direction(const struct mlrt_packet *packet, const struct mlrt_shear *shear)
{
    const uint32_t lane = mlrt_lowest_bit(packet->active);
    int same = shear->scale != 0;
    for (int k = 0; k < 3; ++k) same &= packet->direction[k][lane] == shear->given[k];
    return same;
}

void mlrt_unshear_packet(struct mlrt_packet *packet)
{
    for (int lane = 0; lane < MLRT_PACKET_RAYS; lane += 4) {
        for (int k = 0; k < 3; ++k) f4_store(packet->direction[k] + lane, f4_set1(packet->shear->given[k]));
        const f4 t_max = f4_load(packet->t_max + lane);
        f4_store(packet->lo + lane, t_max);
        f4_store(packet->hi + lane, t_max);
    }
    packet->shear = NULL;
}

float mlrt_shear_box(const struct mlrt_shear *shear, float enter, float exit, float begin[2], float end[2])
{
    for (int side = 0; side < 2; ++side) {
        const float p = enter * shear->slope[side], q = exit * shear->slope[side];
        begin[side] -= p > q ? p : q;
        end[side] -= p < q ? p : q;
    }
    return (1 - MLRT_SHEAR_DISTANCE_SLACK) / (1 - enter * shear->scale);
}
