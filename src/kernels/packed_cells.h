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

/* Adds the directions of a block's rays. Returns whether they are safe, start at the apex and pass the pair. */
MLRT_INLINE int add_packed_block(const struct mlrt_cells *cells, const struct packed_tile *tile, size_t element,
                                 struct direction_extremes *directions)
{
    const struct mlrt_source *source = tile->source;
    const size_t width = source->width;
    const int a = cells->main_axis, axes[2] = {mlrt_slope_axis(a, 0), mlrt_slope_axis(a, 1)};
    vm are_fine = m_from_bits(ALL_LANES);
    if (source->kind == MLRT_SOURCE_RAYS &&
        !are_same_vectors((const float *)source->points.data + 3 * element, 3 * width, cells->apex)) {
        return 0;
    }
    for (size_t v = 0; v < MLRT_PACKET_RAYS; v += VW, element += VW / 4 * width) {
        vf d[3];
        v_triples(tile->ends + 3 * element, 3 * width, d);
        for (int k = 0; k < 3; ++k) d[k] = v_sub(d[k], v_set1(tile->from[k]));
        are_fine = m_and(are_fine, check_vectors(d).is_safe);
        const vf by_slope[3] = {d[a], d[axes[0]], d[axes[1]]};
        add_directions(by_slope, cells->sign, directions);
        if (source->skip.data) {
            vi mesh, triangle;
            i_pairs((const uint32_t *)source->skip.data + 2 * element, 2 * width, &mesh, &triangle);
            are_fine = m_and(are_fine, m_and(i_eq(mesh, i_set1(tile->pair[0])), i_eq(triangle, i_set1(tile->pair[1]))));
        }
    }
    return m_bits(are_fine) == ALL_LANES;
}

/* Makes a closed cell of a whole tile; 0 if its rays are not of one kind, or they are wide. */
static MLRT_NOINLINE int add_packed_tile(const struct mlrt_rectangle *area, struct mlrt_cells *cells, uint32_t place,
                                         struct known_mesh *known, struct packed_tile *tile)
{
    const struct mlrt_source *source = tile->source;
    const float t_max = source->kind == MLRT_SOURCE_POINT_LIGHT ? 1 : INFINITY;
    float greatest_depth;
    struct direction_extremes directions = NO_DIRECTIONS;
    tile->pair[0] = tile->pair[1] = MLRT_NONE;
    if (source->skip.data) memcpy(tile->pair, (const uint32_t *)source->skip.data + 2 * tile->first, sizeof tile->pair);
    for (uint32_t row = 0; row < 16; row += 4) {
        mlrt_prefetch_around(source, area, row);
        for (uint32_t column = 0; column < 16; column += 4) {
            if (!add_packed_block(cells, tile, tile->first + (size_t)row * source->width + column, &directions))
                return 0;
        }
    }
    if (!set_cell_of_directions(cells, place, &directions, t_max, &greatest_depth)) return 0;
    find_mesh(source->tree, tile->pair[0], known);
    cells->skip[place] = tile->pair[1] < known->range.count ? known->range.first + tile->pair[1] : MLRT_NONE;
    return 1;
}

/* Has cells see things as the first ray of a tile does; 0 if float cannot. */
static MLRT_SMALL int look_as_packed_tile(struct packed_tile *tile, struct mlrt_cells *cells)
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
