// SPDX-License-Identifier: MIT
// Compiled by tsc, never run: uses that must have these types, and uses that must not compile.
import * as mlrt from 'mlrt';

async function uses(): Promise<void> {
    const mesh: mlrt.Mesh = { vertices: new Float32Array(9), indices: new Uint16Array(3), id: 1, mask: 2, vertexStride: 12 };
    const stop = new AbortController();
    using pool = new mlrt.Pool(2);
    const threads: number = pool.threads;
    const tree = await mlrt.Tree.build([mesh], { preset: 'best', pool, memoryLimit: 10n, signal: stop.signal, onProgress: (f: number) => void f });
    const kdtree: mlrt.Tree = mlrt.Tree.buildKdtreeSync(mesh, { rulesOff: mlrt.RULE.COPLANAR | mlrt.RULE.RETRACTION });
    const both = new Float32Array(60);
    const rays: mlrt.Rays = { origins: [0, 0, 0], directions: { data: both, stride: 24 }, tMax: 5, count: 10, skip: { data: new Uint32Array(2), stride: 'all' } };
    const t: Float32Array = (await tree.trace(rays, { method: 'ray', outputs: ['t', 'mesh'] })).t;
    const total: Uint32Array = tree.allHitsSync(rays, { capacity: 3, into: { t: { data: t, stride: 8 } } }).crossingTotal;
    const camera = mlrt.lookAt({ eye: [0, 0, 1], target: [0, 0, 0], width: 4, height: 3 });
    await tree.render(camera, { lights: [{ position: [0, 0, 1] }], onTile: (tile: mlrt.Tile) => tile.width > 0 });
    const hit: mlrt.Hit = tree.traceRay({ origin: [0, 0, 0], direction: t });
    const shadow: mlrt.Ray | null = tree.shadowRay({ origin: t, direction: t }, hit, { kind: 'directional', position: [0, 1, 0] });
    const hash: bigint = kdtree.info().treeHash ^ mlrt.hashGeometry(mesh);
    try {
        mlrt.Tree.loadSync(tree.saveSync(), { geometryHash: hash, inPlace: true });
    } catch (error) {
        if (error instanceof mlrt.MlrtError && error.status === mlrt.STATUS.DATA) void [error.code, threads];
    }

    // @ts-expect-error: a preset of the other builder
    mlrt.Tree.buildSync(mesh, { preset: 'tuned' });
    // @ts-expect-error: a call that blocks reports no progress
    tree.traceSync(rays, { onProgress: () => {} });
    // @ts-expect-error: doubles
    mlrt.Tree.buildSync({ vertices: new Float64Array(9) });
    // @ts-expect-error: not a result of the closest-hit query
    tree.traceSync(rays, { outputs: ['occluded'] });
    // @ts-expect-error: trees are made by build and load
    new mlrt.Tree();
    void [total, shadow, pool];
}
void uses;
