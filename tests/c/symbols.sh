#!/bin/sh
# symbols.sh LIBRARY HEADER...: the library exports exactly the functions that the headers declare.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
nm -D --defined-only "$1" | awk '{print $3}' | sort > "$work/exported"
shift
# Without comments, what stands before an opening parenthesis.
cat "$@" | sed -e 's|//.*||' | awk '/\/\*/ {inside = 1} !inside {print} /\*\// {inside = 0}' |
    grep -v '^#' | grep -oE '\bcata_[a-z0-9_]+\(' | tr -d '(' | sort > "$work/declared"
test -s "$work/declared" || { echo "no function declared in $*" >&2; exit 1; }
if ! diff "$work/declared" "$work/exported"; then
    echo "< declared only, > exported only" >&2
    exit 1
fi
echo "symbols: $(wc -l < "$work/exported") exported, all declared, no other"
