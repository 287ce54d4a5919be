// SPDX-License-Identifier: MIT
// The scene of bindings/c/scene.h: prints the hash of the answers, and tests each part of the interface.
'use strict';
const assert = require('node:assert');
const { spawnSync } = require('node:child_process');
const { after, describe, test } = require('node:test');
const mlrt = require('mlrt');
const { koffi, types } = require('mlrt/native.js');

let state = 1;
function draw() {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state >>> 20;
}
const coordinates = (count, divisor) => Float32Array.from({ length: count }, () => (draw() - 2048) / divisor);

const COUNT = 1000;
const meshes = [7, 3].map((id) => ({
    id,
    vertices: coordinates(300, 256),
    indices: Uint32Array.from({ length: 450 }, () => draw() % 100),
}));
const origins = new Float32Array(3 * COUNT), directions = new Float32Array(3 * COUNT);
for (let i = 0; i < COUNT; i++) {
    origins.set(coordinates(3, 256), 3 * i);
    directions.set(coordinates(3, 2048), 3 * i);
    for (let k = 0; k < 3 && i % 4 === 3; k++) {
        directions[3 * i + k] = meshes[0].vertices[3 * (i % 100) + k] - origins[3 * i + k];
    }
}
const rays = { origins, directions };

function hash({ t, u, v, mesh, triangle, facing }) {
    const words = new Uint32Array(6 * t.length), floats = new Float32Array(words.buffer);
    for (let i = 0; i < t.length; i++) {
        floats.set([t[i], u[i], v[i]], 6 * i);
        words.set([mesh[i], triangle[i], facing[i]], 6 * i + 3);
    }
    let sum = 0xCBF29CE484222325n;
    for (const byte of new Uint8Array(words.buffer)) sum = BigInt.asUintN(64, (sum ^ BigInt(byte)) * 0x100000001B3n);
    return sum.toString(16).padStart(16, '0');
}

// One triangle at z = 5, and a mesh that takes a while to build.
const triangle = { vertices: Float32Array.of(0, 0, 5, 1, 0, 5, 0, 1, 5) };
const down = { origin: [0.25, 0.25, 0], direction: [0, 0, 1] };
const large = { vertices: coordinates(900000, 64) };
const camera = mlrt.lookAt({ eye: [0, 0, -30], target: [0, 0, 0], width: 40, height: 30 });

const tree = mlrt.Tree.buildSync(meshes), pool = new mlrt.Pool(2), one = mlrt.Tree.buildSync(triangle);
const hits = tree.traceSync(rays);
after(() => {
    for (const object of [tree, pool, one]) object.close();
});

describe('build', () => {
    test('the same answers from each builder, preset and option, from promises too', async () => {
        const made = [
            mlrt.Tree.buildSync(meshes, { preset: 'fast' }), await mlrt.Tree.build(meshes, { preset: 'best', pool }),
            mlrt.Tree.buildKdtreeSync(meshes, { preset: 'tuned', maxDepth: 5, rulesOff: mlrt.RULE.RETRACTION }),
            await mlrt.Tree.buildKdtree(meshes, { traversalCost: 2, intersectionCost: 1, maxReferences: 100000 }),
        ];
        for (const other of made) {
            assert.deepStrictEqual(other.traceSync(rays), hits);
            other.close();
        }
    });

    test('every option together', () => {
        const lines = [], onLog = (level, text) => lines.push(text), both = { traversalCost: 2, intersectionCost: 0.5, memoryLimit: 1e9, onLog };
        const boxes = mlrt.Tree.buildSync(meshes, { preset: 'best', pool, ...both });
        const kdtree = mlrt.Tree.buildKdtreeSync(meshes, { preset: 'tuned', maxReferences: 1e6, maxDepth: 20, rulesOff: mlrt.RULE.COPLANAR, pool, ...both });
        const loaded = mlrt.Tree.loadSync(boxes.saveSync(), { memoryLimit: 10n ** 9n, onLog });
        for (const same of [boxes, kdtree, loaded]) assert.deepStrictEqual(same.traceSync(rays), hits);
        assert.ok(lines.length >= 2);
        assert.throws(() => mlrt.Tree.buildSync(meshes, { traversalCost: -1 }), { status: mlrt.STATUS.ARGUMENT });
    });

    test('infos', () => {
        const info = tree.info();
        assert.strictEqual(info.triangleCount, 300);
        assert.strictEqual(info.structure, 'bvh');
        assert.strictEqual(typeof info.treeHash, 'bigint');
        assert.ok(info.memorySize > 300 * 36 && info.boundsMin[0] < info.boundsMax[0]);
        const kdtree = mlrt.Tree.buildKdtreeSync(meshes, { maxDepth: 3 });
        assert.strictEqual(kdtree.info().structure, 'kdtree');
        assert.ok(kdtree.info().depth <= 3);
    });

    test('meshes with strides, 2-byte indices, without indices', () => {
        const [{ vertices, indices }] = meshes;
        const wide = new Float32Array(500);
        for (let i = 0; i < 100; i++) wide.set(vertices.subarray(3 * i, 3 * i + 3), 5 * i);
        const quads = new Uint16Array(600);
        for (let i = 0; i < 150; i++) quads.set(indices.subarray(3 * i, 3 * i + 3), 4 * i);
        const corners = Float32Array.from({ length: 1350 }, (_, i) => vertices[3 * indices[Math.floor(i / 3)] + i % 3]);
        const expected = mlrt.Tree.buildSync({ vertices, indices }).traceSync(rays);
        for (const same of [{ vertices: wide, vertexStride: 20, indices: quads, triangleStride: 8 }, { vertices: corners }]) {
            assert.strictEqual(mlrt.hashGeometry(same), mlrt.hashGeometry({ vertices, indices }));
            assert.deepStrictEqual(mlrt.Tree.buildSync(same).traceSync(rays), expected);
        }
    });

    test('estimates, limits', () => {
        const { memorySize, peakMemorySize } = mlrt.estimateTree(meshes);
        assert.ok(memorySize > 0 && peakMemorySize >= memorySize);
        assert.ok(mlrt.estimateKdtree(meshes).memorySize > 0);
        assert.throws(() => mlrt.Tree.buildSync(meshes, { memoryLimit: 1000 }), { status: mlrt.STATUS.OUT_OF_MEMORY, code: 'OUT_OF_MEMORY' });
    });

    test('progress, cancel, log', async () => {
        const fractions = [], lines = [];
        const built = await mlrt.Tree.build(large, { onProgress: (f) => fractions.push(f), onLog: (...line) => lines.push(line) });
        built.close();
        assert.ok(fractions.length > 0 && fractions.at(-1) === 1, `${fractions}`);
        assert.deepStrictEqual([...fractions].sort((a, b) => a - b), fractions);
        assert.ok(lines.some(([level, text]) => level === 'info' && /triangles/.test(text)), `${lines}`);
        const stop = new AbortController();
        const build = mlrt.Tree.build(large, { signal: stop.signal, pool });
        setTimeout(() => stop.abort(), 20);
        await assert.rejects(build, { name: 'AbortError' });
        await assert.rejects(mlrt.Tree.build(large, { signal: stop.signal }), { name: 'AbortError' });
        await assert.rejects(mlrt.Tree.build(large, { onProgress: () => { throw new Error('enough'); } }), /enough/);
        assert.throws(() => mlrt.Tree.buildSync(triangle, { onProgress: () => {} }), /promise/);
    });
});

describe('save and load', () => {
    test('the same tree', async () => {
        const data = tree.saveSync(), geometryHash = mlrt.hashGeometry(meshes);
        assert.deepStrictEqual(await tree.save(), data);
        for (const same of [mlrt.Tree.loadSync(data, { geometryHash }), await mlrt.Tree.load(data), mlrt.Tree.loadSync(data, { inPlace: true })]) {
            assert.strictEqual(same.info().treeHash, tree.info().treeHash);
            assert.deepStrictEqual(same.traceSync(rays), hits);
            same.close();
        }
        assert.throws(() => mlrt.Tree.loadSync(data, { geometryHash: 1n }), { status: mlrt.STATUS.DATA });
        data[data.length - 1] ^= 1;
        await assert.rejects(mlrt.Tree.load(data), { status: mlrt.STATUS.DATA });
    });
});

describe('trace', () => {
    test('options', async () => {
        const kdtree = mlrt.Tree.buildKdtreeSync(meshes);
        const { avx512, avx2, sse, neon } = mlrt.capabilities();
        for (const options of [{ method: 'ray' }, { method: 'tile', isa: sse ? 'sse' : neon ? 'neon' : 'scalar' }, { isa: avx512 ? 'avx512' : avx2 ? 'avx2' : 'auto' }, { pool }]) {
            assert.deepStrictEqual(await tree.trace(rays, options), hits);
        }
        const paper = { method: 'multilevel', culling: 'direct', cullingCheck: true, initialTileSize: 64, minimumTileSize: 8, splitFactor: 4 };
        for (const options of [{ method: 'packet2' }, { method: 'packet4' }, { ...paper, shortcutsOff: mlrt.SHORTCUT.WHOLE_TILES }]) {
            assert.deepStrictEqual(kdtree.traceSync(rays, options), hits);
        }
        assert.throws(() => tree.traceSync(rays, { method: 'packet2' }), { status: mlrt.STATUS.UNSUPPORTED });
        assert.throws(() => tree.traceSync(rays, { method: 'fastest' }), /options.method: fastest is not one of/);
        await assert.rejects(tree.trace(rays, { initialTileSize: 5 }), { status: mlrt.STATUS.ARGUMENT });
    });

    test('occluded', async () => {
        const expected = Uint8Array.from(hits.mesh, (mesh) => Number(mesh !== mlrt.NONE));
        assert.deepStrictEqual(tree.occludedSync(rays), expected);
        assert.deepStrictEqual(await tree.occluded(rays, { pool }), expected);
        const into = { occluded: new Uint8Array(COUNT) };
        assert.strictEqual(tree.occludedSync(rays, { into }), into.occluded);
    });

    test('t ranges, skip, masks', () => {
        const tMax = hits.t.map((t, i) => i % 2 ? t * 1.001 : t * 0.999);
        const near = tree.traceSync({ ...rays, tMax });
        for (let i = 0; i < COUNT; i++) assert.strictEqual(near.mesh[i], i % 2 ? hits.mesh[i] : mlrt.NONE);
        assert.ok(one.traceSync({ origins: [0.25, 0.25, 0], directions: Float32Array.of(0, 0, 1), tMin: 5 }).mesh[0] === mlrt.NONE);
        const skip = new Uint32Array(2 * COUNT);
        hits.mesh.forEach((mesh, i) => skip.set([mesh, hits.triangle[i]], 2 * i));
        const behind = tree.traceSync({ ...rays, skip });
        assert.ok(behind.t.every((t, i) => t >= hits.t[i]) && behind.t.some((t, i) => t > hits.t[i]));
        const masked = mlrt.Tree.buildSync([{ ...meshes[0], mask: 1 }, { ...meshes[1], mask: 2 }]);
        assert.ok(masked.traceSync(rays, { mask: 2 }).mesh.every((mesh) => mesh === 3 || mesh === mlrt.NONE));
        const mask = Uint32Array.from({ length: COUNT }, (_, i) => 1 + i % 2);
        const seen = masked.traceSync({ ...rays, mask });
        assert.ok(seen.mesh.every((mesh, i) => mesh === mlrt.NONE || mesh === (i % 2 ? 3 : 7)));
    });

    test('one element for all, strides, rays per origin', () => {
        const all = tree.traceSync({ origins: [0, 0, 0], directions, tMin: 0.5, tMax: 100 });
        const written = {
            origins: new Float32Array(3 * COUNT), directions, tMin: new Float32Array(COUNT).fill(0.5), tMax: new Float32Array(COUNT).fill(100),
        };
        assert.deepStrictEqual(tree.traceSync(written), all);
        const fan = { origins: origins.slice(0, 600), directions, raysPerOrigin: 5 };
        const repeated = Float32Array.from({ length: 3 * COUNT }, (_, i) => origins[3 * Math.floor(i / 15) + i % 3]);
        assert.deepStrictEqual(tree.traceSync(fan), tree.traceSync({ origins: repeated, directions }));
        const both = new Float32Array(6 * COUNT); // origin and direction side by side
        for (let i = 0; i < COUNT; i++) {
            both.set(origins.subarray(3 * i, 3 * i + 3), 6 * i);
            both.set(directions.subarray(3 * i, 3 * i + 3), 6 * i + 3);
        }
        const strided = { origins: { data: both, stride: 24 }, directions: { data: both.subarray(3), stride: 24 }, count: COUNT };
        assert.deepStrictEqual(tree.traceSync(strided), hits);
        const records = new Float32Array(2 * COUNT);
        tree.traceSync(rays, { into: { t: { data: records, stride: 8 } } });
        assert.deepStrictEqual(records.filter((_, i) => i % 2 === 0), hits.t);
        assert.ok(records.every((x, i) => i % 2 === 0 || x === 0));
        assert.deepStrictEqual(Object.keys(tree.traceSync(rays, { outputs: ['triangle'] })), ['triangle']);
        assert.throws(() => tree.traceSync({ ...strided, count: COUNT + 1 }), RangeError);
        assert.throws(() => tree.traceSync({ ...rays, origins: origins.subarray(3) }), /rays.origins: 2997 numbers, but 3000/);
        assert.throws(() => tree.traceSync(rays, { into: { t: new Float32Array(COUNT - 1) } }), /into.t/);
        assert.throws(() => tree.traceSync(rays, { outputs: ['occluded'] }), /outputs: occluded/);
    });

    test('single rays', () => {
        const hit = one.traceRay(down);
        assert.deepStrictEqual(hit, { t: 5, u: 0.25, v: 0.25, mesh: 0, triangle: 0, facing: 1 });
        assert.strictEqual(one.traceRay({ ...down, tMax: 4 }).mesh, mlrt.NONE);
        assert.strictEqual(one.traceRay({ ...down, tMin: 5 }).mesh, mlrt.NONE);
        assert.strictEqual(one.traceRay({ ...down, skip: { mesh: 0, triangle: 0 } }).triangle, mlrt.NONE);
        assert.strictEqual(one.occludedRay(down), true);
        assert.strictEqual(one.occludedRay({ ...down, direction: [0, 0, -1] }), false);
        for (let i = 0; i < 50; i++) {
            const { t, triangle: number } = tree.traceRay({ origin: origins.subarray(3 * i, 3 * i + 3), direction: directions.subarray(3 * i, 3 * i + 3) });
            assert.deepStrictEqual([t, number], [hits.t[i], hits.triangle[i]]);
        }
        assert.throws(() => one.traceRay(down, { method: 'multilevel' }), { status: mlrt.STATUS.UNSUPPORTED });
    });

    test('all hits', async () => {
        const lists = await tree.allHits(rays, { capacity: 4, pool });
        assert.deepStrictEqual(tree.allHitsSync(rays, { capacity: 4 }), lists);
        for (let i = 0; i < COUNT; i++) {
            assert.strictEqual(lists.t[4 * i], hits.t[i]);
            assert.strictEqual(lists.triangle[4 * i], hits.triangle[i]);
            assert.ok(lists.crossingTotal[i] <= lists.total[i]);
        }
        assert.deepStrictEqual(tree.allHitsSync(rays), { total: lists.total, crossingTotal: lists.crossingTotal });
        assert.deepStrictEqual(Object.keys(tree.allHitsSync(rays, { capacity: 1, outputs: ['crossing'] })), ['crossing']);
    });

    test('counters', () => {
        const counters = new mlrt.Counters();
        tree.traceSync(rays, { counters });
        tree.traceSync(rays, { counters });
        assert.strictEqual(counters.rayCount, 2 * COUNT);
        assert.ok(counters.triangleTestCount > 0);
    });

    test('progress and cancel', async () => {
        const many = 2000000, far = new Float32Array(3 * many).map((_, i) => directions[i % (3 * COUNT)]);
        const job = { origins: [0, 0, 0], directions: far };
        const fractions = [];
        await tree.occluded(job, { onProgress: (f) => fractions.push(f), method: 'ray' });
        assert.ok(fractions.length > 0 && fractions.at(-1) === 1, `${fractions}`);
        const stop = new AbortController();
        const call = tree.trace(job, { signal: stop.signal, method: 'ray', pool });
        assert.throws(() => tree.close(), /in use/);
        setTimeout(() => stop.abort(new Error('not wanted')), 10);
        await assert.rejects(call, /not wanted/);
    });
});

describe('pictures', () => {
    const lights = [{ kind: 'point', position: [0, 10, -30] }, { kind: 'directional', position: [0, 1, -1] }];

    test('the rays of a camera', async () => {
        const written = mlrt.cameraRays(camera);
        assert.strictEqual(written.rowLength, 40);
        const frame = await tree.render(camera, { pool });
        assert.deepStrictEqual(tree.renderSync(camera), frame);
        assert.deepStrictEqual(tree.traceSync(written), frame);
        assert.ok(frame.mesh.some((mesh) => mesh !== mlrt.NONE));
        const any = tree.renderSync(camera, { query: 'any' });
        assert.deepStrictEqual(any, { occluded: Uint8Array.from(frame.mesh, (mesh) => Number(mesh !== mlrt.NONE)) });
        const crop = { x: 8, y: 4, width: 16, height: 12 };
        const part = tree.renderSync({ ...camera, crop }, { outputs: ['t'] });
        for (let i = 0; i < 192; i++) assert.strictEqual(part.t[i], frame.t[(4 + Math.floor(i / 16)) * 40 + 8 + i % 16]);
        const rows = new Float32Array(16 * 100); // a part of a larger picture
        tree.renderSync({ ...camera, crop }, { into: { t: { data: rows, rowStride: 400 } } });
        for (let i = 0; i < 192; i++) assert.strictEqual(rows[100 * Math.floor(i / 16) + i % 16], part.t[i]);
        const parallel = { width: 4, height: 4, projection: 'parallel', direction: [0, 0, 1], d00: [-1, -1, 0], dx: [0.5, 0, 0], dy: [0, 0.5, 0] };
        assert.strictEqual(one.renderSync(parallel).t[2 * 4 + 2], 5);
        assert.strictEqual(one.renderSync({ ...parallel, tMax: 4 }).facing[10], 0);
        assert.strictEqual(one.renderSync({ ...parallel, tMin: 5 }).facing[10], 0);
        assert.throws(() => tree.renderSync({ ...camera, width: 0 }), { status: mlrt.STATUS.CAMERA });
    });

    test('lights, as the shadow rays say', async () => {
        const frame = await tree.render(camera, { lights, pool });
        const { origins: o, directions: d } = mlrt.cameraRays(camera);
        let lit = 0;
        for (let i = 0; i < 1200; i++) {
            if (frame.mesh[i] === mlrt.NONE) continue;
            const ray = { origin: o.subarray(3 * i, 3 * i + 3), direction: d.subarray(3 * i, 3 * i + 3) };
            lights.forEach((light, k) => {
                const shadow = tree.shadowRay(ray, { mesh: frame.mesh[i], triangle: frame.triangle[i] }, light);
                const dark = shadow === null || tree.occludedRay(shadow);
                assert.strictEqual(frame.occluded[i] >> k & 1, Number(dark));
                lit += !dark;
            });
        }
        assert.ok(lit > 0);
        assert.throws(() => tree.shadowRay(down, { mesh: 99, triangle: 0 }, lights[0]), { status: mlrt.STATUS.ARGUMENT });
    });

    test('tiles', async () => {
        const frame = tree.renderSync(camera, { lights }), pixels = { triangle: new Uint32Array(1200), occluded: new Uint8Array(1200) };
        const onTile = (tile) => {
            assert.strictEqual(tile.t, undefined);
            for (let j = 0; j < tile.height; j++) {
                for (const [name, pixel] of Object.entries(pixels)) {
                    pixel.set(tile[name].subarray(j * tile.width, (j + 1) * tile.width), (tile.y + j) * 40 + tile.x);
                }
            }
        };
        const options = { lights, outputs: ['triangle', 'occluded'], initialTileSize: 16 };
        assert.deepStrictEqual(await tree.render(camera, { ...options, onTile, pool }), {});
        assert.deepStrictEqual(pixels, { triangle: frame.triangle, occluded: frame.occluded });
        await assert.rejects(tree.render(camera, { ...options, onTile: () => false }), { status: mlrt.STATUS.CANCELLED });
        await assert.rejects(tree.render(camera, { ...options, pool, onTile: () => { throw new Error('enough'); } }), /enough/);
        await assert.rejects(tree.render(camera, { onTile() {}, outputs: ['depth'] }), /outputs: depth is not one of/);

        // The render needs nothing of this thread: calls that block may use its pool, and tiles wait for the end of them.
        let tiles = 0;
        await tree.render(camera, { pool, initialTileSize: 16, onTile: () => tree.renderSync(camera, { pool }) && tiles++ });
        assert.strictEqual(tiles, 6);
        // All tiles are done before the first one is looked at.
        const late = [];
        const rendering = tree.render(camera, { initialTileSize: 4, onTile: (tile) => late.push(tile) < 3 });
        Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 100);
        await assert.rejects(rendering, { status: mlrt.STATUS.CANCELLED });
        assert.strictEqual(late.length, 3);
        await assert.rejects(tree.render(camera, { pool, initialTileSize: 16, onTile: () => tree.close() }), /in use by a call/);
    });

    test('a program ends during a call', () => {
        const start = `
            const mlrt = require('mlrt'), tree = mlrt.Tree.buildSync({ vertices: Float32Array.of(0, 0, 5, 1, 0, 5, 0, 1, 5) });
            const camera = mlrt.lookAt({ eye: [0, 0, 0], target: [0, 0, 5], width: 20000, height: 20000 });
            const render = (onTile) => tree.render(camera, { method: 'ray', query: 'any', outputs: ['occluded'], onTile });
            const end = () => { throw new Error('enough'); };`;
        for (const [call, status] of [
            ['setTimeout(() => process.exit(3), 50), render(() => {})', 3], ['render(() => process.exit(3))', 3],
            ['setTimeout(end, 50), render(() => {})', 1], ['setTimeout(() => process.exit(3), 50), render()', 3],
        ]) {
            const child = spawnSync(process.execPath, ['-e', `${start} ${call};`], { cwd: __dirname, timeout: 20000, encoding: 'utf8' });
            assert.strictEqual(child.status, status, `${call}: ${child.error ?? child.stderr}`);
        }
    });

    test('points off the surface', async () => {
        const hit = one.traceRay(down), point = one.offsetPoint(hit, -hit.facing);
        assert.ok(point[2] < 5 && point[2] > 4.99);
        assert.throws(() => one.offsetPoint({ ...hit, triangle: 1 }, 1), { status: mlrt.STATUS.ARGUMENT });
        const positions = Float32Array.of(...point, 0.25, 0.25, 6), light = { kind: 'point', position: [0.25, 0.25, 0] };
        assert.deepStrictEqual([...await one.occludedPoints({ positions }, light, { pool })], [0, 1]);
        assert.deepStrictEqual([...one.occludedPointsSync({ positions, skip: [0, 0], rowLength: 2 }, light)], [0, 0]);
        const sky = { kind: 'directional', position: [0, 0, 1] };
        assert.deepStrictEqual([...one.occludedPointsSync({ positions }, sky)], [1, 0]);
    });
});

describe('errors', () => {
    test('say what is wrong, on the thread of the call', async () => {
        const wrong = { vertices: new Float32Array(9), indices: Uint32Array.of(0, 1, 2, 0, 1, 3) };
        const named = { name: 'MlrtError', status: mlrt.STATUS.INDEX_RANGE, code: 'INDEX_RANGE', message: /index 3/ };
        assert.throws(() => mlrt.Tree.buildSync(wrong), named);
        // Many at a time, each with a message of its own.
        await Promise.all([3, 40, 500, 6000].map((index) => assert.rejects(
            mlrt.Tree.build({ vertices: new Float32Array(9), indices: Uint32Array.of(0, 1, index) }), new RegExp(`index ${index}\\b`))));
        assert.throws(() => new mlrt.Pool(5000), (e) => e instanceof mlrt.MlrtError && e.status === mlrt.STATUS.ARGUMENT && e.message !== '');
        assert.throws(() => mlrt.Tree.buildSync({ vertices: [0, 0, 0] }), TypeError);
        assert.throws(() => mlrt.Tree.buildSync({ vertices: new Float32Array(4) }), /meshes\[0\].vertices: 4 numbers/);
        assert.throws(() => new mlrt.Tree(), TypeError);
        assert.throws(() => tree.traceSync({ origins: [0, 0, 0], directions: [0, 0, 1] }), /rays.count/);
        assert.strictEqual(mlrt.statusString(3), new mlrt.MlrtError(3).message);
    });

    test('nothing is taken for something else', () => {
        const three = { vertices: new Float32Array(9), indices: Uint32Array.of(0, 1, 2) };
        for (const count of [-1, 1.5, NaN, 2 ** 32]) {
            assert.throws(() => mlrt.Tree.buildSync({ vertices: three.vertices, vertexCount: count }), /count: .* is not a whole number/);
            assert.throws(() => mlrt.Tree.buildSync({ ...three, triangleCount: count }), /count: .* is not a whole number/);
            assert.throws(() => tree.traceSync({ ...rays, skip: [count, 0] }), /rays.skip: .* is not a whole number/);
        }
        // Objects in place of a pool or counts would be addresses.
        for (const pool of [tree, {}, { handle: 8 }, 'two']) {
            assert.throws(() => tree.traceSync(rays, { pool }), /options.pool: a Pool is needed/);
            assert.throws(() => mlrt.Tree.buildSync(three, { pool }), /options.pool: a Pool is needed/);
            assert.throws(() => mlrt.Tree.buildKdtreeSync(three, { pool }), /options.pool: a Pool is needed/);
        }
        assert.throws(() => tree.traceSync(rays, { counters: { memory: new Uint8Array(1) } }), /options.counters: a Counters is needed/);
        // A size that is another one when it is read again.
        let reads = 0;
        const camera = { ...mlrt.lookAt({ eye: [0, 0, -30], target: [0, 0, 0], width: 8, height: 8 }), get width() { return 8 << reads++; } };
        assert.strictEqual(tree.renderSync(camera).t.length, 64);
        reads = 0;
        assert.strictEqual(mlrt.cameraRays(camera).origins.length, 3 * 64);
    });

    test('numbers that are none', () => {
        const data = one.saveSync(), hit = { mesh: 0, triangle: 0, u: 0.25, v: 0.25 };
        for (const size of [2n ** 64n, -1n, 0.5, NaN, 'x', null, {}]) {
            assert.throws(() => mlrt.Tree.loadSync(data, { geometryHash: size }), /geometryHash: .* is not a whole/);
            assert.throws(() => mlrt.Tree.buildSync(triangle, { memoryLimit: size }), /memoryLimit: .* is not a whole/);
            assert.throws(() => mlrt.estimateKdtree(triangle, { maxReferences: size }), /maxReferences: .* is not/);
        }
        for (const x of ['0', undefined, null, 0n]) {
            const directions = Float32Array.of(0, 0, 1);
            assert.throws(() => one.traceSync({ origins: [0, x, 0], directions }), /rays.origins: a number is needed/);
            assert.throws(() => one.traceSync({ ...rays, tMax: [x] }), /rays.tMax: a number is needed/);
        }
        assert.throws(() => one.traceSync({ ...rays, skip: new Array(2) }), /rays.skip: a number is needed/);
        for (const side of [0.5, 1.5, NaN, 2 ** 32 + 1, '1', undefined]) {
            assert.throws(() => one.offsetPoint(hit, side), /side: .* is not 1 or -1/);
        }
        for (const skip of [{}, { mesh: 0 }, { triangle: 0 }, 5, true]) {
            assert.throws(() => one.traceRay({ ...down, skip }), /ray.skip.* is not a whole number/);
            assert.throws(() => one.shadowRay(down, skip, { position: [0, 0, 0] }), /hit.* is not a whole number/);
            assert.throws(() => one.offsetPoint(skip, 1), /hit.* is not a whole number/);
        }
        assert.throws(() => one.traceRay({ direction: [0, 0, 1] }), /ray.origin: three numbers/);
        assert.throws(() => one.traceRay({ origin: [0, 0, 0] }), /ray.direction: three numbers/);
        assert.throws(() => one.occludedPointsSync({ positions: origins }, {}), /light.position: three numbers/);
        // A stride that is another one when it is read again.
        let reads = 0;
        const changing = { data: Float32Array.of(0, 0, 0), get stride() { return reads++ === 1 ? 'all' : 12; } };
        assert.throws(() => one.traceSync({ origins: changing, directions: [0, 0, 1], count: 9 }), /bytes are too few/);
    });

    test('results that share memory', () => {
        const room = new Float32Array(7 * COUNT), words = new Uint32Array(room.buffer), shared = /shares memory/;
        const part = (array, first, stride) => ({ data: array.subarray(first), stride });
        const both = { origins: part(room, 0, 24), directions: part(room, 3, 24), count: COUNT };
        for (const into of [
            { t: room.subarray(0, COUNT), u: room.subarray(COUNT - 1, 2 * COUNT - 1) },
            { t: room.subarray(0, COUNT), mesh: words.subarray(0, COUNT) },
            { t: part(room, 0, 24), mesh: part(words, 6, 24) }, { t: part(room, 1, 8), u: room.subarray(0, COUNT) },
        ]) assert.throws(() => tree.traceSync(rays, { into }), shared);
        assert.throws(() => tree.traceSync(both, { into: { t: part(room, 5, 24) } }), shared);
        assert.throws(() => tree.traceSync(rays, { into: { t: origins.subarray(0, COUNT) } }), shared);
        const occluded = new Uint8Array(origins.buffer, 7, COUNT), total = words.subarray(9);
        assert.throws(() => tree.occludedSync(rays, { into: { occluded } }), shared);
        assert.throws(() => tree.allHitsSync(rays, { into: { total, crossingTotal: words } }), shared);
        const frame = new Float32Array(2 * 1200), row = (first) => ({ data: frame.subarray(first), rowStride: 320 });
        assert.throws(() => tree.renderSync(camera, { into: { t: row(0), u: row(39) } }), shared);

        // Records, halves and rows in turn do not.
        tree.traceSync(rays, { into: { t: part(room, 0, 24), mesh: part(words, 1, 24), u: part(room, 3, 24) } });
        for (let i = 0; i < COUNT; i++) {
            assert.ok(room[6 * i] === hits.t[i] && words[6 * i + 1] === hits.mesh[i] && room[6 * i + 3] === hits.u[i]);
        }
        tree.traceSync(rays, { into: { t: room.subarray(0, COUNT), u: room.subarray(COUNT, 2 * COUNT) } });
        tree.renderSync(camera, { into: { t: row(0), u: row(40) } });
    });

    test('methods of a tree are for trees', () => {
        const hit = { mesh: 0, triangle: 0, u: 0, v: 0 };
        const calls = {
            info: [], saveSync: [], traceSync: [rays], traceRay: [down], occludedRay: [down],
            shadowRay: [down, hit, { position: [0, 0, 0] }], offsetPoint: [hit, 1],
        };
        for (const [name, args] of Object.entries(calls)) {
            assert.throws(() => mlrt.Tree.prototype[name].apply(pool, args), TypeError);
        }
    });

    test('an error of a callback is thrown, and no tree is left behind', async () => {
        const fail = () => { throw new Error('enough'); };
        const last = (fraction) => fraction === 1 && fail();
        const small = { vertices: large.vertices.subarray(0, 90000) };
        const rss = async () => {
            for (let i = 0; i < 30; i++) {
                assert.throws(() => mlrt.Tree.buildSync(small, { onLog: fail }), /enough/);
                await assert.rejects(mlrt.Tree.build(small, { onProgress: last }), /enough/);
            }
            globalThis.gc?.();
            return process.memoryUsage().rss;
        };
        const size = mlrt.estimateTree(small).memorySize, before = await rss();
        assert.ok(await rss() - before < 30 * size);
    });

    test('an empty tree', () => {
        const empty = mlrt.Tree.buildSync([]);
        assert.deepStrictEqual([...empty.traceSync({ origins: [0, 0, 0], directions: Float32Array.of(0, 0, 1) }).mesh], [mlrt.NONE]);
        assert.strictEqual(empty.traceSync({ origins: new Float32Array(0), directions: new Float32Array(0) }).t.length, 0);
    });

    test('a pool knows its threads', () => {
        const all = new mlrt.Pool(0), two = new mlrt.Pool(2);
        assert.ok(all.threads >= 1);
        all.close();
        two.close();
        assert.strictEqual(two.threads, 2);
    });

    test('closed means closed', async () => {
        const closed = mlrt.Tree.buildSync(meshes), ended = new mlrt.Pool(2);
        ended.close();
        assert.throws(() => closed.traceSync(rays, { pool: ended }), /closed/);
        closed[Symbol.dispose ?? 'close']();
        closed.close();
        assert.throws(() => closed.traceSync(rays), /closed/);
        await assert.rejects(closed.trace(rays), /closed/);
        for (let i = 0; i < 100; i++) {
            const forgotten = mlrt.Tree.buildSync(meshes);
            if (i % 2) forgotten.close();
        }
        global.gc?.(); // frees the others, and those not again
        await new Promise(setImmediate);
    });
});

test('the common scene', () => {
    assert.match(mlrt.version(), /^\d+\.\d+\.\d+$/);
    console.log(hash(hits));
});

// For a C compiler to look at.
for (const [name, type] of Object.entries(types)) {
    console.log(`layout ${name} sizeof ${koffi.sizeof(type)}`);
    for (const field of Object.keys(koffi.type(type).members)) {
        console.log(`layout ${name} ${field} ${koffi.offsetof(type, field)}`);
    }
}
