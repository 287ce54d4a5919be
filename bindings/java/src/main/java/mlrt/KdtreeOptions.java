// SPDX-License-Identifier: MIT
package mlrt;

/** How to build the paper's kd-tree: {@link Tree#buildKdtree}. */
public final class KdtreeOptions {
    /** How a kd-tree is built. */
    public enum Preset {
        /** As the paper tells. */
        PAPER,
        /** Larger leaves, smaller cells: traced faster, takes longer to build. */
        TUNED
    }

    /** An empty side of more than 10 % of a cell is cut off first. */
    public static final int EMPTY_SPACE = 1;
    /** A plane that triangles in it cover wholly is a split. */
    public static final int COPLANAR = 2;
    /** Cells under a minimum size are not split. */
    public static final int MINIMUM_CELL = 4;
    /** Candidates come from triangles clipped to the cell. */
    public static final int CLIPPED_SPLITS = 8;
    /** A subtree that costs more than a leaf becomes a leaf. */
    public static final int RETRACTION = 16;

    Preset preset = Preset.PAPER;
    float traversalCost;
    float intersectionCost;
    long memoryLimit;
    long maxReferences;
    int maxDepth;
    int rulesOff;
    Pool pool;
    Progress progress;
    Log log;

    /** The defaults. */
    public KdtreeOptions() {}

    /**
     * How the tree is built.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions preset(Preset value) {
        preset = value;
        return this;
    }

    /**
     * The cost of a node, 0..1e6; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions traversalCost(float value) {
        traversalCost = value;
        return this;
    }

    /**
     * The cost of a triangle, 0..1e6; 0 = the default.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions intersectionCost(float value) {
        intersectionCost = value;
        return this;
    }

    /**
     * Most bytes held at one time; beyond: OUT_OF_MEMORY; 0 = no limit.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions memoryLimit(long value) {
        memoryLimit = MlrtException.notNegative("memoryLimit", value);
        return this;
    }

    /**
     * Most leaf entries; 0 = 8 per triangle + 1024.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions maxReferences(long value) {
        maxReferences = MlrtException.notNegative("maxReferences", value);
        return this;
    }

    /**
     * Most inner nodes above a leaf, 1..60; 0 = by the number of triangles.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions maxDepth(int value) {
        maxDepth = MlrtException.notNegative("maxDepth", value);
        return this;
    }

    /**
     * Rules to do without: constants of this class, or-ed together.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions rulesOff(int value) {
        rulesOff = value;
        return this;
    }

    /**
     * Whose threads build; null = the calling thread alone. The tree is the same.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions pool(Pool value) {
        pool = value;
        return this;
    }

    /**
     * Receives progress, and can end the call; null = none.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions progress(Progress value) {
        progress = value;
        return this;
    }

    /**
     * Receives messages; null = none.
     *
     * @param value the new value
     * @return this
     */
    public KdtreeOptions log(Log value) {
        log = value;
        return this;
    }

    Native.Struct toStruct(Call call) {
        return call.struct(Native.KDTREE_OPTIONS).set("preset", preset.ordinal()).set("traversal_cost", traversalCost)
            .set("intersection_cost", intersectionCost).set("memory_limit", memoryLimit).set("max_references", maxReferences)
            .set("max_depth", maxDepth).set("rules_off", rulesOff).set("pool", call.hold(pool))
            .set("host", call.host(progress, log));
    }
}
