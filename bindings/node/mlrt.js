// SPDX-License-Identifier: MIT
/**
 * Where do rays hit triangles: the exact answers of libmlrt, for typed arrays.
 *
 *     const tree = new mlrt.Tree({ vertices, indices });               // Float32Array, Uint32Array
 *     const { t, mesh, triangle } = tree.trace(origins, directions);   // Float32Array of three per ray
 *     tree.close();                                                    // or leave it to the garbage collector
 *
 * Typed arrays go in and come out without a copy. trace and occluded block; traceAsync runs on a thread of Node's pool
 * meanwhile. The library is $MLRT_LIBRARY, or else what the system finds as libmlrt.so.0.
 */
'use strict';
const { promisify } = require('node:util');
const koffi = require('koffi');

const library = koffi.load(process.env.MLRT_LIBRARY || 'libmlrt.so.0');

// ---- the C interface: mlrt.h, as far as needed here ----------------------------------------------------------------

const constArray = koffi.struct({ data: 'const void *', stride: 'size_t' });
const array = koffi.struct({ data: 'void *', stride: 'size_t', row_stride: 'size_t' });
const structs = {
    mlrt_mesh: {
        struct_size: 'uint32_t', id: 'uint32_t', vertices: 'const void *', vertex_count: 'size_t',
        vertex_stride: 'size_t', indices: 'const void *', triangle_count: 'size_t', triangle_stride: 'size_t',
        index_size: 'uint32_t', mask: 'uint32_t',
    },
    mlrt_tree_options: {
        struct_size: 'uint32_t', preset: 'int32_t', traversal_cost: 'float', intersection_cost: 'float',
        message: 'void *', message_size: 'size_t', host: 'void *', memory_limit: 'uint64_t', pool: 'void *',
    },
    mlrt_rays: {
        struct_size: 'uint32_t', row_length: 'uint32_t', count: 'size_t', origins: constArray, directions: constArray,
        t_min: constArray, t_max: constArray, skip: constArray, mask: constArray,
        rays_per_origin: 'uint32_t', reserved: 'uint32_t',
    },
    mlrt_hits: {
        struct_size: 'uint32_t', reserved: 'uint32_t', t: array, u: array, v: array, mesh: array, triangle: array,
        facing: array, occluded: array,
    },
    mlrt_trace_options: {
        struct_size: 'uint32_t', query: 'int32_t', method: 'int32_t', isa: 'int32_t', culling: 'int32_t',
        culling_check: 'uint32_t', initial_tile_size: 'uint32_t', minimum_tile_size: 'uint32_t',
        split_factor: 'uint32_t', outputs: 'uint32_t', shortcuts_off: 'uint32_t', mask: 'uint32_t', pool: 'void *',
        counters: 'void *', host: 'void *', lights: 'const void *', light_count: 'uint32_t', reserved: 'uint32_t',
    },
};
const types = Object.fromEntries(Object.entries(structs).map(([name, fields]) => [name, koffi.struct(name, fields)]));

const C = {
    version: library.func('uint32_t mlrt_version()'),
    structSizes: library.func('void mlrt_struct_sizes(_Out_ uint32_t *sizes, uint32_t count)'),
    statusString: library.func('const char *mlrt_status_string(int32_t status)'),
    createPool: library.func('int32_t mlrt_create_pool(uint32_t thread_count, _Out_ void **pool)'),
    destroyPool: library.func('void mlrt_destroy_pool(void *pool)'),
    build: library.func('int32_t mlrt_build_tree(const mlrt_mesh *meshes, size_t mesh_count, const mlrt_tree_options *options, _Out_ void **tree)'),
    destroyTree: library.func('void mlrt_destroy_tree(void *tree)'),
    trace: library.func('int32_t mlrt_trace_packet(void *tree, const mlrt_rays *rays, const mlrt_trace_options *options, const mlrt_hits *hits)'),
};

// Of the version that this file was written for, each layout must be the library's. The numbers are MLRT_STRUCT_*.
const places = { mlrt_mesh: 1, mlrt_tree_options: 2, mlrt_trace_options: 8, mlrt_hits: 10, mlrt_rays: 12 };
if (C.version() === 100) {
    const sizes = new Uint32Array(13);
    C.structSizes(sizes, sizes.length);
    for (const [name, place] of Object.entries(places)) {
        if (sizes[place] !== koffi.sizeof(types[name])) throw new Error(`mlrt: ${name} is not the library's`);
    }
}

/** A struct for a call: zero but for its size and what `fields` says. */
function struct(name, fields) {
    const zero = (type) => typeof type !== 'string' ? { data: null, stride: 0, row_stride: 0 } : type.endsWith('*') ? null : 0;
    const all = Object.entries(structs[name]).map(([field, type]) => [field, zero(type)]);
    return { ...Object.fromEntries(all), struct_size: koffi.sizeof(types[name]), ...fields };
}

const at = (data) => ({ data, stride: 0, row_stride: 0 });

// ---- errors --------------------------------------------------------------------------------------------------------

/** What the library says went wrong; `status` is MLRT_ERROR_*. */
class MlrtError extends Error {
    constructor(status, details = '') {
        super(C.statusString(status) + (details && `: ${details}`));
        this.name = 'MlrtError';
        this.status = status;
    }
}

function check(status, details) {
    if (status !== 0) throw new MlrtError(status, details);
}

function typed(value, type, name) {
    if (!(value instanceof type)) throw new TypeError(`${name}: a ${type.name} is needed`);
    if (value.length % 3) throw new RangeError(`${name}: three numbers each are needed`);
    return value;
}

// ---- handles -------------------------------------------------------------------------------------------------------

const forgotten = new FinalizationRegistry(([destroy, handle]) => destroy(handle));

/** What a Tree and a Pool have in common: freed by close(), or some time after the last use. */
class Handle {
    #destroy;
    #handle;
    #calls = 0; // that run on other threads

    constructor(destroy, handle) {
        this.#destroy = destroy;
        this.#handle = handle;
        forgotten.register(this, [destroy, handle], this);
    }

    /** For this library's own calls. */
    get handle() {
        if (this.#handle === null) throw new Error(`the ${this.constructor.name} is closed`);
        return this.#handle;
    }

    /** Counts calls that must end before close(). */
    hold(calls) {
        this.#calls += calls;
    }

    /** Frees it now. Again does nothing. */
    close() {
        if (this.#calls) throw new Error(`the ${this.constructor.name} is in use by traceAsync`);
        if (this.#handle === null) return;
        forgotten.unregister(this);
        this.#destroy(this.#handle);
        this.#handle = null;
    }
}
if (Symbol.dispose) Handle.prototype[Symbol.dispose] = Handle.prototype.close;

/** Threads that calls share their work with: `threads` at work, the calling one included; 0 = one per processor. */
class Pool extends Handle {
    constructor(threads = 0) {
        const out = [null];
        check(C.createPool(threads, out));
        super(C.destroyPool, out[0]);
    }
}

/** Triangles, and what finds them. Never changes. */
class Tree extends Handle {
    /** Meshes { vertices: Float32Array, indices: Uint32Array, id }; all ids 0 or missing become 0, 1, 2, ... */
    constructor(...meshes) {
        const list = meshes.map(({ vertices, indices, id = 0 }) => struct('mlrt_mesh', {
            id,
            vertices: typed(vertices, Float32Array, 'vertices'),
            vertex_count: vertices.length / 3,
            indices: typed(indices, Uint32Array, 'indices'),
            triangle_count: indices.length / 3,
        }));
        const out = [null], message = Buffer.alloc(256);
        const options = struct('mlrt_tree_options', { message, message_size: message.length });
        const status = C.build(list, list.length, options, out);
        check(status, message.toString('utf8', 0, message.indexOf(0)));
        super(C.destroyTree, out[0]);
    }

    /** The arguments of a call, without the tree. */
    #call(origins, directions, query, pool, out) {
        typed(origins, Float32Array, 'origins');
        typed(directions, Float32Array, 'directions');
        if (origins.length !== directions.length) throw new RangeError('as many origins as directions are needed');
        return [
            struct('mlrt_rays', { count: origins.length / 3, origins: at(origins), directions: at(directions) }),
            struct('mlrt_trace_options', { query, pool: pool ? pool.handle : null }),
            struct('mlrt_hits', Object.fromEntries(Object.entries(out).map(([name, data]) => [name, at(data)]))),
        ];
    }

    static #hits(count) {
        return {
            t: new Float32Array(count), u: new Float32Array(count), v: new Float32Array(count),
            mesh: new Uint32Array(count), triangle: new Uint32Array(count), facing: new Int32Array(count),
        };
    }

    /** The closest hits { t, u, v, mesh, triangle, facing }, a number per ray; a miss has mesh = triangle = NONE. */
    trace(origins, directions, { pool } = {}) {
        const hits = Tree.#hits(origins.length / 3);
        check(C.trace(this.handle, ...this.#call(origins, directions, 0, pool, hits)));
        return hits;
    }

    /** The same as a promise. Leave the arrays alone until it is settled. */
    async traceAsync(origins, directions, { pool } = {}) {
        const hits = Tree.#hits(origins.length / 3);
        const call = [this.handle, ...this.#call(origins, directions, 0, pool, hits)];
        const used = [this, pool].filter(Boolean);
        used.forEach((object) => object.hold(1));
        try {
            check(await promisify(C.trace.async)(...call));
        } finally {
            used.forEach((object) => object.hold(-1));
            call.length = 0; // the arrays in it had to be reachable until now
        }
        return hits;
    }

    /** 1 for each ray that hits anything, else 0: a Uint8Array. */
    occluded(origins, directions, { pool } = {}) {
        const occluded = new Uint8Array(origins.length / 3);
        check(C.trace(this.handle, ...this.#call(origins, directions, 1, pool, { occluded })));
        return occluded;
    }
}

// `library` and `types` are for declaring more of mlrt.h with koffi.
module.exports = { Tree, Pool, MlrtError, NONE: 0xFFFFFFFF, library, types };
