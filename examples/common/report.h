/* SPDX-License-Identifier: MIT */
/*
 * report.h - results as lines of `name value` on stdout, for people and for scripts
 *
 * A line has one result. Its name is lower_snake_case; its value has no spaces (commas separate three numbers).
 */
#ifndef REPORT_H
#define REPORT_H

#include <mlrt.h>

void print_count(const char *name, uint64_t value);
void print_number(const char *name, double value);
void print_ratio(const char *name, double value, double divisor); /* 0 if there is nothing to divide by */
void print_hash(const char *name, uint64_t value);
void print_vector(const char *name, const float value[3]);

/* Every field of the counters as PREFIX_name, and what follows from them per packet and per beam. */
void print_counters(const char *prefix, const mlrt_counters *counters);

/*
 * For the end of a program. Returns `failed`, or 1 after a message on stderr if not all that was printed could be
 * written to stdout.
 */
int end_output(int failed);

#endif
