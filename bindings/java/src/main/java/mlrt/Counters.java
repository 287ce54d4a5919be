// SPDX-License-Identifier: MIT
package mlrt;

import java.util.HashMap;
import java.util.Map;

/** Counts of the work of tracing, to which calls with {@link TraceOptions#counters} add when they end. */
public final class Counters {
    private final Map<String, Long> counts = new HashMap<>();

    /** All zero. */
    public Counters() {}

    /** Adds those of a call. */
    synchronized void add(Native.Struct call) {
        for (String name : Native.COUNTERS.offsets().keySet()) {
            if (name.endsWith("_count") || name.endsWith("_sum")) counts.merge(name, call.getLong(name), Long::sum);
        }
    }

    private synchronized long get(String name) {
        return counts.getOrDefault(name, 0L);
    }

    /**
     * Counts rays traced.
     *
     * @return the count
     */
    public long rayCount() {
        return get("ray_count");
    }

    /**
     * Counts groups of rays traced together, and rays that went alone.
     *
     * @return the count
     */
    public long packetCount() {
        return get("packet_count");
    }

    /**
     * Counts beams for which an entry point was searched.
     *
     * @return the count
     */
    public long beamCount() {
        return get("beam_count");
    }

    /**
     * Counts cells that were opened.
     *
     * @return the count
     */
    public long cellCount() {
        return get("cell_count");
    }

    /**
     * Counts of these, in the entry-point search.
     *
     * @return the count
     */
    public long entryPointCellCount() {
        return get("entry_point_cell_count");
    }

    /**
     * Counts tests of a triangle by a packet.
     *
     * @return the count
     */
    public long triangleTestCount() {
        return get("triangle_test_count");
    }

    /**
     * Counts pairs of a ray and a triangle that the float filter left to double arithmetic.
     *
     * @return the count
     */
    public long judgedLaneCount() {
        return get("judged_lane_count");
    }

    /**
     * Counts entry points from which packets were traced.
     *
     * @return the count
     */
    public long entryPointCount() {
        return get("entry_point_count");
    }

    /**
     * Counts their depths below the root, added up.
     *
     * @return the count
     */
    public long entryPointDepthSum() {
        return get("entry_point_depth_sum");
    }

    /**
     * Counts beams that provably hit nothing.
     *
     * @return the count
     */
    public long missedBeamCount() {
        return get("missed_beam_count");
    }

    /**
     * Counts beams whose rays all provably hit one triangle first.
     *
     * @return the count
     */
    public long coveredBeamCount() {
        return get("covered_beam_count");
    }

    /**
     * Counts inner nodes where the culling test could exclude no child.
     *
     * @return the count
     */
    public long undecidedCullCount() {
        return get("undecided_cull_count");
    }

    /**
     * Counts of these, still undecided after the extra check.
     *
     * @return the count
     */
    public long undecidedCheckedCount() {
        return get("undecided_checked_count");
    }

    /**
     * Counts pairs of a ray and a triangle that the float filter tested.
     *
     * @return the count
     */
    public long laneTestCount() {
        return get("lane_test_count");
    }

    /**
     * Counts of the tests, those with a judged ray.
     *
     * @return the count
     */
    public long undecidedTestCount() {
        return get("undecided_test_count");
    }

    /**
     * Counts pairs of a ray and a triangle settled because the nearest hit lies in the same plane.
     *
     * @return the count
     */
    public long tieLaneCount() {
        return get("tie_lane_count");
    }

    /**
     * Counts exact decisions on which side of an edge a ray passes.
     *
     * @return the count
     */
    public long exactEdgeCount() {
        return get("exact_edge_count");
    }

    /**
     * Counts exact decisions whether a hit is within its range.
     *
     * @return the count
     */
    public long exactRangeCount() {
        return get("exact_range_count");
    }

    /**
     * Counts exact decisions which of two hits is nearer.
     *
     * @return the count
     */
    public long exactOrderCount() {
        return get("exact_order_count");
    }
}
