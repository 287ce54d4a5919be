#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
What doxygen reads in place of include/mlrt.h, whose comments are for people who read the header, and of *.md.

Plain comments become doxygen's: those on lines of their own belong to what follows, those behind a field or constant to
that. Headings become groups, lists of arguments @param, first sentences @brief, and names links; functions that return
a status say so. Every line stays on its line, so that warnings name the right one.

    filter.py FILE      prints the result
"""
import re
import sys

# What holds for everything: said once in the header, linked from each page here.
RULES = 'rules'
GROUP = f'@ref {RULES} "Rules" of all of it: answers, numbers, structs, arrays, ownership, errors, threads.'
STATUS = f'@return #MLRT_OK or one of @ref MLRT_ERROR_ARGUMENT "MLRT_ERROR_*" (@ref {RULES})'

# In a page of docs/ or README.md: a link to what is no page here, such as another README or a part of a page.
PAGE = r'(?:docs/)?[\w-]+\.md\)|(?:\.\./)?include/mlrt\.h\)'
LINK_ELSEWHERE = re.compile(rf'(?<!!)\[([^\]]+)\]\((?!https?://|{PAGE})[^)]*\)')
COMMENT = re.compile(r'/\*.*?\*/', re.S)
HEADING = re.compile(r'/\* -{20,}\n \* (.+)\n \* -{20,} \*/')
CODE = re.compile(r'^ \*\n(?: \*     .*\n(?: \*\n(?= \*     ))?)+', re.M)
# "   name  what it is", or "   a, b  what they are"; more of it is indented further.
ARGUMENT = re.compile(r'^( \*)   (\w+(?:, \w+)*)  +(?=\S)', re.M)
# A constant of an enum that has no comment: versions of doxygen before 1.9.7 do not tell.
BARE_CONSTANT = re.compile(r'^( +(MLRT_\w+) =\s*\d+,?)$', re.M)


def defined_names(text):
    """Everything that has a page or a line of its own: functions, types, constants, macros."""
    code = COMMENT.sub('', text)
    names = set(re.findall(r'\b(mlrt_\w+)\(', code))
    names |= set(re.findall(r'^typedef struct (mlrt_\w+)', code, re.M))
    names |= set(re.findall(r'\(\*?(mlrt_\w+)\)\(', code))
    names |= set(re.findall(r'^ +(MLRT_\w+) =', code, re.M))
    return names | set(re.findall(r'^#define (MLRT_[A-Z_]+) +\S', code, re.M))


def link_names(comment, text, names, own):
    """#name, which has to exist; of "MLRT_TREE_*" and the like the first of them, whose page shows all."""
    # What a program may define for the header to look at has no page.
    switches = set(re.findall(r'(?:defined\(|#ifn?def )(MLRT_\w+)', comment.source)) - names
    ordered = sorted(names, key=lambda n: comment.source.find(f' {n} '))

    def link(match):
        name, field, star = match.group('name', 'field', 'star')
        if star:
            first = next((n for n in ordered if n.startswith(name) and n.isupper()), None)
            return f'@ref {first} "{name}*"' if first else match.group()
        if name == own or name in switches:
            return match.group()
        return f'@ref {name}::{field} "{name}.{field}"' if field else '#' + name

    pattern = r'(?<![\w#/])(?P<name>(?:mlrt|MLRT)_\w+)(?:\.(?P<field>[a-z_]+)\b|(?P<star>(?<=_)\*))?'
    return re.sub(pattern, link, text)


class Comment:
    """A comment, and where it stands."""

    def __init__(self, match):
        self.source, self.start, self.text = match.string, match.start(), match.group()
        line = self.source[self.source.rfind('\n', 0, match.start()) + 1:match.start()]
        self.follows_code = bool(line.strip())
        self.after = self.source[match.end() + 1:]

    def function(self):
        """(result, name) of the function or callback that the comment stands above, if it does."""
        found = re.match(r'MLRT_API ([\w *]+?)(mlrt_\w+)\(', self.after)
        callback = re.match(r'typedef [^(;{]+\(\*(mlrt_\w+)\)\(', self.after)
        return found.groups() if found else ('', callback[1] if callback else None)


def mark_text(comment, names, own):
    """Escapes and links: names, and signs that would mean something to doxygen; examples of code stay as they are."""
    parts, end = [], 0
    for code in CODE.finditer(comment.text):
        parts += [comment.text[end:code.start()], code.group()]
        end = code.end()
    parts.append(comment.text[end:])
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r'(?<=[\s(])\*(?=\w)', r'\\*', link_names(comment, parts[i], names, own))
    return ''.join(parts)


def mark_brief(text):
    """The first sentence is what lists show."""
    first, gap, rest = text.partition('\n *\n')
    first = re.sub(r'^/\*\*\s(?: \* )?', lambda start: start.group() + '@brief ', first)
    return re.sub(r'(?<![ A-Z.])\.(\n \* | )(?=[^*])', r'.\1@details ', first, count=1) + gap + rest


def convert_head(text):
    """The rules of the interface: a section, each with its word in bold."""
    text = re.sub(r'/\*\n \* mlrt\.h - ', '/** @file mlrt.h\n * @brief ', text)
    text = text.replace(' * RULES OF THE WHOLE INTERFACE', f' * @section {RULES} Rules of the whole interface')
    return re.sub(r'^ \*\n \* ([A-Z][a-z]+)(?=\.| (?:start|are) )', r' *\n * **\1**', text, flags=re.M)


def convert(comment, names):
    if comment.text.startswith('/* SPDX') or comment.text == '/* MLRT_H */':
        return comment.text
    heading = HEADING.fullmatch(comment.text)
    if heading:
        slug = re.sub(r'\W+', '_', heading.group(1).lower())
        first = HEADING.search(comment.source).start() == comment.start
        return f'{"" if first else "/** @} */"}\n/** @defgroup {slug} {heading.group(1)}\n * {GROUP} @{{ */'
    result, own = comment.function()
    text = mark_text(comment, names, own)
    if comment.follows_code:
        return '/**< @brief ' + text[2:].lstrip()  # all of it, so that it is shown on the struct's own page
    if text.startswith('/*\n * mlrt.h - '):
        return convert_head(text)
    if own:
        text = ARGUMENT.sub(lambda found: f'{found[1]} @param {found[2].replace(", ", ",")} ', text)
        said = STATUS if result == 'int32_t ' else f'@see @ref {RULES}'
        text = re.sub(r'\s*\*/$', lambda end: f' {said}{end.group()}', text)
    return mark_brief('/**' + text[2:])


def main():
    with open(sys.argv[1], encoding='utf-8') as file:
        source = file.read()
    if sys.argv[1].endswith('.md'):
        sys.stdout.write(LINK_ELSEWHERE.sub(r'\1', source))
        return
    names = defined_names(source)
    text = COMMENT.sub(lambda match: convert(Comment(match), names), source)
    text = BARE_CONSTANT.sub(r'\1 /**< @ref no_comment_for_\2 */', text)
    end = text.rfind('\n#ifdef __cplusplus')
    sys.stdout.write(text[:end] + '/** @} */' + text[end:])


if __name__ == '__main__':
    main()
