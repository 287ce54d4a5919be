// SPDX-License-Identifier: MIT
package mlrt;

/** How to build a hierarchy of boxes: {@link Tree#build}. */
public final class TreeOptions {
    /** What a tree is built for. */
    public enum Preset {
        /** Faster to trace than FAST, slower than BEST. */
        DEFAULT,
        /** Built fastest, for scenes that change. */
        FAST,
        /** Traced fastest; takes more memory and time to build. */
        BEST
    }

    Preset preset = Preset.DEFAULT;
    float traversalCost;
    float intersectionCost;
    long memoryLimit;
    Pool pool;
    Progress progress;
    Log log;

    /** The defaults. */
    public TreeOptions() {}

    /**
     * What the tree is built for.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions preset(Preset value) {
        preset = value;
        return this;
    }

    /**
     * The cost of a node, 0..1e6; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions traversalCost(float value) {
        traversalCost = value;
        return this;
    }

    /**
     * The cost of a triangle, 0..1e6; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions intersectionCost(float value) {
        intersectionCost = value;
        return this;
    }

    /**
     * Most bytes held at one time; beyond: OUT_OF_MEMORY; 0 = no limit.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions memoryLimit(long value) {
        memoryLimit = MlrtException.notNegative("memoryLimit", value);
        return this;
    }

    /**
     * Whose threads build; null = the calling thread alone. The tree is the same.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions pool(Pool value) {
        pool = value;
        return this;
    }

    /**
     * Receives progress, and can end the call; null = none.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions progress(Progress value) {
        progress = value;
        return this;
    }

    /**
     * Receives messages; null = none.
     *
     * @param value the new value
     * @return this
     */
    public TreeOptions log(Log value) {
        log = value;
        return this;
    }

    Native.Struct toStruct(Call call) {
        return call.struct(Native.TREE_OPTIONS).set("preset", preset.ordinal()).set("traversal_cost", traversalCost)
            .set("intersection_cost", intersectionCost).set("memory_limit", memoryLimit).set("pool", call.hold(pool))
            .set("host", call.host(progress, log));
    }
}
