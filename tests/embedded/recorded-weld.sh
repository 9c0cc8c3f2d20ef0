#!/bin/sh
# A whole recorded weld through controller and each law, on this machine and on a Cortex-M7 in QEMU, in float and in
# double: fails unless torques, corrections and faults of every period agree bit for bit. The program is the C
# interface's example. `recorded-weld.sh INPUTS [LAW…]`: the weld as RECORD_WELD of sim-host/plant/tests/cell/recorded_weld.rs
# writes it. Needs gcc, arm-none-eabi-gcc with newlib, qemu-system-arm, and Rust with the target thumbv7em-none-eabihf.
set -eu
inputs=$(realpath "$1")
shift
laws=${*:-none elastostatic feed-forward observer seam-tracking adaptive learning}
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target/c}
library() {
  cargo rustc --release --locked --quiet --lib --crate-type staticlib --features archive \
    --manifest-path c-interface/Cargo.toml --target-dir "$target" "$@"
}
library
if command -v rustup > /dev/null && rustup target list --installed | grep -q thumbv7em-none-eabihf; then
  library --target thumbv7em-none-eabihf
else
  # As in cortex-m7.sh: Debian's compiler builds `core` itself.
  export PATH="/usr/bin:$PATH" RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
  library --target thumbv7em-none-eabihf -Zbuild-std=core
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
include="-std=c99 -O1 -Wl,--gc-sections -Wl,-z,noexecstack -I c-interface/include -I c-interface/examples c-interface/examples/weld.c"
cp "$inputs" "$out/in"
for scalar in FLOAT DOUBLE; do
  # shellcheck disable=SC2086
  gcc -D$scalar $include "$target/release/libtrueweld_c.a" -o "$out/host"
  # shellcheck disable=SC2086
  arm-none-eabi-gcc -D$scalar -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 --specs=rdimon.specs \
    -T tests/embedded/newlib.ld tests/embedded/newlib.c $include "$target/thumbv7em-none-eabihf/release/libtrueweld_c.a" -o "$out/target"
  for law in $laws; do
    "$out/host" "$law" "$out/in" "$out/from-host"
    (cd "$out" && timeout 600 qemu-system-arm -M mps2-an500 -nographic -monitor none -serial none \
      -semihosting-config "enable=on,target=native,arg=weld,arg=$law,arg=in,arg=from-target" -kernel target) \
      || { echo "$law, $scalar: the program on the target ended with $?" >&2; exit 1; }
    periods=$(($(wc -c < "$out/from-host") / 104))
    if cmp "$out/from-host" "$out/from-target"; then
      echo "$law, $scalar: $periods periods agree to the last bit"
    else
      echo "$law, $scalar: host and target differ" >&2
      exit 1
    fi
  done
done
