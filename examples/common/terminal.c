/* SPDX-License-Identifier: MIT */
/* terminal.c - what a program does, for a person who waits: see terminal.h */
#define _POSIX_C_SOURCE 200112L

#include "terminal.h"

#include <stdarg.h>
#include <stdio.h>
#include <unistd.h>

static void write_line(const char *before, const char *format, va_list values, const char *after)
{
    if (!isatty(STDERR_FILENO)) return;
    fputs(before, stderr);
    vfprintf(stderr, format, values);
    fputs(after, stderr);
}

// Back to the first column, and everything behind it is removed.
#define NO_LINE "\r\033[K"

void tell(const char *format, ...)
{
    va_list values;
    va_start(values, format);
    write_line("", format, values, "\n");
    va_end(values);
}

void show_work(const char *format, ...)
{
    va_list values;
    va_start(values, format);
    write_line(NO_LINE, format, values, "");
    va_end(values);
}

void clear_work(void)
{
    if (isatty(STDERR_FILENO)) fputs(NO_LINE, stderr);
}

static int32_t show_progress(void *user, double fraction)
{
    struct progress_line *line = user;
    const int percent = (int)(100 * fraction);
    if (percent <= line->percent) return 0;
    line->percent = percent;
    show_work("%s: %d %%", line->work, percent);
    return 0;
}

mlrt_host host_with_progress(struct progress_line *line)
{
    return (mlrt_host){.struct_size = sizeof(mlrt_host), .user = line, .progress = show_progress};
}

void clear_progress(struct progress_line *line)
{
    if (line->percent > 0) clear_work();
    line->percent = 0;
}
