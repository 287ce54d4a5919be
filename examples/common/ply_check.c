/* SPDX-License-Identifier: MIT */
/* ply_check.c - checks that a PLY file is complete: see ply_check.h */
#include "ply_check.h"

#include <stdio.h>
#include <string.h>

enum { LONGEST_LINE = 4096, MOST_HEADER_LINES = 10000 };

static int is_blank(const char *line)
{
    return line[strspn(line, " \t\r\n")] == 0;
}

static int starts_with(const char *line, const char *word)
{
    return strncmp(line, word, strlen(word)) == 0;
}

// As assimp has it: in any mixture of cases.
static int is_magic(const char *line)
{
    return (line[0] == 'p' || line[0] == 'P') && (line[1] == 'l' || line[1] == 'L') &&
           (line[2] == 'y' || line[2] == 'Y');
}

// Reads up to and with "end_header"; *line_count receives the lines that follow in a text file, 0 for a binary one.
static const char *check_header(FILE *file, unsigned long long *line_count)
{
    char line[LONGEST_LINE];
    int is_text = 0;
    *line_count = 0;
    for (int i = 0; i < MOST_HEADER_LINES && fgets(line, sizeof line, file); i++) {
        unsigned long long count;
        if (starts_with(line, "format ascii")) is_text = 1;
        if (sscanf(line, "element %*s %llu", &count) == 1 && is_text) *line_count += count;
        if (starts_with(line, "end_header")) return NULL;
    }
    return "the header of this PLY file is not complete";
}

static const char *check_lines(FILE *file, unsigned long long line_count)
{
    char line[LONGEST_LINE];
    int is_new = 1;
    while (line_count > 0 && fgets(line, sizeof line, file)) {
        if (is_new && !is_blank(line)) line_count--;
        is_new = strchr(line, '\n') != NULL; // a line longer than the buffer comes in pieces
    }
    return line_count == 0 ? NULL : "this PLY file ends before all of its elements have come";
}

const char *check_ply(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) return "this file cannot be read";
    char magic[5] = "";
    const char *problem = NULL;
    unsigned long long line_count;
    if (fgets(magic, sizeof magic, file) && is_magic(magic)) {
        problem = check_header(file, &line_count);
        if (!problem) problem = check_lines(file, line_count);
    }
    fclose(file);
    return problem;
}
