// SPDX-License-Identifier: MIT
package mlrt;

import java.util.EnumSet;
import java.util.Set;

/** How to trace. Except for the query, the mask and the lights, no option changes an answer. */
public final class TraceOptions {
    /** How rays go through a tree. */
    public enum Method {
        /** The best one of the tree's structure. */
        DEFAULT,
        /** One ray at a time: the reference. */
        RAY,
        /** Kd-tree: 2x2 rays. */
        PACKET2,
        /** Kd-tree: 4x4 rays. */
        PACKET4,
        /** Kd-tree: the paper's. */
        MULTILEVEL,
        /** Boxes: tiles. */
        TILE
    }

    /** Instruction sets. */
    public enum Isa {
        /** The best that the machine has. */
        AUTO,
        /** Plain C: where the processor has neither SSE2 nor NEON. */
        SCALAR,
        /** SSE2. */
        SSE,
        /** AVX2 and FMA. */
        AVX2,
        /** AVX-512. */
        AVX512,
        /** NEON, on aarch64. */
        NEON
    }

    /** How a beam is tested against a cell. */
    public enum Culling {
        /** The planes of the cell against the beam. */
        INVERSE,
        /** The planes of the beam against the cell. */
        DIRECT
    }

    /** What is looked for. */
    public enum Query {
        /** The closest hit. */
        CLOSEST,
        /** Whether there is a hit: only `occluded` is written. */
        ANY
    }

    /** Results that a tile callback receives. */
    public enum Output {
        /** t. */
        T,
        /** u and v. */
        UV,
        /** mesh and triangle. */
        IDS,
        /** facing. */
        FACING,
        /** triangle without mesh. */
        TRIANGLE,
        /** With lights: occluded. */
        OCCLUDED
    }

    /** A tile that one triangle covers is done at once. */
    public static final int WHOLE_TILES = 1;
    /** Packets start at a list of leaves. */
    public static final int ENTRY_LISTS = 2;
    /** Terms of a triangle and an origin are kept for the packets that follow. */
    public static final int SHARED_SETUPS = 4;

    Method method = Method.DEFAULT;
    Isa isa = Isa.AUTO;
    Culling culling = Culling.INVERSE;
    boolean cullingCheck;
    int initialTileSize;
    int minimumTileSize;
    int splitFactor;
    int shortcutsOff;
    int mask;
    Query query = Query.CLOSEST;
    Pool pool;
    Counters counters;
    Light[] lights = {};
    Progress progress;
    Log log;
    Set<Output> outputs = EnumSet.noneOf(Output.class);

    /** The defaults. */
    public TraceOptions() {}

    /**
     * How rays go through the tree. No answer changes.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions method(Method value) {
        method = value;
        return this;
    }

    /**
     * The instruction set. No answer changes.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions isa(Isa value) {
        isa = value;
        return this;
    }

    /**
     * Method multilevel: how a beam is tested against a cell.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions culling(Culling value) {
        culling = value;
        return this;
    }

    /**
     * Method multilevel: check undecided cells against all their faces.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions cullingCheck(boolean value) {
        cullingCheck = value;
        return this;
    }

    /**
     * Pixels, 4..1024, a power of two; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions initialTileSize(int value) {
        initialTileSize = MlrtException.notNegative("initialTileSize", value);
        return this;
    }

    /**
     * Pixels, 4..initialTileSize, a power of two; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions minimumTileSize(int value) {
        minimumTileSize = MlrtException.notNegative("minimumTileSize", value);
        return this;
    }

    /**
     * 4 or 16; 0 = 16.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions splitFactor(int value) {
        splitFactor = MlrtException.notNegative("splitFactor", value);
        return this;
    }

    /**
     * Shortcuts of multilevel to do without: constants of this class, or-ed together.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions shortcutsOff(int value) {
        shortcutsOff = value;
        return this;
    }

    /**
     * Rays see the meshes whose mask has a bit in common with it; 0 = all bits.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions mask(int value) {
        mask = value;
        return this;
    }

    /**
     * What {@link Tree#trace} and {@link Tree#render} look for.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions query(Query value) {
        query = value;
        return this;
    }

    /**
     * Whose threads trace; null = the calling thread alone.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions pool(Pool value) {
        pool = value;
        return this;
    }

    /**
     * What counts the work; null = nothing.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions counters(Counters value) {
        counters = value;
        return this;
    }

    /**
     * {@link Tree#render}: lights, 8 at most, whose shadows are found.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions lights(Light... value) {
        lights = value.clone();
        return this;
    }

    /**
     * Receives progress, and can end the call; null = none.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions progress(Progress value) {
        progress = value;
        return this;
    }

    /**
     * Receives messages; null = none.
     *
     * @param value the new value
     * @return this
     */
    public TraceOptions log(Log value) {
        log = value;
        return this;
    }

    /**
     * {@link Tree#render}: the results that a tile callback receives.
     *
     * @param first one of them
     * @param others more of them
     * @return this
     */
    public TraceOptions outputs(Output first, Output... others) {
        outputs = EnumSet.of(first, others);
        return this;
    }

    /** Only rendering has lights and outputs. */
    Native.Struct toStruct(Call call, Query query, boolean rendering) {
        var struct = call.struct(Native.TRACE_OPTIONS).set("query", query.ordinal()).set("method", method.ordinal())
            .set("isa", isa.ordinal()).set("culling", culling.ordinal()).set("culling_check", cullingCheck ? 1 : 0)
            .set("initial_tile_size", initialTileSize).set("minimum_tile_size", minimumTileSize)
            .set("split_factor", splitFactor).set("shortcuts_off", shortcutsOff).set("mask", mask)
            .set("pool", call.hold(pool)).set("host", call.host(progress, log));
        if (counters != null) struct.set("counters", call.count(counters));
        if (!rendering) return struct;
        if (lights.length > 0) struct.set("lights", Light.toNative(lights, call)).set("light_count", lights.length);
        return struct.set("outputs", outputs.stream().mapToInt(output -> 1 << output.ordinal()).sum());
    }
}
