#!/bin/sh
# Builds the wheel of the Python package, with the program `mpm` and HDF5 in it, into target/wheels (Debian, Ubuntu).
#   --system-hdf5  links the HDF5 of the system instead of one that is built (which needs no CMake: pip has it)
#   --quick        compiles as the tests are compiled
#   --test         installs the wheel into an environment of its own and runs the package's tests there
set -eu
cd "$(dirname "$0")/.."
profile=release
hdf5="--features static-hdf5"
audit=
is_tested=
for argument in "$@"; do
    case "$argument" in
    --system-hdf5) hdf5= audit="--compatibility linux" ;;
    --quick) profile=quick ;;
    --test) is_tested=yes ;;
    *) echo "unknown argument $argument; expected --system-hdf5, --quick or --test" >&2 && exit 2 ;;
    esac
done
if [ -n "$hdf5" ]; then
    sh scripts/setup.sh gcc g++ make pkg-config python3-venv
else
    sh scripts/setup.sh gcc pkg-config libhdf5-dev python3-venv
fi
tools="$PWD/target/wheel-tools"
if ! [ -x "$tools/bin/maturin" ] || ! [ -x "$tools/bin/cmake" ]; then
    python3 -m venv "$tools"
    "$tools/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2' 'cmake>=3.26' 'wheel>=0.40'
fi
PATH="$tools/bin:$PATH"
export PATH

rm -rf target/wheels/implicit_mpm* target/wheels/unpacked
# shellcheck disable=SC2086
maturin build --profile "$profile" --locked $hdf5 $audit -m apps/mpm-python/Cargo.toml --out target/wheels
# shellcheck disable=SC2086
cargo build --profile "$profile" --locked $hdf5 -p mpm-cli --bin mpm
# The program joins the wheel as a script, which pip puts beside `python`.
wheel unpack --dest target/wheels/unpacked target/wheels/implicit_mpm-*.whl
for unpacked in target/wheels/unpacked/implicit_mpm-*; do
    scripts="$unpacked/$(basename "$unpacked").data/scripts"
    mkdir -p "$scripts"
    strip -o "$scripts/mpm" "target/$profile/mpm"
    rm target/wheels/implicit_mpm-*.whl
    wheel pack --dest-dir target/wheels "$unpacked"
done
rm -rf target/wheels/unpacked
ls -l target/wheels/implicit_mpm-*.whl

if [ -n "$is_tested" ]; then
    installed="$PWD/target/wheel-test"
    rm -rf "$installed"
    python3 -m venv "$installed"
    "$installed/bin/pip" install --quiet --disable-pip-version-check target/wheels/implicit_mpm-*.whl pandas pytest
    PATH="$installed/bin:$PATH"
    MPM_PROGRAM="$installed/bin/mpm"
    export MPM_PROGRAM
    "$installed/bin/python" -m pytest -q -p no:cacheprovider apps/mpm-python/tests
fi
