// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.EnumSet;
import java.util.Set;

/** What needs no tree. */
public final class Mlrt {
    /** Mesh and triangle of a miss. */
    public static final int NONE = -1;

    private Mlrt() {}

    /** Instruction sets that a library can have. */
    public enum Capability {
        /** SSE2. */
        SSE,
        /** AVX2 and FMA. */
        AVX2,
        /** AVX-512. */
        AVX512,
        /** NEON, on aarch64. */
        NEON
    }

    /**
     * The library's version.
     *
     * @return three numbers, as in 0.1.0
     */
    public static String version() {
        try {
            int number = (int) Native.VERSION.invokeExact();
            return number / 10000 + "." + number / 100 % 100 + "." + number % 100;
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The instruction sets that the library has and this machine can run.
     *
     * @return the set
     */
    public static Set<Capability> capabilities() {
        try {
            long bits = (long) Native.CAPABILITIES.invokeExact();
            var all = EnumSet.allOf(Capability.class);
            all.removeIf(one -> (bits >> one.ordinal() & 1) == 0);
            return all;
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /** What a status means. */
    static String statusString(int status) {
        try {
            return Native.string((MemorySegment) Native.STATUS_STRING.invokeExact(status));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * A hash of meshes, by which a saved tree can be known to be theirs.
     *
     * @param meshes the meshes
     * @return the hash, all of whose 64 bits count
     */
    public static long hashGeometry(Mesh... meshes) {
        try (var call = new Call()) {
            var list = Mesh.toNative(meshes, call);
            var hash = call.allocate(Long.BYTES);
            call.check((int) Native.HASH_GEOMETRY.invokeExact(list, (long) meshes.length, hash));
            return hash.get(Native.L, 0);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    private static MemoryEstimate read(Native.Struct estimate) {
        return new MemoryEstimate(estimate.getLong("memory_size"), estimate.getLong("peak_memory_size"));
    }

    /**
     * The memory that {@link Tree#build(TreeOptions, Mesh...)} will take, from the numbers of triangles alone.
     *
     * @param options how it would build
     * @param meshes the meshes
     * @return the estimate
     */
    public static MemoryEstimate estimateTree(TreeOptions options, Mesh... meshes) {
        try (var call = new Call()) {
            var list = Mesh.toNative(meshes, call);
            var estimate = call.struct(Native.MEMORY_ESTIMATE);
            var settings = options.toStruct(call).memory();
            call.check((int) Native.ESTIMATE_TREE.invokeExact(list, (long) meshes.length, settings, estimate.memory()));
            return read(estimate);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The memory that {@link Tree#buildKdtree} will take: a guess, which can be off by a factor of two.
     *
     * @param options how it would build
     * @param meshes the meshes
     * @return the estimate
     */
    public static MemoryEstimate estimateKdtree(KdtreeOptions options, Mesh... meshes) {
        try (var call = new Call()) {
            var list = Mesh.toNative(meshes, call);
            var estimate = call.struct(Native.MEMORY_ESTIMATE);
            var settings = options.toStruct(call).memory();
            call.check((int) Native.ESTIMATE_KDTREE.invokeExact(list, (long) meshes.length, settings, estimate.memory()));
            return read(estimate);
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }

    /**
     * The rays of a camera's pixels, row by row: tracing them gives what {@link Tree#render} gives.
     *
     * @param camera the camera; its range of t is not written
     * @return the rays, in memory that the garbage collector frees
     */
    public static Rays cameraRays(Camera camera) {
        long count = camera.pixels();
        var arena = Arena.ofAuto();
        var origins = arena.allocate(12 * count, 64);
        var directions = arena.allocate(12 * count, 64);
        cameraRays(camera, Array.of(origins), Array.of(directions));
        return new Rays(Array.of(origins), Array.of(directions)).rowLength(camera.columns());
    }

    /**
     * The same into memory of the caller's.
     *
     * @param camera the camera; its range of t is not written
     * @param origins where origins go, three floats each; null = nowhere
     * @param directions where directions go, three floats each; null = nowhere
     */
    public static void cameraRays(Camera camera, Array origins, Array directions) {
        try (var call = new Call()) {
            // Two arrays, as a struct has them.
            var arrays = call.struct(Native.HITS);
            call.output(arrays, "t", origins, camera.columns(), camera.rows(), 12, "origins");
            call.output(arrays, "u", directions, camera.columns(), camera.rows(), 12, "directions");
            var first = arrays.memory().asSlice(Native.HITS.offsets().get("t"), Native.ARRAY.size());
            var second = arrays.memory().asSlice(Native.HITS.offsets().get("u"), Native.ARRAY.size());
            call.check((int) Native.CAMERA_RAYS.invokeExact(camera.toStruct(call).memory(), first, second));
        } catch (Throwable problem) {
            throw Native.unexpected(problem);
        }
    }
}
