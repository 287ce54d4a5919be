// SPDX-License-Identifier: MIT
package mlrt;

import static java.lang.foreign.MemoryLayout.PathElement.groupElement;
import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_BYTE;
import static java.lang.foreign.ValueLayout.JAVA_FLOAT;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.lang.foreign.AddressLayout;
import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.Linker;
import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.lang.foreign.SymbolLookup;
import java.lang.foreign.ValueLayout;
import java.lang.invoke.MethodHandle;
import java.lang.ref.Cleaner;
import java.lang.ref.Reference;
import java.util.Map;

/**
 * Where do rays hit triangles: the exact answers of libmlrt, for memory segments. Java 22 and later.
 *
 * <pre>{@code
 * try (var tree = new Mlrt.Tree(new Mlrt.Mesh(0, vertices, indices))) {  // float[], int[]
 *     var hits = tree.trace(origins, directions);                        // float[], three per ray
 *     System.out.println(hits.t(0) + " " + hits.triangle(0));
 * }
 * }</pre>
 *
 * Native segments, those of direct buffers too, go in without a copy; heap arrays are copied once. Results are native
 * segments. The library is that of the property {@code mlrt.path}, or else what the system finds as libmlrt.so.0.
 * Run with {@code --enable-native-access}.
 */
public final class Mlrt {
    /** Mesh and triangle of a miss. */
    public static final int NONE = -1;

    private Mlrt() {}

    // ---- the C interface: mlrt.h, as far as needed here --------------------------------------------------------------

    private static final AddressLayout P = ADDRESS;
    private static final ValueLayout.OfInt I = JAVA_INT;
    private static final ValueLayout.OfLong L = JAVA_LONG;
    private static final ValueLayout.OfFloat F = JAVA_FLOAT;

    private static StructLayout struct(String name, Object... typesAndNames) {
        var members = new MemoryLayout[typesAndNames.length / 2];
        for (int i = 0; i < members.length; i++) {
            members[i] = ((MemoryLayout) typesAndNames[2 * i]).withName((String) typesAndNames[2 * i + 1]);
        }
        return MemoryLayout.structLayout(members).withName(name);
    }

    static final StructLayout ARRAY = struct("mlrt_array", P, "data", L, "stride", L, "row_stride");
    static final StructLayout CONST_ARRAY = struct("mlrt_const_array", P, "data", L, "stride");
    static final StructLayout MESH = struct("mlrt_mesh", I, "struct_size", I, "id", P, "vertices", L, "vertex_count",
        L, "vertex_stride", P, "indices", L, "triangle_count", L, "triangle_stride", I, "index_size", I, "mask");
    static final StructLayout TREE_OPTIONS = struct("mlrt_tree_options", I, "struct_size", I, "preset", F, "traversal_cost",
        F, "intersection_cost", P, "message", L, "message_size", P, "host", L, "memory_limit", P, "pool");
    static final StructLayout TRACE_OPTIONS = struct("mlrt_trace_options", I, "struct_size", I, "query", I, "method", I, "isa",
        I, "culling", I, "culling_check", I, "initial_tile_size", I, "minimum_tile_size", I, "split_factor",
        I, "outputs", I, "shortcuts_off", I, "mask", P, "pool", P, "counters", P, "host",
        P, "lights", I, "light_count", I, "reserved");
    static final StructLayout HITS = struct("mlrt_hits", I, "struct_size", I, "reserved", ARRAY, "t", ARRAY, "u", ARRAY, "v",
        ARRAY, "mesh", ARRAY, "triangle", ARRAY, "facing", ARRAY, "occluded");
    static final StructLayout RAYS = struct("mlrt_rays", I, "struct_size", I, "row_length", L, "count",
        CONST_ARRAY, "origins", CONST_ARRAY, "directions", CONST_ARRAY, "t_min", CONST_ARRAY, "t_max",
        CONST_ARRAY, "skip", CONST_ARRAY, "mask", I, "rays_per_origin", I, "reserved");

    private static final SymbolLookup LIBRARY =
        SymbolLookup.libraryLookup(System.getProperty("mlrt.path", "libmlrt.so.0"), Arena.global());

    private static MethodHandle function(String name, MemoryLayout result, MemoryLayout... arguments) {
        var type = result == null ? FunctionDescriptor.ofVoid(arguments) : FunctionDescriptor.of(result, arguments);
        return Linker.nativeLinker().downcallHandle(LIBRARY.find(name).orElseThrow(), type);
    }

    private static final MethodHandle VERSION = function("mlrt_version", I);
    private static final MethodHandle STRUCT_SIZES = function("mlrt_struct_sizes", null, P, I);
    private static final MethodHandle STATUS_STRING = function("mlrt_status_string", P, I);
    private static final MethodHandle CREATE_POOL = function("mlrt_create_pool", I, I, P);
    private static final MethodHandle DESTROY_POOL = function("mlrt_destroy_pool", null, P);
    private static final MethodHandle BUILD = function("mlrt_build_tree", I, P, L, P, P);
    private static final MethodHandle DESTROY_TREE = function("mlrt_destroy_tree", null, P);
    private static final MethodHandle TRACE = function("mlrt_trace_packet", I, P, P, P, P);

    /** By their numbers MLRT_STRUCT_*. */
    static final Map<Integer, StructLayout> PLACES =
        Map.of(1, MESH, 2, TREE_OPTIONS, 8, TRACE_OPTIONS, 9, ARRAY, 10, HITS, 11, CONST_ARRAY, 12, RAYS);

    // Of the version that this file was written for, each layout must be the library's.
    static {
        try (var arena = Arena.ofConfined()) {
            var sizes = arena.allocate(I, 13);
            STRUCT_SIZES.invokeExact(sizes, 13);
            boolean sameVersion = (int) VERSION.invokeExact() == 100;
            PLACES.forEach((place, layout) -> {
                if (sameVersion && sizes.getAtIndex(I, place) != layout.byteSize())
                    throw new LinkageError("mlrt: not the library's: " + layout);
            });
        } catch (Throwable problem) {
            throw unexpected(problem);
        }
    }

    /** A native function declares no exceptions, but MethodHandle does. */
    private static RuntimeException unexpected(Throwable problem) {
        if (problem instanceof Error error) throw error;
        return problem instanceof RuntimeException exception ? exception : new RuntimeException(problem);
    }

    /** A struct in native memory, zero but for its size. */
    private record Struct(StructLayout layout, MemorySegment memory) {
        Struct(StructLayout layout, Arena arena) {
            this(layout, arena.allocate(layout));
            memory.set(I, 0, (int) layout.byteSize());
        }

        private long at(String field) {
            return layout.byteOffset(groupElement(field)); // arrays begin with their address
        }

        Struct set(String field, int value) {
            memory.set(I, at(field), value);
            return this;
        }

        Struct set(String field, long value) {
            memory.set(L, at(field), value);
            return this;
        }

        Struct set(String field, MemorySegment value) {
            memory.set(P, at(field), value);
            return this;
        }
    }

    // ---- errors ------------------------------------------------------------------------------------------------------

    /** What the library says went wrong. */
    public static final class MlrtException extends RuntimeException {
        private static final long serialVersionUID = 1;

        /** MLRT_ERROR_* */
        public final int status;

        MlrtException(int status, String details) {
            super(text(status) + (details.isEmpty() ? "" : ": " + details));
            this.status = status;
        }

        private static String text(int status) {
            try {
                return ((MemorySegment) STATUS_STRING.invokeExact(status)).reinterpret(Long.MAX_VALUE).getString(0);
            } catch (Throwable problem) {
                throw unexpected(problem);
            }
        }
    }

    private static void check(int status, String details) {
        if (status != 0) throw new MlrtException(status, details);
    }

    // ---- handles -----------------------------------------------------------------------------------------------------

    private static final Cleaner CLEANER = Cleaner.create();

    /** What a Tree and a Pool have in common: freed by close(), or some time after the last use. */
    private abstract static class Handle implements AutoCloseable {
        final Arena arena = Arena.ofShared();
        final MemorySegment handle; // which throws when used after close, and keeps close from freeing it during a call

        Handle(MemorySegment made, MethodHandle destroy) {
            handle = made.reinterpret(arena, memory -> {
                try {
                    destroy.invokeExact(memory);
                } catch (Throwable problem) {
                    throw unexpected(problem);
                }
            });
            Arena owned = arena;
            CLEANER.register(this, () -> close(owned));
        }

        private static synchronized void close(Arena arena) {
            if (arena.scope().isAlive()) arena.close();
        }

        /** Frees it now; IllegalStateException if a call is using it. Again does nothing. */
        @Override
        public void close() {
            close(arena);
        }
    }

    /** Threads that calls share their work with. Calls that share one wait for each other. */
    public static final class Pool extends Handle {
        /** `threads` at work, the calling one included; 0 = one per processor. */
        public Pool(int threads) {
            super(create(threads), DESTROY_POOL);
        }

        private static MemorySegment create(int threads) {
            try (var scratch = Arena.ofConfined()) {
                var out = scratch.allocate(P);
                check((int) CREATE_POOL.invokeExact(threads, out), "");
                return out.get(P, 0);
            } catch (Throwable problem) {
                throw unexpected(problem);
            }
        }

        @Override
        public synchronized void close() {
            super.close();
        }
    }

    /** An indexed mesh: three floats a vertex, three ints a triangle. If all ids are 0, they become 0, 1, 2, ... */
    public record Mesh(int id, MemorySegment vertices, MemorySegment indices) {
        public Mesh(int id, float[] vertices, int[] indices) {
            this(id, MemorySegment.ofArray(vertices), MemorySegment.ofArray(indices));
        }
    }

    /** The closest hits, an element per ray. A miss has an infinite t, and mesh = triangle = NONE. */
    public record Hits(MemorySegment t, MemorySegment u, MemorySegment v, MemorySegment mesh, MemorySegment triangle,
                       MemorySegment facing) {
        /** Room for `rays` hits. */
        public Hits(long rays, Arena arena) {
            this(arena.allocate(F, rays), arena.allocate(F, rays), arena.allocate(F, rays), arena.allocate(I, rays),
                arena.allocate(I, rays), arena.allocate(I, rays));
        }

        public float t(long ray) { return t.getAtIndex(F, ray); }
        public float u(long ray) { return u.getAtIndex(F, ray); }
        public float v(long ray) { return v.getAtIndex(F, ray); }
        public int mesh(long ray) { return mesh.getAtIndex(I, ray); }
        public int triangle(long ray) { return triangle.getAtIndex(I, ray); }
        public int facing(long ray) { return facing.getAtIndex(I, ray); }
    }

    private static final int TRIPLE = 12;

    private static long triples(MemorySegment segment) {
        if (segment.byteSize() % TRIPLE != 0) throw new IllegalArgumentException("three numbers each are needed");
        return segment.byteSize() / TRIPLE;
    }

    private static MemorySegment toNative(MemorySegment segment, Arena arena) {
        return segment.isNative() ? segment : arena.allocate(segment.byteSize(), 4).copyFrom(segment);
    }

    /** Triangles, and what finds them. Never changes; any number of threads may trace it. */
    public static final class Tree extends Handle {
        public Tree(Mesh... meshes) {
            super(build(meshes), DESTROY_TREE);
        }

        private static MemorySegment build(Mesh[] meshes) {
            try (var scratch = Arena.ofConfined()) {
                var list = scratch.allocate(MESH, meshes.length);
                for (int i = 0; i < meshes.length; i++) {
                    var struct = new Struct(MESH, list.asSlice(i * MESH.byteSize(), MESH));
                    struct.set("struct_size", (int) MESH.byteSize()).set("id", meshes[i].id)
                        .set("vertices", toNative(meshes[i].vertices, scratch))
                        .set("vertex_count", triples(meshes[i].vertices))
                        .set("indices", toNative(meshes[i].indices, scratch))
                        .set("triangle_count", triples(meshes[i].indices));
                }
                var message = scratch.allocate(256);
                var options = new Struct(TREE_OPTIONS, scratch).set("message", message).set("message_size", 256L);
                var out = scratch.allocate(P);
                int status = (int) BUILD.invokeExact(list, (long) meshes.length, options.memory, out);
                check(status, message.getString(0));
                return out.get(P, 0);
            } catch (Throwable problem) {
                throw unexpected(problem);
            } finally {
                Reference.reachabilityFence(meshes);
            }
        }

        /** The closest hit of each ray, in memory that the garbage collector frees. */
        public Hits trace(float[] origins, float[] directions) {
            var hits = new Hits(origins.length / 3, Arena.ofAuto());
            trace(MemorySegment.ofArray(origins), MemorySegment.ofArray(directions), null, hits);
            return hits;
        }

        /** The same into memory of the caller's. The pool may be null. No segment may be closed meanwhile. */
        public void trace(MemorySegment origins, MemorySegment directions, Pool pool, Hits hits) {
            try (var scratch = Arena.ofConfined()) {
                var out = new Struct(HITS, scratch);
                out.set("t", room(hits.t, origins, 4)).set("u", room(hits.u, origins, 4)).set("v", room(hits.v, origins, 4))
                    .set("mesh", room(hits.mesh, origins, 4)).set("triangle", room(hits.triangle, origins, 4))
                    .set("facing", room(hits.facing, origins, 4));
                call(origins, directions, 0, pool, out, scratch);
            } finally {
                Reference.reachabilityFence(hits);
            }
        }

        /** Does the ray hit anything? 1 or 0 for each ray. The pool may be null. */
        public byte[] occluded(MemorySegment origins, MemorySegment directions, Pool pool) {
            try (var scratch = Arena.ofConfined()) {
                var occluded = scratch.allocate(triples(origins));
                call(origins, directions, 1, pool, new Struct(HITS, scratch).set("occluded", occluded), scratch);
                return occluded.toArray(JAVA_BYTE);
            }
        }

        private static MemorySegment room(MemorySegment segment, MemorySegment origins, int size) {
            if (segment.byteSize() < triples(origins) * size) throw new IndexOutOfBoundsException("too short for the hits");
            if (!segment.isNative() || segment.isReadOnly())
                throw new IllegalArgumentException("hits go to native memory that can be written");
            return segment;
        }

        private void call(MemorySegment origins, MemorySegment directions, int query, Pool pool, Struct out,
                          Arena scratch) {
            if (triples(origins) != triples(directions))
                throw new IllegalArgumentException("as many origins as directions are needed");
            var rays = new Struct(RAYS, scratch).set("count", triples(origins))
                .set("origins", toNative(origins, scratch)).set("directions", toNative(directions, scratch));
            var options = new Struct(TRACE_OPTIONS, scratch).set("query", query);
            try {
                if (pool == null) {
                    check((int) TRACE.invokeExact(handle, rays.memory, options.memory, out.memory), "");
                } else {
                    synchronized (pool) { // close() waits
                        if (!pool.arena.scope().isAlive()) throw new IllegalStateException("the pool is closed");
                        options.set("pool", pool.handle);
                        check((int) TRACE.invokeExact(handle, rays.memory, options.memory, out.memory), "");
                    }
                }
            } catch (Throwable problem) {
                throw unexpected(problem);
            } finally {
                Reference.reachabilityFence(origins);
                Reference.reachabilityFence(directions);
                Reference.reachabilityFence(pool);
                Reference.reachabilityFence(this);
            }
        }
    }
}
