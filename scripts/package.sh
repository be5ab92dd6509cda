#!/bin/sh
# Packages the crates that are published, without building them from their packages.
set -eu
cd "$(dirname "$0")/.."
exec cargo package --workspace --no-verify --exclude mpm-examples --exclude mpm-validation --exclude mpm-benchmarks --exclude mpm-python "$@"
