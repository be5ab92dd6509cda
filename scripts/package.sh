#!/bin/sh
# Packs the program `mpm`, with HDF5 in it, its scenes, manual pages, completions and guide into target/packages: an archive that
# runs where neither Rust nor HDF5 is installed (Debian, Ubuntu).
#   --system-hdf5  links the HDF5 of the system instead of one that is built (which needs no CMake: pip has it)
#   --quick        compiles as the tests are compiled
#   --crates       packages the published crates instead, without building them from their packages
set -eu
cd "$(dirname "$0")/.."
profile=release
hdf5="--features static-hdf5"
for argument in "$@"; do
    case "$argument" in
    --crates)
        exec cargo package --workspace --no-verify \
            --exclude mpm-examples --exclude mpm-validation --exclude mpm-benchmarks --exclude mpm-python
        ;;
    --system-hdf5) hdf5= ;;
    --quick) profile=quick ;;
    *) echo "unknown argument $argument; expected --system-hdf5, --quick or --crates" >&2 && exit 2 ;;
    esac
done
if [ -n "$hdf5" ]; then
    sh scripts/setup.sh gcc g++ make pkg-config python3-venv
    tools="$PWD/target/package-tools"
    if ! [ -x "$tools/bin/cmake" ]; then
        python3 -m venv "$tools"
        "$tools/bin/pip" install --quiet --disable-pip-version-check 'cmake>=3.26'
    fi
    PATH="$tools/bin:$PATH"
    export PATH
else
    sh scripts/setup.sh gcc pkg-config libhdf5-dev
fi
# shellcheck disable=SC2086
cargo build --profile "$profile" --locked $hdf5 -p mpm-cli --bin mpm
mpm="target/$profile/mpm"
name="mpm-$("$mpm" --version | cut -d' ' -f2)-$(uname -m)-linux"
packed="target/packages/$name"
rm -rf "$packed" "$packed.tar.gz"
mkdir -p "$packed/bin" "$packed/share/man/man1" "$packed/share/bash-completion/completions" "$packed/share/zsh/site-functions" \
    "$packed/share/fish/vendor_completions.d" "$packed/docs"
strip -o "$packed/bin/mpm" "$mpm"
"$mpm" man --output "$packed/share/man/man1"
"$mpm" completions bash > "$packed/share/bash-completion/completions/mpm"
"$mpm" completions zsh > "$packed/share/zsh/site-functions/_mpm"
"$mpm" completions fish > "$packed/share/fish/vendor_completions.d/mpm.fish"
cp -r scenes "$packed/scenes"
cp -r docs/guide docs/pictures "$packed/docs"
cp README.md CHANGELOG.md LICENSE-* "$packed"
tar -C target/packages -czf "$packed.tar.gz" "$name"
ls -l "$packed.tar.gz" "$packed/bin/mpm"
# It runs where it is unpacked, and needs no library but those of C.
[ -z "$hdf5" ] || ! ldd "$packed/bin/mpm" | grep -q hdf5
"$packed/bin/mpm" check "$packed/scenes/simple_stretch.ron" > /dev/null
