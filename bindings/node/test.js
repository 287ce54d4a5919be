// SPDX-License-Identifier: MIT
// The scene of bindings/c/scene.h: prints the hash of the answers, and checks errors and closing.
'use strict';
const assert = require('node:assert');
const koffi = require('koffi');
const { test } = require('node:test');
const mlrt = require('./mlrt.js');

let state = 1;
function draw() {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state >>> 20;
}
const coordinates = (count, divisor) => Float32Array.from({ length: count }, () => (draw() - 2048) / divisor);

const meshes = [7, 3].map((id) => ({
    id,
    vertices: coordinates(300, 256),
    indices: Uint32Array.from({ length: 450 }, () => draw() % 100),
}));
const origins = new Float32Array(3000), directions = new Float32Array(3000);
for (let i = 0; i < 1000; i++) {
    origins.set(coordinates(3, 256), 3 * i);
    directions.set(coordinates(3, 2048), 3 * i);
    for (let k = 0; k < 3 && i % 4 === 3; k++) {
        directions[3 * i + k] = meshes[0].vertices[3 * (i % 100) + k] - origins[3 * i + k];
    }
}

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

test('the same answers', async () => {
    const tree = new mlrt.Tree(...meshes), pool = new mlrt.Pool(2);
    const hits = tree.trace(origins, directions);
    assert.deepStrictEqual(tree.trace(origins, directions, { pool }), hits);
    assert.deepStrictEqual([...tree.occluded(origins, directions, { pool })],
                           [...hits.mesh].map((mesh) => Number(mesh !== mlrt.NONE)));
    const later = Promise.all([1, 2, 3].map(() => tree.traceAsync(origins, directions, { pool })));
    assert.throws(() => tree.close(), /in use/);
    for (const same of await later) assert.deepStrictEqual(same, hits);
    tree.close();
    pool.close();
    console.log(hash(hits));
});

test('errors say what is wrong', () => {
    const wrong = { vertices: new Float32Array(9), indices: Uint32Array.of(0, 1, 2, 0, 1, 3) };
    assert.throws(() => new mlrt.Tree(wrong), (e) => e.status === 3 && /triangle 1: vertex index 3/.test(e.message));
    assert.throws(() => new mlrt.Pool(5000), (e) => e instanceof mlrt.MlrtError && e.status === 1);
    assert.throws(() => new mlrt.Tree({ vertices: [0, 0, 0], indices: new Uint32Array(3) }), TypeError);
    const empty = new mlrt.Tree();
    assert.throws(() => empty.trace(new Float32Array(3), new Float32Array(6)), RangeError);
    assert.deepStrictEqual([...empty.trace(new Float32Array(3), Float32Array.of(0, 0, 1)).mesh], [mlrt.NONE]);
});

test('closed means closed', async () => {
    const tree = new mlrt.Tree(...meshes), pool = new mlrt.Pool(2);
    pool.close();
    assert.throws(() => tree.trace(origins, directions, { pool }), /closed/);
    tree.close();
    tree.close();
    assert.throws(() => tree.trace(origins, directions), /closed/);
    for (let i = 0; i < 100; i++) {
        const forgotten = new mlrt.Tree(...meshes);
        if (i % 2) forgotten.close();
    }
    global.gc(); // frees the others, and those not again
    await new Promise(setImmediate);
});

// For a C compiler to look at.
for (const [name, type] of Object.entries(mlrt.types)) {
    console.log(`layout ${name} sizeof ${koffi.sizeof(type)}`);
    for (const field of Object.keys(koffi.type(type).members)) {
        console.log(`layout ${name} ${field} ${koffi.offsetof(type, field)}`);
    }
}
