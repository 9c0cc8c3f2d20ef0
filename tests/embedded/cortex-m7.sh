#!/bin/sh
# Builds the program for a bare Cortex-M7 and runs it in QEMU: fails unless it links without a panic path and all torques
# agree with the host's. Needs a compiler with the source of `core` beside it, lld, llvm-size and qemu-system-arm.
# On Debian: rustc-web cargo-web rust-web-src lld llvm qemu-system-arm, which `--install` installs.
set -eu
cd "$(dirname "$0")"
if [ "${1-}" = --install ]; then
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
    rustc-web cargo-web rust-web-src lld llvm qemu-system-arm
fi
for tool in /usr/bin/rustc /usr/bin/cargo ld.lld llvm-size qemu-system-arm; do
  command -v "$tool" > /dev/null || { echo "$tool is missing; see the head of $0" >&2; exit 2; }
done
# Debian has no ready-made `core` for this target; RUSTC_BOOTSTRAP lets its stable compiler build it.
export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
/usr/bin/cargo build --locked --release --target thumbv7em-none-eabihf -Zbuild-std=core
program=${CARGO_TARGET_DIR:-target}/thumbv7em-none-eabihf/release/trueweld-embedded
llvm-size "$program"
timeout 120 qemu-system-arm -M mps2-an500 -nographic -monitor none -serial none \
  -semihosting-config enable=on,target=native -icount shift=8 -kernel "$program"
