#!/bin/sh
# SPDX-License-Identifier: MIT
# tables.sh - the check of documents fails where it must: a digit of a table, a watched figure, a table without data, a
# number of the data, and a chart of other data
#
#     tables.sh PYTHON WORK, in the root of the sources

set -eu
python=$1 work=$2
page=$work/docs/study.md data=$work/docs/data

fresh() { rm -rf "$work" && mkdir -p "$work" && cp -R docs "$work/docs"; }
check() { "$python" examples/common/tables.py --check "$data" "$@" >"$work/log"; }
must_fail() {
    what=$1 && shift
    if check "$@"; then echo "tables.sh: nothing said of $what" && exit 1; fi
}

fresh && check "$page" "$work/docs/accuracy-price.png"
fresh && sed -i '/^| frame | /s/1\./2./' "$page" && must_fail "a digit in a table" "$page"
fresh && sed -i 's/) and [0-9]* double/) and 1 double/' "$page" && must_fail "a figure in a sentence" "$page"
fresh && sed -i 's/camera, and [0-9.]* to/camera, and 9.99 to/' "$page" && must_fail "a figure of joined rows" "$page"
fresh && sed -i 's/^<!-- figure: \([0-9]*\) is stages/<!-- figure: \1 stages/' "$page" && must_fail "a comment that watches nothing" "$page"
fresh && printf '\n| scene | speed |\n| --- | ---: |\n| room | 1 |\n' >>"$page" && must_fail "a table without data" "$page"
fresh && sed -i '2s/[0-9]$/&1/' "$data/price.csv" && must_fail "a chart of other data" "$work/docs/accuracy-price.png"
fresh && sed -i '/,frame,/s/[0-9.]*$/1000/' "$data/price.csv" && must_fail "other data" "$page"
fresh && rm "$data/errors.csv" && must_fail "missing data" "$page" && must_fail "missing data of a chart" "$work/docs/errors.png"
echo "tables.sh: what must fail fails"
