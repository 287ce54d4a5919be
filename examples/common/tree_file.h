/* SPDX-License-Identifier: MIT */
/* tree_file.h - saves trees to files, and measures how long they take to load */
#ifndef TREE_FILE_H
#define TREE_FILE_H

#include <mlrt.h>

/* Writes a tree to a file. Returns 0, or 1 after a message on stderr. *seconds: without writing the file. */
int save_tree(const mlrt_tree *tree, const char *name, double *seconds);

/* What a tree took to come back, the best of three each: a copy of the file, the file in place, and memcpy alone. */
struct load_times {
    double copied;
    double in_place;
    double memcpy_alone;
    size_t file_size;
};

/* Maps a file and loads the tree in it, as a copy. Returns 0, or 1 after a message on stderr. */
int load_tree(const char *name, mlrt_tree **tree, struct load_times *times);

#endif
