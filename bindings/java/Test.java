// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemoryLayout.PathElement;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;

/** The scene of bindings/c/scene.h: prints the hash of the answers, and checks errors and closing. */
final class Test {
    private static int state = 1;

    private static int draw() {
        state = state * 1664525 + 1013904223;
        return state >>> 20;
    }

    private static void coordinates(float[] array, int first, int count, float divisor) {
        for (int i = first; i < first + count; i++) array[i] = (draw() - 2048) / divisor;
    }

    private static long hash(Mlrt.Hits hits, int rays) {
        long hash = 0xCBF29CE484222325L;
        for (int i = 0; i < rays; i++) {
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

    public static void main(String[] arguments) throws Exception {
        var meshes = new Mlrt.Mesh[2];
        var vertices = new float[2][300];
        var indices = new int[2][450];
        for (int m = 0; m < 2; m++) {
            coordinates(vertices[m], 0, 300, 256);
            for (int i = 0; i < 450; i++) indices[m][i] = draw() % 100;
            meshes[m] = new Mlrt.Mesh(m == 0 ? 7 : 3, vertices[m], indices[m]);
        }
        float[] origins = new float[3000], directions = new float[3000];
        for (int i = 0; i < 1000; i++) {
            coordinates(origins, 3 * i, 3, 256);
            coordinates(directions, 3 * i, 3, 2048);
            for (int k = 0; k < 3 && i % 4 == 3; k++) {
                directions[3 * i + k] = vertices[0][3 * (i % 100) + k] - origins[3 * i + k];
            }
        }

        var tree = new Mlrt.Tree(meshes);
        var pool = new Mlrt.Pool(2);
        var hits = tree.trace(origins, directions);
        long hash = hash(hits, 1000);

        // Direct buffers and native segments go in as they are.
        var buffer = ByteBuffer.allocateDirect(12000).order(ByteOrder.nativeOrder()).asFloatBuffer().put(0, origins);
        var others = MemorySegment.ofArray(directions);
        try (var arena = Arena.ofShared()) {
            var same = new Mlrt.Hits(1000, arena);
            var thread = new Thread(() -> tree.trace(MemorySegment.ofBuffer(buffer), others, pool, same));
            thread.start();
            thread.join();
            require(hash(same, 1000) == hash, "a pool changes the answers");
            var few = new Mlrt.Hits(999, arena);
            fails(IndexOutOfBoundsException.class, () -> tree.trace(MemorySegment.ofBuffer(buffer), others, pool, few));
        }
        byte[] occluded = tree.occluded(MemorySegment.ofBuffer(buffer), others, pool);
        for (int i = 0; i < 1000; i++) require((occluded[i] == 1) == (hits.mesh(i) != Mlrt.NONE), "any hit is a closest hit");

        var wrong = new Mlrt.Mesh(0, new float[9], new int[] {0, 1, 2, 0, 1, 3});
        var problem = fails(Mlrt.MlrtException.class, () -> new Mlrt.Tree(wrong));
        require(problem.status == 3 && problem.getMessage().contains("triangle 1: vertex index 3"), problem.getMessage());
        require(fails(Mlrt.MlrtException.class, () -> new Mlrt.Pool(5000)).status == 1, "too many threads");
        fails(IllegalArgumentException.class, () -> tree.trace(origins, new float[3]));
        fails(IllegalArgumentException.class, () -> tree.trace(new float[4], new float[4]));

        pool.close();
        pool.close();
        fails(IllegalStateException.class, () -> tree.occluded(others, others, pool));
        tree.close();
        tree.close();
        fails(IllegalStateException.class, () -> tree.trace(origins, directions));
        require(new Mlrt.Tree().trace(origins, directions).mesh(0) == Mlrt.NONE, "an empty tree"); // never closed
        System.gc();

        System.out.printf("%016x%n", hash);
        Mlrt.PLACES.values().forEach(Test::print);
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
