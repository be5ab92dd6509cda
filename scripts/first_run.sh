#!/bin/sh
# Installs what is needed, builds `mpm` and runs the simple stretch (or the scene that is named).
set -eu
cd "$(dirname "$0")/.."
sh scripts/setup.sh gcc pkg-config libhdf5-dev
exec cargo run --release --locked -p mpm-cli --bin mpm -- run "${@:-scenes/simple_stretch.ron}"
