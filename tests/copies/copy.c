/* SPDX-License-Identifier: MIT */
/* Compiled once for each static copy: COPY is the name of its table, MLRT_PREFIX how its functions begin. */
#include "library.h"

extern const struct library COPY;
const struct library COPY = {mlrt_build_tree, mlrt_trace_packet, mlrt_destroy_tree, mlrt_create_pool,
                             mlrt_destroy_pool};
