/* SPDX-License-Identifier: MIT */
/*
 * decide_lanes in the vocabulary that was included before, under the name DECIDE_CLOSE.
 */
#include "close.h"

#define mlrt_decide_lanes decide_rest
#include "hits/close_calls.h"

uint32_t DECIDE_CLOSE(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                      struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters)
{
    return decide_lanes(tree, number, lanes, inside, packet, worker, counters);
}
