#!/bin/sh
# Builds the program and the C library for a bare Cortex-M7 and runs them in QEMU: fails unless they link without a panic
# path, all torques agree with the host's, and instructions, stack and size stay within bounds.txt.
#
#   --install  fetches what is missing by apt first (Debian), and the target by rustup where there is one
#   --renew    writes bounds.txt anew, 10 % above what is reached
#   --table    prints what is reached, as docs/results.md has it
#
# Needs qemu-system-arm, size of LLVM and arm-none-eabi-gcc with newlib; and either a rustup toolchain with
# thumbv7em-none-eabihf, or Debian's rustc-web cargo-web rust-web-src lld.
set -eu
cd "$(dirname "$0")"
mode=${1-}
by_rustup() { command -v rustup > /dev/null && rustup target list --installed | grep -q thumbv7em-none-eabihf; }
if [ "$mode" = --install ]; then
  packages=
  command -v qemu-system-arm > /dev/null || packages=qemu-system-arm
  command -v llvm-size > /dev/null || packages="$packages llvm"
  command -v arm-none-eabi-gcc > /dev/null || packages="$packages gcc-arm-none-eabi libnewlib-arm-none-eabi"
  if command -v rustup > /dev/null; then
    rustup target add thumbv7em-none-eabihf
  else
    packages="$packages rustc-web cargo-web rust-web-src lld"
  fi
  if [ -n "$packages" ]; then
    apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $packages
  fi
fi
if by_rustup; then
  export CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=rust-lld
  build() { command=$1 && shift && cargo "$command" --locked --release --quiet --target thumbv7em-none-eabihf "$@"; }
  tools=cargo
else
  # Debian has no ready-made `core` for this target; RUSTC_BOOTSTRAP lets its stable compiler build it.
  export RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1
  build() {
    command=$1 && shift
    /usr/bin/cargo "$command" --locked --release --quiet --target thumbv7em-none-eabihf -Zbuild-std=core "$@"
  }
  tools="/usr/bin/rustc /usr/bin/cargo ld.lld"
fi
for tool in $tools llvm-size qemu-system-arm arm-none-eabi-gcc; do
  command -v "$tool" > /dev/null || { echo "$tool is missing; see the head of $0" >&2; exit 2; }
done
build build
build build --bin one-law --features one-law
# From the root, as docs/c-interface.md has it, and where recorded-weld.sh looks for it.
(cd ../.. && build rustc --lib --crate-type staticlib --features archive --manifest-path c-interface/Cargo.toml --target-dir target/c)
library=../../target/c/thumbv7em-none-eabihf/release/libtrueweld_c.a
folder=${CARGO_TARGET_DIR:-target}/thumbv7em-none-eabihf/release
printed=$(mktemp)
trap 'rm -f "$printed" "$printed".*' EXIT
run() {
  timeout 600 qemu-system-arm -M mps2-an500 -nographic -monitor none -serial none \
    -semihosting-config "enable=on,target=native$2" -icount shift=8 -kernel "$folder/$1"
}
# The emulator prints what the program says on standard error.
run trueweld-embedded "" > "$printed" 2>&1 || {
  code=$?
  cat "$printed"
  echo "the program on the target ended with $code: 124 hangs, 1 torques or health signals differ from the host's" >&2
  exit 1
}
laws=$(awk '/^laws alone/ { on = /f32/ } on && /^[a-z-]+$/ && !/-in-external$/' "$printed")
for scalar in FLOAT DOUBLE; do
  arm-none-eabi-gcc -D$scalar -std=gnu99 -O1 -Wall -Wextra -Werror -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 \
    --specs=rdimon.specs -Wl,--gc-sections -Wl,-z,noexecstack -T newlib.ld newlib.c -I ../../c-interface/include \
    -I ../../c-interface/examples c_library.c "$library" -o "$folder/c-library"
  # shellcheck disable=SC2086
  run c-library ",arg=c-library$(printf ',arg=%s' $laws)" >> "$printed.c" 2>&1 || {
    code=$?
    cat "$printed.c"
    echo "the program with the C library ended with $code" >&2
    exit 1
  }
done
# What a program with one core in `float` takes of the C library: every law is in it.
arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 -nostdlib -Wl,--gc-sections -Wl,-z,noexecstack \
  -Wl,-e,trueweld_f32_cycle,-u,trueweld_f32_initialise,-u,trueweld_f32_start "$library" -lgcc -o "$folder/c-library-in-float"
size() { llvm-size "$folder/$1" | awk 'NR == 2 { print $1 + $2 }'; }
# program, scalar, instructions at most, stack in bytes
reached() {
  awk '
    /^f(32|64)$/ { scalar = $1; name = "weld" }
    /^laws alone/ { scalar = $3 }
    /^[a-z]/ && !/^(f32|f64|laws alone)/ { name = $1 }
    /instructions.*most/ { instructions = $NF }
    /stack/ { printf "%s %s %d %d\n", name, scalar, instructions, $NF }
  ' "$printed"
  echo "flash-with-tables both $(size trueweld-embedded) 0"
  echo "flash-of-one-law f32 $(size one-law) 0"
  echo "flash-of-c-library f32 $(size c-library-in-float) 0"
  cat "$printed.c"
}
case $mode in
  --renew)
    head -3 bounds.txt > "$printed.new"
    reached | awk '{ printf "%s %s %d %d\n", $1, $2, $3 * 1.1, $4 * 1.1 }' >> "$printed.new"
    mv "$printed.new" bounds.txt
    ;;
  --table)
    reached | awk '
      { if (!(($1) in seen)) { order[++n] = $1; seen[$1] = 1 } i[$1, $2] = $3; s[$1, $2] = $4 }
      END {
        print "| | instructions a period at most, `f32` | `f64` | stack, bytes, `f32` | `f64` |"
        print "|---|---|---|---|---|"
        for (k = 1; k <= n; k++) if (order[k] !~ /^(flash|c-)/)
          printf "| %s | %d | %d | %d | %d |\n", order[k], i[order[k], "f32"], i[order[k], "f64"], s[order[k], "f32"], s[order[k], "f64"]
        print "\n| | instructions of `cycle`, `f32` | `f64` | stack, bytes: `initialise`, `f32` | `f64` | `start`, `f32` | `f64` | `cycle`, `f32` | `f64` |"
        print "|---|---|---|---|---|---|---|---|---|"
        for (k = 1; k <= n; k++) if (sub(/-initialise$/, "", order[k])) {
          c = order[k] "-cycle"
          printf "| %s | %d | %d", substr(order[k], 3), i[c, "f32"], i[c, "f64"]
          split("initialise start cycle", calls, " ")
          for (call = 1; call <= 3; call++) { c = order[k] "-" calls[call]; printf " | %d | %d", s[c, "f32"], s[c, "f64"] }
          print " |"
        }
        printf "\nflash, bytes: %d with tables, %d of one law, %d of the C library in float\n", i["flash-with-tables", "both"], i["flash-of-one-law", "f32"], i["flash-of-c-library", "f32"]
      }'
    ;;
esac
reached | awk '
  BEGIN { while ((getline line < "bounds.txt") > 0) if (line !~ /^#/) { split(line, f, " "); i[f[1], f[2]] = f[3]; s[f[1], f[2]] = f[4] } }
  {
    if (!(($1, $2) in i)) { printf "%s in %s has no bound: run cortex-m7.sh --renew\n", $1, $2; bad = 1; next }
    what = $1 ~ /^flash/ ? "bytes" : "instructions"
    if ($3 > i[$1, $2]) { printf "%s in %s: %d %s, bound %d\n", $1, $2, $3, what, i[$1, $2]; bad = 1 }
    if ($4 > s[$1, $2]) { printf "%s in %s: %d bytes of stack, bound %d\n", $1, $2, $4, s[$1, $2]; bad = 1 }
    n++
  }
  END { if (n < 10) { print "the program on the target reported too little"; bad = 1 } exit bad }
' >&2 || { echo "the target is out of its bounds (tests/embedded/bounds.txt)" >&2; exit 1; }
echo "Cortex-M7: torques as the host's, instructions, stack and size within bounds"
