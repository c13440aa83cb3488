#!/bin/sh
# symbols.sh LIBRARY HEADER...: the library exports exactly the functions that the headers declare,
# all with the version of its ABI, which the first header tells.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
library=$1
shift
part() { sed -n "s/^#define CATA_VERSION_$1 \([0-9]*\).*$/\1/p" "$2"; }
abi=$(part MAJOR "$1")
# While the major version is 0, every minor version has an ABI of its own.
if [ "$abi" = 0 ]; then abi=0.$(part MINOR "$1"); fi
nm -D --defined-only --with-symbol-versions "$library" > "$work/symbols"
# The version itself is an absolute symbol.
awk '$2 != "A" {print $3}' "$work/symbols" | sort > "$work/exported"
# Without comments and directives, what stands before an opening parenthesis.
cat "$@" | "${CC:-cc}" -E -P -x c -I "$(dirname "$1")" - | grep -oE '\bcata_[a-z0-9_]+\(' | tr -d '(' | sed "s/$/@@CATAMARAN_$abi/" |
    sort > "$work/declared"
test -s "$work/declared" || { echo "no function declared in $*" >&2; exit 1; }
if ! diff "$work/declared" "$work/exported"; then
    echo "< declared only, > exported only" >&2
    exit 1
fi
soname=$(objdump -p "$library" | awk '$1 == "SONAME" {print $2}')
test "$soname" = "libcatamaran.so.$abi" || { echo "soname $soname" >&2; exit 1; }
echo "symbols: $(wc -l < "$work/exported") exported, all declared, no other; $soname"
