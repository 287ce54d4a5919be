/* SPDX-License-Identifier: MIT */
/*
 * From packets to single rays: see hybrid.h.
 */
#include "hybrid.h"

#include "kernels/quad.h"
#include "kernels/slopes.h"
#include "tuning.h"

/* Sets the slopes of a packet's rays, as if each were a cell. */
static void set_ray_slopes(struct mlrt_ray_tile *tile, uint32_t place)
{
    const struct mlrt_packet *packet = &tile->packets[place];
    const int a = tile->cells.main_axis;
    for (int lane = 0; lane < MLRT_PACKET_RAYS; lane += 4) {
        const f4 inverse = f4_div(f4_set1(1), f4_abs(f4_load(packet->direction[a] + lane)));
        for (int side = 0; side < 2; ++side) {
            const f4 slope = f4_mul(f4_load(packet->direction[mlrt_slope_axis(a, side)] + lane), inverse);
            const f4 slack = f4_mul(f4_abs(slope), f4_set1(SLOPE_SLACK));
            f4_store(tile->ray_slopes[place][side].lo + lane, f4_sub(slope, slack));
            f4_store(tile->ray_slopes[place][side].hi + lane, f4_add(slope, slack));
        }
    }
    tile->has_ray_slopes |= 1u << place;
}

/* Rays of a packet that may meet a box. */
static uint32_t rays_met(struct mlrt_ray_tile *tile, uint32_t place, const struct mlrt_seen_box *box)
{
    const struct mlrt_packet *packet = &tile->packets[place];
    const struct mlrt_slopes *slopes = tile->ray_slopes[place];
    uint32_t missed = 0;
    if (!(tile->has_ray_slopes >> place & 1)) set_ray_slopes(tile, place);
    for (int lane = 0; lane < MLRT_PACKET_RAYS; lane += 4) {
        const f4 depth = f4_abs(f4_load(packet->direction[tile->cells.main_axis] + lane));
        const f4 farthest = f4_mul(f4_mul(f4_load(packet->hi + lane), depth), f4_set1(1 + SLOPE_SLACK));
        f4 room = f4_sub(farthest, f4_set1(box->nearest));
        for (int side = 0; side < 2; ++side) {
            const f4 lo = f4_load(slopes[side].lo + lane), hi = f4_load(slopes[side].hi + lane);
            const f4 first = f4_set1(box->first), last = f4_set1(box->last);
            const f4 greatest = f4_max(f4_mul(hi, last), f4_mul(hi, first));
            const f4 least = f4_min(f4_mul(lo, last), f4_mul(lo, first));
            room = f4_min(f4_sub(greatest, f4_set1(box->begin[side])), room);
            room = f4_min(f4_sub(f4_set1(box->end[side]), least), room);
        }
        missed |= (uint32_t)f4_signs(room) << lane;
    }
    return packet->active & ~missed;
}

/* Traces rays of a packet, and makes its cell what it is then. */
static void trace_rays(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                       uint32_t place, uint32_t lanes, uint32_t child)
{
    struct mlrt_packet *packet = &tile->packets[place];
    uint32_t hit = 0;
    job->kernels->trace_singles(job, lanes, packet, worker, child);
    for (uint32_t left = job->any ? lanes : 0; left; left &= left - 1) {
        const uint32_t lane = mlrt_lowest_bit(left);
        hit |= (uint32_t)(packet->triangle[lane] != MLRT_NONE) << lane;
    }
    job->kernels->update_cell(tile, place, hit);
}

/*
 * Is a box too large for few rays of a packet to meet it? Guessed by its size and the cell's; four times as many may
 * be found after all, with cells that lie askew.
 */
static int is_large(const struct mlrt_cells *cells, uint32_t place, const struct mlrt_seen_box *box, uint32_t most)
{
    float rays = MLRT_PACKET_RAYS, limit = 4 * (float)most;
    for (int side = 0; side < 2; ++side) {
        rays *= box->end[side] - box->begin[side];
        limit *= box->first * (cells->slopes[side].hi[place] - cells->slopes[side].lo[place]);
    }
    return rays > limit;
}

/*
 * Whether to ask how many rays meet a leaf. On meshes where that is seldom few, asking costs more than it spares; so
 * there it is done for some leaves only.
 */
static int is_worth_asking(struct mlrt_worker *worker)
{
    return worker->leaf_credit > 0 || ++worker->leaves_not_asked % MLRT_LEAVES_NOT_ASKED == 0;
}

static void learn(struct mlrt_worker *worker, int found)
{
    worker->leaf_credit += found ? MLRT_LEAF_GAIN : -1;
    if (worker->leaf_credit < 0) worker->leaf_credit = 0;
    if (worker->leaf_credit > MLRT_MOST_LEAF_CREDIT) worker->leaf_credit = MLRT_MOST_LEAF_CREDIT;
}

/* Finds which rays of packets may meet a box, and whether they are few. */
static int are_few(struct mlrt_cells *cells, uint32_t met, const struct mlrt_seen_box *box, uint32_t most,
                   uint32_t lanes[MLRT_CELL_COUNT])
{
    uint32_t count = 0;
    if (is_large(cells, mlrt_lowest_bit(met), box, most)) return 0;
    for (; met && count <= most; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        lanes[place] = rays_met(cells->tile, place, box);
        count += mlrt_count_bits(lanes[place]);
    }
    return count <= most;
}

int mlrt_trace_few_rays(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_cells *cells, uint32_t slot,
                        uint32_t met)
{
    const struct mlrt_bvh_node *node = &job->tree->bvh.nodes[slot / MLRT_BVH_WIDTH];
    const uint32_t in_node = slot % MLRT_BVH_WIDTH, child = node->child[in_node];
    const int is_leaf = mlrt_bvh_quad_count(child) != 0;
    uint32_t lanes[MLRT_CELL_COUNT];
    struct mlrt_seen_box box;
    if (met & cells->closed) return 0;
    if (is_leaf && (mlrt_is_set_up(cells, child, &worker->caches[job->any]) || !is_worth_asking(worker))) return 0;
    mlrt_see_box(cells, node, in_node, &box);
    const int few = are_few(cells, met, &box, is_leaf ? MLRT_FEW_LEAF_RAYS : MLRT_FEW_RAYS, lanes);
    if (is_leaf) learn(worker, few);
    if (!few) return 0;
    for (; met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        if (lanes[place]) trace_rays(job, worker, cells->tile, place, lanes[place], child);
    }
    return 1;
}

void mlrt_trace_alone(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                      uint32_t place)
{
    trace_rays(job, worker, tile, place, tile->packets[place].active, 0);
    mlrt_leave_out_cell(&tile->cells, place);
}
