// SPDX-License-Identifier: MIT
/**
 * Where do rays hit triangles: the exact answers of libmlrt, for typed arrays.
 *
 *     const tree = await mlrt.Tree.build({ vertices, indices });               // Float32Array, Uint32Array
 *     const { t, mesh, triangle } = await tree.trace({ origins, directions }); // Float32Array of three per ray
 *     tree.close();                                                            // or leave it to the garbage collector
 *
 * Typed arrays go in and come out without a copy. Functions that return promises run on a thread of Node's pool; leave
 * their arrays alone until the promise is settled. Each has a twin `...Sync`, which blocks. index.d.ts describes all
 * arguments and results.
 */
'use strict';
const { promisify } = require('node:util');
const { C, koffi, struct, types } = require('./native.js');

const NONE = 0xFFFFFFFF;

const METHODS = ['default', 'ray', 'packet2', 'packet4', 'multilevel', 'tile'];
const ISAS = ['auto', 'scalar', 'sse', 'avx2', 'avx512', 'neon'];
const CULLINGS = ['inverse', 'direct'];
const PROJECTIONS = ['pinhole', 'parallel'];
const LIGHTS = ['point', 'directional'];
const PRESETS = ['default', 'fast', 'best'];
const KDTREE_PRESETS = ['paper', 'tuned'];
const STRUCTURES = ['', 'kdtree', 'bvh'];
const RULE = { EMPTY_SPACE: 1, COPLANAR: 2, MINIMUM_CELL: 4, CLIPPED_SPLITS: 8, RETRACTION: 16 };
const SHORTCUT = { WHOLE_TILES: 1, ENTRY_LISTS: 2, SHARED_SETUPS: 4 };
const STATUS = {
    OK: 0, ARGUMENT: 1, STRUCT_SIZE: 2, INDEX_RANGE: 3, OUT_OF_MEMORY: 4, TOO_LARGE: 5, CAMERA: 6, UNSUPPORTED: 7, THREAD: 8,
    CANCELLED: 9, DATA: 10,
};
const OUTPUT_OF_TILE = { t: 1, u: 2, v: 2, mesh: 4, triangle: 16, facing: 8, occluded: 32 };

// ---- errors --------------------------------------------------------------------------------------------------------

/** What the library says went wrong: `status` is one of STATUS, `code` its name. */
class MlrtError extends Error {
    constructor(status, reason) {
        super(reason || C.statusString(status));
        this.name = 'MlrtError';
        this.status = status;
        this.code = Object.keys(STATUS).find((name) => STATUS[name] === status) ?? 'UNKNOWN';
    }
}

/** For calls on this thread. */
function check(status) {
    if (status !== 0) throw new MlrtError(status, C.lastMessage());
}

// ---- arguments -----------------------------------------------------------------------------------------------------

/** The number of a name in a list. */
function choose(names, value, what) {
    if (value === undefined) return 0;
    const number = names.indexOf(value);
    if (number < 0) throw new RangeError(`${what}: ${value} is not one of ${names.filter(Boolean).join(', ')}`);
    return number;
}

function whole(value, what, fallback = 0) {
    if (value === undefined) return fallback;
    if (!Number.isInteger(value) || value < 0 || value > NONE) throw new RangeError(`${what}: ${value} is not a whole number, 0..2^32 - 1`);
    return value;
}

function number(value, what, fallback = 0) {
    if (value === undefined) return fallback;
    if (typeof value !== 'number') throw new TypeError(`${what}: a number is needed`);
    return value;
}

/** The mesh and the triangle of a hit, or of what a ray skips. They have no default. */
function idsOf(hit, what) {
    return ['mesh', 'triangle'].map((name) => whole(hit[name] ?? NaN, `${what}.${name}`));
}

/** A uint64_t. Koffi takes the low 64 bits of a longer one, and ends the process where it is of another type. */
function long(value, what) {
    if (value === undefined) return 0;
    if (typeof value === 'bigint' ? value !== BigInt.asUintN(64, value) : !Number.isSafeInteger(value) || value < 0) {
        throw new RangeError(`${what}: ${String(value)} is not a whole number, 0..2^64 - 1`);
    }
    return value;
}

function vector(value, what) {
    const list = Array.from(value ?? []);
    if (list.length !== 3 || !list.every((x) => typeof x === 'number')) throw new TypeError(`${what}: three numbers are needed`);
    return list;
}

/** What an object of this library has for its calls; null without one. Any other's would be a pointer to something else. */
function partOf(object, type, part, what) {
    if (object === undefined || object === null) return null;
    if (!(object instanceof type)) throw new TypeError(`${what}: a ${type.name} is needed`);
    return object[part];
}

const STRIDE_ALL = koffi.sizeof('size_t') === 8 ? 0xFFFFFFFFFFFFFFFFn : 0xFFFFFFFF;
const NOT_GIVEN = { data: null, stride: 0, row_stride: 0 };

/** Where the elements of an array of a call lie: by its struct for the call. */
const places = new WeakMap();

/** Returns the struct, whose `count` elements of `size` bytes lie `step` bytes apart, and remembers where. */
function placed(struct, array, count, step, size) {
    const whole = step === size; // without gaps: like one element
    const elements = whole ? { count: 1, size: count * size } : { count, size };
    places.set(struct, { buffer: array.buffer, start: array.byteOffset, step, ...elements });
    return struct;
}

/** Whether two arrays have bytes in common. Of different strides with gaps it is not known: then false. */
function meet(a, b) {
    if (a.buffer !== b.buffer || a.count * b.count === 0 || a.size * b.size === 0) return false;
    if (a.count > 1 && b.count > 1 && a.step !== b.step) return false;
    const step = a.count > 1 ? a.step : b.step, distance = b.start - a.start;
    // The first of b's elements, seen from one of a's, that ends behind its begin: does it begin before its end?
    const k = Math.max(1 - a.count, Math.floor((-b.size - distance) / step) + 1);
    return k < b.count && distance + k * step < a.size;
}

/** Throws if an array for results has bytes in common with another one, or with one that the call reads. */
function keepApart(written, read) {
    const arrays = [...Object.entries(written), ...Object.entries(read)].filter(([, struct]) => places.has(struct));
    Object.values(written).forEach((struct, i) => {
        const other = arrays.slice(i + 1).find(([, other]) => meet(places.get(struct), places.get(other)));
        if (other) throw new RangeError(`into.${arrays[i][0]}: it shares memory with ${other[0]}`);
    });
}

/** Throws unless `last` elements of `stride` bytes and one of `size` bytes lie in the array. */
function fits(data, last, stride, size, what) {
    if (last >= 0 && last * stride + size > data.byteLength) {
        throw new RangeError(`${what}: ${data.byteLength} bytes are too few, ${last * stride + size} are needed`);
    }
}

/**
 * An input of `count` elements, `width` numbers each: a typed array, { data, stride }, or one element for all, which is
 * a number or a plain array.
 */
function input(value, type, width, count, what) {
    if (value === undefined || value === null) return NOT_GIVEN;
    if (typeof value === 'number') value = [value];
    if (Array.isArray(value)) {
        if (value.length !== width) throw new RangeError(`${what}: ${width} numbers are one element for all, not ${value.length}`);
        for (const x of value) { // undefined, too, where nothing is
            if (typeof x !== 'number') throw new TypeError(`${what}: a number is needed, not ${String(x)}`);
            if (type === Uint32Array) whole(x, what);
        }
        return { data: type.from(value), stride: STRIDE_ALL, row_stride: 0 };
    }
    const data = value instanceof type ? value : value.data;
    if (!(data instanceof type)) throw new TypeError(`${what}: a ${type.name} is needed`);
    const size = width * type.BYTES_PER_ELEMENT;
    if (value === data) {
        if (data.length !== count * width) throw new RangeError(`${what}: ${data.length} numbers, but ${count * width} are needed`);
        return placed({ data, stride: 0, row_stride: 0 }, data, count, size, size);
    }
    const given = value.stride; // which may be another one when it is read again
    const stride = given === 'all' ? STRIDE_ALL : whole(given, `${what}.stride`, size);
    const elements = given === 'all' ? 1 : count, step = given === 'all' ? size : stride || size;
    fits(data, elements - 1, step, size, what);
    return placed({ data, stride, row_stride: 0 }, data, elements, step, size);
}

/** How many elements a packed input has; undefined if it does not tell. */
function countOf(value, width) {
    return ArrayBuffer.isView(value) ? Math.floor(value.length / width) : undefined;
}

/** An array for results: a typed array or { data, stride, rowStride }. A list is one row of `columns`. */
function output(value, type, columns, rows, what) {
    const data = value instanceof type ? value : value.data;
    if (!(data instanceof type)) throw new TypeError(`${what}: a ${type.name} is needed`);
    const size = type.BYTES_PER_ELEMENT;
    const stride = whole(value === data ? 0 : value.stride, `${what}.stride`);
    const row = whole(value === data ? 0 : value.rowStride, `${what}.rowStride`);
    const step = stride || size, rowStep = row || step * columns;
    if (columns > 0 && rows > 0) fits(data, 1, (rows - 1) * rowStep + (columns - 1) * step, size, what);
    // Koffi passes an empty array as NULL, which would mean that it is not wanted.
    const member = { data: data.length > 0 ? data : new type(1), stride, row_stride: row };
    // Rows with gaps between them count as one element each, if they have none within.
    const rowSize = columns * step;
    if (rows < 2 || rowStep === rowSize) return placed(member, data, columns * rows, step, size);
    return placed(member, data, step === size ? rows : 0, rowStep, rowSize);
}

const RESULTS = {
    t: Float32Array, u: Float32Array, v: Float32Array, mesh: Uint32Array, triangle: Uint32Array, facing: Int32Array,
    occluded: Uint8Array, crossing: Uint8Array, total: Uint32Array, crossingTotal: Uint32Array,
};
const CLOSEST = ['t', 'u', 'v', 'mesh', 'triangle', 'facing'];

/** Makes or checks the arrays for results; `length(name)` is [columns, rows]. Returns them, and as fields of a struct. */
function results({ outputs, into = {} }, allowed, wanted, length) {
    const names = outputs ?? (Object.keys(into).length ? Object.keys(into) : wanted);
    const arrays = {}, members = {};
    for (const name of new Set([...names, ...Object.keys(into)])) {
        if (!allowed.includes(name)) throw new RangeError(`outputs: ${name} is not one of ${allowed.join(', ')}`);
        const [columns, rows] = length(name);
        arrays[name] = into[name] ?? new RESULTS[name](columns * rows);
        members[name === 'crossingTotal' ? 'crossing_total' : name] = output(arrays[name], RESULTS[name], columns, rows, `into.${name}`);
    }
    return { arrays, members };
}

function meshStruct({ vertices, indices, id, mask, vertexStride, vertexCount, triangleStride, triangleCount }, place) {
    const what = `meshes[${place}]`;
    if (!(vertices instanceof Float32Array)) throw new TypeError(`${what}.vertices: a Float32Array is needed`);
    if (indices !== undefined && !(indices instanceof Uint32Array || indices instanceof Uint16Array)) {
        throw new TypeError(`${what}.indices: a Uint32Array or a Uint16Array is needed`);
    }
    const elements = (array, stride, given, size, name) => {
        if (stride === undefined && given === undefined && array.byteLength % size) {
            throw new RangeError(`${what}.${name}: ${array.length} numbers are not three each`);
        }
        const step = whole(stride, `${what}.${name}, stride`) || size;
        const count = given !== undefined ? whole(given, `${what}.${name}, count`) : Math.max(0, Math.floor((array.byteLength - size) / step) + 1);
        fits(array, count - 1, step, size, `${what}.${name}`);
        return count;
    };
    const indexSize = indices?.BYTES_PER_ELEMENT ?? 0;
    const vertex_count = elements(vertices, vertexStride, vertexCount, 12, 'vertices');
    return struct('mlrt_mesh', {
        id: whole(id, `${what}.id`), mask: whole(mask, `${what}.mask`), vertices, vertex_count, vertex_stride: whole(vertexStride),
        indices: indices ?? null, index_size: indexSize, triangle_stride: whole(triangleStride, `${what}.triangleStride`),
        triangle_count: indices ? elements(indices, triangleStride, triangleCount, 3 * indexSize, 'indices')
            : whole(triangleCount, `${what}.triangleCount`, Math.floor(vertex_count / 3)),
    });
}

const meshStructs = (meshes) => (Array.isArray(meshes) ? meshes : [meshes]).map(meshStruct);

function treeOptions({ preset, traversalCost, intersectionCost, memoryLimit, pool }) {
    return struct('mlrt_tree_options', {
        preset: choose(PRESETS, preset, 'options.preset'), traversal_cost: number(traversalCost, 'options.traversalCost'),
        intersection_cost: number(intersectionCost, 'options.intersectionCost'),
        memory_limit: long(memoryLimit, 'options.memoryLimit'), pool: partOf(pool, Pool, 'handle', 'options.pool'),
    });
}

function kdtreeOptions({ preset, traversalCost, intersectionCost, memoryLimit, maxReferences, maxDepth, rulesOff, pool }) {
    return struct('mlrt_kdtree_options', {
        preset: choose(KDTREE_PRESETS, preset, 'options.preset'), traversal_cost: number(traversalCost, 'options.traversalCost'),
        intersection_cost: number(intersectionCost, 'options.intersectionCost'),
        memory_limit: long(memoryLimit, 'options.memoryLimit'),
        max_references: long(maxReferences, 'options.maxReferences'),
        max_depth: whole(maxDepth, 'options.maxDepth'), rules_off: whole(rulesOff, 'options.rulesOff'),
        pool: partOf(pool, Pool, 'handle', 'options.pool'),
    });
}

function lightStruct({ kind, position }, what) {
    return struct('mlrt_light', { kind: choose(LIGHTS, kind, `${what}.kind`), position: vector(position, `${what}.position`) });
}

function lightsMemory(lights) {
    if (!lights || lights.length === 0) return null;
    const size = koffi.sizeof(types.mlrt_light), memory = new Uint8Array(size * lights.length);
    lights.forEach((light, i) => koffi.encode(memory, i * size, types.mlrt_light, lightStruct(light, `lights[${i}]`)));
    return memory;
}

function traceOptions(options, query, tileOutputs = 0) {
    const { method, isa, culling, cullingCheck, initialTileSize, minimumTileSize, splitFactor, shortcutsOff, mask, pool, counters, lights } = options;
    return struct('mlrt_trace_options', {
        query, method: choose(METHODS, method, 'options.method'), isa: choose(ISAS, isa, 'options.isa'),
        culling: choose(CULLINGS, culling, 'options.culling'), culling_check: cullingCheck ? 1 : 0,
        initial_tile_size: whole(initialTileSize, 'options.initialTileSize'),
        minimum_tile_size: whole(minimumTileSize, 'options.minimumTileSize'),
        split_factor: whole(splitFactor, 'options.splitFactor'), outputs: tileOutputs,
        shortcuts_off: whole(shortcutsOff, 'options.shortcutsOff'), mask: whole(mask, 'options.mask'),
        pool: partOf(pool, Pool, 'handle', 'options.pool'), counters: partOf(counters, Counters, 'memory', 'options.counters'),
        lights: lightsMemory(lights), light_count: lights?.length ?? 0,
    });
}

/** The number of rays: as given, or that of an array of them which tells its own. */
function rayCount({ origins, directions, tMax, mask, count }, raysPerOrigin) {
    const found = count ?? countOf(directions, 3) ?? countOf(tMax, 1) ?? countOf(mask, 1);
    if (found !== undefined) return whole(found, 'rays.count');
    const groups = countOf(origins, 3);
    if (groups === undefined) throw new TypeError('rays.count: it is needed, since no array of rays is a typed array without a stride');
    return groups * raysPerOrigin;
}

function raysStruct(given) {
    const { origins, directions, tMin, tMax, skip, mask, raysPerOrigin, rowLength } = given;
    const k = whole(raysPerOrigin, 'rays.raysPerOrigin') || 1;
    const rays = rayCount(given, k);
    const groups = Math.floor(rays / k);
    return struct('mlrt_rays', {
        row_length: whole(rowLength, 'rays.rowLength'), count: rays, rays_per_origin: k,
        origins: input(origins, Float32Array, 3, groups, 'rays.origins'),
        directions: input(directions, Float32Array, 3, rays, 'rays.directions'),
        t_min: input(tMin, Float32Array, 1, groups, 'rays.tMin'), t_max: input(tMax, Float32Array, 1, rays, 'rays.tMax'),
        skip: input(skip, Uint32Array, 2, groups, 'rays.skip'), mask: input(mask, Uint32Array, 1, rays, 'rays.mask'),
    });
}

function rayStruct({ origin, direction, tMin, tMax, skip }) {
    const ids = skip ? idsOf(skip, 'ray.skip') : [0, 0];
    return struct('mlrt_ray', {
        origin: vector(origin, 'ray.origin'), direction: vector(direction, 'ray.direction'), flags: skip ? 1 : 0,
        t_min: number(tMin, 'ray.tMin'), t_max: number(tMax, 'ray.tMax'),
        skip_mesh: ids[0], skip_triangle: ids[1],
    });
}

const ZERO = [0, 0, 0];

function cameraStruct(camera) {
    const { projection, width, height, crop = {}, sample = [0.5, 0.5], tMin, tMax } = camera;
    const { eye = ZERO, direction = ZERO, d00 = ZERO, dx = ZERO, dy = ZERO } = camera;
    return struct('mlrt_camera', {
        projection: choose(PROJECTIONS, projection, 'camera.projection'), width: whole(width, 'camera.width'),
        height: whole(height, 'camera.height'), crop_x: whole(crop.x, 'camera.crop.x'), crop_y: whole(crop.y, 'camera.crop.y'),
        crop_width: whole(crop.width, 'camera.crop.width'), crop_height: whole(crop.height, 'camera.crop.height'),
        eye: vector(eye, 'camera.eye'), direction: vector(direction, 'camera.direction'), d00: vector(d00, 'camera.d00'),
        dx: vector(dx, 'camera.dx'), dy: vector(dy, 'camera.dy'), sample_x: number(sample[0], 'camera.sample'),
        sample_y: number(sample[1], 'camera.sample'), t_min: number(tMin, 'camera.tMin'), t_max: number(tMax, 'camera.tMax'),
    });
}

/** Columns and rows that a camera renders. */
function frameSize({ width, height, crop_x, crop_y, crop_width, crop_height }) {
    return [crop_width || Math.max(0, width - crop_x), crop_height || Math.max(0, height - crop_y)];
}

// ---- calls ---------------------------------------------------------------------------------------------------------

const MESSAGE = 16, LOG = MESSAGE + 512; // places in `struct watch` of native.c
const LEVELS = ['error', 'warning', 'info'];
const POLL_MS = 10;

/** The memory that a call and JavaScript share: `struct watch` of native.c. */
class Watch {
    memory = new Uint8Array(C.watchSize());
    #words = new Int32Array(this.memory.buffer, 0, 4);

    get progress() {
        return Atomics.load(this.#words, 0) / 2 ** 30;
    }

    cancel() {
        Atomics.store(this.#words, 1, 1);
    }

    /** Why the call failed. */
    get message() {
        const text = Buffer.from(this.memory.buffer, MESSAGE, LOG - MESSAGE);
        return text.toString('utf8', 0, text.indexOf(0));
    }

    /** Hands the tiles that wait to a function, until it returns false or throws. Returns whether it did neither. */
    deliver(onTile) {
        for (let tile; (tile = C.nextTile(this.memory)) !== null;) {
            try {
                if (onTile(copyTile(koffi.decode(tile, types.mlrt_tile))) === false) return false;
            } finally {
                C.freeTile(tile);
            }
        }
        return true;
    }

    /** Frees the tiles that wait. */
    drop() {
        for (let tile; (tile = C.nextTile(this.memory)) !== null;) C.freeTile(tile);
    }

    /** Hands the lines that the call logged to a function. */
    report(onLog) {
        const text = Buffer.from(this.memory.buffer, LOG).toString('utf8', 0, this.#words[2]);
        for (const line of text.split('\n').slice(0, -1)) onLog(LEVELS[line[0]] ?? 'info', line.slice(1));
    }
}

function finish(status, watch, { onLog }) {
    if (onLog) watch.report(onLog);
    if (status !== 0) throw new MlrtError(status, watch.message);
}

/** Those of the calls that run on other threads. Node waits for them before it ends, so then they are cancelled. */
const running = new Set();
process.on('exit', () => running.forEach((watch) => watch.cancel()));

/** Calls a function of native.c, which blocks. */
function callSync(native, args, options) {
    for (const name of ['signal', 'onProgress', 'onTile']) {
        if (options[name]) throw new TypeError(`options.${name}: only calls that return a promise have it, since this one blocks`);
    }
    const watch = new Watch();
    finish(native(...args, watch.memory), watch, options);
}

/** The same on a thread of Node's pool. `used`: objects that must not be closed until it ends. `onTile` is of renders. */
async function callAsync(native, args, options, used = [], onTile = undefined) {
    const { signal, onProgress } = options;
    signal?.throwIfAborted();
    const watch = new Watch();
    const cancel = () => watch.cancel();
    let thrown, stopped = false; // by a callback
    const report = () => {
        if (thrown || stopped) return;
        try {
            if (onTile && !watch.deliver(onTile)) stopped = true;
            else onProgress?.(watch.progress);
        } catch (error) {
            thrown = { error };
        }
        if (thrown || stopped) cancel();
    };
    const timer = (onProgress || onTile) && setInterval(report, POLL_MS);
    signal?.addEventListener('abort', cancel, { once: true });
    used.forEach((object) => object.hold(1));
    running.add(watch);
    try {
        const status = await promisify(native.async)(...args, watch.memory);
        clearInterval(timer);
        if (onTile && status === 0) report(); // the last tiles
        if (thrown) throw thrown.error; // also of a call that had ended before it could be cancelled
        if (status === STATUS.CANCELLED && signal?.aborted) throw signal.reason;
        finish(stopped ? STATUS.CANCELLED : status, watch, options);
    } finally {
        clearInterval(timer);
        signal?.removeEventListener('abort', cancel);
        used.forEach((object) => object.hold(-1));
        running.delete(watch);
        if (onTile) watch.drop();
        args.length = 0; // the arrays in it had to be reachable until now
    }
    if (onProgress) onProgress(1);
}

const usedBy = (tree, { pool }) => [tree, pool].filter(Boolean);

// ---- handles -------------------------------------------------------------------------------------------------------

const forgotten = new FinalizationRegistry(([destroy, handle]) => destroy(handle));

/** What a Tree and a Pool have in common: freed by close(), or some time after the last use. */
class Handle {
    #destroy;
    #handle;
    #calls = 0; // that run on other threads

    /** `kept` stays reachable as long as the handle lives. */
    constructor(destroy, handle, kept) {
        this.#destroy = destroy;
        this.#handle = handle;
        forgotten.register(this, [destroy, handle, kept], this);
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
        if (this.#calls) throw new Error(`the ${this.constructor.name} is in use by a call: await its promise before close()`);
        if (this.#handle === null) return;
        forgotten.unregister(this);
        this.#destroy(this.#handle);
        this.#handle = null;
    }
}
if (Symbol.dispose) Handle.prototype[Symbol.dispose] = Handle.prototype.close;

/** Threads that calls share their work with: `threads` at work, the calling one included; 0 = one per processor. */
class Pool extends Handle {
    #threads;

    constructor(threads = 0) {
        const out = [null];
        check(C.createPool(whole(threads, 'threads'), out));
        super(C.destroyPool, out[0]);
        this.#threads = C.poolThreadCount(out[0]);
    }

    /** How many threads are at work, the calling one included; also after close(). */
    get threads() {
        return this.#threads;
    }
}

// ---- trees ---------------------------------------------------------------------------------------------------------

/** What constructs a Tree; only this file has it. */
const MADE = Symbol('made');

/** Triangles, and what finds them. Never changes. Made by Tree.build, Tree.buildKdtree and Tree.load. */
class Tree extends Handle {
    constructor(made, handle, kept) {
        if (made !== MADE) throw new TypeError('trees are made by Tree.build, Tree.buildKdtree or Tree.load');
        super(C.destroyTree, handle, kept);
    }

    /** Its handle; throws where `this` is something else that has one. */
    get #tree() {
        return this.handle;
    }

    static #builds(meshes, options) {
        const list = meshStructs(meshes), out = [null];
        return { native: C.buildTree, args: [list, list.length, treeOptions(options), out], out };
    }

    static #buildsKdtree(meshes, options) {
        const list = meshStructs(meshes), out = [null];
        return { native: C.buildKdtree, args: [list, list.length, kdtreeOptions(options), out], out };
    }

    static #loads(data, { inPlace, geometryHash, memoryLimit }) {
        if (!(data instanceof Uint8Array)) throw new TypeError('data: a Uint8Array is needed');
        const settings = struct('mlrt_load_options', {
            flags: inPlace ? 1 : 0, geometry_hash: long(geometryHash, 'options.geometryHash'),
            memory_limit: long(memoryLimit, 'options.memoryLimit'),
        });
        const out = [null];
        return { native: C.loadTree, args: [data, data.length, settings, out], out, kept: inPlace ? data : null };
    }

    static #madeSync({ native, args, out, kept }, options) {
        try {
            callSync(native, args, options);
        } catch (error) {
            C.destroyTree(out[0]); // NULL unless onLog has thrown
            throw error;
        }
        return new Tree(MADE, out[0], kept);
    }

    static async #made({ native, args, out, kept }, options) {
        try {
            await callAsync(native, args, options, options.pool ? [options.pool] : []);
        } catch (error) {
            C.destroyTree(out[0]); // NULL unless onLog or onProgress has thrown
            throw error;
        }
        return new Tree(MADE, out[0], kept);
    }

    static buildSync(meshes, options = {}) {
        return Tree.#madeSync(Tree.#builds(meshes, options), options);
    }

    static async build(meshes, options = {}) {
        return Tree.#made(Tree.#builds(meshes, options), options);
    }

    static buildKdtreeSync(meshes, options = {}) {
        return Tree.#madeSync(Tree.#buildsKdtree(meshes, options), options);
    }

    static async buildKdtree(meshes, options = {}) {
        return Tree.#made(Tree.#buildsKdtree(meshes, options), options);
    }

    static loadSync(data, options = {}) {
        return Tree.#madeSync(Tree.#loads(data, options), options);
    }

    static async load(data, options = {}) {
        return Tree.#made(Tree.#loads(data, options), options);
    }

    #savedSize() {
        const size = [0];
        check(C.saveTree(this.#tree, null, 0, size, new Watch().memory));
        return Number(size[0]);
    }

    saveSync() {
        const data = new Uint8Array(this.#savedSize());
        callSync(C.saveTree, [this.#tree, data, data.length, [0]], {});
        return data;
    }

    async save() {
        const data = new Uint8Array(this.#savedSize());
        await callAsync(C.saveTree, [this.#tree, data, data.length, [0]], {}, [this]);
        return data;
    }

    info() {
        const info = struct('mlrt_tree_info', {});
        check(C.getTreeInfo(this.#tree, info));
        return {
            structure: STRUCTURES[info.structure], depth: info.depth, triangleCount: Number(info.triangle_count),
            nonFiniteCount: Number(info.non_finite_count), zeroAreaCount: Number(info.zero_area_count),
            nodeCount: Number(info.node_count), leafCount: Number(info.leaf_count),
            emptyLeafCount: Number(info.empty_leaf_count), referenceCount: Number(info.reference_count),
            retractedCount: Number(info.retracted_count), memorySize: Number(info.memory_size),
            peakMemorySize: Number(info.peak_memory_size), treeHash: BigInt(info.tree_hash), sahCost: info.sah_cost,
            buildSeconds: info.build_seconds, boundsMin: [...info.bounds_min], boundsMax: [...info.bounds_max],
        };
    }

    #traces(rays, options) {
        const list = raysStruct(rays);
        const { arrays, members } = results(options, CLOSEST, CLOSEST, () => [list.count, 1]);
        keepApart(members, list);
        return { args: [this.#tree, list, traceOptions(options, 0), struct('mlrt_hits', members)], arrays };
    }

    traceSync(rays, options = {}) {
        const { args, arrays } = this.#traces(rays, options);
        callSync(C.tracePacket, args, options);
        return arrays;
    }

    async trace(rays, options = {}) {
        const { args, arrays } = this.#traces(rays, options);
        await callAsync(C.tracePacket, args, options, usedBy(this, options));
        return arrays;
    }

    #asksAny(rays, options) {
        const list = raysStruct(rays);
        const { arrays, members } = results(options, ['occluded'], ['occluded'], () => [list.count, 1]);
        keepApart(members, list);
        return { args: [this.#tree, list, traceOptions(options, 1), struct('mlrt_hits', members)], arrays };
    }

    occludedSync(rays, options = {}) {
        const { args, arrays } = this.#asksAny(rays, options);
        callSync(C.tracePacket, args, options);
        return arrays.occluded;
    }

    async occluded(rays, options = {}) {
        const { args, arrays } = this.#asksAny(rays, options);
        await callAsync(C.tracePacket, args, options, usedBy(this, options));
        return arrays.occluded;
    }

    #lists(rays, options) {
        const list = raysStruct(rays), capacity = whole(options.capacity, 'options.capacity');
        const perHit = [...CLOSEST, 'crossing'], perRay = ['total', 'crossingTotal'];
        const { arrays, members } = results(options, [...perHit, ...perRay], capacity ? [...perHit, ...perRay] : perRay,
            (name) => [perRay.includes(name) ? list.count : list.count * capacity, 1]);
        keepApart(members, list);
        const lists = struct('mlrt_hit_lists', { capacity, ...members });
        return { args: [this.#tree, list, traceOptions(options, 0), lists], arrays };
    }

    allHitsSync(rays, options = {}) {
        const { args, arrays } = this.#lists(rays, options);
        callSync(C.traceAllHits, args, options);
        return arrays;
    }

    async allHits(rays, options = {}) {
        const { args, arrays } = this.#lists(rays, options);
        await callAsync(C.traceAllHits, args, options, usedBy(this, options));
        return arrays;
    }

    #renders(camera, options, onTile = undefined) {
        const { query = 'closest', lights } = options;
        const any = choose(['closest', 'any'], query, 'options.query');
        const allowed = any ? ['occluded'] : lights?.length ? [...CLOSEST, 'occluded'] : CLOSEST;
        const picture = cameraStruct(camera), size = frameSize(picture);
        const names = options.outputs ?? allowed;
        for (const name of names) {
            if (!allowed.includes(name)) throw new RangeError(`outputs: ${name} is not one of ${allowed.join(', ')}`);
        }
        const toTiles = onTile ? names.reduce((bits, name) => bits | (OUTPUT_OF_TILE[name] ?? 0), 0) : 0;
        // With tiles, a frame is written only if it is asked for by `into`.
        const { arrays, members } = onTile && !options.into ? { arrays: {} } : results(options, allowed, allowed, () => size);
        if (members) keepApart(members, {});
        const frame = members ? struct('mlrt_hits', members) : null;
        return { args: [this.#tree, picture, traceOptions(options, any, any ? 0 : toTiles), frame, onTile ? 1 : 0], arrays };
    }

    renderSync(camera, options = {}) {
        const { args, arrays } = this.#renders(camera, options);
        callSync(C.renderTiles, args, options);
        return arrays;
    }

    async render(camera, options = {}) {
        const { onTile } = options;
        const { args, arrays } = this.#renders(camera, options, onTile);
        await callAsync(C.renderTiles, args, options, usedBy(this, options), onTile);
        return arrays;
    }

    #points({ positions, skip, rowLength, count }, light, options) {
        const number = whole(count ?? countOf(positions, 3), 'points.count', 1);
        const points = struct('mlrt_points', {
            row_length: whole(rowLength, 'points.rowLength'), count: number,
            positions: input(positions, Float32Array, 3, number, 'points.positions'),
            skip: input(skip, Uint32Array, 2, number, 'points.skip'),
        });
        const occluded = options.into?.occluded ?? new Uint8Array(number);
        const array = output(occluded, Uint8Array, number, 1, 'into.occluded');
        keepApart({ occluded: array }, points);
        return { args: [this.#tree, points, lightStruct(light, 'light'), traceOptions(options, 0), array], occluded };
    }

    occludedPointsSync(points, light, options = {}) {
        const { args, occluded } = this.#points(points, light, options);
        callSync(C.occludedPoints, args, options);
        return occluded;
    }

    async occludedPoints(points, light, options = {}) {
        const { args, occluded } = this.#points(points, light, options);
        await callAsync(C.occludedPoints, args, options, usedBy(this, options));
        return occluded;
    }

    traceRay(ray, options = {}) {
        const hit = struct('mlrt_hit', {});
        check(C.traceRay(this.#tree, rayStruct(ray), traceOptions(options, 0), hit));
        const { t, u, v, mesh, triangle, facing } = hit;
        return { t, u, v, mesh, triangle, facing };
    }

    occludedRay(ray, options = {}) {
        const hit = struct('mlrt_hit', {});
        check(C.traceRay(this.#tree, rayStruct(ray), traceOptions(options, 1), hit));
        return hit.occluded === 1;
    }

    shadowRay(ray, hit, light) {
        const [mesh, triangle] = idsOf(hit, 'hit'), found = struct('mlrt_hit', { mesh, triangle });
        const shadow = struct('mlrt_ray', {}), faces = [0];
        check(C.shadowRay(this.#tree, rayStruct(ray), found, lightStruct(light, 'light'), shadow, faces));
        if (!faces[0]) return null;
        return {
            origin: [...shadow.origin], direction: [...shadow.direction], tMin: shadow.t_min, tMax: shadow.t_max,
            skip: shadow.flags & 1 ? { mesh: shadow.skip_mesh, triangle: shadow.skip_triangle } : undefined,
        };
    }

    offsetPoint(hit, side) {
        if (side !== 1 && side !== -1) throw new RangeError(`side: ${String(side)} is not 1 or -1`);
        const point = new Float32Array(3);
        const u = number(hit.u, 'hit.u', NaN), v = number(hit.v, 'hit.v', NaN);
        check(C.offsetPoint(this.#tree, ...idsOf(hit, 'hit'), u, v, side, point));
        return [...point];
    }
}

/** A tile with arrays of its own, since the library's are gone when the callback returns. */
function copyTile(tile) {
    const { worker, x, y, width, height } = tile, copy = { worker, x, y, width, height };
    for (const name of [...CLOSEST, 'occluded']) {
        if (tile[name] === null) continue;
        const type = RESULTS[name], size = width * height * type.BYTES_PER_ELEMENT;
        copy[name] = new type(koffi.view(tile[name], size).slice(0));
    }
    return copy;
}

// ---- without a tree ------------------------------------------------------------------------------------------------

/** Counts of the work of tracing, which calls with options.counters add to. */
class Counters {
    /** The struct, for this library's own calls. */
    memory = new Uint8Array(koffi.sizeof(types.mlrt_counters));

    constructor() {
        new Uint32Array(this.memory.buffer, 0, 1)[0] = this.memory.length;
    }
}
for (const field of Object.keys(types.mlrt_counters.members).slice(2)) {
    const name = field.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
    const offset = koffi.offsetof(types.mlrt_counters, field);
    Object.defineProperty(Counters.prototype, name, {
        enumerable: true,
        get() {
            return Number(new BigUint64Array(this.memory.buffer, offset, 1)[0]);
        },
    });
}

function cameraRays(camera) {
    const picture = cameraStruct(camera), [columns, rows] = frameSize(picture);
    const origins = new Float32Array(3 * columns * rows), directions = new Float32Array(3 * columns * rows);
    check(C.cameraRays(picture, { data: origins, stride: 0, row_stride: 0 }, { data: directions, stride: 0, row_stride: 0 }));
    return { origins, directions, rowLength: columns };
}

function lookAt({ eye, target, up = [0, 1, 0], fov = 45, width, height }) {
    const subtract = (a, b) => a.map((x, k) => x - b[k]);
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unit = (a, what) => {
        const length = Math.hypot(...a);
        if (!(length > 0 && length < Infinity)) throw new RangeError(`${what}: the vector is zero or not finite`);
        return a.map((x) => x / length);
    };
    if (!(fov > 0 && fov < 180)) throw new RangeError(`fov: between 0 and 180 degrees, not ${fov}`);
    const forward = unit(subtract(target, eye), 'target - eye');
    const right = unit(cross(forward, up), 'up, seen along target - eye'), upward = cross(right, forward);
    const pixel = 2 * Math.tan(fov * Math.PI / 360) / height;
    return {
        width, height, eye, d00: forward.map((x, k) => x + pixel * (upward[k] * height - right[k] * width) / 2),
        dx: right.map((x) => x * pixel), dy: upward.map((x) => -x * pixel),
    };
}

function hashGeometry(meshes) {
    const list = meshStructs(meshes), hash = [0];
    check(C.hashGeometry(list, list.length, hash));
    return BigInt(hash[0]);
}

function estimate(native, meshes, options) {
    const list = meshStructs(meshes), result = struct('mlrt_memory_estimate', {});
    check(native(list, list.length, options, result));
    return { memorySize: Number(result.memory_size), peakMemorySize: Number(result.peak_memory_size) };
}

const estimateTree = (meshes, options = {}) => estimate(C.estimateTree, meshes, treeOptions(options));
const estimateKdtree = (meshes, options = {}) => estimate(C.estimateKdtree, meshes, kdtreeOptions(options));

function version() {
    const number = C.version();
    return `${Math.floor(number / 10000)}.${Math.floor(number / 100) % 100}.${number % 100}`;
}

function capabilities() {
    const bits = BigInt(C.capabilities());
    return { sse: (bits & 1n) !== 0n, avx2: (bits & 2n) !== 0n, avx512: (bits & 4n) !== 0n, neon: (bits & 8n) !== 0n };
}

module.exports = {
    Tree, Pool, Counters, MlrtError, NONE, STATUS, RULE, SHORTCUT, cameraRays, lookAt, hashGeometry, estimateTree, estimateKdtree,
    version, capabilities, statusString: C.statusString,
};
