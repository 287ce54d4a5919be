/* SPDX-License-Identifier: MIT */
/*
 * options.h - command line options from a table, from which the help text is made too
 *
 * An option is `--name value`, `--name=value` or, for flags, `--name`. A word without a dash is a value of --scene, if
 * the table has that. An option that is not in the table, or a value
 * that is not of its kind, is reported on stderr.
 */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stddef.h>
#include <stdint.h>

enum option_kind {
    OPTION_HEADING,      /* a line of the help text */
    OPTION_FLAG,         /* int: set to 1 */
    OPTION_TEXT,         /* const char * */
    OPTION_COUNT,        /* uint32_t from low to high */
    OPTION_POWER_OF_TWO, /* uint32_t from low to high */
    OPTION_NUMBER,       /* double, finite */
    OPTION_VECTOR,       /* double[3], finite, as x,y,z */
    OPTION_SIZE,         /* uint32_t[2], each from low to high, as WxH */
    OPTION_CHOICE,       /* int32_t: low + the position in `values`, which are parted by | */
    OPTION_SET,          /* uint32_t: a bit for each of `values` that is in the list given, parted by commas */
    OPTION_LIST          /* struct word_list: the words given, parted by commas, are added; can be repeated */
};

enum { MAXIMUM_WORDS = 64 };

/* Words of the command line. Each ends at a comma or at its 0. */
struct word_list {
    size_t count;
    const char *words[MAXIMUM_WORDS];
};

struct option {
    enum option_kind kind;
    const char *name;   /* with its dashes */
    void *value;        /* where to put it; holds the default before */
    const char *values; /* how the help text writes the value; the words of a choice or set */
    const char *help;   /* what it does; \n starts a new line */
    uint32_t low, high;
};

/*
 * Reads the command line. Returns 1 to go on, or 0 to end with *exit_code: 0 after -h or --help, which
 * print `purpose` and the table to stdout, or --version; 1 if that cannot be written; 2 after a mistake. `purpose`
 * begins with the program's name.
 */
int parse_options(const char *purpose, const struct option *options, size_t count, int argc, char **argv,
                  int *exit_code);

#endif
