// SPDX-License-Identifier: MIT
package mlrt;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_FLOAT;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.io.IOException;
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
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;

/** The C interface: the library's file, the structs of mlrt.h, and its functions. */
final class Native {
    private Native() {}

    // ---- structs -----------------------------------------------------------------------------------------------------

    static final AddressLayout P = ADDRESS;
    static final ValueLayout.OfInt I = JAVA_INT;
    static final ValueLayout.OfLong L = JAVA_LONG;
    static final ValueLayout.OfFloat F = JAVA_FLOAT;
    private static final MemoryLayout F3 = MemoryLayout.sequenceLayout(3, F);

    /** A struct: its layout, and where its fields are. */
    record Type(StructLayout layout, Map<String, Long> offsets) {
        /** Of types, each followed by the names that have it, in one string. */
        static Type of(String name, Object... typesAndNames) {
            List<MemoryLayout> members = new ArrayList<>();
            Map<String, Long> offsets = new HashMap<>();
            long offset = 0;
            for (int i = 0; i < typesAndNames.length; i += 2) {
                var type = typesAndNames[i] instanceof Type struct ? struct.layout : (MemoryLayout) typesAndNames[i];
                for (String field : ((String) typesAndNames[i + 1]).split(" ")) {
                    members.add(type.withName(field));
                    offsets.put(field, offset);
                    offset += type.byteSize();
                }
            }
            return new Type(MemoryLayout.structLayout(members.toArray(MemoryLayout[]::new)).withName(name), Map.copyOf(offsets));
        }

        long size() {
            return layout.byteSize();
        }
    }

    static final Type HOST = Type.of("mlrt_host", I, "struct_size reserved", P, "user allocate free log progress");
    static final Type MESH = Type.of("mlrt_mesh", I, "struct_size id", P, "vertices", L, "vertex_count vertex_stride",
        P, "indices", L, "triangle_count triangle_stride", I, "index_size mask");
    static final Type TREE_OPTIONS = Type.of("mlrt_tree_options", I, "struct_size preset", F, "traversal_cost intersection_cost",
        P, "message", L, "message_size", P, "host", L, "memory_limit", P, "pool");
    static final Type KDTREE_OPTIONS = Type.of("mlrt_kdtree_options", I, "struct_size preset",
        F, "traversal_cost intersection_cost", P, "message", L, "message_size", P, "host", L, "memory_limit max_references",
        I, "max_depth rules_off", P, "pool");
    static final Type MEMORY_ESTIMATE = Type.of("mlrt_memory_estimate", I, "struct_size reserved", L, "memory_size peak_memory_size");
    static final Type TREE_INFO = Type.of("mlrt_tree_info", I, "struct_size depth",
        L, "triangle_count non_finite_count zero_area_count node_count leaf_count empty_leaf_count reference_count "
            + "retracted_count memory_size peak_memory_size tree_hash",
        ValueLayout.JAVA_DOUBLE, "sah_cost build_seconds", F3, "bounds_min bounds_max", I, "structure reserved");
    static final Type LOAD_OPTIONS = Type.of("mlrt_load_options", I, "struct_size flags", L, "geometry_hash memory_limit",
        P, "message", L, "message_size", P, "host");
    static final Type POOL_OPTIONS = Type.of("mlrt_pool_options", I, "struct_size thread_count", P, "host user enqueue finish");
    static final Type COUNTERS = Type.of("mlrt_counters", I, "struct_size reserved",
        L, "ray_count packet_count beam_count cell_count entry_point_cell_count triangle_test_count judged_lane_count "
            + "entry_point_count entry_point_depth_sum missed_beam_count covered_beam_count undecided_cull_count "
            + "undecided_checked_count lane_test_count undecided_test_count tie_lane_count exact_edge_count "
            + "exact_range_count exact_order_count");
    static final Type TRACE_OPTIONS = Type.of("mlrt_trace_options", I, "struct_size query method isa culling culling_check "
        + "initial_tile_size minimum_tile_size split_factor outputs shortcuts_off mask", P, "pool counters host lights",
        I, "light_count reserved");
    static final Type ARRAY = Type.of("mlrt_array", P, "data", L, "stride row_stride");
    static final Type CONST_ARRAY = Type.of("mlrt_const_array", P, "data", L, "stride");
    static final Type HITS = Type.of("mlrt_hits", I, "struct_size reserved", ARRAY, "t u v mesh triangle facing occluded");
    static final Type HIT_LISTS = Type.of("mlrt_hit_lists", I, "struct_size capacity",
        ARRAY, "t u v mesh triangle facing crossing total crossing_total");
    static final Type RAYS = Type.of("mlrt_rays", I, "struct_size row_length", L, "count",
        CONST_ARRAY, "origins directions t_min t_max skip mask", I, "rays_per_origin reserved");
    static final Type RAY = Type.of("mlrt_ray", I, "struct_size flags", F3, "origin direction", F, "t_min t_max",
        I, "skip_mesh skip_triangle");
    static final Type HIT = Type.of("mlrt_hit", I, "struct_size", F, "t u v", I, "mesh triangle facing occluded");
    static final Type CAMERA = Type.of("mlrt_camera", I, "struct_size projection width height crop_x crop_y crop_width crop_height",
        F3, "eye direction d00 dx dy", F, "sample_x sample_y t_min t_max");
    static final Type TILE = Type.of("mlrt_tile", I, "struct_size worker x y width height",
        P, "t u v mesh triangle facing occluded");
    static final Type LIGHT = Type.of("mlrt_light", I, "struct_size kind", F3, "position");
    static final Type POINTS = Type.of("mlrt_points", I, "struct_size row_length", L, "count", CONST_ARRAY, "positions skip");

    /** By their numbers, MLRT_STRUCT_*. */
    static final List<Type> TYPES = List.of(HOST, MESH, TREE_OPTIONS, TREE_INFO, MEMORY_ESTIMATE, LOAD_OPTIONS, POOL_OPTIONS,
        COUNTERS, TRACE_OPTIONS, ARRAY, HITS, CONST_ARRAY, RAYS, RAY, HIT, HIT_LISTS, CAMERA, TILE, LIGHT, POINTS, KDTREE_OPTIONS);

    /** A struct in native memory. */
    record Struct(Type type, MemorySegment memory) {
        /** Zero but for its size. */
        static Struct make(Type type, Arena arena) {
            return new Struct(type, arena.allocate(type.layout)).set("struct_size", (int) type.size());
        }

        private long at(String field) {
            return type.offsets.get(field);
        }

        Struct set(String field, int value) {
            memory.set(I, at(field), value);
            return this;
        }

        Struct set(String field, long value) {
            memory.set(L, at(field), value);
            return this;
        }

        Struct set(String field, float value) {
            memory.set(F, at(field), value);
            return this;
        }

        Struct set(String field, MemorySegment value) {
            memory.set(P, at(field), value);
            return this;
        }

        Struct set(String field, float[] value) {
            if (value.length != 3) throw new IllegalArgumentException(field + ": three numbers are needed, not " + value.length);
            MemorySegment.copy(value, 0, memory, F, at(field), 3);
            return this;
        }

        int getInt(String field) {
            return memory.get(I, at(field));
        }

        long getLong(String field) {
            return memory.get(L, at(field));
        }

        float getFloat(String field) {
            return memory.get(F, at(field));
        }

        double getDouble(String field) {
            return memory.get(ValueLayout.JAVA_DOUBLE, at(field));
        }

        float[] getVector(String field) {
            return memory.asSlice(at(field), 12).toArray(F);
        }

        MemorySegment getAddress(String field) {
            return memory.get(P, at(field));
        }
    }

    // ---- the library -------------------------------------------------------------------------------------------------

    /** As in the jar: linux-x86_64. */
    private static String machine() {
        String system = System.getProperty("os.name").toLowerCase(Locale.ROOT).split(" ")[0];
        String processor = System.getProperty("os.arch");
        return system + "-" + (processor.equals("amd64") ? "x86_64" : processor);
    }

    private static SymbolLookup open() {
        String path = System.getProperty("mlrt.path");
        if (path != null) return SymbolLookup.libraryLookup(Path.of(path).toAbsolutePath(), Arena.global());
        String file = System.mapLibraryName("mlrt");
        for (String folder : System.getProperty("java.library.path", "").split(System.getProperty("path.separator"))) {
            Path library = Path.of(folder, file);
            if (!folder.isEmpty() && Files.exists(library)) return SymbolLookup.libraryLookup(library.toAbsolutePath(), Arena.global());
        }
        var inside = Native.class.getResource("native/" + machine() + "/" + file);
        if (inside != null) return extract(inside, file);
        try {
            return SymbolLookup.libraryLookup("libmlrt.so.0", Arena.global());
        } catch (IllegalArgumentException missing) {
            throw new UnsatisfiedLinkError("mlrt: this jar has no library for " + machine() + ", and the system has none: install "
                + "libmlrt (make install), and name its file by -Dmlrt.path=FILE, or its folder by -Djava.library.path=FOLDER");
        }
    }

    /** Loads the library of the jar by way of a temporary file. */
    private static SymbolLookup extract(java.net.URL inside, String file) {
        Path copy = null;
        try (var stream = inside.openStream()) {
            copy = Files.createTempFile("mlrt", file);
            Files.copy(stream, copy, StandardCopyOption.REPLACE_EXISTING);
            return SymbolLookup.libraryLookup(copy, Arena.global());
        } catch (IOException | IllegalArgumentException problem) {
            var error = new UnsatisfiedLinkError("mlrt: the library in the jar cannot be loaded from " + copy + " ("
                + problem.getMessage() + "): name a folder that files can be loaded from by -Djava.io.tmpdir=FOLDER, or an "
                + "installed library by -Dmlrt.path=FILE");
            error.initCause(problem);
            throw error;
        } finally {
            // Where a library that is in use can't be deleted, it goes when the program ends.
            if (copy != null && !copy.toFile().delete()) copy.toFile().deleteOnExit();
        }
    }

    private static final SymbolLookup LIBRARY = open();
    static final Linker LINKER = Linker.nativeLinker();

    private static MethodHandle function(String name, MemoryLayout result, MemoryLayout... arguments) {
        var type = result == null ? FunctionDescriptor.ofVoid(arguments) : FunctionDescriptor.of(result, arguments);
        var address = LIBRARY.find(name).orElseThrow(() -> new UnsatisfiedLinkError("mlrt: the library has no " + name
            + ": it is older than this jar"));
        return LINKER.downcallHandle(address, type);
    }

    static final MethodHandle VERSION = function("mlrt_version", I);
    static final MethodHandle CAPABILITIES = function("mlrt_capabilities", L);
    static final MethodHandle STATUS_STRING = function("mlrt_status_string", P, I);
    static final MethodHandle LAST_MESSAGE = function("mlrt_last_message", P);
    static final MethodHandle CREATE_POOL = function("mlrt_create_pool", I, I, P);
    static final MethodHandle CREATE_POOL_WITH_OPTIONS = function("mlrt_create_pool_with_options", I, P, P);
    static final MethodHandle POOL_THREAD_COUNT = function("mlrt_pool_thread_count", I, P);
    static final MethodHandle DESTROY_POOL = function("mlrt_destroy_pool", null, P);
    static final MethodHandle BUILD_TREE = function("mlrt_build_tree", I, P, L, P, P);
    static final MethodHandle BUILD_KDTREE = function("mlrt_build_kdtree", I, P, L, P, P);
    static final MethodHandle DESTROY_TREE = function("mlrt_destroy_tree", null, P);
    static final MethodHandle GET_TREE_INFO = function("mlrt_get_tree_info", I, P, P);
    static final MethodHandle ESTIMATE_TREE = function("mlrt_estimate_tree", I, P, L, P, P);
    static final MethodHandle ESTIMATE_KDTREE = function("mlrt_estimate_kdtree", I, P, L, P, P);
    static final MethodHandle HASH_GEOMETRY = function("mlrt_hash_geometry", I, P, L, P);
    static final MethodHandle SAVE_TREE = function("mlrt_save_tree", I, P, P, L, P);
    static final MethodHandle LOAD_TREE = function("mlrt_load_tree", I, P, L, P, P);
    static final MethodHandle TRACE_PACKET = function("mlrt_trace_packet", I, P, P, P, P);
    static final MethodHandle TRACE_RAY = function("mlrt_trace_ray", I, P, P, P, P);
    static final MethodHandle TRACE_ALL_HITS = function("mlrt_trace_all_hits", I, P, P, P, P);
    static final MethodHandle RENDER_TILES = function("mlrt_render_tiles", I, P, P, P, P, P, P);
    static final MethodHandle CAMERA_RAYS = function("mlrt_camera_rays", I, P, P, P);
    static final MethodHandle OCCLUDED_POINTS = function("mlrt_occluded_points", I, P, P, P, P, P);
    static final MethodHandle SHADOW_RAY = function("mlrt_shadow_ray", I, P, P, P, P, P, P);
    static final MethodHandle OFFSET_POINT = function("mlrt_offset_point", I, P, I, I, F, F, I, P);

    // Of the version that this file was written for, each layout must be the library's.
    static {
        try (var arena = Arena.ofConfined()) {
            var sizes = arena.allocate(I, TYPES.size());
            function("mlrt_struct_sizes", null, P, I).invoke(sizes, TYPES.size());
            for (int place = 0; place < TYPES.size() && (int) VERSION.invokeExact() == 100; place++) {
                if (sizes.getAtIndex(I, place) != TYPES.get(place).size())
                    throw new LinkageError("mlrt: not the library's: " + TYPES.get(place).layout);
            }
        } catch (Throwable problem) {
            throw unexpected(problem);
        }
    }

    /** A native function declares no exceptions, but MethodHandle does. */
    static RuntimeException unexpected(Throwable problem) {
        if (problem instanceof Error error) throw error;
        return problem instanceof RuntimeException exception ? exception : new RuntimeException(problem);
    }

    /** A string of the library. */
    static String string(MemorySegment text) {
        return text.reinterpret(Long.MAX_VALUE).getString(0);
    }
}
