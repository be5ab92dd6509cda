#!/bin/sh
# Builds the program of many ranks (Debian, Ubuntu), runs a scene on two, and runs its tests.
set -eu
cd "$(dirname "$0")/.."
sh scripts/setup.sh gcc pkg-config libhdf5-dev libpetsc-real-dev libopenmpi-dev openmpi-bin libclang-dev clang
# PETSc's packages point hdf5.pc at the library for MPI; results are written with the serial one.
serial=$(ls /usr/lib/*/pkgconfig/hdf5-serial.pc 2>/dev/null | head -n 1)
if [ -n "$serial" ] && [ "$(readlink -f /etc/alternatives/hdf5.pc)" != "$serial" ]; then
    if [ "$(id -u)" -eq 0 ]; then as_root=; else as_root=sudo; fi
    $as_root update-alternatives --set hdf5.pc "$serial"
fi
# Several ranks on few cores, also as root in a container.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1
cd apps/mpm-mpi
cargo build --locked --profile quick
target=${CARGO_TARGET_DIR:-target}
results=$(mktemp -d)
trap 'rm -r "$results"' EXIT
mpirun -n 2 --oversubscribe "$target/quick/mpm-mpi" run ../../scenes/column.ron -o "$results/column.h5"
cargo test --locked --profile quick --workspace "$@"
