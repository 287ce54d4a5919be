/* SPDX-License-Identifier: MIT */
/* The last message of each thread: see message.h. */
#include "base/message.h"

#include <stdarg.h>
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

int32_t mlrt_fail(int32_t status, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    vsnprintf(mlrt_message_of_thread(), MLRT_MESSAGE_SIZE, format, values);
    va_end(values);
    return status;
}

int32_t mlrt_fail_null(const char *names, int missing)
{
    int length;
    for (;; names += length + 1, missing >>= 1) {
        for (length = 0; names[length] && names[length] != ' '; ++length) continue;
        if (!names[length] || missing & 1) break;
    }
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%.*s: NULL is not allowed", length, names);
}

int32_t mlrt_fail_at(int32_t status, const char *path, size_t index, const char *field, const char *format, ...)
{
    char *message = mlrt_message_of_thread();
    va_list values;
    const char *const form = !field[0] ? ": " : path[0] ? ".%s: " : "%s: ";
    /* Names leave more than half of the message to the rest. */
    int length = snprintf(message, MLRT_MESSAGE_SIZE, path, (unsigned long)index);
    length += snprintf(message + length, MLRT_MESSAGE_SIZE / 4, form, field);
    va_start(values, format);
    vsnprintf(message + length, MLRT_MESSAGE_SIZE - (size_t)length, format, values);
    va_end(values);
    return status;
}

const char *mlrt_write_digits(uint64_t number, char digits[MLRT_DIGITS])
{
    char *at = digits + MLRT_DIGITS - 1;
    *at = '\0';
    do *--at = (char)('0' + number % 10);
    while (number /= 10);
    return at;
}

const char *mlrt_meaning_of(int32_t status)
{
    /* One string, because addresses would take three times their place in a shared library. */
    static const char texts[] =
        "ok\0"
        "invalid argument\0"
        "struct_size is not set or not of any version\0"
        "a triangle names a vertex that does not exist\0"
        "out of memory\0"
        "more triangles, rays or pixels than 32-bit counts allow\0"
        "camera of size zero, crop outside of it, numbers that are not finite, or vectors that span no picture\0"
        "instruction set not available here, or a method for a tree of the other structure\0"
        "the system would not start a thread\0"
        "stopped by a callback\0"
        "not a saved tree, or one that is damaged, of another version, or of other triangles\0"
        "unknown status";
    const char *text = texts;
    if (status < MLRT_OK || status > MLRT_ERROR_DATA) status = MLRT_ERROR_DATA + 1;
    for (int32_t i = 0; i < status; ++text) i += !*text;
    return text;
}

int32_t mlrt_note_status(int32_t status)
{
    return status == MLRT_OK ? status : mlrt_fail(status, "%s", mlrt_meaning_of(status));
}
