#!/usr/bin/env bash
# The static library without an operating system: linked into a program in C, nothing of panics or allocation is left, and its answers are
# those of the exported C.
#
#     bash controller-ffi/check.sh
#
# Ends with 3 where there is no C compiler.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v cc >/dev/null && command -v nm >/dev/null || exit 3
target=${CARGO_TARGET_DIR:-target}
build=$target/ffi-check
mkdir -p "$build"
cargo rustc --quiet --locked -p saltus-controller-ffi --profile firmware --no-default-features --crate-type staticlib
library=$target/firmware/libsaltus_controller_ffi.a
# No allocator is needed to link it, and none is there: no standard library of Rust.
tables=controller/examples/rats_planar
sed 's|../controller/examples/rats_planar/||' controller-ffi/check.c >"$build/check.c"
# As exported, and once more with approach rates that count at the firing angle, whatever the tables then mean.
for at_firing in 0 1; do
    sed "s/^#define AT_FIRING .*/#define AT_FIRING $at_firing/" "$tables/saltus_controller.c" >"$build/saltus_controller.c"
    cc -std=c99 -O2 -Wall -Wextra -Werror -ffunction-sections -Icontroller-ffi/include -I"$build" -I"$tables" -Icontroller/firmware \
        "$build/check.c" controller/firmware/drill.c "$library" -Wl,--gc-sections -lm -o "$build/check"
    "$build/check"
done
if nm "$build/check" | grep -Ei 'panic|unwind|__rust|alloc$|alloc@'; then
    printf 'the linked program can panic or allocate\n' >&2
    exit 1
fi
printf 'no symbol of panics or allocation in the linked program\n'
