#!/bin/sh
# Installs what is needed, builds `mpm`, draws a plough through clay and makes a picture of it (or runs the scene that is
# named).
set -eu
cd "$(dirname "$0")/.."
sh scripts/setup.sh gcc pkg-config libhdf5-dev
mpm() {
    cargo run --release --locked --quiet -p mpm-cli --bin mpm -- "$@"
}
cargo build --release --locked -p mpm-cli --bin mpm
if [ $# -gt 0 ]; then
    mpm run "$@"
else
    mpm run scenes/plough.ron
    mpm plot plough.h5 --show body
fi
