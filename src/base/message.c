/* SPDX-License-Identifier: MIT */
/*
 * The last message of each thread: see message.h.
 */
#include "base/message.h"

#include <stdio.h>

#include "base/platform.h"

/*
 * The only state besides what the processor can do. The C library makes it with the thread and frees it with the
 * thread.
 */
static MLRT_THREAD_LOCAL char last_message[MLRT_MESSAGE_SIZE];

/*
 * Not inlined: in a shared library that is loaded late, finding the address may be a call into the C library, which
 * keeps vector registers only in some versions.
 */
MLRT_NOINLINE char *mlrt_message_of_thread(void)
{
    return last_message;
}

const char *mlrt_meaning_of(int32_t status)
{
    static const char *const texts[] = {
        "ok",
        "invalid argument",
        "struct_size is not set or not of any version",
        "a triangle names a vertex that does not exist",
        "out of memory",
        "more triangles, rays or pixels than 32-bit counts allow",
        "camera of size zero, crop outside of it, numbers that are not finite, or vectors that span no picture",
        "instruction set not available here, or a method for a tree of the other structure",
        "the system would not start a thread",
        "stopped by a callback",
        "not a saved tree, or one that is damaged, of another version, or of other triangles",
    };
    const int32_t count = (int32_t)(sizeof texts / sizeof *texts);
    return status >= 0 && status < count ? texts[status] : "unknown status";
}

int32_t mlrt_note_status(int32_t status)
{
    if (status != MLRT_OK) snprintf(mlrt_message_of_thread(), MLRT_MESSAGE_SIZE, "%s", mlrt_meaning_of(status));
    return status;
}
