/* SPDX-License-Identifier: MIT */
/*
 * terminal.h - tells a person who waits what a program does: on stderr, and only if that is a terminal
 *
 * So logs and pipes get results alone.
 */
#ifndef TERMINAL_H
#define TERMINAL_H

#include <mlrt.h>

/* Writes a line, formatted as by printf. */
void tell(const char *format, ...);

/* Shows a line that the next one replaces, and removes it again: before results are printed. */
void show_work(const char *format, ...);
void clear_work(void);

/* A line that shows how much of a call is done. All zero but `work`: nothing is shown yet. */
struct progress_line {
    const char *work; /* what the call does: "rendering" */
    int percent;      /* as shown */
};

/* A host without memory and log of its own whose `progress` shows the line; it must outlive the call. */
mlrt_host host_with_progress(struct progress_line *line);

/* Removes the line, if it was shown. */
void clear_progress(struct progress_line *line);

#endif
