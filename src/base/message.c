/* SPDX-License-Identifier: MIT */
/*
 * The last message of each thread: see message.h.
 */
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

int32_t mlrt_fail_null(const char *names, ...)
{
    va_list arguments;
    int length = 0;
    va_start(arguments, names);
    for (;; names += length + 1) {
        for (length = 0; names[length] && names[length] != ' '; ++length) continue;
        if (!names[length] || !va_arg(arguments, const void *)) break;
    }
    va_end(arguments);
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%.*s: NULL is not allowed", length, names);
}

int32_t mlrt_fail_at(int32_t status, const char *path, size_t index, const char *field, const char *format, ...)
{
    char *message = mlrt_message_of_thread();
    va_list values;
    /* Names leave more than half of the message to the rest. */
    int length = snprintf(message, MLRT_MESSAGE_SIZE, path, (unsigned long)index);
    length += snprintf(message + length, MLRT_MESSAGE_SIZE / 4, field[0] ? ".%s: " : ": ", field);
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

int32_t mlrt_fail_plainly(int32_t status)
{
    return mlrt_fail(status, "%s", mlrt_meaning_of(status));
}
