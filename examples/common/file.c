/* SPDX-License-Identifier: MIT */
/* file.c - files that appear whole or not at all, and files that can be read again and again: see file.h */
#define _XOPEN_SOURCE 700
#include "file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

const char *find_input_problem(const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0) return strerror(errno);
    if (S_ISDIR(status.st_mode)) return "a folder";
    if (!S_ISREG(status.st_mode)) return "a pipe or a device, and no file";
    FILE *file = fopen(path, "rb");
    if (!file) return strerror(errno);
    fclose(file);
    return NULL;
}

/* ---- output -------------------------------------------------------------------------------------------------- */

static int complain(const char *path)
{
    fprintf(stderr, "%s: cannot be written: %s\n", path, strerror(errno));
    return 1;
}

// What renaming would replace by a file: a pipe, a device, or the name of an open file, which is a link to it.
static int is_in_place(const char *path)
{
    static const char *const names[] = {"/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/"};
    struct stat status;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strncmp(path, names[i], strlen(names[i])) == 0) return 1;
    }
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

static int name_part(const char *path, struct output_file *output)
{
    static const char suffix[] = ".part";
    struct stat status;
    const int is_link = lstat(path, &status) == 0 && S_ISLNK(status.st_mode);
    output->target = is_link ? realpath(path, NULL) : NULL;
    if (!output->target) output->target = strdup(path);
    output->part = output->target ? malloc(strlen(output->target) + sizeof suffix) : NULL;
    if (!output->part) return 1;
    strcat(strcpy(output->part, output->target), suffix);
    return 0;
}

static void forget_names(struct output_file *output)
{
    free(output->target);
    free(output->part);
    output->target = output->part = NULL;
}

int open_output(const char *path, struct output_file *output)
{
    *output = (struct output_file){.path = path};
    if (is_in_place(path))
        output->file = fopen(path, "wb");
    else if (name_part(path, output) == 0)
        output->file = fopen(output->part, "wb");
    if (output->file) return 0;
    complain(path);
    forget_names(output);
    return 1;
}

int close_output(struct output_file *output, int failed)
{
    if (fclose(output->file) != 0 && !failed) failed = complain(output->path);
    if (output->part && !failed && rename(output->part, output->target) != 0) failed = complain(output->path);
    if (output->part && failed) remove(output->part);
    forget_names(output);
    return failed;
}
