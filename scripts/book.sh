#!/bin/sh
# Makes a book for browsers of the guide and the reference of scenes, with search: target/book/book/index.html.
set -eu
cd "$(dirname "$0")/.."
sh scripts/setup.sh gcc python3
mdbook=target/book-tools/bin/mdbook
if ! command -v mdbook >/dev/null && ! [ -x "$mdbook" ]; then
    cargo install --locked --quiet --root target/book-tools mdbook
fi
PATH="$PATH:$PWD/target/book-tools/bin"
export PATH
python3 scripts/book.py target/book
mdbook build target/book
echo "target/book/book/index.html"
