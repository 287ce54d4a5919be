/* SPDX-License-Identifier: MIT */
/*
 * Closed cells (cells.h) of tiles of rays that lie packed in arrays. Their rays are looked at twice if a cell does not
 * stay closed; but where light falls on a wall, most do.
 */
#if VW >= 8 && !MLRT_COUNTING

/* What a tile's rays are compared with. */
struct packed_tile {
    const struct mlrt_source *source;
    const float *ends; /* directions, or where rays end */
    float from[3];     /* what is subtracted from these */
    size_t first;      /* element */
    uint32_t pair[2];  /* that all pass: mesh and triangle */
};

/* Adds the directions of four blocks side by side. Returns whether all rays start at the apex. */
static MLRT_NOINLINE int add_packed_blocks(const struct mlrt_cells *cells, const struct packed_tile *tile,
                                           size_t element, struct direction_extremes *directions,
                                           struct usual_vectors *vectors)
{
    const struct mlrt_source *source = tile->source;
    const size_t step = 3 * source->width;
    const int a = cells->main_axis, axes[3] = {a, mlrt_slope_axis(a, 0), mlrt_slope_axis(a, 1)};
    const vf from[3] = {v_set1(tile->from[0]), v_set1(tile->from[1]), v_set1(tile->from[2])};
    const vf sign = v_set1(cells->sign);
    struct direction_extremes of = *directions;
    struct usual_vectors all = *vectors;
    for (size_t first = 3 * element; first < 3 * element + 48; first += 12) {
        if (source->kind == MLRT_SOURCE_RAYS &&
            !are_same_vectors((const float *)source->points.data + first, step, cells->apex)) {
            return 0;
        }
        for (size_t v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            vf d[3];
            v_triples(tile->ends + first + v / 4 * step, step, d);
            for (int k = 0; k < 3; ++k) d[k] = v_sub(d[k], from[k]);
            add_usual_vectors(d, &all);
            const vf by_slope[3] = {d[axes[0]], d[axes[1]], d[axes[2]]};
            add_directions(by_slope, sign, &of);
        }
    }
    *directions = of;
    *vectors = all;
    return 1;
}

/* Makes a closed cell of a whole tile; 0 if its rays are not of one kind, or they are wide. */
static MLRT_NOINLINE int add_packed_tile(const struct mlrt_rectangle *area, struct mlrt_cells *cells, uint32_t place,
                                         struct known_mesh *known, struct packed_tile *tile)
{
    const struct mlrt_source *source = tile->source;
    const float t_max = source->kind == MLRT_SOURCE_POINT_LIGHT ? 1 : INFINITY;
    float greatest_depth;
    struct direction_extremes directions = NO_DIRECTIONS;
    struct usual_vectors vectors = NO_VECTORS;
    tile->pair[0] = tile->pair[1] = MLRT_NONE;
    if (source->skip.data) {
        memcpy(tile->pair, (const uint32_t *)source->skip.data + 2 * tile->first, sizeof tile->pair);
        if (!mlrt_pass_one_triangle(source, tile->first)) return 0;
    }
    for (uint32_t row = 0; row < 16; row += 4) {
        mlrt_prefetch_around(source, area, row);
        if (!add_packed_blocks(cells, tile, tile->first + (size_t)row * source->width, &directions, &vectors)) return 0;
    }
    if (!are_usual(&vectors) || !set_cell_of_directions(cells, place, &directions, t_max, &greatest_depth)) return 0;
    find_mesh(source->tree, tile->pair[0], known);
    cells->skip[place] = tile->pair[1] < known->range.count ? known->range.first + tile->pair[1] : MLRT_NONE;
    return 1;
}

/* Has cells see things as the first ray of a tile does; 0 if float cannot. */
static int look_as_packed_tile(struct packed_tile *tile, struct mlrt_cells *cells)
{
    const struct mlrt_source *source = tile->source;
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT;
    float direction[3];
    memcpy(cells->apex, is_light ? source->light : (const float *)source->points.data + 3 * tile->first,
           sizeof cells->apex);
    for (int k = 0; k < 3; ++k) {
        tile->from[k] = is_light ? cells->apex[k] : 0;
        direction[k] = tile->ends[3 * tile->first + (size_t)k] - tile->from[k];
    }
    mlrt_set_main_axis(direction, cells);
    return mlrt_are_float_safe(cells->apex);
}

static int gather_packed_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, struct mlrt_cells *cells)
{
    const struct mlrt_source *source = &job->source;
    if (!has_packed_rays(source) || source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT) return 0;
    struct packed_tile tile = {.source = source};
    struct known_mesh known = NO_MESH;
    tile.ends = (const float *)(source->kind == MLRT_SOURCE_RAYS ? source->directions.data : source->points.data);
    cells->closed = 0;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        const uint32_t x = 16 * (place % 4), y = 16 * (place / 4);
        const struct mlrt_rectangle part = {area->x + x, area->y + y, 16, 16};
        tile.first = (size_t)part.y * source->width + part.x;
        if (x + 16 > area->width || y + 16 > area->height ||
            tile.first + 15 * (size_t)source->width + 16 > source->count ||
            (!cells->closed && !look_as_packed_tile(&tile, cells)) ||
            !add_packed_tile(&part, cells, place, &known, &tile)) {
            mlrt_leave_out_cell(cells, place);
        } else {
            cells->closed |= 1u << place;
        }
    }
    if (!cells->closed) return 0;
    sum_up_cells(cells);
    return 1;
}
#else
static int gather_packed_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, struct mlrt_cells *cells)
{
    (void)job, (void)area, (void)cells;
    return 0;
}
#endif
