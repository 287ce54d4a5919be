/* SPDX-License-Identifier: MIT */
/* method.c - the list of all methods: see method.h */
#include "method.h"

#include <string.h>

static const struct method *const parts[] = {moeller_trumbore_methods, projection_methods, pluecker_methods,
                                             watertight_methods,       box_walk_methods,   embree_methods,
                                             tinybvh_methods,          guess_methods,      library_methods};

// NULL behind the last one.
static const struct method *method_or_end(size_t i)
{
    for (size_t part = 0; part < sizeof parts / sizeof *parts; part++) {
        for (const struct method *method = parts[part]; method->name; method++, i--) {
            if (i == 0) return method;
        }
    }
    return NULL;
}

size_t method_count(void)
{
    size_t count = 0;
    while (method_or_end(count)) count++;
    return count;
}

const struct method *method_at(size_t i)
{
    return method_or_end(i);
}

const struct method *find_method(const char *word)
{
    size_t length = strcspn(word, ",");
    const struct method *method;
    for (size_t i = 0; (method = method_or_end(i)); i++) {
        if (strlen(method->name) == length && strncmp(method->name, word, length) == 0) return method;
    }
    return NULL;
}
