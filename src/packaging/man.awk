# SPDX-License-Identifier: MIT
#
# Makes the manual page mlrt(3) from the comments of mlrt.h: awk -f man.awk include/mlrt.h
#
# The page has the prototype of each function and the first paragraph of its comment, the rules of the whole interface,
# the status codes, and the program at the head of the header.

function roff(text)
{
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    if (text ~ /^[.']/) text = "\\&" text
    return text
}

function add_to(part, text) { parts[part] = parts[part] text "\n" }

# A line of a comment at the start of a line, without the comment's signs.
function plain(line)
{
    sub(/^\/?\*\/?/, "", line)
    sub(/^ \*\/?/, "", line)
    sub(/ *\*\/$/, "", line)
    sub(/^ /, "", line)
    return line
}

/^#define MLRT_VERSION_STRING/ { gsub(/"/, "", $3); version = $3 }

# The head of the header: the first line, a program, then the rules.
!head_ended {
    line = plain($0)
    if (line ~ /^mlrt\.h - /) { subject = substr(line, 10); sub(/:.*/, "", subject) }
    else if (line ~ /^RULES OF THE WHOLE INTERFACE/) in_rules = 1
    else if (!in_rules && line ~ /^    /) add_to("example", roff(substr(line, 5)))
    else if (in_rules && $0 != " */") {
        if (line == "") { after_blank = 1; next }
        if (line ~ /^  - /) { add_to("rules", ".IP \\(bu 2"); sub(/^  - /, "", line) }
        else if (after_blank && match(line, /^[A-Z][a-z]*( [a-z]*)?\. /)) {
            add_to("rules", ".TP\n.B " roff(substr(line, 1, RLENGTH - 2)))
            line = substr(line, RLENGTH + 1)
        } else if (after_blank) add_to("rules", ".PP")
        sub(/^ */, "", line)
        add_to("rules", roff(line))
        after_blank = 0
    }
    if ($0 ~ /^ \*\// && in_rules) head_ended = 1
    next
}

# The first paragraph of the comment that comes before a function.
/^\/\*/ { comment = ""; paragraph_ended = 0; in_comment = 1 }
in_comment {
    line = plain($0)
    if (line == "" && comment != "") paragraph_ended = 1
    if (!paragraph_ended && line != "") comment = comment roff(line) "\n"
    if ($0 ~ /\*\/$/) in_comment = 0
    next
}

/^MLRT_API/ { prototype = ""; in_prototype = 1 }
in_prototype {
    line = $0
    sub(/^MLRT_API /, "", line)
    sub(/^ */, "", line)
    prototype = prototype (prototype == "" ? "" : "\n    ") line
    if (line ~ /;$/) {
        in_prototype = 0
        name = prototype
        sub(/\(.*/, "", name)
        sub(/.*[ *]/, "", name)
        add_to("prototypes", roff(prototype))
        add_to("functions", ".TP\n.BR " roff(name) " ()\n" comment)
    }
    next
}

# Status codes, whose comments may take two lines.
/^    MLRT_(OK|ERROR_[A-Z_]*) = / {
    code = $1
    line = $0
    sub(/.*\/\* */, "", line)
    in_code = 1
    add_to("codes", ".TP\n.B " code)
}
in_code {
    if ($1 != code) line = $0
    sub(/^ */, "", line)
    if (line ~ /\*\/$/) in_code = 0
    sub(/ *\*\/$/, "", line)
    add_to("codes", roff(line))
}

END {
    printf ".TH MLRT 3 \"\" \"mlrt %s\" \"Library Functions Manual\"\n", version
    printf ".SH NAME\nmlrt \\- %s\n", subject
    printf ".SH SYNOPSIS\n.nf\n.B #include <mlrt.h>\n.PP\n%s.PP\ncc program.c $(pkg\\-config \\-\\-cflags \\-\\-libs mlrt)\n.fi\n", parts["prototypes"]
    printf ".SH DESCRIPTION\nThe header mlrt.h is the whole manual: it describes every argument, struct and constant.\n"
    printf "For C++ there is also mlrt.hpp.\n"
    printf ".SS Functions\n%s", parts["functions"]
    printf ".SS Rules of the whole interface\n%s", parts["rules"]
    printf ".SH ERRORS\nFunctions that can fail return one of these codes.\n%s", parts["codes"]
    printf ".SH EXAMPLES\n.nf\n%s.fi\n", parts["example"]
}
