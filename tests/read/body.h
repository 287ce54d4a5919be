/* SPDX-License-Identifier: MIT */
/*
 * The functions of read.h in the vocabulary that was included before, under the name READERS.
 */
#include "read.h"
#include "rays/fetch_block.h"
#include "trace/read_tile.h"

const struct readers READERS = {fetch_block, check_block, read_packets};
