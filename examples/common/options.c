/* SPDX-License-Identifier: MIT */
/* options.c - command line options from a table: see options.h */
#include "options.h"

#include "report.h"

#include <mlrt.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The option that words without a dash belong to.
#define SCENES "--scene"

static const struct option *find_option(const struct option *options, size_t count, const char *name, size_t length)
{
    for (size_t i = 0; i < count; i++) {
        if (options[i].kind == OPTION_HEADING) continue;
        if (strlen(options[i].name) == length && strncmp(options[i].name, name, length) == 0) return &options[i];
    }
    return NULL;
}

/* ---- help ---------------------------------------------------------------------------------------------------- */

enum { HELP_COLUMN = 32 };

static void print_option(const char *name, const char *values, const char *help)
{
    int width = printf("  %s%s%s", name, values ? " " : "", values ? values : "");
    if (width > HELP_COLUMN - 2) width = 0, putchar('\n');
    printf("%*s", HELP_COLUMN - width, "");
    for (const char *c = help; *c; c++) {
        putchar(*c);
        if (*c == '\n') printf("%*s", HELP_COLUMN, "");
    }
    putchar('\n');
}

static void print_help(const char *purpose, const struct option *options, size_t count)
{
    puts(purpose);
    if (find_option(options, count, SCENES, strlen(SCENES)))
        puts("A word without a dash is a scene, as after " SCENES ".");
    for (size_t i = 0; i < count; i++) {
        if (options[i].kind == OPTION_HEADING)
            printf("\n%s\n", options[i].help);
        else
            print_option(options[i].name, options[i].values, options[i].help);
    }
    print_option("-h, --help", NULL, "this text");
    print_option("--version", NULL, "the version of the library");
}

// The first word of the purpose is the program's name.
static void print_version(const char *purpose)
{
    const uint32_t version = mlrt_version();
    printf("%.*s (mlrt) %lu.%lu.%lu\n", (int)strcspn(purpose, " "), purpose, (unsigned long)(version / 10000),
           (unsigned long)(version / 100 % 100), (unsigned long)(version % 100));
}

/* ---- values -------------------------------------------------------------------------------------------------- */

// Reads a number at *text and moves on behind it.
static int read_number(const char **text, double *number)
{
    char *end;
    *number = strtod(*text, &end);
    int good = end != *text && isfinite(*number);
    *text = end;
    return good;
}

static int read_count(const char **text, const struct option *option, uint32_t *count)
{
    if (**text < '0' || **text > '9') return 0;
    char *end;
    errno = 0;
    unsigned long long number = strtoull(*text, &end, 10);
    if (errno || number < option->low || number > option->high) return 0;
    *text = end;
    *count = (uint32_t)number;
    return 1;
}

static int read_vector(const char *text, double vector[3])
{
    double v[3];
    for (int k = 0; k < 3; k++) {
        if (!read_number(&text, &v[k]) || *text != (k < 2 ? ',' : 0)) return 0;
        text++;
    }
    memcpy(vector, v, sizeof v);
    return 1;
}

static int read_size(const char *text, const struct option *option, uint32_t size[2])
{
    if (!read_count(&text, option, &size[0]) || *text != 'x') return 0;
    text++;
    return read_count(&text, option, &size[1]) && !*text;
}

// The position of a word of `length` among words parted by |, or -1.
static int word_position(const char *words, const char *word, size_t length)
{
    for (int position = 0;; position++) {
        size_t size = strcspn(words, "|,");
        if (size == length && strncmp(words, word, length) == 0) return position;
        if (!words[size]) return -1;
        words += size + 1;
    }
}

static int read_set(const char *text, const struct option *option, uint32_t *set)
{
    uint32_t bits = 0;
    for (;; text++) {
        size_t length = strcspn(text, ",");
        int position = word_position(option->values, text, length);
        if (position < 0) return 0;
        bits |= 1u << position;
        text += length;
        if (!*text) break;
    }
    *set = bits;
    return 1;
}

static int read_list(const char *text, struct word_list *list)
{
    for (;; text++) {
        size_t length = strcspn(text, ",");
        if (length == 0 || list->count == MAXIMUM_WORDS) return 0;
        list->words[list->count++] = text;
        text += length;
        if (!*text) return 1;
    }
}

static int read_value(const struct option *option, const char *text)
{
    const char *rest = text;
    uint32_t count;
    double number;
    int position;
    switch (option->kind) {
    case OPTION_TEXT:
        *(const char **)option->value = text;
        return *text != 0;
    case OPTION_COUNT:
    case OPTION_POWER_OF_TWO:
        if (!read_count(&rest, option, &count) || *rest) return 0;
        if (option->kind == OPTION_POWER_OF_TWO && (count & (count - 1))) return 0;
        *(uint32_t *)option->value = count;
        return 1;
    case OPTION_NUMBER:
        if (!read_number(&rest, &number) || *rest) return 0;
        *(double *)option->value = number;
        return 1;
    case OPTION_VECTOR:
        return read_vector(text, option->value);
    case OPTION_SIZE:
        return read_size(text, option, option->value);
    case OPTION_CHOICE:
        position = word_position(option->values, text, strlen(text));
        if (position < 0) return 0;
        *(int32_t *)option->value = (int32_t)option->low + position;
        return 1;
    case OPTION_SET:
        return read_set(text, option, option->value);
    case OPTION_LIST:
        return read_list(text, option->value);
    default:
        return 0;
    }
}

/* ---- command line -------------------------------------------------------------------------------------------- */

static void complain_about_value(const struct option *option, const char *text)
{
    fprintf(stderr, "%s: %s is not %s", option->name, text, option->values);
    if (option->kind == OPTION_COUNT || option->kind == OPTION_SIZE) {
        fprintf(stderr, ", numbers from %lu to %lu", (unsigned long)option->low, (unsigned long)option->high);
    }
    if (option->kind == OPTION_POWER_OF_TWO) {
        fprintf(stderr, ", a power of two from %lu to %lu", (unsigned long)option->low, (unsigned long)option->high);
    }
    if (option->kind == OPTION_LIST) fprintf(stderr, ", at most %d words and none empty", MAXIMUM_WORDS);
    fprintf(stderr, "\n");
}

// Reads the option at *argument and its value, and moves on to the last word read.
static int read_option(const struct option *options, size_t count, char ***argument)
{
    const char *word = **argument;
    size_t length = strcspn(word, "=");
    const struct option *scenes = word[0] == '-' ? NULL : find_option(options, count, SCENES, strlen(SCENES));
    const struct option *option = find_option(options, count, word, length);
    if (scenes) {
        if (read_value(scenes, word)) return 1;
        complain_about_value(scenes, word);
        return 0;
    }
    if (!option || (option->kind == OPTION_FLAG && word[length])) {
        fprintf(stderr, "%s: no such option; --help lists them\n", word);
        return 0;
    }
    if (option->kind == OPTION_FLAG) {
        *(int *)option->value = 1;
        return 1;
    }
    const char *text = word[length] ? word + length + 1 : *++*argument;
    if (!text) {
        fprintf(stderr, "%s: a value is missing: %s\n", option->name, option->values);
        return 0;
    }
    if (read_value(option, text)) return 1;
    complain_about_value(option, text);
    return 0;
}

int parse_options(const char *purpose, const struct option *options, size_t count, int argc, char **argv,
                  int *exit_code)
{
    for (char **argument = argv + (argc > 0); *argument; argument++) {
        const int wants_help = strcmp(*argument, "-h") == 0 || strcmp(*argument, "--help") == 0;
        if (wants_help || strcmp(*argument, "--version") == 0) {
            if (wants_help)
                print_help(purpose, options, count);
            else
                print_version(purpose);
            *exit_code = end_output(0);
            return 0;
        }
        if (!read_option(options, count, &argument)) {
            *exit_code = 2;
            return 0;
        }
    }
    return 1;
}
