/* SPDX-License-Identifier: MIT */
/*
 * Which lights reach what a picture's rays hit. Where one triangle covers a cell of the picture, the light sees a cell
 * there, too, as a rule, and it needs no rays as long as nothing lies between, or one triangle shades all of it. Other
 * packets have rays of their own to the light.
 */

/* What is known of a cell of the picture that one triangle covers: bit per light. */
struct known_lights {
    uint32_t cover;
    uint8_t known;
    uint8_t dark; /* of those known, which do not reach it */
};

#if MLRT_COUNTING
/* One ray at a time: who counts can wait, and should be small. */
static uint32_t shade_cells(const struct mlrt_job *job, struct mlrt_worker *worker, const struct cells *seen,
                            struct known_lights known[CELL_COUNT])
{
    uint32_t missed = 0;
    (void)job, (void)worker;
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        known[place] = (struct known_lights){seen->cover[place], 0, 0};
        missed |= (uint32_t)(seen->cover[place] == MLRT_NONE) << place;
    }
    return missed;
}

static void shade_packets(const struct mlrt_job *job, const struct mlrt_job *light, struct mlrt_worker *worker,
                          struct ray_tile *seen, uint32_t dark_lanes[CELL_COUNT])
{
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        dark_lanes[place] = 0;
        if (!has_block(seen, place)) continue;
        for (uint32_t left = find_seen(job, seen, place); left; left &= left - 1) {
            const struct mlrt_packet *packet = &seen->packets[place];
            const uint32_t lane = mlrt_lowest_bit(left);
            struct mlrt_ray_segment ray;
            mlrt_get_segment(packet, lane, &ray);
            dark_lanes[place] |= (uint32_t)mlrt_is_shaded(light, &ray, packet->triangle[lane], &worker->counters)
                                 << lane;
        }
    }
}
#else
/* Makes cells of what a point light sees of closed cells of a picture. Returns those; *dark receives those behind. */
static MLRT_NOINLINE uint32_t gather_lit_cells(const struct mlrt_job *job, const struct cells *seen, uint32_t among,
                                               struct cells *cells, uint32_t *dark)
{
    const struct mlrt_seen_cells given = {seen->slopes, seen->cover, seen->apex, seen->main_axis, seen->sign};
    struct mlrt_lit_cells lit = {cells->slopes, cells->farthest, cells->shortest, 0, 0};
    cells->closed = mlrt_make_lit_cells(&job->source, job->tree, &given, among, &lit, dark);
    if (!cells->closed) return 0;
    cells->main_axis = lit.main_axis;
    cells->sign = lit.sign;
    memcpy(cells->apex, job->source.light, sizeof cells->apex);
    memset(&cells->shear, 0, sizeof cells->shear);
    memcpy(cells->skip, seen->cover, sizeof cells->skip);
    sum_up_cells(cells);
    return cells->closed;
}

/* Do closed cells of a picture have what a light's cells are made of? */
MLRT_INLINE int have_lit_cells(const struct mlrt_job *job, const struct mlrt_job *light)
{
    return is_pinhole(&job->source) && light->source.kind == MLRT_SOURCE_POINT_LIGHT;
}

/* Cells with a cover. */
MLRT_INLINE uint32_t covered_cells(const struct cells *cells)
{
    uint32_t covered = 0;
    for (int v = 0; v < CELL_COUNT; v += VW) {
        covered |= (~m_bits(i_eq(i_load(cells->cover + v), i_set1(MLRT_NONE))) & ALL_LANES) << v;
    }
    return covered & cells->closed;
}

/* What is known of the lights at the closed cells of a square. Returns the cells of which all is known. */
static MLRT_SMALL uint32_t shade_cells(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          const struct cells *seen, struct known_lights known[CELL_COUNT])
{
    const uint32_t covered = covered_cells(seen);
    uint32_t all = seen->closed;
    MLRT_KEEP_LOOP
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        known[place] = (struct known_lights){seen->cover[place], 0, 0};
    }
    for (uint32_t i = 0; i < job->light_count; ++i) {
        const struct mlrt_job *light = &job->lights[i];
        struct cells cells;
        uint32_t dark = 0, lit = 0;
        if (covered && have_lit_cells(job, light)) {
            cells.tile = NULL;
            if (gather_lit_cells(light, seen, covered, &cells, &dark)) {
                traverse_bvh(light, worker, &cells);
                const uint32_t shaded = covered_cells(&cells);
                dark |= shaded;
                lit = cells.closed & ~shaded;
            }
        }
        for (uint32_t left = dark | lit; left; left &= left - 1) {
            struct known_lights *of = &known[mlrt_lowest_bit(left)];
            of->known |= (uint8_t)(1u << i);
            of->dark |= (uint8_t)((dark >> mlrt_lowest_bit(left) & 1) << i);
        }
        all &= dark | lit | (seen->closed & ~covered);
    }
    return all;
}

/* Finds the lanes of a tile's packets that a light does not reach. */
static MLRT_NOINLINE void shade_packets(const struct mlrt_job *job, const struct mlrt_job *light, struct mlrt_worker *worker,
                          struct ray_tile *seen, uint32_t dark_lanes[CELL_COUNT])
{
    struct ray_tile tile;
    uint32_t dark = 0, lit = 0, waiting = 0, made = 0;
    tile.area = seen->area;
    tile.column_bits = 2;
    tile.limits_below = 0;
    tile.made = 0;
    tile.seen = seen;
    tile.picture = job;
    const uint32_t covered = covered_cells(&seen->cells), missed = seen->cells.closed & ~covered;
    if (covered && have_lit_cells(job, light)) {
        tile.cells.tile = &tile;
        if (gather_lit_cells(light, &seen->cells, covered, &tile.cells, &dark)) {
            traverse_bvh(light, worker, &tile.cells);
            const uint32_t shaded = covered_cells(&tile.cells);
            dark |= shaded;
            lit = tile.cells.closed & ~shaded;
            made = tile.made;
        }
    }
    MLRT_KEEP_LOOP
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        if (!has_block(&tile, place) || (dark | lit | missed | made) >> place & 1) continue;
        make_rays_to_light(light, &tile, place);
        waiting |= (tile.packets[place].active != 0u) << place;
        made |= 1u << place;
    }
    tile.made = 0xFFFF;
    trace_packets(light, worker, &tile, waiting);
    MLRT_KEEP_LOOP
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        dark_lanes[place] = dark >> place & 1 ? 0xFFFF : 0;
        if (!(made >> place & 1)) continue;
        finish_packet(light, worker, &tile.packets[place]);
        dark_lanes[place] = tile.dark[place] | (~lanes_of_triangle(&tile.packets[place], MLRT_NONE) & 0xFFFF);
    }
}
#endif

/* Finds and writes which lights do not reach what the rays of a tile hit. `known`: what is known of all of it, or NULL. */
static MLRT_NOINLINE void shade_tile(const struct mlrt_job *job, struct mlrt_worker *worker, struct ray_tile *tile,
                                     const struct known_lights *known)
{
    MLRT_ALIGNED(16) uint8_t shadows[CELL_COUNT][MLRT_PACKET_RAYS];
    memset(shadows, known ? known->dark : 0, sizeof shadows);
    for (uint32_t i = 0; i < job->light_count; ++i) {
        uint32_t dark_lanes[CELL_COUNT];
        if (known && known->known >> i & 1) continue;
        shade_packets(job, &job->lights[i], worker, tile, dark_lanes);
        MLRT_KEEP_LOOP
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
            if (dark_lanes[place]) mlrt_add_shadow(shadows[place], dark_lanes[place], (uint8_t)(1u << i));
        }
    }
    MLRT_KEEP_LOOP
    for (uint32_t place = 0; place < CELL_COUNT; ++place) {
        if (!has_block(tile, place)) continue;
        const struct rectangle block = block_of_tile(tile, place);
        write_shadows(job, worker, shadows[place], existing_lanes(&job->source, &block), &block);
    }
}
