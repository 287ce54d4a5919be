/* SPDX-License-Identifier: MIT */
/* ply_check.h - checks that a PLY file is complete */
#ifndef PLY_CHECK_H
#define PLY_CHECK_H

/*
 * NULL if the file at `path` may be given to assimp, or what is wrong with it. Files of other kinds are let through.
 *
 * assimp 5.2 reads the header of a PLY file forever if it never ends, and repeats the last line of a text file that
 * ends too early. It notices by itself when a binary file does.
 */
const char *check_ply(const char *path);

#endif
