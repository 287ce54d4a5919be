/* SPDX-License-Identifier: MIT */
/*
 * Adding up counters: a call's workers count for themselves and are summed at the end.
 */
#include "counters.h"

void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from)
{
    to->ray_count += from->ray_count;
    to->packet_count += from->packet_count;
    to->beam_count += from->beam_count;
    to->cell_count += from->cell_count;
    to->entry_point_cell_count += from->entry_point_cell_count;
    to->triangle_test_count += from->triangle_test_count;
    to->judged_lane_count += from->judged_lane_count;
    to->entry_point_count += from->entry_point_count;
    to->entry_point_depth_sum += from->entry_point_depth_sum;
    to->missed_beam_count += from->missed_beam_count;
    to->covered_beam_count += from->covered_beam_count;
    to->undecided_cull_count += from->undecided_cull_count;
    to->undecided_checked_count += from->undecided_checked_count;
    to->lane_test_count += from->lane_test_count;
    to->undecided_test_count += from->undecided_test_count;
    to->tie_lane_count += from->tie_lane_count;
    to->exact_edge_count += from->exact_edge_count;
    to->exact_range_count += from->exact_range_count;
    to->exact_order_count += from->exact_order_count;
}
