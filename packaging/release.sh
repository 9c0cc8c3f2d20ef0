#!/usr/bin/env bash
# What a release is made of, into dist/. `bash packaging/release.sh` makes all of it, or the parts that are named:
#
#   program    dist/trueweld, static (musl): runs on any Linux of this processor
#   library    dist/libtrueweld_fmu.so, for `export-fmu`; wanted beside the program
#   wheel      dist/*.whl, where python/ is there
#   crates     dist/crates/*.crate: core, laws, C interface, each built from its archive
#   container  an image `trueweld` of program, library and fixtures; needs Docker or Podman
set -euo pipefail
cd "$(dirname "$0")/.."
target="$(uname -m)-unknown-linux-musl"
# Where the copies below look.
export CARGO_TARGET_DIR="$PWD/target"
mkdir -p dist

program() {
  rustup target add "$target"
  # No C is compiled, and Rust brings what linking with musl needs.
  cargo build --release --locked --target "$target" -p trueweld-cli
  cp "target/$target/release/trueweld" dist/
  # ldd says so of a static program, and ends with a status of its own.
  { ldd dist/trueweld 2>&1 || true; } | grep -Eq "statically linked|not a dynamic"
  dist/trueweld --version
}

library() {
  # A static program loads no libraries, but importers do: this one is of glibc.
  cargo build --release --locked -p trueweld-fmu
  cp target/release/libtrueweld_fmu.so dist/
}

wheel() {
  if [ ! -d python ]; then
    echo "wheel: left out, there is no folder python/"
    return
  fi
  python3 -m venv dist/venv
  dist/venv/bin/pip install --quiet maturin==1.16.0
  dist/venv/bin/maturin build --release --locked --out dist --manifest-path python/Cargo.toml
  rm -r dist/venv
}

crates() {
  mkdir -p dist/crates
  cargo package --locked -p trueweld-core -p trueweld-compensators
  cp target/package/trueweld-core-*.crate target/package/trueweld-compensators-*.crate dist/crates/
  # A workspace of its own. Until the other two are published they stand in for themselves.
  cargo package --manifest-path c-interface/Cargo.toml --target-dir target/c \
    --config "patch.crates-io.trueweld-core.path='$PWD/core-nostd'" \
    --config "patch.crates-io.trueweld-compensators.path='$PWD/compensators'"
  cp target/c/package/trueweld-c-*.crate dist/crates/
}

container() {
  for engine in podman docker; do
    if command -v "$engine" >/dev/null && "$engine" info >/dev/null 2>&1; then
      [ -f dist/trueweld ] || program
      [ -f dist/libtrueweld_fmu.so ] || library
      "$engine" build --tag trueweld --file packaging/Containerfile .
      "$engine" run --rm trueweld --version
      return
    fi
  done
  echo "container: left out, neither Podman nor Docker runs here"
}

for part in "${@:-program library wheel crates container}"; do
  for one in $part; do
    echo "== $one"
    "$one"
  done
done
