// SPDX-License-Identifier: MIT
/// <reference lib="es2020" />
/// <reference lib="esnext.disposable" />

/** The id that is reported for a miss. */
export const NONE: 0xFFFFFFFF;

/** What `MlrtError.status` can be. */
export const STATUS: {
    readonly OK: 0;
    readonly ARGUMENT: 1;
    readonly STRUCT_SIZE: 2;
    readonly INDEX_RANGE: 3;
    readonly OUT_OF_MEMORY: 4;
    readonly TOO_LARGE: 5;
    readonly CAMERA: 6;
    readonly UNSUPPORTED: 7;
    readonly THREAD: 8;
    readonly CANCELLED: 9;
    readonly DATA: 10;
};

/** Rules of the kd-tree's builder that `rulesOff` switches off, or-ed together. */
export const RULE: {
    readonly EMPTY_SPACE: 1;
    readonly COPLANAR: 2;
    readonly MINIMUM_CELL: 4;
    readonly CLIPPED_SPLITS: 8;
    readonly RETRACTION: 16;
};

/** Shortcuts of method multilevel that `shortcutsOff` switches off, or-ed together. */
export const SHORTCUT: { readonly WHOLE_TILES: 1; readonly ENTRY_LISTS: 2; readonly SHARED_SETUPS: 4 };

/** What the library says went wrong. The message names the argument, its value and the rule. */
export class MlrtError extends Error {
    constructor(status: number, reason?: string);
    /** One of STATUS. */
    readonly status: number;
    /** The name of the status in STATUS. */
    readonly code: string;
}

/** Three numbers. */
export type Vector = readonly [number, number, number] | Float32Array | readonly number[];

/** Elements in a typed array at other places than one after the other; with stride 'all', one element for all. */
export interface Strided<A> {
    data: A;
    /** Bytes from one element to the next; by default the size of an element. */
    stride?: number | 'all';
}

/**
 * An input array: packed, with a stride, or one element for all rays (a number, or a plain array of as many numbers as an
 * element has).
 */
export type Input<A> = A | Strided<A> | number | readonly number[];

/**
 * An array for results: packed, or with strides in bytes from element to element and from row to row of a picture. Its
 * elements share memory neither with those of another one nor with anything that the call reads.
 */
export type Output<A> = A | { data: A; stride?: number; rowStride?: number };

/** What all calls have. */
export interface CallOptions {
    /** Receives what the library reports, when the call ends. */
    onLog?: (level: 'error' | 'warning' | 'info', message: string) => void;
}

/** What calls that return a promise have besides. */
export interface AsyncOptions {
    /** Ends the call within some milliseconds; the promise is rejected with the signal's reason. */
    signal?: AbortSignal;
    /** Receives the part that is done, 0..1 and never less than before, every 10 ms, and 1 at the end of a call that succeeds. */
    onProgress?: (fraction: number) => void;
}

/** An indexed triangle mesh. */
export interface Mesh {
    /** Three numbers each, `vertexStride` bytes apart. */
    vertices: Float32Array;
    /** Three indices each, `triangleStride` bytes apart; without, triangle i has the vertices 3i, 3i + 1, 3i + 2. */
    indices?: Uint32Array | Uint16Array;
    /** Reported with hits. If all ids are 0 or missing, they are 0, 1, 2, ... */
    id?: number;
    /** Rays see the mesh if their mask has a bit in common with it; 0 = all bits. */
    mask?: number;
    vertexStride?: number;
    vertexCount?: number;
    triangleStride?: number;
    triangleCount?: number;
}

export type Meshes = Mesh | readonly Mesh[];

export interface TreeOptions {
    /** FAST is built fastest, BEST is traced fastest. */
    preset?: 'default' | 'fast' | 'best';
    traversalCost?: number;
    intersectionCost?: number;
    /** Most bytes held at one time; beyond: an error. */
    memoryLimit?: number | bigint;
    /** Whose threads build; without, one thread alone. The tree is the same. */
    pool?: Pool;
}

export interface KdtreeOptions {
    preset?: 'paper' | 'tuned';
    traversalCost?: number;
    intersectionCost?: number;
    memoryLimit?: number | bigint;
    /** Most leaf entries. */
    maxReferences?: number | bigint;
    /** Most inner nodes above a leaf, 1..60. */
    maxDepth?: number;
    /** RULE, or-ed together. */
    rulesOff?: number;
    /** Whose threads build; without, one thread alone. The tree is the same. */
    pool?: Pool;
}

export interface LoadOptions {
    /** Use the bytes where they lie, if their address is a multiple of 64: they must not change until the tree is closed. */
    inPlace?: boolean;
    /** What `hashGeometry` says of the meshes: a tree of others is an error. */
    geometryHash?: bigint;
    memoryLimit?: number | bigint;
}

/** The build report. */
export interface TreeInfo {
    structure: 'kdtree' | 'bvh';
    depth: number;
    triangleCount: number;
    nonFiniteCount: number;
    zeroAreaCount: number;
    nodeCount: number;
    leafCount: number;
    emptyLeafCount: number;
    referenceCount: number;
    retractedCount: number;
    memorySize: number;
    peakMemorySize: number;
    treeHash: bigint;
    sahCost: number;
    buildSeconds: number;
    boundsMin: number[];
    boundsMax: number[];
}

export interface MemoryEstimate {
    memorySize: number;
    peakMemorySize: number;
}

/** Rays. Each array has an element per ray, or one for all rays. */
export interface Rays {
    /** Three numbers each. */
    origins: Input<Float32Array>;
    /** Three numbers each, of any length. */
    directions: Input<Float32Array>;
    /** Without: 0. */
    tMin?: Input<Float32Array>;
    /** Without: no limit. 0 means 0. */
    tMax?: Input<Float32Array>;
    /** Mesh and triangle, as reported, that the ray passes through. */
    skip?: Input<Uint32Array>;
    /** A mask for each ray in place of that of the options. */
    mask?: Input<Uint32Array>;
    /** k: each k neighbouring rays have one element of origins, tMin and skip, which have count / k elements. */
    raysPerOrigin?: number;
    /** Rays in a row of a picture: a hint for speed only. */
    rowLength?: number;
    /** The number of rays, where no packed array tells it. */
    count?: number;
}

/** Points of which `occludedPoints` tells whether they are in shadow. */
export interface Points {
    positions: Input<Float32Array>;
    /** Mesh and triangle that the point lies on, which does not shade it. */
    skip?: Input<Uint32Array>;
    rowLength?: number;
    count?: number;
}

export interface Ray {
    origin: Vector;
    direction: Vector;
    tMin?: number;
    /** 0 or missing: no limit. */
    tMax?: number;
    skip?: { mesh: number; triangle: number };
}

export interface Hit {
    /** The distance in units of the direction's length; Infinity for a miss. */
    t: number;
    /** The weight of the triangle's second vertex. */
    u: number;
    /** The weight of its third. */
    v: number;
    /** The id of the mesh; NONE = miss. */
    mesh: number;
    /** The number of the triangle in its mesh; NONE = miss. */
    triangle: number;
    /** The sign of direction . normal; 0 = miss. */
    facing: number;
}

export interface Light {
    /** Without: 'point'. */
    kind?: 'point' | 'directional';
    /** That of a point light, or the direction towards a directional one. */
    position: Vector;
}

/**
 * A camera: pixel (i, j) has the vector p = d00 + (i + sample[0]) dx + (j + sample[1]) dy. The ray of a pinhole camera has the
 * origin eye and the direction p, that of a parallel one the origin p and the direction `direction`. See `lookAt`.
 */
export interface Camera {
    projection?: 'pinhole' | 'parallel';
    width: number;
    height: number;
    /** Only these pixels. */
    crop?: { x?: number; y?: number; width?: number; height?: number };
    eye?: Vector;
    direction?: Vector;
    d00: Vector;
    dx: Vector;
    dy: Vector;
    /** Where in the pixel; without: [0.5, 0.5], the middle. */
    sample?: readonly [number, number];
    tMin?: number;
    /** 0 or missing: no limit. */
    tMax?: number;
}

/** How to trace. None of it changes an answer, except `mask`. */
export interface TraceOptions {
    method?: 'default' | 'ray' | 'packet2' | 'packet4' | 'multilevel' | 'tile';
    isa?: 'auto' | 'scalar' | 'sse' | 'avx2' | 'avx512' | 'neon';
    culling?: 'inverse' | 'direct';
    cullingCheck?: boolean;
    initialTileSize?: number;
    minimumTileSize?: number;
    splitFactor?: number;
    /** SHORTCUT, or-ed together. */
    shortcutsOff?: number;
    /** Rays see the meshes whose mask has a bit in common with it; 0 = all bits. */
    mask?: number;
    /** Whose threads trace; without, one thread alone. */
    pool?: Pool;
    counters?: Counters;
}

/** Which results are wanted, by name, or the arrays that they are written to; without both, all of them. */
export interface ResultOptions<R> {
    outputs?: readonly (keyof R)[];
    into?: { [K in keyof R]?: Output<R[K]> };
}

/** Closest hits, an element per ray or pixel; a miss has mesh = triangle = NONE. */
export interface Hits {
    t: Float32Array;
    u: Float32Array;
    v: Float32Array;
    mesh: Uint32Array;
    triangle: Uint32Array;
    facing: Int32Array;
}

/** A picture: with lights, bit k of `occluded` is 1 if light k does not reach the hit; with query 'any' it is the only array. */
export interface Frame extends Hits {
    occluded: Uint8Array;
}

export interface Occlusion {
    occluded: Uint8Array;
}

/** All hits: `capacity` elements per ray, so hit j of ray i is element i * capacity + j. */
export interface HitLists extends Hits {
    /** 1 = the hit crosses the surface, 0 = it only touches it, or there is no hit. */
    crossing: Uint8Array;
    /** The number of hits of each ray, with those beyond `capacity`. */
    total: Uint32Array;
    /** How many of these cross the surface: odd inside a closed mesh, even outside. */
    crossingTotal: Uint32Array;
}

/** The results of a finished part of a picture, row by row. */
export interface Tile extends Partial<Frame> {
    worker: number;
    x: number;
    y: number;
    width: number;
    height: number;
}

export interface RenderOptions extends TraceOptions, ResultOptions<Frame> {
    query?: 'closest' | 'any';
    /** At most 8, with query 'closest'. */
    lights?: readonly Light[];
}

export interface TileOptions {
    /**
     * Receives each tile once, some milliseconds after it is done: until then it waits in memory. Return false to end the
     * render. With `onTile` no frame is written, unless `into` is given.
     */
    onTile?: (tile: Tile) => boolean | void;
}

type Sync = CallOptions;
type Async = CallOptions & AsyncOptions;

/** Threads that calls share their work with. Calls that share one wait for each other. */
export class Pool {
    /** `threads` at work, the calling one included, 1..1024; 0 = one per processor. */
    constructor(threads?: number);
    /** How many are at work, the calling one included; also after close(). */
    readonly threads: number;
    /** Ends the threads now; again does nothing. Throws while a call uses them. */
    close(): void;
    [Symbol.dispose](): void;
}

/** Counts of the work of tracing, which calls with `counters` add to. mlrt.h says what each counts. */
export class Counters {
    readonly rayCount: number;
    readonly packetCount: number;
    readonly beamCount: number;
    readonly cellCount: number;
    readonly entryPointCellCount: number;
    readonly triangleTestCount: number;
    readonly judgedLaneCount: number;
    readonly entryPointCount: number;
    readonly entryPointDepthSum: number;
    readonly missedBeamCount: number;
    readonly coveredBeamCount: number;
    readonly undecidedCullCount: number;
    readonly undecidedCheckedCount: number;
    readonly laneTestCount: number;
    readonly undecidedTestCount: number;
    readonly tieLaneCount: number;
    readonly exactEdgeCount: number;
    readonly exactRangeCount: number;
    readonly exactOrderCount: number;
}

/**
 * Triangles, and what finds them. It never changes, and any number of calls may use it at once. Calls that return a promise
 * run on a thread of Node's pool: leave their arrays alone until it is settled.
 */
export class Tree {
    private constructor();
    /** The best tree there is: a hierarchy of boxes. */
    static build(meshes: Meshes, options?: TreeOptions & Async): Promise<Tree>;
    static buildSync(meshes: Meshes, options?: TreeOptions & Sync): Tree;
    /** The kd-tree of the paper that mlrt is named after: for study. */
    static buildKdtree(meshes: Meshes, options?: KdtreeOptions & Async): Promise<Tree>;
    static buildKdtreeSync(meshes: Meshes, options?: KdtreeOptions & Sync): Tree;
    /** The tree whose bytes `save` returned. */
    static load(data: Uint8Array, options?: LoadOptions & CallOptions): Promise<Tree>;
    static loadSync(data: Uint8Array, options?: LoadOptions & CallOptions): Tree;

    save(): Promise<Uint8Array>;
    saveSync(): Uint8Array;
    info(): TreeInfo;

    /** The closest hit of each ray. */
    trace(rays: Rays, options?: TraceOptions & ResultOptions<Hits> & Async): Promise<Hits>;
    traceSync(rays: Rays, options?: TraceOptions & ResultOptions<Hits> & Sync): Hits;
    /** 1 for each ray that hits anything, else 0. */
    occluded(rays: Rays, options?: TraceOptions & ResultOptions<Occlusion> & Async): Promise<Uint8Array>;
    occludedSync(rays: Rays, options?: TraceOptions & ResultOptions<Occlusion> & Sync): Uint8Array;
    /** Every triangle that each ray hits, nearest first. With capacity 0 or missing only the totals. */
    allHits(rays: Rays, options?: TraceOptions & ResultOptions<HitLists> & { capacity?: number } & Async): Promise<HitLists>;
    allHitsSync(rays: Rays, options?: TraceOptions & ResultOptions<HitLists> & { capacity?: number } & Sync): HitLists;
    /** A picture, row by row. */
    render(camera: Camera, options?: RenderOptions & TileOptions & Async): Promise<Frame>;
    renderSync(camera: Camera, options?: RenderOptions & Sync): Frame;
    /** 1 for each point that is in the shadow of the light, else 0. */
    occludedPoints(points: Points, light: Light, options?: TraceOptions & ResultOptions<Occlusion> & Async): Promise<Uint8Array>;
    occludedPointsSync(points: Points, light: Light, options?: TraceOptions & ResultOptions<Occlusion> & Sync): Uint8Array;

    /** The closest hit of one ray. For more than a few, `trace` is many times faster per ray. */
    traceRay(ray: Ray, options?: TraceOptions): Hit;
    /** Whether one ray hits anything. */
    occludedRay(ray: Ray, options?: TraceOptions): boolean;
    /** The ray that decides whether the light reaches the hit of a ray; null if the light is on the other side. */
    shadowRay(ray: Ray, hit: Pick<Hit, 'mesh' | 'triangle'>, light: Light): Ray | null;
    /** A point just off a hit, strictly on one side: +1 is that of the normal; -hit.facing that from which the ray came. */
    offsetPoint(hit: Pick<Hit, 'mesh' | 'triangle' | 'u' | 'v'>, side: 1 | -1 | number): number[];

    /** Frees the tree now; again does nothing. Throws while a call uses it. */
    close(): void;
    [Symbol.dispose](): void;
}

/** The rays of a camera's pixels, row by row: tracing them gives what `render` gives. */
export function cameraRays(camera: Camera): { origins: Float32Array; directions: Float32Array; rowLength: number };

/** A pinhole camera at `eye` with `target` in the middle; `fov` is the height of the picture in degrees (45). */
export function lookAt(view: { eye: number[]; target: number[]; up?: number[]; fov?: number; width: number; height: number }): Camera;

/** A hash of meshes, to see whether a saved tree is still theirs. */
export function hashGeometry(meshes: Meshes): bigint;

/** The memory that `Tree.build` will take, from the numbers of triangles. */
export function estimateTree(meshes: Meshes, options?: TreeOptions): MemoryEstimate;
export function estimateKdtree(meshes: Meshes, options?: KdtreeOptions): MemoryEstimate;

/** The library's version, as '0.1.0'. */
export function version(): string;

/** The instruction sets that this library has and this machine can run. */
export function capabilities(): { sse: boolean; avx2: boolean; avx512: boolean; neon: boolean };

/** What a status means. */
export function statusString(status: number): string;
