#!/bin/sh
# Installs what is needed and runs every test. Results files are read back and drawn with h5py, VTK and pyvista; the Python
# package runs its own tests.
set -eu
cd "$(dirname "$0")/.."
sh scripts/setup.sh gcc pkg-config libhdf5-dev python3-venv
if ! target/python/bin/python -c 'import h5py, pandas, pytest, pyvista' 2>/dev/null; then
    python3 -m venv target/python
    target/python/bin/pip install --quiet --disable-pip-version-check h5py pandas pytest pyvista
fi
MPM_PYTHON="$PWD/target/python/bin/python"
export MPM_PYTHON
exec cargo test --profile quick --locked --workspace "$@"
