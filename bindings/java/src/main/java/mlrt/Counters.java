// SPDX-License-Identifier: MIT
package mlrt;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;

/** Counts of the work of tracing, to which calls with {@link TraceOptions#counters} add, one at a time. */
public final class Counters {
    private final Native.Struct struct = Native.Struct.make(Native.COUNTERS, Arena.ofAuto());

    /** All zero. */
    public Counters() {}

    MemorySegment memory() {
        return struct.memory();
    }

    /**
     * Counts rays traced.
     *
     * @return the count
     */
    public long rayCount() {
        return struct.getLong("ray_count");
    }

    /**
     * Counts groups of rays traced together, and rays that went alone.
     *
     * @return the count
     */
    public long packetCount() {
        return struct.getLong("packet_count");
    }

    /**
     * Counts beams for which an entry point was searched.
     *
     * @return the count
     */
    public long beamCount() {
        return struct.getLong("beam_count");
    }

    /**
     * Counts cells that were opened.
     *
     * @return the count
     */
    public long cellCount() {
        return struct.getLong("cell_count");
    }

    /**
     * Counts of these, in the entry-point search.
     *
     * @return the count
     */
    public long entryPointCellCount() {
        return struct.getLong("entry_point_cell_count");
    }

    /**
     * Counts tests of a triangle by a packet.
     *
     * @return the count
     */
    public long triangleTestCount() {
        return struct.getLong("triangle_test_count");
    }

    /**
     * Counts pairs of a ray and a triangle that the float filter left to double arithmetic.
     *
     * @return the count
     */
    public long judgedLaneCount() {
        return struct.getLong("judged_lane_count");
    }

    /**
     * Counts entry points from which packets were traced.
     *
     * @return the count
     */
    public long entryPointCount() {
        return struct.getLong("entry_point_count");
    }

    /**
     * Counts their depths below the root, added up.
     *
     * @return the count
     */
    public long entryPointDepthSum() {
        return struct.getLong("entry_point_depth_sum");
    }

    /**
     * Counts beams that provably hit nothing.
     *
     * @return the count
     */
    public long missedBeamCount() {
        return struct.getLong("missed_beam_count");
    }

    /**
     * Counts beams whose rays all provably hit one triangle first.
     *
     * @return the count
     */
    public long coveredBeamCount() {
        return struct.getLong("covered_beam_count");
    }

    /**
     * Counts inner nodes where the culling test could exclude no child.
     *
     * @return the count
     */
    public long undecidedCullCount() {
        return struct.getLong("undecided_cull_count");
    }

    /**
     * Counts of these, still undecided after the extra check.
     *
     * @return the count
     */
    public long undecidedCheckedCount() {
        return struct.getLong("undecided_checked_count");
    }

    /**
     * Counts pairs of a ray and a triangle that the float filter tested.
     *
     * @return the count
     */
    public long laneTestCount() {
        return struct.getLong("lane_test_count");
    }

    /**
     * Counts of the tests, those with a judged ray.
     *
     * @return the count
     */
    public long undecidedTestCount() {
        return struct.getLong("undecided_test_count");
    }

    /**
     * Counts pairs of a ray and a triangle settled because the nearest hit lies in the same plane.
     *
     * @return the count
     */
    public long tieLaneCount() {
        return struct.getLong("tie_lane_count");
    }

    /**
     * Counts exact decisions on which side of an edge a ray passes.
     *
     * @return the count
     */
    public long exactEdgeCount() {
        return struct.getLong("exact_edge_count");
    }

    /**
     * Counts exact decisions whether a hit is within its range.
     *
     * @return the count
     */
    public long exactRangeCount() {
        return struct.getLong("exact_range_count");
    }

    /**
     * Counts exact decisions which of two hits is nearer.
     *
     * @return the count
     */
    public long exactOrderCount() {
        return struct.getLong("exact_order_count");
    }
}
