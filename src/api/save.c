/* SPDX-License-Identifier: MIT */
/*
 * Trees as bytes, to be written to a file and used again: saving, loading, and the hash of a geometry.
 *
 * THE FORMAT, version 4
 *
 * A file is a header and eleven sections, each at a multiple of 64 bytes from the start of the file, in the order
 * below. Bytes between sections are zero, and so is the end of the file, up to a multiple of 64. Numbers are in the
 * byte order of the machine that wrote them; floats are those of IEEE 754. The bytes depend on the tree alone, not on
 * pointers, the compiler or the time: the same tree is always the same file.
 *
 *     header    struct header: 8 bytes that identify the format, byte order, version, the size of the
 *               file, the hash of the file, the hash of the geometry (at byte 32: a program may look there before it
 *               loads), counts, the unit and the quads of leaves of a hierarchy of boxes, the build report, and
 *               offset and size of each section
 *     section   size in bytes               contents
 *     0         36 ordered_count            triangles in order: three coordinates each of a, b, c, as they were given.
 *                                           ordered_count = triangle_count, or 0 if the file has places
 *     1          4 mesh_count               ids of the meshes
 *     2          4 (mesh_count + 1)         number of the first triangle of each mesh, and triangle_count
 *     3          4 mesh_count               positions of the meshes in the order of their ids
 *     4          4 mask_count               the mask of each triangle (mask_count = triangle_count), or none
 *     5          8 node_count               kd-tree: nodes, see kdtree.h
 *     6          4 reference_count          kd-tree: entries of leaves
 *     7        448 box_node_count           hierarchy of boxes: nodes in units, see bvh/node.h
 *     8        144 quad_count + 64          hierarchy of boxes: corners, in leaves in units, see bvh/unit.h
 *     9         16 quad_count + 64          hierarchy of boxes: numbers
 *     10         4 place_count              hierarchy of boxes: the place of each triangle, see bvh/node.h
 *                                           (place_count = triangle_count), or none
 *
 * Sections 8 and 9 end with 16 elements without a meaning, because vectors may read beyond the last quad. If
 * quad_count is 0, both are empty.
 *
 * Both hashes are those of base/hash.h over 32-bit words. That of the file is over all of it, with 0 in place of the
 * hash. That of the geometry is over the number of meshes, then for each mesh its id, its number of triangles and its
 * mask (of a mesh without triangles: all bits), then the coordinates of all triangles in order.
 *
 * The first of the counts is the structure of the tree, MLRT_STRUCTURE_*, and sections of the other structure are
 * empty. In the build report the structure is 0, and so are bytes and seconds, which belong to the process that built
 * the tree.
 *
 * CHECKS OF LOADING
 *
 * After the hash, loading checks all that memory safety and the end of every traversal depend on. Sizes and places of
 * sections must be those that follow from the counts. Tables of meshes must ascend. Each triangle must be at its place,
 * and the corners in leaves must be those of their triangles. Bounds, the unit and the numbers of triangles left out
 * are computed again. Nodes must pass mlrt_check_nodes or mlrt_check_boxes. One kind of invariant is not checked: that
 * boxes and cells contain what is below them (I3, B3). If one is violated, rays can miss a triangle, but there are no
 * false hits: whether a ray hits a triangle, and where, is decided with the triangle alone.
 *
 * Checks read the tree's own copy, so a change of the data meanwhile does no harm, unless they are used in place.
 */
#include <string.h>

#include "base/hash.h"
#include "base/host.h"
#include "base/platform.h"
#include "base/structs.h"
#include "job/structure.h"
#include "scene/meshes.h"

#define SECTION_ALIGNMENT 64

/* As in PNG: a byte above 127, line ends of both kinds and an end-of-file character reveal a transfer as text. */
static const unsigned char magic[8] = {0x89, 'M', 'L', 'R', 'T', '\r', '\n', 0x1A};

#define BYTE_ORDER_MARK 0x01020304u
#define FORMAT_VERSION  4

#define SECTION_COUNT 11

struct section {
    uint64_t offset;
    uint64_t size;
};

struct header {
    unsigned char magic[8];
    uint32_t byte_order;
    uint32_t version;
    uint64_t size;
    uint64_t hash;
    uint64_t geometry_hash;
    uint32_t counts[MLRT_SAVED_COUNTS];
    uint32_t numbers[2]; /* boxes: bvh.unit, a float, and bvh.leaf_quad_count; kd-tree: 0 */
    mlrt_tree_info info; /* struct_size, memory_size, peak_memory_size, build_seconds and structure are 0 */
    struct section sections[SECTION_COUNT];
};

/* This struct is the format, so it must have no padding. If mlrt_tree_info grows, FORMAT_VERSION must grow too. */
typedef char header_is_packed[sizeof(struct header) == 88 + 144 + 176 ? 1 : -1];

/* The sections of all trees. The first of the counts, the structure, is never 0, and so also stands for "always". */
static const struct mlrt_section common_sections[] = {
    MLRT_SECTION(triangles, triangle_count, sizeof(struct mlrt_triangle), 0, ORDERED, ORDERED),
    MLRT_SECTION(meshes.ids, meshes.count, 4, 0, MESHES, STRUCTURE),
    MLRT_SECTION(meshes.first, meshes.count, 4, 4, MESHES, STRUCTURE),
    MLRT_SECTION(meshes.by_id, meshes.count, 4, 0, MESHES, STRUCTURE),
    MLRT_SECTION(masks, triangle_count, 4, 0, MASKS, MASKS),
};

#define COMMON_COUNT ((int)(sizeof common_sections / sizeof *common_sections))

static const struct mlrt_structure *find_structure(uint32_t code)
{
    if (code == mlrt_structure_bvh.code) return &mlrt_structure_bvh;
    return code == mlrt_structure_kdtree.code ? &mlrt_structure_kdtree : NULL;
}

/* Section i of the files of a structure; NULL if they have none. */
static const struct mlrt_section *section_at(const struct mlrt_structure *structure, int i)
{
    if (i < COMMON_COUNT) return &common_sections[i];
    i -= structure->file.first;
    return i >= 0 && i < structure->file.count ? &structure->file.sections[i] : NULL;
}

/* A member of a tree, at an offset of a table. */
static void *member_at(const struct mlrt_tree *tree, size_t offset)
{
    return (unsigned char *)(uintptr_t)tree + offset;
}

/* The tree's pointer to the array of a section. Copied by memcpy, as the pointers have different types. */
static void *get_array(const struct mlrt_tree *tree, const struct mlrt_section *section)
{
    void *array;
    memcpy(&array, member_at(tree, section->array), sizeof array);
    return array;
}

static void set_array(struct mlrt_tree *tree, const struct mlrt_section *section, const void *array)
{
    memcpy(member_at(tree, section->array), &array, sizeof array);
}

/*
 * Sets offsets and sizes of the sections by the counts of the header. Returns the size of the file, which is far below
 * 2^64, as counts have 32 bits.
 */
static uint64_t lay_out(const struct mlrt_structure *structure, const struct header *header,
                        struct section sections[SECTION_COUNT])
{
    uint64_t end = sizeof *header;
    for (int i = 0; i < SECTION_COUNT; ++i) {
        const struct mlrt_section *kind = section_at(structure, i);
        sections[i].offset = (end + SECTION_ALIGNMENT - 1) / SECTION_ALIGNMENT * SECTION_ALIGNMENT;
        sections[i].size = 0;
        if (kind && header->counts[kind->needs])
            sections[i].size = header->counts[kind->count] * (uint64_t)kind->element + kind->more;
        end = sections[i].offset + sections[i].size;
    }
    return (end + SECTION_ALIGNMENT - 1) / SECTION_ALIGNMENT * SECTION_ALIGNMENT;
}

/* The hash of the file: of the header with its hash as 0, and of the bytes that follow it in `data`. */
static uint64_t hash_file(const struct header *header, const unsigned char *data)
{
    struct header without_hash = *header;
    struct mlrt_hash hash;
    without_hash.hash = 0;
    mlrt_start_hash(&hash);
    mlrt_add_words(&hash, &without_hash, sizeof without_hash / 4);
    mlrt_add_words(&hash, data + sizeof *header, (size_t)(header->size - sizeof *header) / 4);
    return mlrt_finish_hash(&hash);
}

/* ---- the hash of a geometry ---- */

static void add_mesh(struct mlrt_hash *hash, uint32_t id, uint32_t triangle_count, uint32_t mask)
{
    const uint32_t words[3] = {id, triangle_count, triangle_count > 0 ? mask : MLRT_MASK_ALL};
    mlrt_add_words(hash, words, 3);
}

static uint64_t hash_tree_geometry(const struct mlrt_tree *tree)
{
    struct mlrt_hash hash;
    mlrt_start_hash(&hash);
    mlrt_add_words(&hash, &tree->meshes.count, 1);
    for (uint32_t i = 0; i < tree->meshes.count; ++i) {
        const uint32_t first = tree->meshes.first[i], count = tree->meshes.first[i + 1] - first;
        add_mesh(&hash, tree->meshes.ids[i], count, tree->masks && count > 0 ? tree->masks[first] : MLRT_MASK_ALL);
    }
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, i);
        mlrt_add_words(&hash, &triangle, 9);
    }
    return mlrt_finish_hash(&hash);
}

static int32_t add_triangles(const mlrt_mesh *mesh, size_t position, struct mlrt_hash *hash)
{
    struct mlrt_triangle triangle;
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        const int32_t status = mlrt_copy_triangle(mesh, position, i, 1, &triangle);
        if (status != MLRT_OK) return status;
        mlrt_add_words(hash, &triangle, 9);
    }
    return MLRT_OK;
}

/* Adds meshes with the ids that a tree gives them: their positions if all ids are 0. */
static void add_meshes(const mlrt_mesh *meshes, uint32_t mesh_count, struct mlrt_hash *hash)
{
    uint32_t any = 0;
    for (uint32_t i = 0; i < mesh_count; ++i) any |= mlrt_mesh_at(meshes, i).id;
    mlrt_add_words(hash, &mesh_count, 1);
    for (uint32_t i = 0; i < mesh_count; ++i) {
        const mlrt_mesh mesh = mlrt_mesh_at(meshes, i);
        add_mesh(hash, any ? mesh.id : i, (uint32_t)mesh.triangle_count, mesh.mask);
    }
}

MLRT_API int32_t mlrt_hash_geometry(const mlrt_mesh *meshes, size_t mesh_count, uint64_t *hash)
{
    if (!hash) return mlrt_fail_null("hash", 0);
    *hash = 0;
    struct mlrt_hash state;
    uint32_t triangle_count;
    int32_t status = mlrt_check_meshes(meshes, mesh_count, &triangle_count);
    if (status != MLRT_OK) return status;
    mlrt_start_hash(&state);
    add_meshes(meshes, (uint32_t)mesh_count, &state);
    for (size_t i = 0; i < mesh_count && status == MLRT_OK; ++i) {
        const mlrt_mesh mesh = mlrt_mesh_at(meshes, i);
        status = add_triangles(&mesh, i, &state);
    }
    if (status == MLRT_OK) *hash = mlrt_finish_hash(&state);
    return status;
}

/* ---- saving ---- */

static void make_header(const struct mlrt_tree *tree, struct header *header)
{
    const struct mlrt_structure *structure = tree->structure;
    memset(header, 0, sizeof *header);
    header->byte_order = BYTE_ORDER_MARK;
    header->version = FORMAT_VERSION;
    header->counts[MLRT_SAVED_STRUCTURE] = structure->code;
    header->counts[MLRT_SAVED_TRIANGLES] = tree->triangle_count;
    for (int i = 0; i < SECTION_COUNT; ++i) {
        const struct mlrt_section *kind = section_at(structure, i);
        if (kind && get_array(tree, kind))
            memcpy(&header->counts[kind->count], member_at(tree, kind->length), sizeof header->counts[0]);
    }
    if (structure->file.numbers)
        memcpy(header->numbers, member_at(tree, structure->file.numbers), sizeof header->numbers);
    header->info = tree->info;
    memcpy(header->magic, magic, sizeof magic);
    header->info.struct_size = 0;
    header->info.memory_size = header->info.peak_memory_size = 0;
    header->info.build_seconds = 0;
    header->info.structure = 0;
    header->size = lay_out(structure, header, header->sections);
}

static void write_file(const struct mlrt_tree *tree, struct header *header, unsigned char *buffer)
{
    size_t end = sizeof *header;
    for (int i = 0; i < SECTION_COUNT; ++i) {
        const size_t offset = (size_t)header->sections[i].offset, size = (size_t)header->sections[i].size;
        memset(buffer + end, 0, offset - end);
        if (size > 0) memcpy(buffer + offset, get_array(tree, section_at(tree->structure, i)), size);
        end = offset + size;
    }
    memset(buffer + end, 0, (size_t)header->size - end);
    header->geometry_hash = hash_tree_geometry(tree);
    header->hash = hash_file(header, buffer);
    memcpy(buffer, header, sizeof *header);
}

MLRT_API int32_t mlrt_save_tree(const mlrt_tree *tree, void *buffer, size_t capacity, size_t *size)
{
    if (size) *size = 0;
    if (!tree || !size) return mlrt_fail_null("tree size", !tree);
    struct header header;
    char given[MLRT_DIGITS], needed[MLRT_DIGITS];
    make_header(tree, &header);
    const char *file_size = mlrt_write_digits(header.size, needed);
    if (header.size > SIZE_MAX)
        return mlrt_fail(MLRT_ERROR_TOO_LARGE, "tree: its %s bytes are more than this process can address", file_size);
    *size = (size_t)header.size;
    if (!buffer) return MLRT_OK;
    if (capacity < header.size) {
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "capacity: %s is less than the %s bytes of the tree",
                         mlrt_write_digits(capacity, given), file_size);
    }
    MLRT_COMPUTE(write_file(tree, &header, buffer));
    return MLRT_OK;
}

/* ---- loading ---- */

static const char wrong_counts[] = "counts that no tree has", other_triangles[] = "of other triangles";

/* Are the counts that all trees have within their limits? */
static int counts_make_sense(const uint32_t counts[MLRT_SAVED_COUNTS])
{
    const uint32_t triangles = counts[MLRT_SAVED_TRIANGLES], masks = counts[MLRT_SAVED_MASKS],
                   ordered = counts[MLRT_SAVED_ORDERED], places = counts[MLRT_SAVED_PLACES];
    return triangles <= MLRT_TRIANGLE_LIMIT && counts[MLRT_SAVED_MESHES] <= INT32_MAX &&
           (masks == 0 || masks == triangles) && ordered + places == triangles && (!ordered || !places);
}

/* Checks a header. Returns the error as a static string, or NULL. */
static const char *check_header(const struct header *header, size_t size)
{
    struct section sections[SECTION_COUNT];
    if (memcmp(header->magic, magic, sizeof magic) != 0) return "not a saved tree";
    if (header->byte_order != BYTE_ORDER_MARK) return "saved on a machine of another byte order";
    if (header->version != FORMAT_VERSION) return "of another version of the format";
    if (header->size != size) return "not as long as it was: cut off, or followed by something";
    const struct mlrt_structure *structure = find_structure(header->counts[MLRT_SAVED_STRUCTURE]);
    if (!structure || !counts_make_sense(header->counts)) return wrong_counts;
    if (lay_out(structure, header, sections) != header->size ||
        memcmp(sections, header->sections, sizeof sections) != 0) {
        return "sections are not where they have to be";
    }
    return NULL;
}

/*
 * Sets the tree's arrays to copies of the sections, or if borrowed, to the data themselves. Dropping `const` is safe,
 * since the arrays of a tree are never written. Returns 0 if out of memory.
 */
static int take_sections(const struct header *header, const unsigned char *data, struct mlrt_tree *tree)
{
    const struct mlrt_structure *structure = tree->structure;
    tree->triangle_count = header->counts[MLRT_SAVED_TRIANGLES];
    if (structure->file.numbers)
        memcpy(member_at(tree, structure->file.numbers), header->numbers, sizeof header->numbers);
    for (int i = 0; i < SECTION_COUNT; ++i) {
        const struct mlrt_section *kind = section_at(structure, i);
        const unsigned char *from = data + (size_t)header->sections[i].offset;
        const size_t size = (size_t)header->sections[i].size;
        if (!kind || header->counts[kind->needs] == 0) continue;
        memcpy(member_at(tree, kind->length), &header->counts[kind->count], sizeof header->counts[0]);
        void *copy = tree->borrowed ? NULL : mlrt_allocate(&tree->memory, size, 1);
        if (!tree->borrowed && !copy) return 0;
        set_array(tree, kind, copy ? memcpy(copy, from, size) : from);
    }
    mlrt_find_triangles(tree);
    return 1;
}

/* Checks the tables of meshes. If ids ascend strictly in meshes.by_id, all positions differ, and so do all ids. */
static const char *check_meshes(const struct mlrt_tree *tree)
{
    uint32_t first = 0;
    if (tree->meshes.first[0] != 0) return "meshes are out of order"; // also where there are none
    for (uint32_t i = 0; i < tree->meshes.count; ++i) {
        if (tree->meshes.first[i] < first) return "meshes are out of order";
        first = tree->meshes.first[i];
        if (tree->meshes.by_id[i] >= tree->meshes.count) return "a position is not that of a mesh";
        const uint32_t id = tree->meshes.ids[tree->meshes.by_id[i]];
        if (id == MLRT_NONE || (i > 0 && id <= tree->meshes.ids[tree->meshes.by_id[i - 1]]))
            return "ids of meshes are not in order, or not different";
    }
    const uint32_t last = tree->meshes.first[tree->meshes.count];
    return last == tree->triangle_count && last >= first ? NULL : "meshes have not as many triangles as the tree";
}

/* Computes bounds and numbers of triangles left out, compares them with the report, and sets the tree's bounds. */
static const char *check_report(struct mlrt_tree *tree)
{
    uint64_t non_finite_count = 0, zero_area_count = 0;
    struct mlrt_box box = MLRT_NO_BOX;
    for (uint32_t i = 0; i < tree->triangle_count; ++i) {
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, i);
        if (!mlrt_keep_triangle(&triangle, &non_finite_count, &zero_area_count)) continue;
        struct mlrt_box own;
        mlrt_bound_triangle(&triangle, own.lo, own.hi);
        mlrt_extend_box(own.lo, own.hi, &box);
    }
    const int is_empty = non_finite_count + zero_area_count == tree->triangle_count;
    if (is_empty) memset(&box, 0, sizeof box);
    for (int k = 0; k < 3; ++k)
        if (tree->info.bounds_min[k] != box.lo[k] || tree->info.bounds_max[k] != box.hi[k]) return "bounds are wrong";
    if (tree->info.triangle_count != tree->triangle_count || tree->info.non_finite_count != non_finite_count ||
        tree->info.zero_area_count != zero_area_count) {
        return "triangles are miscounted";
    }
    memcpy(tree->bounds.lo, tree->info.bounds_min, sizeof tree->bounds.lo); // zeros have the signs they had
    memcpy(tree->bounds.hi, tree->info.bounds_max, sizeof tree->bounds.hi);
    return NULL;
}

/* Also checks that the file has no counts or numbers of another structure: saved again, the tree has the same. */
static const char *check_contents(const struct header *header, struct mlrt_tree *tree)
{
    struct header again;
    make_header(tree, &again);
    if (memcmp(again.counts, header->counts, sizeof again.counts) != 0 ||
        memcmp(again.numbers, header->numbers, sizeof again.numbers) != 0) {
        return wrong_counts;
    }
    const char *wrong = check_meshes(tree);
    if (!wrong) wrong = tree->structure->file.take(tree);
    if (!wrong) wrong = check_report(tree);
    return wrong ? wrong : tree->structure->file.check(tree);
}

/* Copies the header of a file, and checks it and the hash. Returns the error as a static string, or NULL. */
static const char *read_header(const unsigned char *data, size_t size, uint64_t geometry_hash, struct header *header)
{
    if (size < sizeof *header) return "not a saved tree";
    memcpy(header, data, sizeof *header);
    const char *wrong = check_header(header, size);
    if (wrong) return wrong;
    if (geometry_hash != 0 && header->geometry_hash != geometry_hash) return other_triangles;
    return header->hash == hash_file(header, data) ? NULL : "damaged: its hash is not that of its contents";
}

/* Fills an empty tree, of which `borrowed` is set. For MLRT_ERROR_DATA, *wrong receives the reason. */
static MLRT_NOINLINE int32_t take_file(const struct header *header, const unsigned char *data, uint64_t geometry_hash,
                                       struct mlrt_tree *tree, const char **wrong)
{
    if (!take_sections(header, data, tree)) return MLRT_ERROR_OUT_OF_MEMORY;
    tree->info = header->info;
    *wrong = check_contents(header, tree);
    if (!*wrong && geometry_hash != 0 && hash_tree_geometry(tree) != geometry_hash) *wrong = other_triangles;
    if (*wrong) return MLRT_ERROR_DATA;
    tree->info.struct_size = sizeof tree->info;
    tree->info.memory_size = tree->memory.held_size;
    tree->info.peak_memory_size = tree->memory.peak_size;
    tree->info.build_seconds = 0;
    tree->info.structure = tree->structure->code;
    tree->info.reserved = 0;
    tree->memory.limit_size = 0;
    return MLRT_OK;
}

/* Sets *tree, or frees what was made of it. For MLRT_ERROR_DATA, *wrong receives the reason. */
static MLRT_NOINLINE int32_t load(const void *data, size_t size, const mlrt_load_options *options,
                                  const mlrt_host *host, mlrt_tree **tree, const char **wrong)
{
    struct header header;
    *wrong = read_header(data, size, options->geometry_hash, &header);
    if (*wrong) return MLRT_ERROR_DATA;
    const struct mlrt_memory memory = mlrt_host_memory(host, options->memory_limit);
    struct mlrt_tree *made = mlrt_allocate_tree(find_structure(header.counts[MLRT_SAVED_STRUCTURE]), &memory);
    if (!made) return MLRT_ERROR_OUT_OF_MEMORY;
    made->borrowed = options->flags & MLRT_LOAD_IN_PLACE && (uintptr_t)data % SECTION_ALIGNMENT == 0;
    const int32_t status = take_file(&header, data, options->geometry_hash, made, wrong);
    if (status == MLRT_OK)
        *tree = made;
    else
        mlrt_destroy_tree(made);
    return status;
}

MLRT_API int32_t mlrt_load_tree(const void *data, size_t size, const mlrt_load_options *options, mlrt_tree **tree)
{
    mlrt_load_options own;
    struct mlrt_voice voice = {.message = NULL};
    if (tree) *tree = NULL;
    int32_t status = mlrt_copy_struct(MLRT_STRUCT_LOAD_OPTIONS, "options", 0, options, &own);
    if (status == MLRT_OK)
        status = mlrt_begin_call(MLRT_STRUCT_LOAD_OPTIONS, &own, own.message, own.message_size, own.host, &voice);
    if (status == MLRT_OK && (!data || !tree)) {
        status = mlrt_fail_null("data tree", !data);
    } else if (status == MLRT_OK) {
        const char *wrong = NULL;
        MLRT_COMPUTE(status = load(data, size, &own, &voice.host, tree, &wrong));
        status = status == MLRT_ERROR_DATA ? mlrt_fail(status, "data: %s", wrong) : mlrt_note_status(status);
    }
    return mlrt_end_call(&voice, status);
}
