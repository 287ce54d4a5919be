// SPDX-License-Identifier: MIT
/** Finds the compiled library, and declares the structs and functions of mlrt.h that index.js calls. */
'use strict';
const fs = require('node:fs');
const path = require('node:path');
const koffi = require('koffi');

// Calls on other threads run on stacks of this size. Koffi's own 128 kB are too few for a library compiled without
// optimisation.
koffi.config({ async_stack_size: 1 << 20 });

// ---- the library ---------------------------------------------------------------------------------------------------

const FILE = 'mlrt.node.so';
const PREBUILT = path.join(__dirname, 'prebuilt', `${process.platform}-${process.arch}`, FILE);
const BUILT = path.join(__dirname, 'build', FILE);

/** The library compiled on this machine, or else the one that the package brings. */
function load() {
    const reasons = [];
    for (const file of [BUILT, PREBUILT]) {
        if (!fs.existsSync(file)) continue;
        try {
            return koffi.load(file);
        } catch (error) {
            reasons.push(`\n  ${error.message}`);
        }
    }
    throw new Error(`mlrt: there is no library for ${process.platform}-${process.arch} yet. Compile it by "npx mlrt-build", ` +
        `which needs gcc or clang and some twenty seconds.${reasons.join('')}`);
}

// ---- the structs of mlrt.h -----------------------------------------------------------------------------------------

const places = ['host', 'mesh', 'tree_options', 'tree_info', 'memory_estimate', 'load_options', 'pool_options', 'counters',
    'trace_options', 'array', 'hits', 'const_array', 'rays', 'ray', 'hit', 'hit_lists', 'camera', 'tile', 'light', 'points',
    'kdtree_options']; // MLRT_STRUCT_*

const constArray = koffi.struct('mlrt_const_array', { data: 'const void *', stride: 'size_t' });
const array = koffi.struct('mlrt_array', { data: 'void *', stride: 'size_t', row_stride: 'size_t' });
const float3 = koffi.array('float', 3);

/** All fields of a type named in `names`, a word each. */
const all = (type, names) => Object.fromEntries(names.split(' ').map((name) => [name, type]));

const fields = {
    mlrt_mesh: {
        ...all('uint32_t', 'struct_size id'), vertices: 'const void *', ...all('size_t', 'vertex_count vertex_stride'),
        indices: 'const void *', ...all('size_t', 'triangle_count triangle_stride'), ...all('uint32_t', 'index_size mask'),
    },
    mlrt_tree_options: {
        struct_size: 'uint32_t', preset: 'int32_t', ...all('float', 'traversal_cost intersection_cost'), message: 'void *',
        message_size: 'size_t', host: 'void *', memory_limit: 'uint64_t', pool: 'void *',
    },
    mlrt_kdtree_options: {
        struct_size: 'uint32_t', preset: 'int32_t', ...all('float', 'traversal_cost intersection_cost'), message: 'void *',
        message_size: 'size_t', host: 'void *', ...all('uint64_t', 'memory_limit max_references'),
        ...all('uint32_t', 'max_depth rules_off'), pool: 'void *',
    },
    mlrt_memory_estimate: { ...all('uint32_t', 'struct_size reserved'), ...all('uint64_t', 'memory_size peak_memory_size') },
    mlrt_tree_info: {
        ...all('uint32_t', 'struct_size depth'),
        ...all('uint64_t', 'triangle_count non_finite_count zero_area_count node_count leaf_count empty_leaf_count ' +
            'reference_count retracted_count memory_size peak_memory_size tree_hash'),
        ...all('double', 'sah_cost build_seconds'), ...all(float3, 'bounds_min bounds_max'),
        ...all('uint32_t', 'structure reserved'),
    },
    mlrt_load_options: {
        ...all('uint32_t', 'struct_size flags'), ...all('uint64_t', 'geometry_hash memory_limit'), message: 'void *',
        message_size: 'size_t', host: 'void *',
    },
    mlrt_pool_options: { ...all('uint32_t', 'struct_size thread_count'), ...all('void *', 'host user enqueue finish') },
    mlrt_counters: {
        ...all('uint32_t', 'struct_size reserved'),
        ...all('uint64_t', 'ray_count packet_count beam_count cell_count entry_point_cell_count triangle_test_count ' +
            'judged_lane_count entry_point_count entry_point_depth_sum missed_beam_count covered_beam_count ' +
            'undecided_cull_count undecided_checked_count lane_test_count undecided_test_count tie_lane_count ' +
            'exact_edge_count exact_range_count exact_order_count'),
    },
    mlrt_trace_options: {
        struct_size: 'uint32_t', ...all('int32_t', 'query method isa culling'),
        ...all('uint32_t', 'culling_check initial_tile_size minimum_tile_size split_factor outputs shortcuts_off mask'),
        ...all('void *', 'pool counters host lights'), ...all('uint32_t', 'light_count reserved'),
    },
    mlrt_hits: { ...all('uint32_t', 'struct_size reserved'), ...all(array, 't u v mesh triangle facing occluded') },
    mlrt_hit_lists: {
        ...all('uint32_t', 'struct_size capacity'), ...all(array, 't u v mesh triangle facing crossing total crossing_total'),
    },
    mlrt_rays: {
        ...all('uint32_t', 'struct_size row_length'), count: 'size_t',
        ...all(constArray, 'origins directions t_min t_max skip mask'), ...all('uint32_t', 'rays_per_origin reserved'),
    },
    mlrt_ray: {
        ...all('uint32_t', 'struct_size flags'), ...all(float3, 'origin direction'), ...all('float', 't_min t_max'),
        ...all('uint32_t', 'skip_mesh skip_triangle'),
    },
    mlrt_hit: {
        struct_size: 'uint32_t', ...all('float', 't u v'), ...all('uint32_t', 'mesh triangle'), facing: 'int32_t',
        occluded: 'uint32_t',
    },
    mlrt_camera: {
        struct_size: 'uint32_t', projection: 'int32_t', ...all('uint32_t', 'width height crop_x crop_y crop_width crop_height'),
        ...all(float3, 'eye direction d00 dx dy'), ...all('float', 'sample_x sample_y t_min t_max'),
    },
    mlrt_tile: { ...all('uint32_t', 'struct_size worker x y width height'), ...all('void *', 't u v mesh triangle facing occluded') },
    mlrt_light: { struct_size: 'uint32_t', kind: 'int32_t', position: float3 },
    mlrt_points: { ...all('uint32_t', 'struct_size row_length'), count: 'size_t', ...all(constArray, 'positions skip') },
};

const types = Object.fromEntries(Object.entries(fields).map(([name, members]) => [name, koffi.struct(name, members)]));
types.mlrt_array = array;
types.mlrt_const_array = constArray;

function zero(type) {
    if (type === float3) return [0, 0, 0];
    if (type === array || type === constArray) return { data: null, stride: 0, row_stride: 0 };
    return type.endsWith('*') ? null : 0;
}

/** A struct for a call: zero but for its size and what `members` says. */
function struct(name, members) {
    const zeros = Object.fromEntries(Object.entries(fields[name]).map(([field, type]) => [field, zero(type)]));
    return { ...zeros, struct_size: koffi.sizeof(types[name]), ...members };
}

// ---- the functions -------------------------------------------------------------------------------------------------

const library = load();
const declare = (text) => library.func(text);

const C = {
    version: declare('uint32_t mlrt_version()'),
    capabilities: declare('uint64_t mlrt_capabilities()'),
    structSizes: declare('void mlrt_struct_sizes(_Out_ uint32_t *sizes, uint32_t count)'),
    statusString: declare('const char *mlrt_status_string(int32_t status)'),
    lastMessage: declare('const char *mlrt_last_message()'),
    createPool: declare('int32_t mlrt_create_pool(uint32_t thread_count, _Out_ void **pool)'),
    poolThreadCount: declare('uint32_t mlrt_pool_thread_count(void *pool)'),
    destroyPool: declare('void mlrt_destroy_pool(void *pool)'),
    destroyTree: declare('void mlrt_destroy_tree(void *tree)'),
    getTreeInfo: declare('int32_t mlrt_get_tree_info(void *tree, _Inout_ mlrt_tree_info *info)'),
    estimateTree: declare('int32_t mlrt_estimate_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, _Inout_ mlrt_memory_estimate *estimate)'),
    estimateKdtree: declare('int32_t mlrt_estimate_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options, _Inout_ mlrt_memory_estimate *estimate)'),
    hashGeometry: declare('int32_t mlrt_hash_geometry(const mlrt_mesh *meshes, size_t mesh_count, _Out_ uint64_t *hash)'),
    traceRay: declare('int32_t mlrt_trace_ray(void *tree, const mlrt_ray *ray, const mlrt_trace_options *options, _Inout_ mlrt_hit *hit)'),
    cameraRays: declare('int32_t mlrt_camera_rays(const mlrt_camera *camera, const mlrt_array *origins, const mlrt_array *directions)'),
    shadowRay: declare('int32_t mlrt_shadow_ray(void *tree, const mlrt_ray *ray, const mlrt_hit *hit, const mlrt_light *light, _Inout_ mlrt_ray *shadow, _Out_ int32_t *faces)'),
    offsetPoint: declare('int32_t mlrt_offset_point(void *tree, uint32_t mesh, uint32_t triangle, float u, float v, int32_t side, float *point)'),
    // native.c
    watchSize: declare('uint32_t mlrt_node_watch_size()'),
    nextTile: declare('void *mlrt_node_next_tile(void *watch)'),
    freeTile: declare('void mlrt_node_free_tile(void *tile)'),
    buildTree: declare('int32_t mlrt_node_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, _Out_ void **tree, void *watch)'),
    buildKdtree: declare('int32_t mlrt_node_build_kdtree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_kdtree_options *options, _Out_ void **tree, void *watch)'),
    loadTree: declare('int32_t mlrt_node_load_tree(const void *data, size_t size, const mlrt_load_options *options, _Out_ void **tree, void *watch)'),
    saveTree: declare('int32_t mlrt_node_save_tree(void *tree, void *buffer, size_t capacity, _Out_ size_t *size, void *watch)'),
    tracePacket: declare('int32_t mlrt_node_trace_packet(void *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hits *hits, void *watch)'),
    traceAllHits: declare('int32_t mlrt_node_trace_all_hits(void *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hit_lists *lists, void *watch)'),
    renderTiles: declare('int32_t mlrt_node_render_tiles(void *tree, const mlrt_camera *camera, const mlrt_trace_options *options, const mlrt_hits *frame, int32_t tiles, void *watch)'),
    occludedPoints: declare('int32_t mlrt_node_occluded_points(void *tree, const mlrt_points *points, const mlrt_light *light, const mlrt_trace_options *options, const mlrt_array *occluded, void *watch)'),
};

// Of the version that this file was written for, each layout must be the library's.
if (C.version() === 100) {
    const sizes = new Uint32Array(places.length);
    C.structSizes(sizes, sizes.length);
    places.forEach((name, place) => {
        const type = types[`mlrt_${name}`];
        if (type && sizes[place] !== koffi.sizeof(type)) throw new Error(`mlrt: mlrt_${name} is not the library's`);
    });
}

module.exports = { C, koffi, struct, types };
