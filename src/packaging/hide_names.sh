#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Makes the static library of which programs see only the functions of mlrt.h: one object, whose internal names are
# hidden and clash with no others.
#
#     hide_names.sh ARCHIVE AR OBJCOPY OBJECT... -- CC [FLAG...]
#
# An OBJECT can also be an archive, whose objects are all taken. If there is no objcopy, or it fails, internal names
# stay visible, and two such archives cannot be linked into one program. On 32-bit x86 the compiler adds small functions
# in section groups; a linker keeps one copy of a group for all objects. Ours are local now, so they must not be that
# copy: their groups are removed.
set -eu
archive=$1 ar=$2 objcopy=$3
shift 3
objects=
while [ "$1" != -- ]; do
    objects="$objects $1"
    shift
done
shift

rm -f "$archive"
one=$archive.o
# shellcheck disable=SC2086 # a list
if "$@" -r -nostdlib -Wl,--whole-archive $objects -Wl,--no-whole-archive -o "$one" &&
    "$objcopy" --localize-hidden --remove-section=.group "$one"; then
    "$ar" rcs "$archive" "$one"
else
    echo "$archive: $objcopy did not hide the names inside: they stay visible"
    "$ar" rcs "$archive" $objects
fi
rm -f "$one"
