/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile out of the caller's arrays, whatever their strides: a whole block a vector at a time. Blocks at the
 * end of a list, and those of which rows do not share elements evenly, are read by source.c.
 */

/* How the elements of a block lie: neighbours of a row, and rows, in bytes apart. Elements of twelve bytes with nothing
 * between them are packed; behind some others a word follows that is an element of another array. */
struct array_layout {
    const unsigned char *data;
    size_t stride; /* between elements; 0: one serves all rays */
    size_t step;   /* between the neighbours of a block; 0 where they share elements */
    size_t row_step;
    int is_packed;
    int has_word; /* a word behind each element may be read, too */
};

/* The arrays of a source as its whole blocks are read: the same for all blocks of a tile. */
struct array_reader {
    const struct mlrt_source *source;
    struct array_layout points;
    struct array_layout directions;
    struct array_layout t_min;
    struct array_layout t_max;
    struct array_layout skip;
    int points_have_t_min; /* as the word behind them */
    int directions_have_t_max;
};

static void lay_out_array(const mlrt_const_array *array, uint32_t group, size_t row_length, struct array_layout *layout)
{
    layout->data = array->data;
    layout->stride = array->data ? array->stride : 0;
    layout->step = group > 1 ? 0 : layout->stride;
    layout->row_step = layout->step * row_length;
    layout->is_packed = layout->step == 12;
    layout->has_word = 0;
}

/* Does an element of `other` follow each of these, twelve bytes from where it begins? */
static int is_followed_by(const struct array_layout *array, const struct array_layout *other)
{
    return array->data && other->data == array->data + 12 && array->stride && array->stride == other->stride &&
           array->step == other->step;
}

/* 0 if neighbours share origins in another way than sixteen at a time. */
static int begin_reading(const struct mlrt_source *source, struct array_reader *reader)
{
    const uint32_t group = source->rays_per_origin;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS;
    static const mlrt_const_array none;
    if (source->kind == MLRT_SOURCE_CAMERA || (group > 1 && group % MLRT_PACKET_RAYS != 0)) return 0;
    reader->source = source;
    lay_out_array(&source->points, group, source->width, &reader->points);
    lay_out_array(&source->skip, group, source->width, &reader->skip);
    lay_out_array(is_rays ? &source->t_min : &none, group, source->width, &reader->t_min);
    lay_out_array(is_rays ? &source->directions : &none, 1, source->width, &reader->directions);
    lay_out_array(is_rays ? &source->t_max : &none, 1, source->width, &reader->t_max);
    reader->points_have_t_min = is_followed_by(&reader->points, &reader->t_min);
    reader->directions_have_t_max = is_followed_by(&reader->directions, &reader->t_max);
    reader->points.has_word = reader->points_have_t_min || is_followed_by(&reader->points, &reader->t_max) ||
                              is_followed_by(&reader->points, &reader->directions) ||
                              is_followed_by(&reader->points, &reader->skip);
    reader->directions.has_word = reader->directions_have_t_max ||
                                  is_followed_by(&reader->directions, &reader->t_min) ||
                                  is_followed_by(&reader->directions, &reader->points) ||
                                  is_followed_by(&reader->directions, &reader->skip);
    return 1;
}

/* The column and row of a packet's lane. */
MLRT_INLINE size_t offset_of_lane(const struct array_layout *layout, int lane)
{
    return (size_t)((lane & 1) | (lane >> 1 & 2)) * layout->step + (size_t)((lane >> 1 & 1) | (lane >> 2 & 2)) * layout->row_step;
}

/* Vectors of lanes from v on: three words, and that behind them, if there is one. */
MLRT_INLINE void read_vectors(const struct array_layout *layout, const unsigned char *first, int v, vf words[4])
{
    const unsigned char *at = first + offset_of_lane(layout, v);
    if (layout->is_packed) {
        v_triples(at, layout->row_step, words);
    } else if (layout->step == 0) {
        const float *one = (const float *)(const void *)first;
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) words[k] = v_set1(one[k]);
        if (layout->has_word) words[3] = v_set1(one[3]);
    } else if (layout->has_word) {
        v_quads_at(at, layout->step, layout->row_step, words);
    } else {
        v_triples_at(at, layout->step, layout->row_step, words);
    }
}

MLRT_INLINE vf read_floats(const struct array_layout *layout, const unsigned char *first, int v)
{
    return v_floats_at(first + offset_of_lane(layout, v), layout->step, layout->row_step);
}

/* What the rays of a block pass: pairs of mesh and triangle, as numbers. Neighbours mostly pass triangles of one mesh, or
 * nothing. */
static void read_skips(const struct array_layout *skip, size_t element, const struct mlrt_tree *tree,
                       struct known_mesh *known, struct mlrt_packet *packet)
{
    const unsigned char *first = skip->data + element * skip->stride;
    uint32_t mesh;
    vm same = m_from_bits(ALL_LANES);
    memcpy(&mesh, first, sizeof mesh);
    find_mesh(tree, mesh, known);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vi meshes, triangles;
        i_pairs_at(first + offset_of_lane(skip, v), skip->step, skip->row_step, &meshes, &triangles);
        same = m_and(same, i_eq(meshes, i_set1(mesh)));
        i_store(packet->skip_mesh + v, meshes);
        i_store(packet->skip + v, triangles);
    }
    if (MLRT_UNLIKELY(m_bits(same) != ALL_LANES)) {
        mlrt_number_skips(tree, packet);
        return;
    }
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        i_store(packet->skip + v, numbers_in_mesh(known, i_load(packet->skip + v)));
    }
}

/* Reads the rays of a whole block; not masks. t_min is not negative then, unless it is no number. */
static void read_whole_block(const struct array_reader *reader, uint32_t x, uint32_t y, struct known_mesh *known,
                             struct mlrt_packet *packet)
{
    const struct mlrt_source *source = reader->source;
    const struct array_layout *t_min = &reader->t_min, *t_max = &reader->t_max;
    const size_t ray = (size_t)y * source->width + x;
    const size_t origin = source->rays_per_origin == 1 ? ray : ray / source->rays_per_origin;
    const unsigned char *points = reader->points.data + origin * reader->points.stride;
    const unsigned char *directions = reader->directions.data + ray * reader->directions.stride;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS, is_point = source->kind == MLRT_SOURCE_POINT_LIGHT;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf point[4], direction[4];
        read_vectors(&reader->points, points, v, point);
        vf least = v_set1(0), most = v_set1(is_point ? 1 : INFINITY);
        if (is_rays) {
            read_vectors(&reader->directions, directions, v, direction);
            if (reader->directions_have_t_max) {
                most = direction[3];
            } else if (t_max->data) {
                most = read_floats(t_max, t_max->data + ray * t_max->stride, v);
            }
            if (reader->points_have_t_min) {
                least = point[3];
            } else if (t_min->data) {
                least = read_floats(t_min, t_min->data + origin * t_min->stride, v);
            }
        }
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const vf light = v_set1(source->light[k]);
            if (is_point) {
                direction[k] = v_sub(point[k], light);
            } else {
                v_store(packet->origin[k] + v, point[k]);
                if (!is_rays) direction[k] = light;
            }
            v_store(packet->direction[k] + v, direction[k]);
        }
        v_store(packet->t_min + v, least);
        v_store(packet->t_max + v, most);
    }
    packet->has_apex = is_point;
    if (is_point) memcpy(packet->apex, source->light, sizeof packet->apex);
    packet->has_limits = t_min->data || t_max->data;
    packet->has_masks = 0;
    packet->has_skip = reader->skip.data != NULL;
    if (packet->has_skip) read_skips(&reader->skip, origin, source->tree, known, packet);
}
