// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemoryLayout.PathElement;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.lang.foreign.ValueLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.List;
import java.util.concurrent.Executors;
import java.util.concurrent.Future;
import mlrt.MlrtException.Status;
import mlrt.TraceOptions.Method;
import mlrt.TraceOptions.Output;
import mlrt.TraceOptions.Query;

/** The scene of bindings/c/scene.h: prints the hash of the answers, and tests each part of the interface. */
final class Test {
    private static final int COUNT = 1000;
    private static int state = 1;

    private static int draw() {
        state = state * 1664525 + 1013904223;
        return state >>> 20;
    }

    private static void coordinates(float[] array, int first, int count, float divisor) {
        for (int i = first; i < first + count; i++) array[i] = (draw() - 2048) / divisor;
    }

    private static long hash(Hits hits) {
        long hash = 0xCBF29CE484222325L;
        for (int i = 0; i < COUNT; i++) {
            int[] words = {Float.floatToRawIntBits(hits.t(i)), Float.floatToRawIntBits(hits.u(i)),
                Float.floatToRawIntBits(hits.v(i)), hits.mesh(i), hits.triangle(i), hits.facing(i)};
            for (int word : words) {
                for (int b = 0; b < 32; b += 8) hash = (hash ^ (word >>> b & 0xFF)) * 0x100000001B3L;
            }
        }
        return hash;
    }

    private static void require(boolean fact, String what) {
        if (!fact) throw new AssertionError(what);
    }

    private static <T extends Throwable> T fails(Class<T> type, Runnable call) {
        try {
            call.run();
        } catch (Throwable problem) {
            if (type.isInstance(problem)) return type.cast(problem);
            throw problem;
        }
        throw new AssertionError("no " + type.getSimpleName());
    }

    private static void fails(Status status, Runnable call) {
        var problem = fails(MlrtException.class, call);
        require(problem.status() == status && !problem.getMessage().isEmpty(), problem.status() + ": " + problem.getMessage());
    }

    // ---- the scene ---------------------------------------------------------------------------------------------------

    private static final float[][] VERTICES = new float[2][300];
    private static final int[][] INDICES = new int[2][450];
    private static final float[] ORIGINS = new float[3 * COUNT];
    private static final float[] DIRECTIONS = new float[3 * COUNT];
    private static final float[] CORNERS = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    private static final Ray DOWN = new Ray(new float[] {0.25f, 0.25f, 0}, new float[] {0, 0, 1});

    private static void makeScene() {
        for (int m = 0; m < 2; m++) {
            coordinates(VERTICES[m], 0, 300, 256);
            for (int i = 0; i < 450; i++) INDICES[m][i] = draw() % 100;
        }
        for (int i = 0; i < COUNT; i++) {
            coordinates(ORIGINS, 3 * i, 3, 256);
            coordinates(DIRECTIONS, 3 * i, 3, 2048);
            for (int k = 0; k < 3 && i % 4 == 3; k++) {
                DIRECTIONS[3 * i + k] = VERTICES[0][3 * (i % 100) + k] - ORIGINS[3 * i + k];
            }
        }
    }

    private static Mesh[] meshes() {
        return new Mesh[] {new Mesh(VERTICES[0], INDICES[0]).id(7), new Mesh(VERTICES[1], INDICES[1]).id(3)};
    }

    private static Rays rays() {
        return new Rays(ORIGINS, DIRECTIONS);
    }

    /** Takes a while to build. */
    private static Mesh large() {
        float[] many = new float[900000];
        coordinates(many, 0, many.length, 64);
        return new Mesh(many);
    }

    private static Camera camera() {
        return Camera.lookAt(new float[] {0, 0, -30}, new float[3], new float[] {0, 1, 0}, 45, 40, 30);
    }

    // ---- tests -------------------------------------------------------------------------------------------------------

    private static void testBuild(Tree tree, Pool pool, long hash) {
        Tree[] made = {
            Tree.build(new TreeOptions().preset(TreeOptions.Preset.BEST).pool(pool), meshes()),
            Tree.build(new TreeOptions().preset(TreeOptions.Preset.FAST).traversalCost(2).intersectionCost(0.5f), meshes()),
            Tree.buildKdtree(new KdtreeOptions().preset(KdtreeOptions.Preset.TUNED).maxDepth(3).maxReferences(100000)
                .rulesOff(KdtreeOptions.COPLANAR | KdtreeOptions.RETRACTION), meshes())};
        for (Tree same : made) require(hash(same.trace(ORIGINS, DIRECTIONS)) == hash, "a builder changes the answers");
        require(made[2].info().structure() == TreeInfo.Structure.KDTREE && made[2].info().depth() <= 3, "a kd-tree's info");
        for (Tree same : made) same.close();
        var info = tree.info();
        require(info.structure() == TreeInfo.Structure.BVH && info.triangleCount() == 300 && info.memorySize() > 300 * 36
            && info.boundsMin()[0] < info.boundsMax()[0], info.toString());
        require(Mlrt.estimateTree(new TreeOptions(), meshes()).memorySize() > 0
            && Mlrt.estimateKdtree(new KdtreeOptions(), meshes()).peakMemorySize() > 0, "estimates");
        fails(Status.OUT_OF_MEMORY, () -> Tree.build(new TreeOptions().memoryLimit(1000), meshes()));
    }

    /** Every option together. */
    private static void testAllOptions(Pool pool, long hash) {
        List<String> lines = new ArrayList<>();
        Log log = (level, line) -> lines.add(line);
        var boxes = Tree.build(new TreeOptions().preset(TreeOptions.Preset.BEST).traversalCost(2).intersectionCost(0.5f)
            .memoryLimit(1 << 30).pool(pool).log(log).progress(fraction -> true), meshes());
        var kdtree = Tree.buildKdtree(new KdtreeOptions().preset(KdtreeOptions.Preset.TUNED).traversalCost(2).intersectionCost(0.5f)
            .memoryLimit(1 << 30).maxReferences(1000000).maxDepth(20).rulesOff(KdtreeOptions.COPLANAR).pool(pool).log(log)
            .progress(fraction -> true), meshes());
        var loaded = Tree.load(MemorySegment.ofArray(boxes.save()), new LoadOptions().memoryLimit(1 << 30).log(log));
        for (Tree same : new Tree[] {boxes, kdtree, loaded}) {
            require(hash(same.trace(ORIGINS, DIRECTIONS)) == hash, "options change the answers");
            same.close();
        }
        require(lines.size() >= 2, lines.toString());
        fails(Status.ARGUMENT, () -> Tree.build(new TreeOptions().traversalCost(-1), meshes()));
    }

    private static void testMeshes() {
        short[] narrow = new short[450];
        float[] plain = new float[1350], wide = new float[500];
        int[] quads = new int[600];
        for (int i = 0; i < 450; i++) {
            narrow[i] = (short) INDICES[0][i];
            quads[i / 3 * 4 + i % 3] = INDICES[0][i];
            System.arraycopy(VERTICES[0], 3 * INDICES[0][i], plain, 3 * i, 3);
        }
        for (int i = 0; i < 100; i++) System.arraycopy(VERTICES[0], 3 * i, wide, 5 * i, 3);
        var mesh = new Mesh(VERTICES[0], INDICES[0]);
        Mesh[] others = {new Mesh(VERTICES[0], narrow), new Mesh(plain),
            Mesh.of(Array.strided(MemorySegment.ofArray(wide), 20), Array.strided(MemorySegment.ofArray(quads), 16), 4)};
        long hash = hash(Tree.build(mesh).trace(ORIGINS, DIRECTIONS));
        for (Mesh same : others) {
            require(Mlrt.hashGeometry(same) == Mlrt.hashGeometry(mesh), "the hash depends on the layout");
            require(hash(Tree.build(same).trace(ORIGINS, DIRECTIONS)) == hash, "the layout changes the answers");
        }
        require(Mlrt.hashGeometry(meshes()) != Mlrt.hashGeometry(mesh), "hashes are equal");
    }

    private static boolean enough() {
        throw new ArithmeticException("enough");
    }

    private static void testCallbacks(Tree tree, Pool pool) {
        List<Double> fractions = Collections.synchronizedList(new ArrayList<>());
        List<String> lines = new ArrayList<>();
        Tree.build(new TreeOptions().pool(pool).progress(fractions::add).log((level, line) -> lines.add(level + line)), large()).close();
        require(!fractions.isEmpty() && fractions.getLast() == 1 && fractions.stream().sorted().toList().equals(fractions), fractions.toString());
        require(lines.stream().anyMatch(line -> line.startsWith("INFO")), lines.toString());
        fails(Status.CANCELLED, () -> Tree.build(new TreeOptions().progress(fraction -> false), large()));
        fails(ArithmeticException.class, () -> Tree.build(new TreeOptions().pool(pool).progress(fraction -> enough()), large()));
        fails(ArithmeticException.class, () -> Tree.build(new TreeOptions().log((level, line) -> enough()), large()));
        float[] many = new float[3000000];
        for (int i = 0; i < many.length; i++) many[i] = DIRECTIONS[i % DIRECTIONS.length];
        var job = new Rays(Array.all(0f, 0f, 0f), Array.of(many));
        fails(Status.CANCELLED, () -> tree.trace(job, new TraceOptions().method(Method.RAY).pool(pool).progress(fraction -> false)));
    }

    private static void testSaved(Tree tree, long hash) {
        byte[] data = tree.save();
        long geometry = Mlrt.hashGeometry(meshes());
        try (var arena = Arena.ofConfined()) {
            Tree[] loaded = {Tree.load(data), Tree.load(tree.save(arena), new LoadOptions().inPlace(true).geometryHash(geometry))};
            for (Tree same : loaded) {
                require(hash(same.trace(ORIGINS, DIRECTIONS)) == hash, "a saved tree has other answers");
                require(same.info().treeHash() == tree.info().treeHash(), "a saved tree has another hash");
                same.close();
            }
        }
        fails(Status.DATA, () -> Tree.load(MemorySegment.ofArray(data), new LoadOptions().geometryHash(1)));
        data[data.length - 1] ^= 1;
        fails(Status.DATA, () -> Tree.load(data));
    }

    private static void testOptions(Tree tree, Pool pool, long hash) {
        var can = Mlrt.capabilities();
        var narrowest = can.contains(Mlrt.Capability.SSE) ? TraceOptions.Isa.SSE
            : can.contains(Mlrt.Capability.NEON) ? TraceOptions.Isa.NEON : TraceOptions.Isa.SCALAR;
        TraceOptions[] ways = {new TraceOptions().method(Method.RAY), new TraceOptions().method(Method.TILE).isa(narrowest),
            new TraceOptions().pool(pool)};
        for (var options : ways) require(hash(tree.trace(rays(), options)) == hash, "an option changes the answers");
        var paper = new TraceOptions().method(Method.MULTILEVEL).culling(TraceOptions.Culling.DIRECT).cullingCheck(true)
            .initialTileSize(64).minimumTileSize(8).splitFactor(4).shortcutsOff(TraceOptions.WHOLE_TILES);
        try (var kdtree = Tree.buildKdtree(new KdtreeOptions(), meshes())) {
            require(hash(kdtree.trace(rays(), paper)) == hash, "the paper's method changes the answers");
        }
        fails(Status.UNSUPPORTED, () -> tree.trace(rays(), paper));
        fails(Status.ARGUMENT, () -> tree.trace(rays(), new TraceOptions().initialTileSize(5)));
        var counters = new Counters();
        tree.trace(rays(), new TraceOptions().counters(counters));
        tree.trace(rays(), new TraceOptions().counters(counters));
        require(counters.rayCount() == 2 * COUNT && counters.triangleTestCount() > 0, "counters");
        try (var threads = Executors.newFixedThreadPool(2); var shared = Pool.of(threads, 3)) {
            require(hash(tree.trace(rays(), new TraceOptions().pool(shared))) == hash, "an executor changes the answers");
            Tree.build(new TreeOptions().pool(shared), large()).close();
        }
    }

    private static void testArrays(Tree tree, Pool pool, Hits hits, long hash) throws InterruptedException {
        // Direct buffers and native segments go in as they are.
        var buffer = ByteBuffer.allocateDirect(12 * COUNT).order(ByteOrder.nativeOrder()).asFloatBuffer().put(0, ORIGINS);
        var given = new Rays(Array.of(buffer), Array.of(DIRECTIONS));
        try (var arena = Arena.ofShared()) {
            var same = Hits.allocate(COUNT, arena);
            var thread = new Thread(() -> tree.trace(given, new TraceOptions().pool(pool), same));
            thread.start();
            thread.join();
            require(hash(same) == hash, "a pool changes the answers");
            fails(IndexOutOfBoundsException.class, () -> tree.trace(given, new TraceOptions(), Hits.allocate(COUNT - 1, arena)));
            // Every second float receives t, the others nothing.
            var spread = arena.allocate(8 * COUNT);
            tree.trace(given, new TraceOptions(), new Hits(Array.strided(spread, 8), null, null, null, null, null, null));
            for (int i = 0; i < COUNT; i++) require(spread.getAtIndex(ValueLayout.JAVA_FLOAT, 2 * i) == hits.t(i)
                && spread.getAtIndex(ValueLayout.JAVA_FLOAT, 2 * i + 1) == 0, "strided results");
        }
        byte[] occluded = tree.occluded(given, new TraceOptions().pool(pool));
        var any = tree.trace(given, new TraceOptions().query(Query.ANY));
        for (int i = 0; i < COUNT; i++) {
            require((occluded[i] == 1) == (hits.mesh(i) != Mlrt.NONE) && any.occluded(i) == occluded[i], "any hit is a closest hit");
        }
        // Origin and direction side by side.
        float[] both = new float[6 * COUNT], zeros = new float[3 * COUNT], fan = Arrays.copyOf(ORIGINS, 600), written = new float[3 * COUNT];
        for (int i = 0; i < COUNT; i++) {
            System.arraycopy(ORIGINS, 3 * i, both, 6 * i, 3);
            System.arraycopy(DIRECTIONS, 3 * i, both, 6 * i + 3, 3);
            System.arraycopy(ORIGINS, i / 5 * 3, written, 3 * i, 3);
        }
        var memory = MemorySegment.ofArray(both);
        var strided = new Rays(Array.strided(memory, 24), Array.strided(memory.asSlice(12), 24));
        fails(IllegalArgumentException.class, () -> tree.trace(strided, new TraceOptions()));
        require(hash(tree.trace(strided.count(COUNT), new TraceOptions())) == hash, "strides change the answers");
        fails(IndexOutOfBoundsException.class, () -> tree.trace(strided.count(COUNT + 1), new TraceOptions()));
        require(hash(tree.trace(new Rays(Array.all(0f, 0f, 0f), Array.of(DIRECTIONS)), new TraceOptions()))
            == hash(tree.trace(zeros, DIRECTIONS)), "one origin for all changes the answers");
        require(hash(tree.trace(new Rays(fan, DIRECTIONS).raysPerOrigin(5), new TraceOptions()))
            == hash(tree.trace(written, DIRECTIONS)), "rays per origin change the answers");
    }

    private static void testRanges(Tree tree, Hits hits) {
        float[] limits = new float[COUNT];
        int[] skipped = new int[2 * COUNT], masks = new int[COUNT];
        for (int i = 0; i < COUNT; i++) {
            limits[i] = hits.t(i) * (i % 2 == 0 ? 0.999f : 1.001f);
            skipped[2 * i] = hits.mesh(i);
            skipped[2 * i + 1] = hits.triangle(i);
            masks[i] = 1 + i % 2;
        }
        var near = tree.trace(rays().tMin(Array.all(0f)).tMax(Array.of(limits)), new TraceOptions());
        var behind = tree.trace(rays().skip(Array.of(skipped)), new TraceOptions());
        boolean farther = false;
        for (int i = 0; i < COUNT; i++) {
            require(near.mesh(i) == (i % 2 == 0 ? Mlrt.NONE : hits.mesh(i)), "limits");
            require(behind.t(i) >= hits.t(i), "skipped triangles");
            farther |= behind.t(i) > hits.t(i);
        }
        require(farther, "nothing was skipped");
        try (var masked = Tree.build(new Mesh(VERTICES[0], INDICES[0]).id(7).mask(1), new Mesh(VERTICES[1], INDICES[1]).id(3).mask(2))) {
            var all = masked.trace(rays(), new TraceOptions().mask(2));
            var each = masked.trace(rays().mask(Array.of(masks)), new TraceOptions());
            for (int i = 0; i < COUNT; i++) {
                require(all.mesh(i) == Mlrt.NONE || all.mesh(i) == 3, "a mask for all");
                require(each.mesh(i) == Mlrt.NONE || each.mesh(i) == (i % 2 == 0 ? 7 : 3), "a mask for each");
            }
        }
    }

    private static void testLists(Tree tree, Pool pool, Hits hits) {
        var lists = tree.allHits(rays(), 4, new TraceOptions().pool(pool));
        var totals = tree.allHits(rays(), 0, new TraceOptions());
        for (int i = 0; i < COUNT; i++) {
            require(lists.t(4 * i) == hits.t(i) && lists.triangle(4 * i) == hits.triangle(i) && lists.mesh(4 * i) == hits.mesh(i), "first hits");
            require(lists.total(i) == totals.total(i) && lists.crossingTotal(i) <= lists.total(i), "totals");
        }
        require(totals.t() == null, "no room was asked for");
    }

    private static void testSingle(Tree tree, Hits hits) {
        try (var one = Tree.build(new Mesh(CORNERS))) {
            var hit = one.traceRay(DOWN, new TraceOptions());
            require(hit.equals(new Hit(5, 0.25f, 0.25f, 0, 0, 1)) && hit.isHit(), hit.toString());
            var ray = new Ray(DOWN.origin(), DOWN.direction());
            require(!one.traceRay(ray.tMax(4), new TraceOptions()).isHit(), "t_max");
            require(!one.traceRay(ray.tMin(5).tMax(0), new TraceOptions()).isHit(), "t_min");
            require(!one.occludedRay(ray.tMin(0).skip(0, 0), new TraceOptions()), "skip");
            require(one.occludedRay(DOWN, new TraceOptions()), "occluded");
            fails(Status.UNSUPPORTED, () -> one.traceRay(DOWN, new TraceOptions().method(Method.MULTILEVEL)));

            float[] point = one.offsetPoint(0, 0, hit.u(), hit.v(), -hit.facing());
            require(point[2] < 5 && point[2] > 4.99f, Arrays.toString(point));
            fails(Status.ARGUMENT, () -> one.offsetPoint(0, 1, 0, 0, 1));
            float[] points = {point[0], point[1], point[2], 0.25f, 0.25f, 6};
            var light = Light.point(0.25f, 0.25f, 0);
            require(Arrays.equals(one.occludedPoints(new Points(points), light, new TraceOptions()), new byte[] {0, 1}), "point light");
            require(Arrays.equals(one.occludedPoints(new Points(Array.of(points), Array.all(0, 0), 2), light, new TraceOptions()), new byte[2]), "skip");
            require(Arrays.equals(one.occludedPoints(new Points(points), Light.directional(0, 0, 1), new TraceOptions()), new byte[] {1, 0}), "sky");
        }
        for (int i = 0; i < 50; i++) {
            var ray = new Ray(Arrays.copyOfRange(ORIGINS, 3 * i, 3 * i + 3), Arrays.copyOfRange(DIRECTIONS, 3 * i, 3 * i + 3));
            var hit = tree.traceRay(ray, new TraceOptions());
            require(hit.t() == hits.t(i) && hit.triangle() == hits.triangle(i), "single rays have other answers");
        }
    }

    private static void testPictures(Tree tree, Pool pool) {
        Light[] lights = {Light.point(0, 10, -30), Light.directional(0, 1, -1)};
        var options = new TraceOptions().pool(pool).lights(lights);
        var frame = tree.render(camera(), options);
        var traced = tree.trace(Mlrt.cameraRays(camera()), new TraceOptions());
        var origins = Arena.ofAuto().allocate(12 * 1200);
        var directions = Arena.ofAuto().allocate(12 * 1200);
        Mlrt.cameraRays(camera(), Array.of(origins), Array.of(directions));
        int lit = 0;
        for (int i = 0; i < 1200; i++) {
            require(frame.t(i) == traced.t(i) && frame.triangle(i) == traced.triangle(i), "a picture has other answers");
            if (frame.facing(i) == 0) continue;
            var ray = new Ray(origins.asSlice(12 * i, 12).toArray(ValueLayout.JAVA_FLOAT), directions.asSlice(12 * i, 12).toArray(ValueLayout.JAVA_FLOAT));
            for (int k = 0; k < 2; k++) {
                var shadow = tree.shadowRay(ray, frame.mesh(i), frame.triangle(i), lights[k]);
                boolean dark = shadow == null || tree.occludedRay(shadow, new TraceOptions());
                require((frame.occluded(i) >> k & 1) == (dark ? 1 : 0), "shadows");
                if (!dark) lit++;
            }
        }
        require(lit > 0, "nothing is lit");
        fails(Status.ARGUMENT, () -> tree.shadowRay(DOWN, 99, 0, lights[0]));

        var any = tree.render(camera(), new TraceOptions().query(Query.ANY));
        var part = tree.render(camera().crop(8, 4, 16, 12), new TraceOptions());
        for (int i = 0; i < 1200; i++) require(any.occluded(i) == (frame.facing(i) == 0 ? 0 : 1), "any");
        for (int i = 0; i < 192; i++) require(part.t(i) == frame.t((4 + i / 16) * 40 + 8 + i % 16), "crop");
        var wide = Arena.ofAuto().allocate(400 * 12); // rows of a larger picture
        tree.render(camera().crop(8, 4, 16, 12), new TraceOptions(), new Hits(new Array(wide, 0, 400), null, null, null, null, null, null), null);
        for (int i = 0; i < 192; i++) require(wide.getAtIndex(ValueLayout.JAVA_FLOAT, 100 * (i / 16) + i % 16) == part.t(i), "rows");
        var flat = Camera.parallel(4, 4, new float[] {0, 0, 1}, new float[] {-1, -1, 0}, new float[] {0.5f, 0, 0}, new float[] {0, 0.5f, 0});
        try (var one = Tree.build(new Mesh(CORNERS))) {
            require(one.render(flat, new TraceOptions()).t(2 * 4 + 2) == 5, "parallel");
            require(one.render(flat.range(5, 0), new TraceOptions()).facing(10) == 0, "range");
            require(one.render(flat.range(0, 4), new TraceOptions()).facing(10) == 0, "range");
        }
        fails(Status.CAMERA, () -> tree.render(camera().sample(Float.NaN, 0), new TraceOptions()));

        int[] triangles = new int[1200], dark = new int[1200];
        tree.render(camera(), options.outputs(Output.TRIANGLE, Output.OCCLUDED).initialTileSize(16), null, tile -> {
            var hits = tile.hits();
            require(hits.t() == null, "an output that was not asked for");
            for (int j = 0; j < tile.height(); j++) {
                for (int i = 0; i < tile.width(); i++) {
                    int pixel = (tile.y() + j) * 40 + tile.x() + i;
                    triangles[pixel] = hits.triangle(j * tile.width() + i);
                    dark[pixel] = hits.occluded(j * tile.width() + i);
                }
            }
            return true;
        });
        for (int i = 0; i < 1200; i++) require(triangles[i] == frame.triangle(i) && dark[i] == frame.occluded(i), "tiles");
        fails(Status.CANCELLED, () -> tree.render(camera(), options, null, tile -> false));
        fails(ArithmeticException.class, () -> tree.render(camera(), options, null, tile -> enough()));
    }

    /** Without memory for results, which would be too much of it. */
    private static void testRefused(Tree tree) {
        var one = Array.all(0f, 0f, 1f);
        var options = new TraceOptions();
        for (long count : new long[] {1L << 31, 1L << 33, 1L << 62}) {
            fails(Status.TOO_LARGE, () -> tree.trace(new Rays(one, one).count(count), options));
            fails(Status.TOO_LARGE, () -> tree.occluded(new Rays(one, one).count(count), options));
            fails(Status.TOO_LARGE, () -> tree.allHits(new Rays(one, one).count(count), 0, options));
            fails(Status.TOO_LARGE, () -> Hits.allocate(count, Arena.global()));
            fails(Status.TOO_LARGE, () -> Hits.allocateOccluded(count, Arena.global()));
            fails(Status.TOO_LARGE, () -> HitLists.allocate(count, 0, Arena.global()));
        }
        fails(Status.TOO_LARGE, () -> tree.trace(new Rays(Array.of(new float[12]), one).raysPerOrigin(1 << 30), options));
        var large = Camera.lookAt(new float[] {0, 0, -30}, new float[3], new float[] {0, 1, 0}, 45, 1 << 23, 1 << 23);
        fails(Status.TOO_LARGE, () -> tree.render(large, options));
        fails(Status.TOO_LARGE, () -> Mlrt.cameraRays(large));
        List<Runnable> negative = List.of(() -> rays().count(-5), () -> rays().raysPerOrigin(-1), () -> rays().rowLength(-1),
            () -> Hits.allocate(-1, Arena.global()), () -> camera().crop(0, 0, -3, 0), () -> new Pool(-1), () -> Pool.of(Runnable::run, -1),
            () -> Camera.pinhole(-1, 4, new float[3], new float[3], new float[3], new float[3]), () -> options.initialTileSize(-16),
            () -> new TreeOptions().memoryLimit(1 << 31), () -> new LoadOptions().memoryLimit(-1),
            () -> new KdtreeOptions().memoryLimit(-1), () -> new KdtreeOptions().maxReferences(-1));
        for (var call : negative) require(fails(IllegalArgumentException.class, call).getMessage().contains("below"), "what is below 0");
        fails(IllegalArgumentException.class, () -> Tree.build(new Mesh(new float[15])));
        fails(NullPointerException.class, () -> Pool.of(null, 2));
        fails(ArithmeticException.class, () -> tree.trace(ORIGINS, DIRECTIONS).t(1L << 62));
        var other = ByteOrder.nativeOrder() == ByteOrder.LITTLE_ENDIAN ? ByteOrder.BIG_ENDIAN : ByteOrder.LITTLE_ENDIAN;
        var bytes = ByteBuffer.allocateDirect(12).order(other);
        fails(IllegalArgumentException.class, () -> Array.of(bytes.asFloatBuffer()));
        fails(IllegalArgumentException.class, () -> Array.of(bytes.asIntBuffer()));
        fails(IllegalArgumentException.class, () -> Array.of(bytes.asShortBuffer()));
    }

    private static void sharesMemory(Runnable call) {
        require(fails(IllegalArgumentException.class, call).getMessage().contains("shares memory"), "shared memory");
    }

    /** Results that have bytes in common with each other, or with rays. */
    private static void testSharedMemory(Tree tree, Hits hits) {
        var options = new TraceOptions();
        var arena = Arena.ofAuto();
        var room = arena.allocate(24 * COUNT, 64);
        var both = arena.allocate(28 * COUNT, 64);
        for (int i = 0; i < COUNT; i++) {
            MemorySegment.copy(ORIGINS, 3 * i, both, ValueLayout.JAVA_FLOAT, 28 * i, 3);
            MemorySegment.copy(DIRECTIONS, 3 * i, both, ValueLayout.JAVA_FLOAT, 28 * i + 12, 3);
        }
        var strided = new Rays(Array.strided(both, 28), Array.strided(both.asSlice(12), 28)).count(COUNT);
        sharesMemory(() -> tree.trace(rays(), options, closest(Array.of(room), Array.of(room.asSlice(4 * COUNT - 4)))));
        sharesMemory(() -> tree.trace(rays(), options, closest(Array.strided(room, 24), Array.of(room.asSlice(24)))));
        sharesMemory(() -> tree.trace(rays(), options, closest(Array.strided(room, 12), Array.strided(room.asSlice(12), 12))));
        sharesMemory(() -> tree.trace(strided, options, closest(Array.strided(both.asSlice(20), 28), null)));
        sharesMemory(() -> tree.allHits(rays(), options, new HitLists(0, null, null, null, null, null, null, null, Array.of(room), Array.of(room))));
        sharesMemory(() -> Mlrt.cameraRays(camera().crop(0, 0, 2, 2), Array.of(room), Array.of(room.asSlice(36))));

        // Records, halves and rows in turn do not.
        tree.trace(strided, options, closest(Array.strided(both.asSlice(24), 28), Array.of(room)));
        for (int i = 0; i < COUNT; i++) {
            require(both.getAtIndex(ValueLayout.JAVA_FLOAT, 7 * i + 6) == hits.t(i)
                && room.getAtIndex(ValueLayout.JAVA_FLOAT, i) == hits.u(i), "records");
        }
        var part = camera().crop(0, 0, 16, 12);
        var picture = tree.render(part, options);
        tree.render(part, options, closest(new Array(room, 0, 128), new Array(room.asSlice(64), 0, 128)), null);
        for (int i = 0; i < 192; i++) {
            require(room.getAtIndex(ValueLayout.JAVA_FLOAT, i / 16 * 32 + i % 16) == picture.t(i)
                && room.getAtIndex(ValueLayout.JAVA_FLOAT, i / 16 * 32 + 16 + i % 16) == picture.u(i), "rows in turn");
        }
        tree.render(part, options, closest(new Array(room, 48, 4), null), null); // transposed
        for (int i = 0; i < 192; i++) require(room.getAtIndex(ValueLayout.JAVA_FLOAT, i / 16 + i % 16 * 12) == picture.t(i), "transposed");
        sharesMemory(() -> tree.render(part, options, closest(new Array(room, 0, 128), new Array(room.asSlice(60), 0, 128)), null));
        for (var rows : new Array[] {new Array(room, 0, 60), new Array(room, 44, 4), new Array(room, 8, 64)}) {
            var problem = fails(IllegalArgumentException.class, () -> tree.render(part, options, closest(rows, null), null));
            require(problem.getMessage().contains("overlap"), "rows");
        }
    }

    private static Hits closest(Array t, Array u) {
        return new Hits(t, u, null, null, null, null, null);
    }

    /** What would wait for itself, and what is the library's no longer. */
    private static void testWithinCallbacks(Tree tree) throws InterruptedException {
        var many = new Rays(Array.all(0f, 0f, 0f), Array.of(new float[900000]));
        var options = new TraceOptions().outputs(Output.T).initialTileSize(16);
        List<Tile> tiles = Collections.synchronizedList(new ArrayList<>());
        List<Hits> hits = Collections.synchronizedList(new ArrayList<>());
        try (var own = new Pool(2); var other = new Pool(2)) {
            options.pool(own);
            var thread = new Thread(() -> {
                fails(IllegalStateException.class, () -> tree.render(camera(), options, null, tile -> {
                    tree.trace(many, new TraceOptions().pool(own));
                    return true;
                }));
                fails(IllegalStateException.class, () -> tree.render(camera(), options, null, tile -> {
                    tree.render(camera(), new TraceOptions().outputs(Output.T), null, inner -> {
                        tree.trace(many, new TraceOptions().pool(own));
                        return true;
                    });
                    return true;
                }));
                tree.render(camera(), options, null, tile -> {
                    tiles.add(tile);
                    hits.add(tile.hits());
                    tree.trace(many, new TraceOptions().pool(other));
                    return true;
                });
            });
            thread.setDaemon(true);
            thread.start();
            thread.join(60000);
            require(!thread.isAlive(), "a call in a callback waits for itself");
        }
        require(tiles.size() == 6, "tiles");
        for (var tile : tiles) fails(RuntimeException.class, tile::width); // ended, or of another thread
        for (var array : hits) fails(RuntimeException.class, () -> array.t(0));

        // Counts of calls at once, and in callbacks.
        var counters = new Counters();
        tree.render(camera(), new TraceOptions().outputs(Output.T).counters(counters).initialTileSize(16), null, tile -> {
            tree.trace(rays(), new TraceOptions().counters(counters));
            return counters.rayCount() % COUNT == 0;
        });
        require(counters.rayCount() == 1200 + 6 * COUNT, "counts " + counters.rayCount());
        // An executor must not be able to cancel what the library waits for.
        List<Runnable> tasks = Collections.synchronizedList(new ArrayList<>());
        try (var pool = Pool.of(tasks::add, 4)) {
            tree.render(camera(), new TraceOptions().pool(pool).initialTileSize(4));
        }
        require(!tasks.isEmpty() && tasks.stream().noneMatch(task -> task instanceof Future), "tasks that can be cancelled");
    }

    private static void testThreads() {
        var two = new Pool(2);
        try (var all = new Pool(0); var tasks = Pool.of(Runnable::run, 3)) {
            require(all.threads() >= 1 && two.threads() == 2 && tasks.threads() == 3, "threads of a pool");
        }
        two.close();
        require(two.threads() == 2, "threads of a closed pool");
    }

    private static void testErrors(Tree tree, Pool pool) {
        var wrong = new Mesh(new float[9], new int[] {0, 1, 2, 0, 1, 3});
        var problem = fails(MlrtException.class, () -> Tree.build(wrong));
        require(problem.status() == Status.INDEX_RANGE && problem.code() == 3, problem.getMessage());
        require(problem.getMessage().contains("triangle 1: vertex index 3"), problem.getMessage());
        fails(Status.ARGUMENT, () -> new Pool(5000));
        require(!Mlrt.statusString(3).isEmpty(), "what a status means");
        fails(IllegalArgumentException.class, () -> tree.trace(ORIGINS, new float[3]));
        fails(IllegalArgumentException.class, () -> tree.trace(new float[4], new float[4]));
        fails(IllegalArgumentException.class, () -> Tree.build(new Mesh(new float[4])));
        fails(IllegalArgumentException.class, () -> Tree.build(new Mesh(new float[9], new int[4])));

        // Sizes that are 0, or little, modulo 2^64.
        var empty = Array.of(new float[0]);
        fails(Status.TOO_LARGE, () -> tree.occluded(new Rays(empty, empty).count(1L << 62), new TraceOptions()));
        var two = Array.strided(MemorySegment.ofArray(new float[6]), 1L << 40);
        fails(IndexOutOfBoundsException.class, () -> tree.trace(new Rays(two, two).count((1L << 24) + 1), new TraceOptions(),
            new Hits(null, null, null, null, null, null, null)));
        fails(IllegalArgumentException.class, () -> tree.allHits(rays(), -1, new TraceOptions()));
        fails(IllegalArgumentException.class, () -> HitLists.allocate(Integer.MAX_VALUE, Integer.MAX_VALUE, Arena.global()));
        try (var arena = Arena.ofConfined()) {
            var one = Array.of(arena.allocate(4 * COUNT, 64));
            fails(IllegalArgumentException.class, () -> tree.allHits(rays(), new TraceOptions(), new HitLists(-1, one, null, null, null, null, null, null, null, null)));
        }

        // Memory that was freed.
        var freed = Arena.ofShared();
        var array = Array.of(freed.allocate(12 * COUNT, 64));
        var saved = tree.save(freed);
        var loaded = Tree.load(saved, new LoadOptions().inPlace(true));
        freed.close();
        fails(IllegalStateException.class, () -> tree.trace(new Rays(array, Array.of(DIRECTIONS)), new TraceOptions()));
        fails(IllegalStateException.class, () -> tree.trace(rays(), new TraceOptions(), new Hits(array, null, null, null, null, null, null)));
        fails(IllegalStateException.class, () -> Tree.build(Mesh.of(array, null, 0)));
        fails(IllegalStateException.class, () -> Tree.load(saved, new LoadOptions()));
        fails(IllegalStateException.class, () -> loaded.trace(ORIGINS, DIRECTIONS));
        loaded.close();

        fails(IllegalStateException.class, () -> tree.render(camera(), new TraceOptions().outputs(Output.T), null, tile -> {
            tree.close(); // which the render uses
            return true;
        }));
        pool.close();
        pool.close();
        fails(IllegalStateException.class, () -> tree.occluded(rays(), new TraceOptions().pool(pool)));
        tree.close();
        tree.close();
        fails(IllegalStateException.class, () -> tree.trace(ORIGINS, DIRECTIONS));
        require(Tree.build().trace(ORIGINS, DIRECTIONS).mesh(0) == Mlrt.NONE, "an empty tree"); // never closed
        System.gc();
    }

    public static void main(String[] arguments) throws Exception {
        makeScene();
        var tree = Tree.build(meshes());
        var pool = new Pool(2);
        var hits = tree.trace(ORIGINS, DIRECTIONS);
        long hash = hash(hits);
        require(Mlrt.version().matches("\\d+\\.\\d+\\.\\d+") && Mlrt.capabilities() != null, "version");
        testBuild(tree, pool, hash);
        testAllOptions(pool, hash);
        testMeshes();
        testCallbacks(tree, pool);
        testSaved(tree, hash);
        testOptions(tree, pool, hash);
        testThreads();
        testArrays(tree, pool, hits, hash);
        testRanges(tree, hits);
        testLists(tree, pool, hits);
        testSingle(tree, hits);
        testPictures(tree, pool);
        testRefused(tree);
        testSharedMemory(tree, hits);
        testWithinCallbacks(tree);
        testErrors(tree, pool);

        System.out.printf("%016x%n", hash);
        Native.TYPES.forEach(type -> print(type.layout()));
    }

    /** For a C compiler to look at. */
    private static void print(StructLayout layout) {
        String name = layout.name().orElseThrow();
        System.out.printf("layout %s sizeof %d%n", name, layout.byteSize());
        for (MemoryLayout member : layout.memberLayouts()) {
            String field = member.name().orElseThrow();
            System.out.printf("layout %s %s %d%n", name, field, layout.byteOffset(PathElement.groupElement(field)));
        }
    }
}
