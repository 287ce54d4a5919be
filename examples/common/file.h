/* SPDX-License-Identifier: MIT */
/* file.h - files that appear whole or not at all, and files that can be read again and again */
#ifndef FILE_H
#define FILE_H

#include <stdio.h>

/*
 * NULL if `path` is a file that can be read, or what is wrong with it: it is not there, or it is a folder, or a pipe or
 * a device, which could be read once at most, and might never end.
 */
const char *find_input_problem(const char *path);

/* A file that is being written. */
struct output_file {
    FILE *file;
    const char *path;
    char *target, *part; /* what is renamed to what at the end; NULL = written in place */
};

/*
 * Begins to write a file. It is written under another name beside `path`, and renamed when it is complete; if `path` is
 * a link, then beside what it leads to. Pipes, devices and names of open files, such as /dev/stdout, are written in
 * place. Returns 0, or 1 after a message on stderr.
 */
int open_output(const char *path, struct output_file *output);

/* Ends it. If `failed`, or if the rest cannot be written, `path` stays as it was. Returns 1 then, with a message unless
 * `failed`; or else 0. */
int close_output(struct output_file *output, int failed);

#endif
