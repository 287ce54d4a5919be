// SPDX-License-Identifier: MIT
package mlrt;

import mlrt.Native.Struct;

/**
 * The build report of a tree.
 *
 * @param structure what finds the triangles
 * @param depth inner nodes above the deepest leaf
 * @param triangleCount as given, with those that were left out
 * @param nonFiniteCount left out: a vertex is NaN or infinite
 * @param zeroAreaCount left out: the area is exactly zero
 * @param nodeCount nodes
 * @param leafCount leaves, with the empty ones
 * @param emptyLeafCount leaves without triangles
 * @param referenceCount entries of all leaves together
 * @param retractedCount subtrees turned back into leaves
 * @param memorySize bytes held by the tree
 * @param peakMemorySize most bytes held at one time while building
 * @param treeHash equal trees have equal hashes
 * @param sahCost expected cost of a random ray
 * @param buildSeconds time that passed during the build
 * @param boundsMin the least coordinates, three numbers
 * @param boundsMax the greatest coordinates, three numbers
 */
public record TreeInfo(Structure structure, int depth, long triangleCount, long nonFiniteCount, long zeroAreaCount,
                       long nodeCount, long leafCount, long emptyLeafCount, long referenceCount, long retractedCount,
                       long memorySize, long peakMemorySize, long treeHash, double sahCost, double buildSeconds,
                       float[] boundsMin, float[] boundsMax) {
    /** What finds the triangles. */
    public enum Structure {
        /** The paper's kd-tree. */
        KDTREE,
        /** A hierarchy of boxes. */
        BVH
    }

    TreeInfo(Struct info) {
        this(Structure.values()[info.getInt("structure") - 1], info.getInt("depth"), info.getLong("triangle_count"),
            info.getLong("non_finite_count"), info.getLong("zero_area_count"), info.getLong("node_count"),
            info.getLong("leaf_count"), info.getLong("empty_leaf_count"), info.getLong("reference_count"),
            info.getLong("retracted_count"), info.getLong("memory_size"), info.getLong("peak_memory_size"),
            info.getLong("tree_hash"), info.getDouble("sah_cost"), info.getDouble("build_seconds"),
            info.getVector("bounds_min"), info.getVector("bounds_max"));
    }
}
