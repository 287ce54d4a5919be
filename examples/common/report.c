/* SPDX-License-Identifier: MIT */
/* report.c - results as lines of `name value` on stdout: see report.h */
#include "report.h"

#include <inttypes.h>
#include <stdio.h>

void print_count(const char *name, uint64_t value)
{
    printf("%s %" PRIu64 "\n", name, value);
}

void print_number(const char *name, double value)
{
    printf("%s %.6g\n", name, value);
}

void print_ratio(const char *name, double value, double divisor)
{
    print_number(name, divisor ? value / divisor : 0);
}

void print_hash(const char *name, uint64_t value)
{
    printf("%s 0x%016" PRIx64 "\n", name, value);
}

void print_vector(const char *name, const float value[3])
{
    printf("%s %.9g,%.9g,%.9g\n", name, (double)value[0], (double)value[1], (double)value[2]);
}

void print_counters(const char *prefix, const mlrt_counters *c)
{
    const struct {
        const char *name;
        uint64_t value;
    } counts[] = {
        {"ray_count", c->ray_count},
        {"packet_count", c->packet_count},
        {"beam_count", c->beam_count},
        {"cell_count", c->cell_count},
        {"entry_point_cell_count", c->entry_point_cell_count},
        {"triangle_test_count", c->triangle_test_count},
        {"undecided_test_count", c->undecided_test_count},
        {"lane_test_count", c->lane_test_count},
        {"tie_lane_count", c->tie_lane_count},
        {"judged_lane_count", c->judged_lane_count},
        {"exact_edge_count", c->exact_edge_count},
        {"exact_range_count", c->exact_range_count},
        {"exact_order_count", c->exact_order_count},
        {"entry_point_count", c->entry_point_count},
        {"entry_point_depth_sum", c->entry_point_depth_sum},
        {"missed_beam_count", c->missed_beam_count},
        {"covered_beam_count", c->covered_beam_count},
        {"undecided_cull_count", c->undecided_cull_count},
        {"undecided_checked_count", c->undecided_checked_count},
    };
    const struct {
        const char *name;
        uint64_t value, divisor;
    } ratios[] = {
        {"rays_per_packet", c->ray_count, c->packet_count},
        {"cells_per_packet", c->cell_count, c->packet_count},
        {"triangle_tests_per_packet", c->triangle_test_count, c->packet_count},
        {"judged_lanes_per_ray", c->judged_lane_count, c->ray_count},
        {"packets_per_entry_point", c->packet_count, c->entry_point_count},
        {"entry_point_depth", c->entry_point_depth_sum, c->entry_point_count},
        {"entry_point_cells_per_beam", c->entry_point_cell_count, c->beam_count},
        {"undecided_culls_per_entry_point_cell", c->undecided_cull_count, c->entry_point_cell_count},
    };
    char name[96];
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        snprintf(name, sizeof name, "%s_%s", prefix, counts[i].name);
        print_count(name, counts[i].value);
    }
    for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++) {
        snprintf(name, sizeof name, "%s_%s", prefix, ratios[i].name);
        print_ratio(name, (double)ratios[i].value, (double)ratios[i].divisor);
    }
}

int end_output(int failed)
{
    // What was lost earlier has left its mark, and fflush may have nothing left to lose.
    const int is_lost = ferror(stdout) != 0;
    if (fflush(stdout) == 0 && !is_lost) return failed;
    fputs("standard output: not all could be written\n", stderr);
    return 1;
}
