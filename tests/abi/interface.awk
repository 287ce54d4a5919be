# SPDX-License-Identifier: MIT
#
# The structs and constants of mlrt.h as a list of C macros, for tests/abi/interface.h:
#
#     cc -E -P -dD include/mlrt.h | awk -f tests/abi/interface.awk
#
# Fields are found by what every line of a struct here is: a type, a name, perhaps a [count], a semicolon.

/^#define MLRT_[A-Z_0-9]+ +[0-9]/ && !/VERSION/ { constants[++constant_count] = $2 }
/^#/ { next }
{ text = text " " $0 }

function trim(s)
{
    sub(/^[ \t]+/, "", s)
    sub(/[ \t]+$/, "", s)
    return s
}

function print_fields(type, body,    fields, count, i, field, array, name)
{
    count = split(body, fields, ";")
    for (i = 1; i < count; i++) {
        field = trim(fields[i])
        array = ""
        if (match(field, /\[[0-9]+\]$/)) {
            array = substr(field, RSTART)
            field = substr(field, 1, RSTART - 1)
        }
        match(field, /[A-Za-z_0-9]+$/)
        name = substr(field, RSTART)
        printf "FIELD(%s, %s, \"%s%s\")\n", type, name, trim(substr(field, 1, RSTART - 1)), array
    }
}

END {
    rest = text
    while (match(rest, /typedef struct mlrt_[a-z_0-9]+ *\{[^}]*\}/)) {
        whole = substr(rest, RSTART, RLENGTH)
        rest = substr(rest, RSTART + RLENGTH)
        match(whole, /mlrt_[a-z_0-9]+/)
        type = substr(whole, RSTART, RLENGTH)
        body = substr(whole, index(whole, "{") + 1)
        printf "STRUCT(%s, MLRT_STRUCT_%s)\n", type, toupper(substr(type, 6))
        print_fields(type, substr(body, 1, length(body) - 1))
        printf "END(%s)\n", type
    }
    rest = text
    while (match(rest, /enum *\{[^}]*\}/)) {
        body = substr(rest, RSTART, RLENGTH - 1)
        rest = substr(rest, RSTART + RLENGTH)
        count = split(substr(body, index(body, "{") + 1), entries, ",")
        for (i = 1; i <= count; i++)
            if (match(entries[i], /MLRT_[A-Z_0-9]+/))
                constants[++constant_count] = substr(entries[i], RSTART, RLENGTH)
    }
    for (i = 1; i <= constant_count; i++) printf "CONSTANT(%s)\n", constants[i]
}
